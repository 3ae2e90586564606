//! Which half of a circular transfer can be read.

/// A half of the buffer that a circular transfer writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Half {
    /// The lower one.
    First,
    /// The upper one.
    Second,
}

impl Half {
    /// The other one.
    pub const fn other(self) -> Self {
        match self {
            Self::First => Self::Second,
            Self::Second => Self::First,
        }
    }

    /// Its part of the buffer.
    pub fn of<T>(self, buffer: &[T]) -> &[T] {
        let (first, second) = buffer.split_at(buffer.len() / 2);
        match self {
            Self::First => first,
            Self::Second => second,
        }
    }
}

/// What the transfer's interrupt finds and clears.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HalfFlags {
    /// The first half has been written: "half transfer".
    pub first: bool,
    /// The second half has been written: "transfer complete".
    pub second: bool,
}

/// The writer has come round to what was not read yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Overrun {
    /// Halves lost, at least.
    pub halves: u32,
}

/// Follows a circular transfer of two halves by what its interrupt finds.
#[derive(Debug)]
pub struct Halves {
    next: Half,
}

impl Default for Halves {
    fn default() -> Self {
        Self::new()
    }
}

impl Halves {
    /// The transfer begins with the first half.
    pub const fn new() -> Self {
        Self { next: Half::First }
    }

    /// Says which half is to be read now, `None` when the interrupt came for another reason.
    ///
    /// `remaining` is how many of `length` values the transfer still writes before it is at the start
    /// again, read after the flags.
    ///
    /// # Errors
    /// When a half was not read before it was overwritten. What is whole next is expected again.
    pub fn finished(
        &mut self,
        flags: HalfFlags,
        remaining: u16,
        length: u16,
    ) -> Result<Option<Half>, Overrun> {
        let done = match flags {
            HalfFlags { first: false, second: false } => return Ok(None),
            HalfFlags { first: true, second: false } => Half::First,
            HalfFlags { first: false, second: true } => Half::Second,
            HalfFlags { first: true, second: true } => {
                return Err(self.overrun(writing(remaining, length), 2));
            }
        };
        let writing = writing(remaining, length);
        if done != self.next || writing == done {
            return Err(self.overrun(writing, 1));
        }
        self.next = done.other();
        Ok(Some(done))
    }

    /// Asks once more after `half` has been read: the flags that have come up meanwhile, which stay for
    /// the next interrupt, tell whether it was overwritten under the reader's hands.
    ///
    /// # Errors
    /// When it was. The other half may still be whole.
    pub fn was_read(
        &self,
        half: Half,
        flags: HalfFlags,
        remaining: u16,
        length: u16,
    ) -> Result<(), Overrun> {
        let other_is_done = match half {
            Half::First => flags.second,
            Half::Second => flags.first,
        };
        let overwritten = other_is_done || writing(remaining, length) == half;
        if overwritten { Err(Overrun { halves: 1 }) } else { Ok(()) }
    }

    fn overrun(&mut self, writing: Half, halves: u32) -> Overrun {
        self.next = writing;
        Overrun { halves }
    }
}

/// Where the transfer writes. With nothing remaining it is at the start again.
fn writing(remaining: u16, length: u16) -> Half {
    let position = length.saturating_sub(remaining);
    if remaining != 0 && position >= length / 2 { Half::Second } else { Half::First }
}

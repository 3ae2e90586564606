//! Determines which half of a circular transfer's buffer can be read.

/// One half of the buffer of a circular transfer.
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

    /// This half of a buffer.
    pub fn of<T>(self, buffer: &[T]) -> &[T] {
        let (first, second) = buffer.split_at(buffer.len() / 2);
        match self {
            Self::First => first,
            Self::Second => second,
        }
    }
}

/// Flags that the transfer's interrupt reads and clears.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HalfFlags {
    /// The first half has been written: "half transfer".
    pub first: bool,
    /// The second half has been written: "transfer complete".
    pub second: bool,
}

/// The transfer has overwritten values that were not read yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Overrun {
    /// Least number of halves that were lost.
    pub halves: u32,
}

/// Tracks a circular transfer of two halves from the flags that its interrupt reads.
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
    /// A transfer that begins with the first half.
    pub const fn new() -> Self {
        Self { next: Half::First }
    }

    /// Returns the half to be read now, or `None` when the interrupt had another reason.
    ///
    /// `remaining` is how many of the buffer's `length` values the transfer still writes before it wraps
    /// to the start. It must be read after the flags.
    ///
    /// # Errors
    /// [`Overrun`] when a half was overwritten before it was read. Tracking resumes with the half that is
    /// being written.
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

    /// Checks after `half` has been read that it was not overwritten meanwhile. `flags` are those that
    /// were set since; they are not cleared, and the next interrupt handles them.
    ///
    /// # Errors
    /// [`Overrun`] when `half` was overwritten. The other half may still be intact.
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

/// The half that the transfer is writing. With nothing remaining it is back at the start.
fn writing(remaining: u16, length: u16) -> Half {
    let position = length.saturating_sub(remaining);
    if remaining != 0 && position >= length / 2 { Half::Second } else { Half::First }
}

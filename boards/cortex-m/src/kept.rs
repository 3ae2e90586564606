//! Memory that survives a reset.

use core::cell::UnsafeCell;

/// Words of memory that the start-up code leaves as they are, if they lie in a section of their own. Every access is
/// volatile: the compiler knows nothing of what they hold.
#[repr(transparent)]
pub struct RetainedWords<const SIZE: usize>(UnsafeCell<[u32; SIZE]>);

// SAFETY: it is accessed before interrupts are enabled, while they are disabled, or by one task.
unsafe impl<const SIZE: usize> Sync for RetainedWords<SIZE> {}

impl<const SIZE: usize> RetainedWords<SIZE> {
    /// Memory for words.
    pub const fn new() -> Self {
        Self(UnsafeCell::new([0; SIZE]))
    }

    /// What it holds.
    pub fn read(&self) -> [u32; SIZE] {
        // SAFETY: the words are memory of this value, and any bits are a number.
        unsafe { self.0.get().read_volatile() }
    }

    /// Replaces what it holds.
    pub fn write(&self, words: [u32; SIZE]) {
        // SAFETY: as for `read`.
        unsafe { self.0.get().write_volatile(words) };
    }
}

impl<const SIZE: usize> Default for RetainedWords<SIZE> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boot::Words;

    static KEPT: RetainedWords<{ Words::SIZE }> = RetainedWords::new();

    #[test]
    fn what_was_written_last_is_read() {
        assert_eq!(Words::read(&KEPT.read()), None);
        for message in ["index 7 of 5", "out of memory"] {
            KEPT.write(Words::of(format_args!("{message}")).encode());
            assert_eq!(Words::read(&KEPT.read()).as_deref(), Some(message));
        }
    }
}

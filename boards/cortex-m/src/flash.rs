//! A part of the chip's internal flash, as the region of the store.
//!
//! Reading, writing and erasing block until they are complete; on a chip with one bank of flash the core
//! stalls meanwhile. The application erases only while it is idle.

use embedded_storage::nor_flash::{self as blocking, NorFlashErrorKind};
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, NorFlashError, ReadNorFlash};

/// What a chip does besides reading, writing and erasing.
pub trait Supervisor {
    /// A read begins.
    fn before_read(&mut self) {}

    /// The read has ended; true when it has returned something other than what was written: flash with an error
    /// correcting code detects torn words.
    fn read_failed(&mut self) -> bool {
        false
    }

    /// The content has changed: drops what caches hold of it.
    fn changed(&mut self) {}
}

/// Nothing besides.
#[derive(Clone, Copy, Debug)]
pub struct NoSupervisor;

impl Supervisor for NoSupervisor {}

/// A window of `size` bytes from `start` on; both are multiples of a page.
#[derive(Debug)]
pub struct Window<F, C> {
    flash: F,
    start: u32,
    size: u32,
    supervisor: C,
}

impl<F: blocking::NorFlash, C: Supervisor> Window<F, C> {
    /// A window for the exclusive use of the store.
    pub fn new(flash: F, start: u32, size: u32, supervisor: C) -> Self {
        Self { flash, start, size, supervisor }
    }

    fn at(&self, offset: u32, length: usize) -> Result<u32, WindowError<F::Error>> {
        let end = u32::try_from(length).ok().and_then(|length| offset.checked_add(length));
        if end.is_some_and(|end| end <= self.size) {
            Ok(self.start + offset)
        } else {
            Err(WindowError::OutOfBounds)
        }
    }
}

/// Why an operation on the flash failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WindowError<E> {
    /// The range goes beyond the end of the window.
    OutOfBounds,
    /// The content has decayed or was torn by a loss of power.
    Unreadable,
    /// An error of the chip's driver.
    Flash(E),
}

impl<E: blocking::NorFlashError> NorFlashError for WindowError<E> {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::OutOfBounds => NorFlashErrorKind::OutOfBounds,
            Self::Unreadable => NorFlashErrorKind::Other,
            Self::Flash(error) => error.kind(),
        }
    }
}

impl<F: blocking::NorFlash, C: Supervisor> ErrorType for Window<F, C> {
    type Error = WindowError<F::Error>;
}

impl<F: blocking::NorFlash, C: Supervisor> ReadNorFlash for Window<F, C> {
    const READ_SIZE: usize = F::READ_SIZE;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        let at = self.at(offset, bytes.len())?;
        self.supervisor.before_read();
        let read = self.flash.read(at, bytes).map_err(WindowError::Flash);
        if self.supervisor.read_failed() { Err(WindowError::Unreadable) } else { read }
    }

    fn capacity(&self) -> usize {
        self.size as usize
    }
}

impl<F: blocking::NorFlash, C: Supervisor> NorFlash for Window<F, C> {
    const WRITE_SIZE: usize = F::WRITE_SIZE;
    const ERASE_SIZE: usize = F::ERASE_SIZE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        let length = to.checked_sub(from).ok_or(WindowError::OutOfBounds)?;
        let at = self.at(from, length as usize)?;
        let erased = self.flash.erase(at, at + length).map_err(WindowError::Flash);
        self.supervisor.changed();
        erased
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        let at = self.at(offset, bytes.len())?;
        let written = self.flash.write(at, bytes).map_err(WindowError::Flash);
        self.supervisor.changed();
        written
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embassy_futures::block_on;

    /// 64 bytes in pages of 16.
    struct Chip([u8; 64]);

    impl blocking::ErrorType for Chip {
        type Error = NorFlashErrorKind;
    }

    impl blocking::ReadNorFlash for Chip {
        const READ_SIZE: usize = 1;

        fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
            bytes.copy_from_slice(&self.0[offset as usize..][..bytes.len()]);
            Ok(())
        }

        fn capacity(&self) -> usize {
            64
        }
    }

    impl blocking::NorFlash for Chip {
        const WRITE_SIZE: usize = 4;
        const ERASE_SIZE: usize = 16;

        fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
            blocking::check_erase(self, from, to)?;
            self.0[from as usize..to as usize].fill(0xFF);
            Ok(())
        }

        fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
            blocking::check_write(self, offset, bytes.len())?;
            self.0[offset as usize..][..bytes.len()].copy_from_slice(bytes);
            Ok(())
        }
    }

    #[test]
    fn only_the_window_is_written_and_erased() {
        let mut window = Window::new(Chip([7; 64]), 16, 32, NoSupervisor);
        assert_eq!(window.capacity(), 32);
        block_on(async {
            window.erase(0, 32).await.unwrap();
            window.write(28, &[1, 2, 3, 4]).await.unwrap();
            let mut read = [0; 4];
            window.read(28, &mut read).await.unwrap();
            assert_eq!(read, [1, 2, 3, 4]);
        });
        let mut expected = [7; 64];
        expected[16..44].fill(0xFF);
        expected[44..48].copy_from_slice(&[1, 2, 3, 4]);
        assert_eq!(window.flash.0, expected);
    }

    /// Which reads fail, and whether one is under way.
    struct Errors(Vec<bool>, bool);

    impl Supervisor for Errors {
        fn before_read(&mut self) {
            assert!(!core::mem::replace(&mut self.1, true));
        }

        fn read_failed(&mut self) -> bool {
            assert!(core::mem::take(&mut self.1));
            self.0.remove(0)
        }
    }

    #[test]
    fn a_read_that_the_chip_could_not_correct_fails_and_no_other_does() {
        let errors = Errors(vec![false, true, false], false);
        let mut window = Window::new(Chip([7; 64]), 0, 64, errors);
        let mut read = |offset| block_on(window.read(offset, &mut [0; 4]));
        assert_eq!(read(0), Ok(()));
        assert_eq!(read(4), Err(WindowError::Unreadable));
        assert_eq!(read(8), Ok(()));
    }

    /// Data that was read before, as a cache holds it.
    struct CacheDropCounter<'a>(&'a core::cell::Cell<usize>);

    impl Supervisor for CacheDropCounter<'_> {
        fn changed(&mut self) {
            self.0.set(self.0.get() + 1);
        }
    }

    #[test]
    fn caches_are_dropped_after_every_change_also_a_failed_one_and_after_no_read() {
        let dropped = core::cell::Cell::new(0);
        let mut window = Window::new(Chip([7; 64]), 16, 32, CacheDropCounter(&dropped));
        block_on(async {
            window.read(0, &mut [0; 4]).await.unwrap();
            assert_eq!(dropped.get(), 0);
            window.erase(0, 16).await.unwrap();
            assert_eq!(dropped.get(), 1);
            window.write(0, &[1; 4]).await.unwrap();
            assert_eq!(dropped.get(), 2);
            window.write(2, &[1; 4]).await.unwrap_err();
            assert_eq!(dropped.get(), 3);
        });
    }

    #[test]
    fn beyond_the_window_nothing_is_touched() {
        let mut window = Window::new(Chip([7; 64]), 16, 32, NoSupervisor);
        let outside = Err(WindowError::OutOfBounds);
        block_on(async {
            assert_eq!(window.erase(16, 48).await, outside);
            assert_eq!(window.erase(16, 0).await, outside);
            assert_eq!(window.write(32, &[0; 4]).await, outside);
            assert_eq!(window.write(u32::MAX - 3, &[0; 8]).await, outside);
            assert_eq!(window.read(31, &mut [0; 2]).await, outside);
            let unaligned = WindowError::Flash(NorFlashErrorKind::NotAligned);
            assert_eq!(window.write(2, &[0; 4]).await, Err(unaligned));
        });
        assert_eq!(window.flash.0, [7; 64]);
    }
}

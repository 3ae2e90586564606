//! Simulated NOR flash in memory that survives a reset.
//!
//! A page of 4 KiB is erased to ones as a whole. A word of 4 bytes can be written once after an erase.

use core::fmt;
use core::ops::Range;

use embedded_storage_async::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};

/// Bytes per page.
pub const PAGE: usize = 4096;
/// Bytes per word.
pub const WORD: usize = 4;
const ERASED: u8 = 0xFF;

/// A region of flash in plain memory.
#[derive(Debug)]
pub struct MemoryFlash<'a> {
    bytes: &'a mut [u8],
}

impl<'a> MemoryFlash<'a> {
    /// Flash in `bytes`, which keep their content and must be whole pages.
    pub fn new(bytes: &'a mut [u8]) -> Self {
        debug_assert_eq!(bytes.len() % PAGE, 0);
        Self { bytes }
    }

    /// Erases everything, for a machine that starts for the first time.
    pub fn erase_all(&mut self) {
        self.bytes.fill(ERASED);
    }

    /// The bytes of `length` from `offset`, both multiples of `unit`.
    fn part(&mut self, offset: u32, length: usize, unit: usize) -> Result<&mut [u8], FlashError> {
        let start = offset as usize;
        let range = Range { start, end: start.saturating_add(length) };
        if !range.start.is_multiple_of(unit) || !length.is_multiple_of(unit) {
            return Err(FlashError::Address(NorFlashErrorKind::NotAligned));
        }
        self.bytes.get_mut(range).ok_or(FlashError::Address(NorFlashErrorKind::OutOfBounds))
    }
}

/// Why an operation on the flash was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlashError {
    /// An address is not aligned to a word or page, or lies outside the region.
    Address(NorFlashErrorKind),
    /// The word to be written had not been erased.
    NotErased,
}

impl fmt::Display for FlashError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Address(kind) => write!(f, "{kind}"),
            Self::NotErased => f.write_str("the word had not been erased"),
        }
    }
}

impl core::error::Error for FlashError {}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Address(kind) => *kind,
            Self::NotErased => NorFlashErrorKind::Other,
        }
    }
}

impl ErrorType for MemoryFlash<'_> {
    type Error = FlashError;
}

impl ReadNorFlash for MemoryFlash<'_> {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        bytes.copy_from_slice(self.part(offset, bytes.len(), Self::READ_SIZE)?);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for MemoryFlash<'_> {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = PAGE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        let length =
            to.checked_sub(from).ok_or(FlashError::Address(NorFlashErrorKind::OutOfBounds))?;
        self.part(from, length as usize, PAGE)?.fill(ERASED);
        Ok(())
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        let place = self.part(offset, bytes.len(), WORD)?;
        for (word, new) in place.chunks_exact_mut(WORD).zip(bytes.chunks_exact(WORD)) {
            if word.iter().any(|&byte| byte != ERASED) {
                return Err(FlashError::NotErased);
            }
            word.copy_from_slice(new);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embassy_futures::block_on;

    fn with_flash(test: impl AsyncFnOnce(&mut MemoryFlash<'_>)) {
        let mut bytes = vec![0; 4 * PAGE];
        let mut flash = MemoryFlash::new(&mut bytes);
        flash.erase_all();
        block_on(test(&mut flash));
    }

    #[test]
    fn what_is_written_is_read_and_the_rest_stays_erased() {
        with_flash(async |flash| {
            flash.write(8, &[1, 2, 3, 4]).await.unwrap();
            let mut bytes = [0; 12];
            flash.read(4, &mut bytes).await.unwrap();
            assert_eq!(bytes, [255, 255, 255, 255, 1, 2, 3, 4, 255, 255, 255, 255]);
        });
    }

    #[test]
    fn a_word_is_written_once_between_two_erases() {
        with_flash(async |flash| {
            flash.write(0, &[0; 4]).await.unwrap();
            assert_eq!(flash.write(0, &[0; 4]).await, Err(FlashError::NotErased));
            flash.erase(0, PAGE as u32).await.unwrap();
            flash.write(0, &[0; 4]).await.unwrap();
        });
    }

    #[test]
    fn an_erase_takes_whole_pages_and_leaves_the_others() {
        with_flash(async |flash| {
            let second = PAGE as u32;
            flash.write(second, &[9; 4]).await.unwrap();
            flash.erase(0, second).await.unwrap();
            let mut word = [0; 4];
            flash.read(second, &mut word).await.unwrap();
            assert_eq!(word, [9; 4]);
            let unaligned = Err(FlashError::Address(NorFlashErrorKind::NotAligned));
            assert_eq!(flash.erase(4, second).await, unaligned);
            assert_eq!(flash.write(2, &[0; 4]).await, unaligned);
        });
    }

    #[test]
    fn an_address_outside_is_refused() {
        with_flash(async |flash| {
            let outside = Err(FlashError::Address(NorFlashErrorKind::OutOfBounds));
            let end = flash.capacity() as u32;
            assert_eq!(flash.write(end, &[0; 4]).await, outside);
            assert_eq!(flash.read(end - 2, &mut [0; 4]).await, outside);
            assert_eq!(flash.erase(end, end + PAGE as u32).await, outside);
        });
    }
}

//! Flash of a chip, in memory or in a file, with the rules of that chip's NOR flash, wear counters, and
//! power that can be cut at any word.
//!
//! An erase sets whole pages to ones, a write only clears bits. What a power cut leaves of the word or
//! page being changed differs from chip to chip: see [`Chip`].

mod cells;
mod file;

use std::fs::File;
use std::io;
use std::marker::PhantomData;
use std::path::PathBuf;

use embedded_storage_async::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};

pub use cells::{Cut, FlashMemory, FlashStep};

/// The rules of a chip's flash.
pub trait Chip: Send + 'static {
    /// Bytes of the region.
    const BYTES: usize;
    /// Bytes of a page, which is erased as a whole.
    const PAGE: usize;
    /// Bytes of a word, which is written as a whole.
    const WORD: usize;
    /// Whether every word has its own error-correcting code.
    ///
    /// * Without one, a word may be written again as long as bits are only cleared. A cut write clears
    ///   any of the bits that it was to clear, and a cut erase leaves random bits.
    /// * With one, a word is written once between two erases. A cut write or a cut erase leaves words
    ///   that cannot be read until their page is erased.
    const ECC: bool;
}

/// The virtual board's own flash.
#[derive(Clone, Copy, Debug)]
pub enum VirtualChip {}

impl Chip for VirtualChip {
    const BYTES: usize = FLASH_BYTES;
    const PAGE: usize = PAGE_BYTES;
    const WORD: usize = WORD_BYTES;
    const ECC: bool = false;
}

/// Sectors 1 to 3 of an STM32F411.
#[derive(Clone, Copy, Debug)]
pub enum F411 {}

impl Chip for F411 {
    const BYTES: usize = 48 * 1024;
    const PAGE: usize = 16 * 1024;
    const WORD: usize = 4;
    const ECC: bool = false;
}

/// The end of an STM32G474's second bank: double words with an error-correcting code.
#[derive(Clone, Copy, Debug)]
pub enum G474 {}

impl Chip for G474 {
    const BYTES: usize = 50 * 1024;
    const PAGE: usize = 2 * 1024;
    const WORD: usize = 8;
    const ECC: bool = true;
}

/// The end of the flash beside an RP2350 (W25Q32), written by single bytes.
#[derive(Clone, Copy, Debug)]
pub enum W25q {}

impl Chip for W25q {
    const BYTES: usize = 64 * 1024;
    const PAGE: usize = 4 * 1024;
    const WORD: usize = 1;
    const ECC: bool = false;
}

/// Bytes of the virtual board's flash.
pub const FLASH_BYTES: usize = 256 * 1024;
/// Bytes per page of that flash.
pub const PAGE_BYTES: usize = 4096;
/// Bytes per word of that flash.
pub const WORD_BYTES: usize = 4;

/// Where the bits of a [`Flash`] live.
#[derive(Clone, Debug)]
pub enum FlashBacking {
    /// In this process. A rig restarted on a clone finds what the first one has written.
    Memory(FlashMemory),
    /// In this file, which is created when it does not exist. Only one rig may use it at a time.
    File(PathBuf),
}

impl Default for FlashBacking {
    fn default() -> Self {
        Self::Memory(FlashMemory::default())
    }
}

/// Why flash could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum FlashOpenError {
    /// The file cannot be read or created.
    #[error("cannot open the flash file {path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// Another rig has it open.
    #[error("the flash file {path} is in use by another rig")]
    InUse {
        /// The file.
        path: PathBuf,
    },
    /// It is not a flash file.
    #[error("{path} is not a flash file: it has {found} bytes instead of {FLASH_BYTES}")]
    WrongLength {
        /// The file.
        path: PathBuf,
        /// Its length in bytes.
        found: u64,
    },
}

/// Why an operation on flash failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlashError {
    /// The offset or the length is not a multiple of the unit that the operation needs.
    NotAligned,
    /// The range goes beyond the end.
    OutOfBounds,
    /// A write would have to set a cleared bit, or would write a word a second time.
    NotErased,
    /// The word was torn by a power cut: its error-correcting code does not match.
    Torn,
    /// The power is off.
    PowerCut,
    /// The file could not be written.
    File,
    /// The flash does not take changes.
    Refused,
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::NotAligned => NorFlashErrorKind::NotAligned,
            Self::OutOfBounds => NorFlashErrorKind::OutOfBounds,
            Self::NotErased | Self::Torn | Self::PowerCut | Self::File | Self::Refused => {
                NorFlashErrorKind::Other
            }
        }
    }
}

/// The flash of a chip. With a file behind it, a write or an erase reaches the file before it returns, so
/// the content survives the end of the process.
#[derive(Debug)]
pub struct ChipFlash<C> {
    memory: FlashMemory,
    file: Option<File>,
    chip: PhantomData<C>,
}

/// The virtual board's flash.
pub type Flash = ChipFlash<VirtualChip>;

impl Flash {
    /// Opens the virtual board's flash; new flash is erased.
    ///
    /// # Errors
    /// When the file cannot be opened, is in use, or is not a flash file.
    pub fn open(backing: &FlashBacking) -> Result<Self, FlashOpenError> {
        match backing {
            FlashBacking::Memory(memory) => Ok(Self::over(memory)),
            FlashBacking::File(path) => {
                let mut file = file::open_locked(path)?;
                let memory = file::load(&mut file, path)?;
                Ok(Self { file: Some(file), ..Self::over(&memory) })
            }
        }
    }
}

impl<C: Chip> ChipFlash<C> {
    /// Opens memory made for this chip by [`FlashMemory::of`]; restores its power.
    pub fn over(memory: &FlashMemory) -> Self {
        memory.with(cells::Cells::power_up);
        Self { memory: memory.clone(), file: None, chip: PhantomData }
    }

    /// Changes `length` bytes at `offset`, in memory and in the file.
    fn change(
        &mut self,
        offset: u32,
        length: usize,
        change: impl FnOnce(&mut cells::Cells, usize) -> Result<(), FlashError>,
    ) -> Result<(), FlashError> {
        let file = self.file.as_mut();
        self.memory.with(|cells| {
            let start = offset as usize;
            let changed = change(cells, start);
            if let Some(file) = file {
                let place = cells.bytes(start, length);
                file::save(file, offset, place).map_err(|_| FlashError::File)?;
            }
            changed
        })
    }
}

fn check<C: Chip>(offset: u32, length: usize, unit: usize) -> Result<(), FlashError> {
    let start = offset as usize;
    if !start.is_multiple_of(unit) || !length.is_multiple_of(unit) {
        return Err(FlashError::NotAligned);
    }
    match start.checked_add(length) {
        Some(end) if end <= C::BYTES => Ok(()),
        _ => Err(FlashError::OutOfBounds),
    }
}

impl<C> ErrorType for ChipFlash<C> {
    type Error = FlashError;
}

impl<C: Chip> ReadNorFlash for ChipFlash<C> {
    const READ_SIZE: usize = C::WORD;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        check::<C>(offset, bytes.len(), Self::READ_SIZE)?;
        self.memory.with(|cells| cells.read(offset as usize, bytes))
    }

    fn capacity(&self) -> usize {
        C::BYTES
    }
}

impl<C: Chip> NorFlash for ChipFlash<C> {
    const WRITE_SIZE: usize = C::WORD;
    const ERASE_SIZE: usize = C::PAGE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        let length = to.checked_sub(from).ok_or(FlashError::OutOfBounds)? as usize;
        check::<C>(from, length, Self::ERASE_SIZE)?;
        self.change(from, length, |cells, start| cells.erase(start, length))
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        check::<C>(offset, bytes.len(), Self::WRITE_SIZE)?;
        self.change(offset, bytes.len(), |cells, start| cells.write(start, bytes))
    }
}

#[cfg(test)]
mod tests;

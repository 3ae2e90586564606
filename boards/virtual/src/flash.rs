//! Flash in memory or in a file, with the rules of NOR flash: an erase sets whole pages to ones, a
//! write only clears bits.

use std::fmt;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use embedded_storage_async::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};

/// Bytes of the flash.
pub const FLASH_BYTES: usize = 256 * 1024;
/// Bytes that are erased together.
pub const PAGE_BYTES: usize = 4096;
/// Bytes that are written together.
pub const WORD_BYTES: usize = 4;

/// Where the bits of a [`Flash`] live.
#[derive(Clone, Debug)]
pub enum FlashBacking {
    /// In this process. A rig started again over a clone finds what the first has written.
    Memory(FlashMemory),
    /// In this file, made when it is not there. One rig at a time.
    File(PathBuf),
}

impl Default for FlashBacking {
    fn default() -> Self {
        Self::Memory(FlashMemory::default())
    }
}

/// The content of a flash in memory; clones are the same flash.
#[derive(Clone)]
pub struct FlashMemory(Arc<Mutex<Vec<u8>>>);

impl Default for FlashMemory {
    fn default() -> Self {
        Self(Arc::new(Mutex::new(vec![0xFF; FLASH_BYTES])))
    }
}

impl fmt::Debug for FlashMemory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("FlashMemory")
    }
}

impl FlashMemory {
    /// Another flash with the same content.
    pub fn copied(&self) -> Self {
        Self(Arc::new(Mutex::new(self.with(|bytes| bytes.clone()))))
    }

    fn with<T>(&self, what: impl FnOnce(&mut Vec<u8>) -> T) -> T {
        what(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// Why flash cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum FlashOpenError {
    /// The file cannot be read or made.
    #[error("cannot open the flash file {path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Another rig has it open.
    #[error("the flash file {path} is in use by another rig")]
    InUse {
        /// The file.
        path: PathBuf,
    },
    /// It is not a flash file.
    #[error("{path} is no flash file: it has {found} bytes, not {FLASH_BYTES}")]
    WrongLength {
        /// The file.
        path: PathBuf,
        /// Its bytes.
        found: u64,
    },
}

/// Why flash refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlashError {
    /// The place or the length is no multiple of what the flash can do.
    NotAligned,
    /// Beyond the end.
    OutOfBounds,
    /// A write would have to set a bit that is cleared.
    NotErased,
    /// The file could not be written.
    File,
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::NotAligned => NorFlashErrorKind::NotAligned,
            Self::OutOfBounds => NorFlashErrorKind::OutOfBounds,
            Self::NotErased | Self::File => NorFlashErrorKind::Other,
        }
    }
}

/// A [`NorFlash`] of [`FLASH_BYTES`]. A file is written before a write or an erase returns, so its
/// content survives the end of the process.
#[derive(Debug)]
pub struct Flash {
    memory: FlashMemory,
    file: Option<File>,
}

impl Flash {
    /// Opens the flash; new flash is erased.
    ///
    /// # Errors
    /// When the file cannot be opened, is in use, or is no flash file.
    pub fn open(backing: &FlashBacking) -> Result<Self, FlashOpenError> {
        match backing {
            FlashBacking::Memory(memory) => Ok(Self { memory: memory.clone(), file: None }),
            FlashBacking::File(path) => {
                let mut file = open_locked(path)?;
                let memory = load(&mut file, path)?;
                Ok(Self { memory, file: Some(file) })
            }
        }
    }

    /// Changes `length` bytes at `offset`, in memory and in the file.
    fn change(
        &mut self,
        offset: u32,
        length: usize,
        change: impl FnOnce(&mut [u8]) -> Result<(), FlashError>,
    ) -> Result<(), FlashError> {
        let file = self.file.as_mut();
        self.memory.with(|memory| {
            let start = offset as usize;
            let place = memory.get_mut(start..start + length).ok_or(FlashError::OutOfBounds)?;
            change(place)?;
            match file {
                Some(file) => save(file, offset, place).map_err(|_| FlashError::File),
                None => Ok(()),
            }
        })
    }
}

fn open_locked(path: &Path) -> Result<File, FlashOpenError> {
    let failed = |source| FlashOpenError::Io { path: path.to_owned(), source };
    let file = OpenOptions::new()
        .read(true)
        .write(true)
        .create(true)
        .truncate(false)
        .open(path)
        .map_err(failed)?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(FlashOpenError::InUse { path: path.to_owned() }),
        Err(TryLockError::Error(source)) => Err(failed(source)),
    }
}

fn load(file: &mut File, path: &Path) -> Result<FlashMemory, FlashOpenError> {
    let failed = |source| FlashOpenError::Io { path: path.to_owned(), source };
    let memory = FlashMemory::default();
    match file.metadata().map_err(failed)?.len() {
        0 => memory.with(|bytes| file.write_all(bytes)).map_err(failed)?,
        length if length == FLASH_BYTES as u64 => {
            memory.with(|bytes| file.read_exact(bytes)).map_err(failed)?;
        }
        found => return Err(FlashOpenError::WrongLength { path: path.to_owned(), found }),
    }
    Ok(memory)
}

fn save(file: &mut File, offset: u32, bytes: &[u8]) -> io::Result<()> {
    file.seek(SeekFrom::Start(offset.into()))?;
    file.write_all(bytes)
}

fn check(offset: u32, length: usize, unit: usize) -> Result<(), FlashError> {
    let start = offset as usize;
    if !start.is_multiple_of(unit) || !length.is_multiple_of(unit) {
        return Err(FlashError::NotAligned);
    }
    match start.checked_add(length) {
        Some(end) if end <= FLASH_BYTES => Ok(()),
        _ => Err(FlashError::OutOfBounds),
    }
}

impl ErrorType for Flash {
    type Error = FlashError;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = WORD_BYTES;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        check(offset, bytes.len(), Self::READ_SIZE)?;
        let start = offset as usize;
        self.memory.with(|memory| bytes.copy_from_slice(&memory[start..start + bytes.len()]));
        Ok(())
    }

    fn capacity(&self) -> usize {
        FLASH_BYTES
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = WORD_BYTES;
    const ERASE_SIZE: usize = PAGE_BYTES;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        let length = to.checked_sub(from).ok_or(FlashError::OutOfBounds)? as usize;
        check(from, length, Self::ERASE_SIZE)?;
        self.change(from, length, |place| {
            place.fill(0xFF);
            Ok(())
        })
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        check(offset, bytes.len(), Self::WRITE_SIZE)?;
        self.change(offset, bytes.len(), |place| {
            if place.iter().zip(bytes).any(|(&old, &new)| new & !old != 0) {
                return Err(FlashError::NotErased);
            }
            place.copy_from_slice(bytes);
            Ok(())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embassy_futures::block_on;

    fn flash() -> Flash {
        Flash::open(&FlashBacking::default()).unwrap()
    }

    fn read(flash: &mut Flash, offset: u32) -> [u8; 8] {
        let mut bytes = [0; 8];
        block_on(flash.read(offset, &mut bytes)).unwrap();
        bytes
    }

    #[test]
    fn new_flash_is_erased() {
        assert_eq!(read(&mut flash(), (FLASH_BYTES - 8) as u32), [0xFF; 8]);
    }

    #[test]
    fn a_write_clears_bits_and_cannot_set_them() {
        let mut flash = flash();
        block_on(flash.write(8, &[0xF0; 4])).unwrap();
        block_on(flash.write(8, &[0x30; 4])).unwrap();
        assert_eq!(block_on(flash.write(8, &[0x31, 0x30, 0x30, 0x30])), Err(FlashError::NotErased));
        assert_eq!(read(&mut flash, 8), [0x30, 0x30, 0x30, 0x30, 0xFF, 0xFF, 0xFF, 0xFF]);
    }

    #[test]
    fn an_erase_sets_its_pages_and_no_others() {
        let mut flash = flash();
        for page in 0..4 {
            block_on(flash.write(page * 4096, &[0; 4096])).unwrap();
        }
        block_on(flash.erase(4096, 3 * 4096)).unwrap();
        for (page, expected) in [(0, 0), (1, 0xFF), (2, 0xFF), (3, 0)] {
            assert_eq!(read(&mut flash, page * 4096), [expected; 8], "page {page}");
            assert_eq!(read(&mut flash, page * 4096 + 4088), [expected; 8], "page {page}");
        }
    }

    #[test]
    fn what_is_not_aligned_or_beyond_the_end_is_refused() {
        let mut flash = flash();
        let end = FLASH_BYTES as u32;
        assert_eq!(block_on(flash.write(2, &[0; 4])), Err(FlashError::NotAligned));
        assert_eq!(block_on(flash.write(4, &[0; 3])), Err(FlashError::NotAligned));
        assert_eq!(block_on(flash.write(end, &[0; 4])), Err(FlashError::OutOfBounds));
        assert_eq!(block_on(flash.erase(0, 100)), Err(FlashError::NotAligned));
        assert_eq!(block_on(flash.erase(4096, 0)), Err(FlashError::OutOfBounds));
        assert_eq!(block_on(flash.erase(0, end + 4096)), Err(FlashError::OutOfBounds));
        assert_eq!(block_on(flash.read(end - 4, &mut [0; 8])), Err(FlashError::OutOfBounds));
    }

    #[test]
    fn a_file_keeps_its_content_when_the_rig_starts_again() {
        let folder = tempfile::tempdir().unwrap();
        let backing = FlashBacking::File(folder.path().join("flash.bin"));
        let mut flash = Flash::open(&backing).unwrap();
        block_on(flash.write(4096, &[1, 2, 3, 4, 5, 6, 7, 8])).unwrap();
        block_on(flash.write(8192, &[0; 8])).unwrap();
        block_on(flash.erase(8192, 12288)).unwrap();
        drop(flash);
        let mut flash = Flash::open(&backing).unwrap();
        assert_eq!(read(&mut flash, 4096), [1, 2, 3, 4, 5, 6, 7, 8]);
        assert_eq!(read(&mut flash, 8192), [0xFF; 8]);
    }

    #[test]
    fn memory_keeps_its_content_when_the_rig_starts_again() {
        let backing = FlashBacking::default();
        block_on(Flash::open(&backing).unwrap().write(0, &[9; 8])).unwrap();
        assert_eq!(read(&mut Flash::open(&backing).unwrap(), 0), [9; 8]);
    }

    #[test]
    fn a_copy_of_flash_goes_its_own_way() {
        let memory = FlashMemory::default();
        let copy = memory.copied();
        block_on(Flash::open(&FlashBacking::Memory(copy)).unwrap().write(0, &[9; 8])).unwrap();
        assert_eq!(read(&mut Flash::open(&FlashBacking::Memory(memory)).unwrap(), 0), [0xFF; 8]);
    }

    #[test]
    fn a_file_serves_one_rig_at_a_time() {
        let folder = tempfile::tempdir().unwrap();
        let backing = FlashBacking::File(folder.path().join("flash.bin"));
        let _first = Flash::open(&backing).unwrap();
        assert!(matches!(Flash::open(&backing), Err(FlashOpenError::InUse { .. })));
    }

    #[test]
    fn a_file_of_another_length_is_refused_and_not_touched() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("notes.txt");
        std::fs::write(&path, "not flash").unwrap();
        let error = Flash::open(&FlashBacking::File(path.clone())).unwrap_err();
        assert!(matches!(error, FlashOpenError::WrongLength { found: 9, .. }));
        assert_eq!(std::fs::read_to_string(path).unwrap(), "not flash");
    }
}

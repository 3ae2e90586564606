//! Flash whose content lives in a file.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;

use super::{FLASH_BYTES, FlashMemory, FlashOpenError};

/// Opens the file and locks it against other rigs.
pub(super) fn open_locked(path: &Path) -> Result<File, FlashOpenError> {
    let failed = |source| FlashOpenError::Io { path: path.to_owned(), source };
    let file = OpenOptions::new()
        .read(true)
        .write(true)
        .create(true)
        .truncate(false)
        .open(path)
        .map_err(failed)?;
    // A pipe or a device would be waited for, or hold no flash.
    if !file.metadata().map_err(failed)?.is_file() {
        return Err(failed(io::Error::other("it is not a regular file")));
    }
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(FlashOpenError::InUse { path: path.to_owned() }),
        Err(TryLockError::Error(source)) => Err(failed(source)),
    }
}

/// The content of the file; an empty file becomes erased flash.
pub(super) fn load(file: &mut File, path: &Path) -> Result<FlashMemory, FlashOpenError> {
    let failed = |source| FlashOpenError::Io { path: path.to_owned(), source };
    let mut bytes = vec![0xFF; FLASH_BYTES];
    match file.metadata().map_err(failed)?.len() {
        0 => file.write_all(&bytes).map_err(|source| {
            // An incomplete file would be refused the next time.
            let _ = file.set_len(0);
            failed(source)
        })?,
        length if length == FLASH_BYTES as u64 => file.read_exact(&mut bytes).map_err(failed)?,
        length => return Err(FlashOpenError::WrongLength { path: path.to_owned(), found: length }),
    }
    Ok(FlashMemory::holding(bytes))
}

pub(super) fn save(file: &mut File, offset: u32, bytes: &[u8]) -> io::Result<()> {
    file.seek(SeekFrom::Start(offset.into()))?;
    file.write_all(bytes)
}

//! The machine's PSRAM as a file that QEMU and this process map.
#![allow(unsafe_code, reason = "a file that another process changes is mapped")]

use std::fs::File;
use std::path::{Path, PathBuf};

use massline_mps2_an386::ring::Ring;
use massline_mps2_an386::{FLASH_OFFSET, FLASH_SIZE, PSRAM_SIZE, RING_OFFSET};
use massline_shared::signal::AdcProperties;
use memmap2::MmapMut;
use tempfile::NamedTempFile;

use crate::{Error, Result};

/// The PSRAM: ring and flash. The file is deleted when this is dropped.
#[derive(Debug)]
pub(super) struct Psram {
    file: NamedTempFile,
    map: MmapMut,
}

impl Psram {
    /// Creates a PSRAM with an open ring and an erased flash.
    pub fn create(adc: &AdcProperties) -> Result<Self> {
        let failed = |error| {
            Error::internal(
                "qemu_memory",
                format!("cannot make the memory of the emulated rig: {error}"),
            )
        };
        let file = tempfile::Builder::new()
            .prefix("massline-psram-")
            .tempfile_in(directory())
            .map_err(failed)?;
        file.as_file().set_len(PSRAM_SIZE as u64).map_err(failed)?;
        let mut map = map(file.as_file()).map_err(failed)?;
        map[FLASH_OFFSET..FLASH_OFFSET + FLASH_SIZE].fill(0xFF);
        let psram = Self { file, map };
        psram.ring().open(adc);
        Ok(psram)
    }

    /// The path of the file, for QEMU.
    pub fn path(&self) -> &Path {
        self.file.path()
    }

    pub fn ring(&self) -> &Ring {
        let start = self.map[RING_OFFSET..][..size_of::<Ring>()].as_ptr();
        // SAFETY: the map is page aligned and long enough, lives as long as `self`, and `Ring` consists of
        // atomics, for which all bit patterns are valid.
        unsafe { &*start.cast::<Ring>() }
    }
}

fn map(file: &File) -> std::io::Result<MmapMut> {
    // SAFETY: the file keeps its length, because it belongs to this process and QEMU does not resize it.
    // After the rig has started only the atomics of the ring are accessed.
    unsafe { MmapMut::map_mut(file) }
}

/// A directory in memory rather than on disk, if there is one.
fn directory() -> PathBuf {
    let shared_memory = PathBuf::from("/dev/shm");
    if shared_memory.is_dir() { shared_memory } else { std::env::temp_dir() }
}

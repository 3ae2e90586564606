//! The scans of a tape, read as they are played: a tape may be longer than the memory.

use std::fmt;
use std::io::{self, Read, Seek, SeekFrom};

use massline_shared::signal::{CHANNELS, Scan};

/// Length of a scan, bytes.
pub(super) const SCAN: u64 = 2 * CHANNELS as u64;
/// Scans that are read at a time.
const BLOCK: u64 = 4096;

/// A place that bytes are read from.
trait Bytes: Read + Seek + Send {}

impl<T: Read + Seek + Send> Bytes for T {}

/// The scans of a tape.
pub struct Scans {
    bytes: Box<dyn Bytes>,
    /// Offset of the first scan, bytes.
    offset: u64,
    count: u64,
    /// Index of the first scan of the block in memory, and the block.
    first: u64,
    block: Vec<Scan>,
}

impl Scans {
    /// Scans of little-endian codes from this offset on.
    pub(super) fn new(bytes: impl Read + Seek + Send + 'static, offset: u64, count: u64) -> Self {
        Self { bytes: Box::new(bytes), offset, count, first: 0, block: Vec::new() }
    }

    /// Number of scans.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The scan with this index; `None` behind the last.
    ///
    /// # Errors
    /// When the file cannot be read any more.
    pub fn get(&mut self, index: u64) -> io::Result<Option<Scan>> {
        if index >= self.count {
            return Ok(None);
        }
        let last = self.first + self.block.len() as u64;
        if !(self.first..last).contains(&index) {
            self.load(index)?;
        }
        Ok(self.block.get((index - self.first) as usize).copied())
    }

    /// All scans.
    ///
    /// # Errors
    /// When the file cannot be read any more.
    pub fn to_vec(&mut self) -> io::Result<Vec<Scan>> {
        (0..self.count).filter_map(|index| self.get(index).transpose()).collect()
    }

    fn load(&mut self, first: u64) -> io::Result<()> {
        self.block.clear();
        self.bytes.seek(SeekFrom::Start(self.offset + first * SCAN))?;
        let mut bytes = vec![0; ((self.count - first).min(BLOCK) * SCAN) as usize];
        self.bytes.read_exact(&mut bytes)?;
        let scan = |bytes: &[u8]| {
            let mut codes = bytes.as_chunks::<2>().0.iter().map(|code| u16::from_le_bytes(*code));
            std::array::from_fn(|_| codes.next().unwrap_or_default())
        };
        self.block.extend(bytes.chunks_exact(SCAN as usize).map(scan));
        self.first = first;
        Ok(())
    }
}

impl From<Vec<Scan>> for Scans {
    fn from(scans: Vec<Scan>) -> Self {
        let bytes: Vec<u8> = scans.as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect();
        Self::new(io::Cursor::new(bytes), 0, scans.len() as u64)
    }
}

impl fmt::Debug for Scans {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Scans").field("count", &self.count).finish_non_exhaustive()
    }
}

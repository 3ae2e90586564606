//! NumPy's array file, limited to what a tape needs: two dimensions of little-endian u16.

use std::fs::{self, File};
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use massline_shared::signal::{CHANNELS, Scan};
use npyz::{DType, NpyHeader, Order, WriteOptions, WriterBuilder};
use thiserror::Error;

use super::scans::{SCAN, Scans};
use super::{Sidecar, sidecar_path};
use crate::file::{self, Existing};
use crate::npy::{HeaderError, open, shape_text};
use crate::{Error, Result};

/// The data type of a tape.
const TYPE: &str = "<u2";
/// Longest header that is read, bytes: NumPy reads dictionaries of 10 000.
const LONGEST_HEADER: u64 = 1 << 14;

/// Why bytes are not a tape.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub(super) enum NpyError {
    #[error(transparent)]
    Header(#[from] HeaderError),
    #[error(
        "the array's type is {0}; a tape is little-endian u16, '<u2': save \
         array.astype('<u2')"
    )]
    Type(String),
    #[error("the array's shape is {0}; a tape has the shape (scans, {CHANNELS})")]
    Shape(String),
    #[error("the array is in Fortran order; save numpy.ascontiguousarray(array)")]
    Order,
    #[error(
        "the tape is truncated: its header states {wanted} bytes of scans, {found} are there; copy \
         it again"
    )]
    Truncated { wanted: u64, found: u64 },
    #[error("the tape has no scans; record it again")]
    Empty,
    #[error("the scans cannot be read: {0}; copy the tape again")]
    Data(String),
}

impl From<NpyError> for Error {
    fn from(error: NpyError) -> Self {
        let code = match error {
            NpyError::Type(_) => "tape_wrong_type",
            NpyError::Shape(_) | NpyError::Order => "tape_wrong_shape",
            NpyError::Truncated { .. } => "tape_truncated",
            NpyError::Empty => "tape_empty",
            NpyError::Header(_) | NpyError::Data(_) => "tape_malformed",
        };
        Self::input(code, error.to_string())
    }
}

/// The scans of an array file, and whether its recording was cut short, so that the header does not state how many there
/// are.
pub(super) fn scans(
    mut file: impl Read + Seek + Send + 'static,
) -> Result<(Scans, bool), NpyError> {
    let unreadable = |e: io::Error| NpyError::Data(e.to_string());
    let mut head = Vec::new();
    (&mut file).take(LONGEST_HEADER).read_to_end(&mut head).map_err(unreadable)?;
    let (header, rest) = open(&head)?;
    let offset = (head.len() - rest.len()) as u64;
    let length = file.seek(SeekFrom::End(0)).map_err(unreadable)?;
    let found = length.saturating_sub(offset);
    match scans_in(&header)? {
        0 if found < SCAN => Err(NpyError::Empty),
        0 => Ok((Scans::new(file, offset, found / SCAN), true)),
        scans if scans.saturating_mul(SCAN) > found => {
            Err(NpyError::Truncated { wanted: scans.saturating_mul(SCAN), found })
        }
        scans => Ok((Scans::new(file, offset, scans), false)),
    }
}

/// The number of scans of an array.
fn scans_in(header: &NpyHeader) -> Result<u64, NpyError> {
    let descr = header.dtype().descr();
    if descr.trim_matches('\'') != TYPE {
        return Err(NpyError::Type(descr));
    }
    let scans = match *header.shape() {
        [scans, channels] if channels == CHANNELS as u64 => scans,
        _ => return Err(NpyError::Shape(shape_text(header.shape()))),
    };
    if header.order() == Order::Fortran { Err(NpyError::Order) } else { Ok(scans) }
}

/// The header for a number of scans: always 128 bytes, so that it can be rewritten in place.
fn header_bytes(scans: u64) -> io::Result<Vec<u8>> {
    let dtype = DType::new_scalar(TYPE.parse().map_err(io::Error::other)?);
    let header = WriteOptions::new_header_only().dtype(dtype).shape(&[scans, CHANNELS as u64]);
    header.writer(Vec::new()).write_header_only()
}

/// Writes a tape during a recording. Scans are appended, and the sidecar is up to date after each hit, so that a process
/// that is killed leaves a tape that can be replayed: its header, which [`TapeWriter::finish`] completes, states no scans
/// until then. A writer that is dropped earlier completes it in the same way.
///
/// npyz's own writer, which would also complete its header, is not used because it cannot be moved to the
/// recording thread.
#[derive(Debug)]
pub struct TapeWriter {
    path: PathBuf,
    file: BufWriter<File>,
    sidecar: Sidecar,
    scans: u64,
    finished: bool,
}

impl TapeWriter {
    /// Checks that a tape and its sidecar may be written here.
    ///
    /// # Errors
    /// Exit 2 when one of them exists and is kept, the name does not end with `.npy`, or the folder does not exist.
    pub fn check(path: &Path, existing: Existing) -> Result<()> {
        if path.extension().is_none_or(|extension| extension != "npy") {
            return Err(file::cannot(path, "the name of a tape ends with .npy"));
        }
        file::check(path, existing)?;
        let sidecar = sidecar_path(path);
        // Not even with --force: it may be the layout.
        if sidecar.exists() && Sidecar::read(&sidecar).is_err() {
            return Err(file::cannot(
                path,
                format!(
                    "its sidecar would be {}, which is another file; give another name",
                    sidecar.display()
                ),
            ));
        }
        file::check(&sidecar, existing)
    }

    /// Creates a tape; `sidecar` may already hold segments.
    ///
    /// # Errors
    /// As [`TapeWriter::check`], and exit 2 when a file cannot be written; then there is neither.
    pub fn create(path: &Path, sidecar: Sidecar, existing: Existing) -> Result<Self> {
        Self::check(path, existing)?;
        let text = sidecar.to_toml();
        file::write(&sidecar_path(path), text.as_bytes(), existing)?;
        let created = File::create(path).map_err(|e| file::cannot(path, e));
        let opened = created.and_then(|file| {
            let file = BufWriter::new(file);
            let path = path.to_owned();
            let mut writer = Self { path, file, sidecar, scans: 0, finished: true };
            writer.write_header().map_err(|e| file::cannot(&writer.path, e))?;
            writer.finished = false;
            Ok(writer)
        });
        if opened.is_err() {
            // They would be in the way of the next attempt.
            let _ = (fs::remove_file(path), fs::remove_file(sidecar_path(path)));
        }
        opened
    }

    /// Appends scans.
    ///
    /// # Errors
    /// Exit 2 when the file cannot be written; the tape keeps the scans so far.
    pub fn push(&mut self, scans: &[Scan]) -> Result<()> {
        for code in scans.as_flattened() {
            self.file.write_all(&code.to_le_bytes()).map_err(|e| file::cannot(&self.path, e))?;
        }
        self.scans += scans.len() as u64;
        Ok(())
    }

    /// Number of scans written so far, which is the index of the next.
    pub fn scans(&self) -> u64 {
        self.scans
    }

    /// Records the segment of a hit.
    ///
    /// # Errors
    /// Exit 2 when the sidecar cannot be written.
    pub fn segment(&mut self, segment: super::Segment) -> Result<()> {
        self.sidecar.segments.push(segment);
        self.write_sidecar()
    }

    /// Replaces all segments.
    ///
    /// # Errors
    /// Exit 2 when the sidecar cannot be written.
    pub fn set_segments(&mut self, segments: &[super::Segment]) -> Result<()> {
        self.sidecar.segments = segments.to_vec();
        self.write_sidecar()
    }

    /// Completes the tape; returns its number of scans.
    ///
    /// # Errors
    /// Exit 2 when a file cannot be written.
    pub fn finish(mut self) -> Result<u64> {
        self.complete()?;
        Ok(self.scans)
    }

    fn complete(&mut self) -> Result<()> {
        self.finished = true;
        self.write_header().map_err(|e| file::cannot(&self.path, e))?;
        self.write_sidecar()
    }

    fn write_sidecar(&self) -> Result<()> {
        let text = self.sidecar.to_toml();
        file::write(&sidecar_path(&self.path), text.as_bytes(), Existing::Replaced)
    }

    /// Writes the header for the scans so far and moves to its end.
    fn write_header(&mut self) -> io::Result<()> {
        self.file.seek(SeekFrom::Start(0))?;
        self.file.write_all(&header_bytes(self.scans)?)?;
        self.file.flush()
    }
}

impl Drop for TapeWriter {
    fn drop(&mut self) {
        if !self.finished {
            // A drop cannot report an error.
            let _ = self.complete();
        }
    }
}

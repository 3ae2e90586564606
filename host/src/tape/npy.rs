//! NumPy's array file, limited to what a tape needs: two dimensions of little-endian u16.

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use massline_shared::signal::{CHANNELS, Scan};
use npyz::{DType, NpyFile, NpyHeader, NpyReader, Order, WriteOptions, WriterBuilder};
use thiserror::Error;

use super::{Sidecar, sidecar_path};
use crate::npy::{HeaderError, open, shape_text};
use crate::{Error, Result};

/// The data type of a tape.
const TYPE: &str = "<u2";
/// Length of a scan, bytes.
const SCAN: u64 = 2 * CHANNELS as u64;

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
    #[error("the scans cannot be read: {0}; copy the tape again")]
    Data(String),
}

impl From<NpyError> for Error {
    fn from(error: NpyError) -> Self {
        let code = match error {
            NpyError::Type(_) => "tape_wrong_type",
            NpyError::Shape(_) | NpyError::Order => "tape_wrong_shape",
            NpyError::Truncated { .. } => "tape_truncated",
            NpyError::Header(_) | NpyError::Data(_) => "tape_malformed",
        };
        Self::input(code, error.to_string())
    }
}

/// Reads the scans of an array file.
pub(super) fn scans(bytes: &[u8]) -> Result<Vec<Scan>, NpyError> {
    let (header, data) = open(bytes)?;
    let scans = scans_in(&header)?;
    let (wanted, found) = (scans.saturating_mul(SCAN), data.len() as u64);
    if wanted > found {
        return Err(NpyError::Truncated { wanted, found });
    }
    let unreadable = |e: &dyn std::fmt::Display| NpyError::Data(e.to_string());
    let codes = NpyFile::with_header(header, data).data().map_err(|e| unreadable(&e))?;
    scans_of(codes).map_err(|e| unreadable(&e))
}

/// Groups the codes into scans of ten, as the shape states.
fn scans_of(mut codes: NpyReader<u16, &[u8]>) -> io::Result<Vec<Scan>> {
    let mut scans = Vec::with_capacity(codes.len() as usize / CHANNELS);
    while codes.len() > 0 {
        let mut scan = [0; CHANNELS];
        for (to, code) in scan.iter_mut().zip(&mut codes) {
            *to = code?;
        }
        scans.push(scan);
    }
    Ok(scans)
}

/// The number of scans of an array.
fn scans_in(header: &NpyHeader) -> Result<u64, NpyError> {
    let descr = header.dtype().descr();
    if descr.trim_matches('\'') != TYPE {
        return Err(NpyError::Type(descr));
    }
    let scans = match *header.shape() {
        [scans, channels] if channels == CHANNELS as u64 && scans > 0 => scans,
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

/// Writes a tape during a recording. Scans are appended; [`TapeWriter::finish`] completes the header and
/// writes the sidecar. A writer that is dropped earlier saves the scans so far in the same way.
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
    /// Checks that a tape may be written here: an earlier tape may be replaced, any other file may not.
    ///
    /// # Errors
    /// Exit 2 when the tape or its sidecar would replace another file, or the folder does not exist.
    pub fn check(path: &Path) -> Result<()> {
        let refuse = |message: String| Err(Error::input("tape_not_writable", message));
        let sidecar = sidecar_path(path);
        if sidecar == path {
            return refuse(format!("{}: a tape's name ends with .npy", path.display()));
        }
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        if folder.is_some_and(|folder| !folder.is_dir()) {
            return refuse(format!("{}: there is no such folder", path.display()));
        }
        if sidecar.exists() && Sidecar::read(&sidecar).is_err() {
            return refuse(format!(
                "{} would become the sidecar of {} but is another file; give the tape another name",
                sidecar.display(),
                path.display(),
            ));
        }
        if path.exists() && !sidecar.exists() {
            return refuse(format!(
                "{} is there already and no tape of this program; give the tape another name",
                path.display(),
            ));
        }
        Ok(())
    }

    /// Creates a tape; `sidecar` may already hold segments.
    ///
    /// # Errors
    /// As [`TapeWriter::check`], and exit 2 when the file cannot be written.
    pub fn create(path: &Path, sidecar: Sidecar) -> Result<Self> {
        Self::check(path)?;
        let file = File::create(path).map_err(|e| not_writable(path, &e))?;
        let mut writer = Self {
            path: path.to_owned(),
            file: BufWriter::new(file),
            sidecar,
            scans: 0,
            finished: false,
        };
        writer.write_header().map_err(|e| not_writable(path, &e))?;
        Ok(writer)
    }

    /// Appends scans.
    ///
    /// # Errors
    /// Exit 2 when the file cannot be written.
    pub fn push(&mut self, scans: &[Scan]) -> Result<()> {
        for code in scans.as_flattened() {
            self.file.write_all(&code.to_le_bytes()).map_err(|e| not_writable(&self.path, &e))?;
        }
        self.scans += scans.len() as u64;
        Ok(())
    }

    /// Number of scans written so far, which is the index of the next.
    pub fn scans(&self) -> u64 {
        self.scans
    }

    /// Records the segment of a hit.
    pub fn segment(&mut self, segment: super::Segment) {
        self.sidecar.segments.push(segment);
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
        self.write_header().map_err(|e| not_writable(&self.path, &e))?;
        let sidecar = sidecar_path(&self.path);
        std::fs::write(&sidecar, self.sidecar.to_toml()).map_err(|e| not_writable(&sidecar, &e))
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

fn not_writable(path: &Path, error: &io::Error) -> Error {
    Error::input("tape_not_writable", format!("{}: cannot be written: {error}", path.display()))
}

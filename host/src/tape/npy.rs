//! NumPy's array file, as far as a tape needs it: two dimensions of little-endian u16.

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use massline_shared::signal::{CHANNELS, Scan};
use thiserror::Error;

use super::{Sidecar, sidecar_path};
use crate::npy::{Header, HeaderError, MAGIC};
use crate::{Error, Result};

/// Bytes before the data in a file that this program writes.
const HEADER: usize = 128;
/// Bytes of a scan.
const SCAN: usize = 2 * CHANNELS;

/// Why bytes are no tape.
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
        "the tape is truncated: its header tells {wanted} bytes of scans, {found} are there; copy \
         it again"
    )]
    Truncated { wanted: u64, found: u64 },
}

impl From<NpyError> for Error {
    fn from(error: NpyError) -> Self {
        let code = match error {
            NpyError::Type(_) => "tape_wrong_type",
            NpyError::Shape(_) | NpyError::Order => "tape_wrong_shape",
            NpyError::Truncated { .. } => "tape_truncated",
            _ => "tape_malformed",
        };
        Self::input(code, error.to_string())
    }
}

/// Reads the scans of an array file.
pub(super) fn scans(bytes: &[u8]) -> Result<Vec<Scan>, NpyError> {
    let (header, data) = Header::read(bytes)?;
    let wanted = scans_in(&header)?;
    let data = wanted
        .checked_mul(SCAN as u64)
        .and_then(|length| usize::try_from(length).ok())
        .and_then(|length| data.get(..length))
        .ok_or(NpyError::Truncated {
            wanted: wanted.saturating_mul(SCAN as u64),
            found: data.len() as u64,
        })?;
    let scan = |bytes: &[u8]| {
        let mut scan = [0; CHANNELS];
        for (code, pair) in scan.iter_mut().zip(bytes.chunks_exact(2)) {
            *code = u16::from_le_bytes([pair[0], pair[1]]);
        }
        scan
    };
    Ok(data.chunks_exact(SCAN).map(scan).collect())
}

/// The number of scans of an array.
fn scans_in(header: &Header) -> Result<u64, NpyError> {
    if header.descr != "<u2" {
        return Err(NpyError::Type(header.descr.clone()));
    }
    let scans = match header.sizes().as_deref() {
        Some(&[scans, channels]) if channels == CHANNELS as u64 && scans > 0 => scans,
        _ => return Err(NpyError::Shape(header.shape.clone())),
    };
    if header.fortran_order { Err(NpyError::Order) } else { Ok(scans) }
}

/// The header for a number of scans, [`HEADER`] bytes.
fn header_bytes(scans: u64) -> Vec<u8> {
    let dictionary =
        format!("{{'descr': '<u2', 'fortran_order': False, 'shape': ({scans}, {CHANNELS}), }}");
    let length = HEADER - MAGIC.len() - 4;
    let mut bytes = MAGIC.to_vec();
    bytes.extend([1, 0]);
    bytes.extend((length as u16).to_le_bytes());
    bytes.extend(format!("{dictionary:width$}\n", width = length - 1).as_bytes());
    bytes
}

/// Writes a tape while it is recorded. Scans are appended; [`TapeWriter::finish`] completes the
/// header and writes the sidecar. Dropped before, the scans so far are kept in the same way.
#[derive(Debug)]
pub struct TapeWriter {
    path: PathBuf,
    file: BufWriter<File>,
    sidecar: Sidecar,
    scans: u64,
    finished: bool,
}

impl TapeWriter {
    /// Whether a tape may be written here: an earlier tape is replaced, nothing else is.
    ///
    /// # Errors
    /// Exit 2 when the tape or its sidecar would replace another file, or there is no such folder.
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

    /// Begins a tape; `sidecar` may hold segments already.
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
        writer.file.write_all(&header_bytes(0)).map_err(|e| not_writable(path, &e))?;
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

    /// Scans written so far: the index of the next.
    pub fn scans(&self) -> u64 {
        self.scans
    }

    /// Notes where a DOF is hit.
    pub fn segment(&mut self, segment: super::Segment) {
        self.sidecar.segments.push(segment);
    }

    /// Completes the tape; gives its number of scans.
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

    fn write_header(&mut self) -> io::Result<()> {
        self.file.seek(SeekFrom::Start(0))?;
        self.file.write_all(&header_bytes(self.scans))?;
        self.file.flush()
    }
}

impl Drop for TapeWriter {
    fn drop(&mut self) {
        if !self.finished {
            // What a dropped writer cannot save it has nobody to tell.
            let _ = self.complete();
        }
    }
}

fn not_writable(path: &Path, error: &io::Error) -> Error {
    Error::input("tape_not_writable", format!("{}: cannot be written: {error}", path.display()))
}

//! NumPy's array file, limited to what a tape needs: two dimensions of little-endian u16.

use std::io::{self, Read, Seek, SeekFrom};

use massline_shared::signal::CHANNELS;
use thiserror::Error;

use super::scans::{SCAN, Scans};
use crate::npy::{Header, HeaderError, open, shape_text};
use massline_result::Error;

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
        "the tape is truncated: its header states {wanted} bytes of scans, {available} are there; copy \
         it again"
    )]
    Truncated { wanted: u64, available: u64 },
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

/// The scans of an array file, and whether its recording was cut short, so that the header does not state how many
/// there are.
pub(super) fn scans(
    mut file: impl Read + Seek + Send + 'static,
) -> Result<(Scans, bool), NpyError> {
    let unreadable = |e: io::Error| NpyError::Data(e.to_string());
    let mut head = Vec::new();
    (&mut file).take(LONGEST_HEADER).read_to_end(&mut head).map_err(unreadable)?;
    let (header, rest) = open(&head)?;
    let offset = (head.len() - rest.len()) as u64;
    let length = file.seek(SeekFrom::End(0)).map_err(unreadable)?;
    let available = length.saturating_sub(offset);
    match scans_in(&header)? {
        0 if available < SCAN => Err(NpyError::Empty),
        0 => Ok((Scans::new(file, offset, available / SCAN), true)),
        scans if scans.saturating_mul(SCAN) > available => {
            Err(NpyError::Truncated { wanted: scans.saturating_mul(SCAN), available })
        }
        scans => Ok((Scans::new(file, offset, scans), false)),
    }
}

/// The number of scans of an array.
fn scans_in(header: &Header) -> Result<u64, NpyError> {
    if header.descr != TYPE {
        return Err(NpyError::Type(header.type_text()));
    }
    let scans = match *header.shape {
        [scans, channels] if channels == CHANNELS as u64 => scans,
        _ => return Err(NpyError::Shape(shape_text(&header.shape))),
    };
    if header.fortran_order { Err(NpyError::Order) } else { Ok(scans) }
}

/// The header for a number of scans: always 128 bytes, so that it can be rewritten in place.
pub(super) fn header_bytes(scans: u64) -> Vec<u8> {
    let shape = vec![scans, CHANNELS as u64];
    Header { descr: TYPE.into(), fortran_order: false, shape }.to_bytes()
}

//! Recorded scans: a NumPy file of raw ADC codes with a sidecar TOML of the same name.
//!
//! `NAME.npy` is little-endian u16, shape (scans, 10), C order: the hammer, then sensor 1 x, y, z, sensor 2
//! …; `NAME.toml` states how the scans were recorded and at which scans each DOF was hit. A replay plays the
//! segments of the DOF that the rig is armed at.

mod npy;
mod scans;
mod sidecar;
mod writer;

use std::io::Cursor;
use std::path::{Path, PathBuf};

use massline_shared::layout::Dof;
use massline_shared::signal::{AdcProperties, Calibration, PRE_TRIGGER_SCANS, RECORD_SCANS};

use massline_result::{Error, Result};

pub use scans::Scans;
pub use writer::TapeWriter;

/// The contents of a tape's sidecar.
#[derive(Clone, Debug, PartialEq)]
pub struct Sidecar {
    /// Sampling rate, resolution, delay, and the channels in use.
    pub adc: AdcProperties,
    /// Zeros and sensitivities of the recorded measuring chain.
    pub calibration: Calibration,
    /// Scans of a record before its trigger.
    pub pre_trigger_scans: u32,
    /// Hash of the layout in use during the recording.
    pub layout_hash: u32,
    /// The segments and the DOF of each.
    pub segments: Vec<Segment>,
}

/// A part of a tape that holds one hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Segment {
    /// Its first scan.
    pub start: u64,
    /// The DOF that was hit.
    pub dof: Dof,
}

/// A whole tape.
#[derive(Debug)]
pub struct Tape {
    /// The sidecar.
    pub sidecar: Sidecar,
    /// Raw ADC codes.
    pub scans: Scans,
    /// The recording was cut short: the scans are those before that, and segments whose hit they do not wholly have
    /// are left out.
    pub cut_short: bool,
}

impl Tape {
    /// Opens a tape and reads its sidecar; the scans are read as they are played.
    ///
    /// # Errors
    /// Exit 2 when a file is missing, the array has another type or shape or is truncated, or the sidecar
    /// does not match the array.
    pub fn read(path: &Path) -> Result<Self> {
        let file = path.display().to_string();
        let opened = crate::file::open(path).map_err(|error| {
            Error::input("tape_not_readable", crate::file::unreadable(path, &error))
        })?;
        let (scans, cut_short) = npy::scans(opened).map_err(|e| Error::from(e).within(&file))?;
        let mut sidecar = Sidecar::read(&sidecar_path(path))?;
        let length = scans.count();
        if cut_short {
            sidecar.segments.retain(|segment| has_whole_hit(*segment, length));
        }
        if let Some(segment) = sidecar.segments.iter().find(|s| s.start >= length) {
            let message = format!(
                "{}: the segment of {} starts at scan {}, and the tape has {length}; the two files \
                 do not belong together",
                sidecar_path(path).display(),
                segment.dof,
                segment.start
            );
            return Err(Error::input("sidecar_malformed", message));
        }
        Ok(Self { sidecar, scans, cut_short })
    }
}

/// Reads the scans of a NumPy array file.
///
/// # Errors
/// Exit 2 when the bytes are not an array of little-endian u16 of shape (scans, 10) in C order, or are
/// truncated.
pub fn scans_of_npy(bytes: Vec<u8>) -> Result<Scans> {
    Ok(npy::scans(Cursor::new(bytes))?.0)
}

/// The sidecar of a tape: the same name with `.toml`.
pub fn sidecar_path(tape: &Path) -> PathBuf {
    tape.with_extension("toml")
}

/// Scans that a recorded segment has before its record, at least.
pub const LEAD_IN_SCANS: usize = PRE_TRIGGER_SCANS / 2;

/// Whether a tape of this many scans has a whole record in a segment that a recording wrote.
fn has_whole_hit(segment: Segment, scans: u64) -> bool {
    segment.start.saturating_add((LEAD_IN_SCANS + RECORD_SCANS) as u64) <= scans
}

#[cfg(test)]
mod tests;

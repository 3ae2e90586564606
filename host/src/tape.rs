//! Recorded scans: a NumPy file of raw ADC codes with a sidecar TOML of the same name.
//!
//! `NAME.npy` is little-endian u16, shape (scans, 10), C order: the hammer, then sensor 1 x, y, z,
//! sensor 2 …; `NAME.toml` says how they were taken and where in them which DOF was hit. A replay
//! plays the segments of the DOF that the rig asks for ([`TapeSource`]).

mod npy;
mod play;
mod sidecar;

use std::path::{Path, PathBuf};

use massline_shared::layout::Dof;
use massline_shared::signal::{AdcProperties, CHANNELS, Calibration, Scan};

use crate::{Error, Result};

pub use npy::TapeWriter;
pub use play::{TapeProgress, TapeSource};

/// Longest tape that is read, bytes: about seven hours at 4 kS/s.
pub const MAX_BYTES: u64 = 1 << 31;

/// What a tape's sidecar says.
#[derive(Clone, Debug, PartialEq)]
pub struct Sidecar {
    /// Rate, resolution, delay, and the channels that are in use.
    pub adc: AdcProperties,
    /// Zeros and sensitivities of the chain that was recorded.
    pub calibration: Calibration,
    /// Scans of a record before its trigger.
    pub pre_trigger_scans: u32,
    /// Hash of the layout that was measured.
    pub layout_hash: u32,
    /// Where which DOF was hit.
    pub segments: Vec<Segment>,
}

/// A stretch of a tape that holds one hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Segment {
    /// Its first scan.
    pub start: u64,
    /// The DOF that was hit.
    pub dof: Dof,
}

/// A whole tape.
#[derive(Clone, Debug, PartialEq)]
pub struct Tape {
    /// How it was taken.
    pub sidecar: Sidecar,
    /// Raw codes.
    pub scans: Vec<Scan>,
}

impl Tape {
    /// Reads a tape and its sidecar.
    ///
    /// # Errors
    /// Exit 2 when a file is missing, the array has another type or shape, is truncated, or the
    /// sidecar does not fit it.
    pub fn read(path: &Path) -> Result<Self> {
        let file = path.display().to_string();
        let bytes = crate::bounded::read(path, MAX_BYTES).map_err(|error| {
            let message = format!("{file}: the tape cannot be read: {error}; check the path");
            Error::input("tape_not_readable", message)
        })?;
        let scans = npy::scans(&bytes).map_err(|e| Error::from(e).within(&file))?;
        let sidecar = Sidecar::read(&sidecar_path(path))?;
        let length = scans.len() as u64;
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
        Ok(Self { sidecar, scans })
    }
}

/// Reads the scans of an array as NumPy stores it.
///
/// # Errors
/// Exit 2 when the bytes are no array of little-endian u16 of shape (scans, 10) in C order, or end
/// too soon.
pub fn scans_of_npy(bytes: &[u8]) -> Result<Vec<Scan>> {
    Ok(npy::scans(bytes)?)
}

/// The sidecar of a tape: the same name with `.toml`.
pub fn sidecar_path(tape: &Path) -> PathBuf {
    tape.with_extension("toml")
}

/// Sensors whose three channels are in use.
fn sensors(adc: &AdcProperties) -> usize {
    usize::from(adc.channels).min(CHANNELS).saturating_sub(1) / 3
}

#[cfg(test)]
mod tests;

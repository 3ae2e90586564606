//! Recorded scans: a NumPy file of raw ADC codes with a sidecar TOML of the same name.
//!
//! `NAME.npy` is little-endian u16, shape (scans, 10), C order: the hammer, then sensor 1 x, y, z, sensor 2
//! …; `NAME.toml` states how the scans were recorded and at which scans each DOF was hit. A replay plays the
//! segments of the DOF that the rig is armed at ([`TapeSource`]).

mod npy;
mod play;
mod sidecar;

use std::path::{Path, PathBuf};

use massline_shared::layout::Dof;
use massline_shared::signal::{AdcProperties, CHANNELS, Calibration, Scan};

use crate::{Error, Result};

pub use npy::TapeWriter;
pub use play::{TapeProgress, TapeSource};

/// Largest tape that is read, bytes: about seven hours at 4 kS/s.
pub const MAX_BYTES: u64 = 1 << 31;

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
#[derive(Clone, Debug, PartialEq)]
pub struct Tape {
    /// The sidecar.
    pub sidecar: Sidecar,
    /// Raw ADC codes.
    pub scans: Vec<Scan>,
}

impl Tape {
    /// Reads a tape and its sidecar.
    ///
    /// # Errors
    /// Exit 2 when a file is missing, the array has another type or shape or is truncated, or the sidecar
    /// does not match the array.
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

/// Reads the scans of a NumPy array file.
///
/// # Errors
/// Exit 2 when the bytes are not an array of little-endian u16 of shape (scans, 10) in C order, or are
/// truncated.
pub fn scans_of_npy(bytes: &[u8]) -> Result<Vec<Scan>> {
    Ok(npy::scans(bytes)?)
}

/// The sidecar of a tape: the same name with `.toml`.
pub fn sidecar_path(tape: &Path) -> PathBuf {
    tape.with_extension("toml")
}

/// Number of sensors whose three channels are all in use.
fn sensors(adc: &AdcProperties) -> usize {
    usize::from(adc.channels).min(CHANNELS).saturating_sub(1) / 3
}

#[cfg(test)]
mod tests;

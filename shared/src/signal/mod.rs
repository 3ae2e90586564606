//! From ADC codes to frequency responses.
//!
//! ```text
//! scans ─▶ trigger ─▶ record ─▶ grade ─▶ window ─▶ FFT ─▶ spectra averaged over hits ─▶ H1, coherence
//! ```
//! A *scan* is one reading of every channel: the hammer first, then sensor 1 x, y, z, sensor 2 x, …
//! Channel `k` is read `k·τ` after the hammer. A *record* is a fixed number of scans about one hit,
//! the first of them before the hammer touched.

mod chain;
mod fft;
mod grade;
mod record;
mod spectra;
mod trigger;
mod window;

pub use chain::{AdcProperties, Calibration, ChannelCalibration};

/// Channels of the rig: the hammer and three triaxial sensors.
pub const CHANNELS: usize = 10;
/// Response channels of the rig.
pub const RESPONSES: usize = CHANNELS - 1;

/// One reading of every channel, raw ADC codes: hammer, sensor 1 x, y, z, sensor 2 x, …
pub type Scan = [u16; CHANNELS];

/// Scans of a record.
pub const RECORD_SCANS: usize = 2048;
/// Scans of a record before the trigger.
pub const PRE_TRIGGER_SCANS: usize = 80;
/// Lines of the averaged spectra that the rig keeps, the first at 0 Hz.
pub const SPECTRUM_LINES: usize = 128;

//! From ADC codes to frequency responses.
//!
//! ```text
//! scans ─▶ trigger ─▶ record ─▶ grade ─▶ window ─▶ FFT ─▶ spectra averaged over hits ─▶ H1, coherence
//! ```
//! A *scan* is one reading of every channel: the hammer first, then sensor 1 x, y, z, sensor 2 x, … Channel
//! `k` is sampled `k·τ` after the hammer. A *record* is a fixed number of scans around one hit; the first of
//! them are from before the contact.
//!
//! A *long record*, of the suspension profile, has the force at the full rate and decimated *rows* of responses
//! (`decimator`, `long_capture`, `grade/long`, `long_record`).

mod analysis;
mod bins;
mod chain;
mod compact_lines;
mod decimator;
mod fft;
mod grade;
mod hit_noise;
mod hum;
mod long_capture;
mod long_record;
mod record;
mod repeat_hits;
mod rest_statistics;
mod samples;
pub mod self_test;
mod spectra;
mod trigger;
pub mod window;

pub use analysis::{HitAnalysis, divide_by_force};
pub use bins::{resolution, ringing_s, transform_of};
pub use chain::{AdcProperties, Calibration, ChannelCalibration, CrossAxis, HAMMER};
pub use compact_lines::{COMPACT_RESPONSE, CompactLines, CompactLinesError, expand_response};
pub use decimator::{Decimator, Row, SETTLING_ROWS, transfer};
pub use fft::{FftError, RealFft};
pub use grade::{ChannelRange, HitGrader, HitReport, Swing, grade, grade_long};
pub use hit_noise::HitNoise;
pub use hum::{Hum, HumFit, HumSearch};
pub use long_capture::{FullRateExtremes, LongCapture};
pub use long_record::LongRecordAnalysis;
pub use record::Record;
pub use repeat_hits::{ELSEWHERE, HitAgreement, KnownScatter, RepeatHits};
pub use rest_statistics::RestStatistics;
pub use samples::{Samples, Signal};
pub use spectra::{Spectra, bins_of_band};
pub use trigger::{Capture, CaptureState, EdgeTrigger, Trigger};

/// Number of channels of the rig: the hammer and three triaxial sensors.
pub const CHANNELS: usize = 10;
/// Number of response channels of the rig.
pub const RESPONSES: usize = CHANNELS - 1;

/// One reading of every channel in raw ADC codes: hammer, sensor 1 x, y, z, sensor 2 x, …
pub type Scan = [u16; CHANNELS];

/// Number of scans in a record.
pub const RECORD_SCANS: usize = 2048;
/// Number of scans in a record before the trigger.
pub const PRE_TRIGGER_SCANS: usize = 80;
/// Scans in a row of responses of a long record.
pub const DECIMATION: usize = 80;
/// Resolution of the codes of a long record, bits.
pub const ROW_BITS: u8 = 16;
/// Points of the transform of a long record's responses; the bins of a longer one in between are left out.
pub const LONG_POINTS: usize = 512;
/// Number of bins in the averaged spectra of the rig, the first at 0 Hz.
pub const SPECTRUM_BINS: usize = 128;

#[cfg(test)]
pub(crate) mod tests {
    use super::{AdcProperties, Calibration};
    use crate::units::{Hertz, Seconds, Volts};

    /// Properties of the rig's converter.
    pub const ADC: AdcProperties = AdcProperties {
        rate: Hertz(4000.0),
        channels: 10,
        bits: 12,
        reference: Volts(3.0),
        channel_delay: Seconds(10e-6),
    };

    /// The code of a force with the nominal calibration.
    pub fn hammer_code(newtons: f32) -> u16 {
        code(0, newtons)
    }

    /// The code of a force or an acceleration with the nominal calibration, clipped by the ADC.
    pub fn code(channel: usize, value: f32) -> u16 {
        let calibration = Calibration::default();
        let rest = calibration.channels[channel].zero.0 / ADC.volts_per_code();
        (rest + value / calibration.per_code(&ADC, channel)).round().clamp(0.0, 4095.0) as u16
    }
}

//! Calibrations: as a rig keeps them, as found by tumble and block tests, and as checked.

use serde::{Deserialize, Serialize};

use super::{Electronics, Memory};
use massline_result::Verdict;
use massline_result::{CalibrationSigma, Finding};

/// A calibration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Calibration {
    /// How it was made.
    pub method: String,
    /// Its day, `yyyy-mm-dd`; empty when it is not known.
    pub date: String,
    /// Temperature during the calibration.
    pub temperature_c: Option<f64>,
    /// Its standard deviations.
    pub sigma: CalibrationSigma,
    /// The hammer.
    pub hammer: HammerCalibration,
    /// The sensors, in the order of the inputs.
    pub sensors: Vec<SensorCalibration>,
}

/// The calibration of the hammer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct HammerCalibration {
    /// Its name or serial number, may be empty.
    pub id: String,
    /// Voltage at rest.
    pub zero_v: f64,
    /// Its sensitivity.
    pub sensitivity_v_per_n: f64,
    /// Cutoff of its RC low-pass; 0 when it is not known.
    pub rc_cutoff_hz: f64,
}

/// The calibration of a sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SensorCalibration {
    /// Its name or serial number, may be empty.
    pub id: String,
    /// Voltages of its axes without acceleration.
    pub zero_v: [f64; 3],
    /// Its sensitivities, row by row: volts of axis x, y, z for accelerations along x, y, z.
    pub sensitivity_v_per_m_per_s2: [[f64; 3]; 3],
    /// Cutoffs of the RC low-passes of its axes; 0 where one is not known.
    pub rc_cutoff_hz: [f64; 3],
}

/// A calibration after a tumble test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TumbleCalibration {
    /// Whether the calibration can be used.
    pub verdict: Verdict,
    /// The calibration.
    #[serde(flatten)]
    pub calibration: Calibration,
    /// What the test has found.
    pub tumble: Tumble,
    /// Whether the rig keeps the calibration now; `false` after a dry run.
    pub stored: bool,
}

/// What a tumble test has found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Tumble {
    /// The sensors.
    pub sensors: Vec<TumbledSensor>,
    /// Mains hum that was taken out of the readings.
    pub hum: Vec<Hum>,
    /// What the hammer's channel keeps of the one before it; `null` where the readings do not show it.
    pub memory: Option<Memory>,
}

/// A sensor in a tumble test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TumbledSensor {
    /// Voltages of its axes without acceleration.
    pub zero_v: [f64; 3],
    /// Their standard deviations.
    pub zero_sigma_v: [f64; 3],
    /// Its sensitivities, row by row.
    pub sensitivity_v_per_m_per_s2: [[f64; 3]; 3],
    /// Their standard deviations.
    pub sensitivity_sigma_v_per_m_per_s2: [[f64; 3]; 3],
    /// Root mean square of the tilt of its positions.
    pub tilt_rad: f64,
}

/// Mains hum in the reading of a position.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Hum {
    /// The position.
    pub position: String,
    /// Its frequency.
    pub frequency_hz: f64,
    /// Name of the channel with the largest amplitude.
    pub loudest: String,
    /// Amplitude in every channel, the hammer first.
    pub amplitude_v: [f64; 10],
}

/// A calibration after a block test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BlockCalibration {
    /// Whether the calibration can be used.
    pub verdict: Verdict,
    /// The calibration.
    #[serde(flatten)]
    pub calibration: Calibration,
    /// What the test has found.
    pub block: Block,
    /// Whether the rig keeps the calibration now; `false` after a dry run.
    pub stored: bool,
}

/// What a block test has found, relative to the calibration before it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Block {
    /// The sensors against the hammer.
    pub sensors: Vec<SensorRatio>,
    /// The hammer against the sensors; `null` where no tumble test was done before.
    pub hammer: Option<HammerRatio>,
    /// The RC low-passes of the sensors.
    pub rc_cutoffs: Vec<RcCutoff>,
    /// What the hits show of multiplexer and converter.
    pub electronics: Electronics,
    /// The rig's warnings about the hits.
    pub diagnostics: Vec<Finding>,
}

/// Responses of a sensor over those that the hammer lets expect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SensorRatio {
    /// The ratios, row by row: the unit matrix for a sensor that has not changed.
    pub ratio: [[f64; 3]; 3],
    /// Their standard deviations.
    pub sigma: [[f64; 3]; 3],
}

/// The true force over that of the calibration before.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct HammerRatio {
    /// The ratio.
    pub ratio: f64,
    /// Its standard deviation.
    pub sigma: f64,
    /// Largest departure of a direction from it, relative.
    pub largest_departure: f64,
    /// Whether the directions agree.
    pub consistent: bool,
}

/// The RC low-pass of a sensor axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RcCutoff {
    /// The sensor, from 1.
    pub sensor: usize,
    /// Its axis.
    pub axis: char,
    /// The cutoff; `null` where it was not found.
    pub cutoff_hz: Option<f64>,
    /// Its standard deviation.
    pub sigma_hz: Option<f64>,
    /// The cutoff in force before; 0 when it was not known.
    pub before_hz: f64,
    /// What happens to the cutoff in force.
    pub verdict: String,
    /// Stable name of the reason why it was not found.
    pub reason: Option<String>,
}

/// A check of a calibration by a block test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CalibrationCheck {
    /// Whether the calibration can be used.
    pub verdict: Verdict,
    /// The sensors.
    pub sensors: Vec<SensorCheck>,
    /// Their axes.
    pub channels: Vec<AxisDrift>,
    /// Day of the calibration, `yyyy-mm-dd`; empty when it is not known.
    pub calibrated: String,
    /// What the hits show of multiplexer and converter.
    pub electronics: Electronics,
    /// The rig's warnings about the hits.
    pub diagnostics: Vec<Finding>,
}

/// The verdict on a sensor: that of its worst axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SensorCheck {
    /// The sensor, from 1.
    pub sensor: usize,
    /// `pass`, `fail` or `unclear`.
    pub outcome: String,
    /// The largest drift of its axes, relative.
    pub largest_drift: f64,
    /// The largest drift that passes, relative.
    pub limit: f64,
}

/// The drift of a sensor axis against the hammer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct AxisDrift {
    /// The sensor, from 1.
    pub sensor: usize,
    /// Its axis.
    pub axis: char,
    /// The response over that which the hammer lets expect, minus one.
    pub drift: f64,
    /// Its standard deviation.
    pub sigma: f64,
    /// `good`, `unclear` or `drifted`.
    pub verdict: String,
}

/// A calibration on the simulated bench, and what it improves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CalibrationDemo {
    /// The calibration.
    pub calibration: Calibration,
    /// Its largest errors against the bench.
    pub largest_error_percent: CalibrationErrors,
    /// The tests of `massline demo` with the data sheets and with the calibration.
    pub tests: Vec<CalibratedTest>,
}

/// Largest errors of a calibration, in % of the sensitivity of their channel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CalibrationErrors {
    /// Of the sensitivities of the axes.
    pub gain: f64,
    /// Of the cross-axis sensitivities.
    pub cross_axis: f64,
    /// Of the hammer's sensitivity.
    pub hammer: f64,
}

/// A test before and after a calibration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CalibratedTest {
    /// Name of the test.
    pub name: String,
    /// Root mean square error of the ten properties.
    pub rms_error_percent_of_scale: BeforeAndAfter,
}

/// Errors before and after a calibration, in % of m, L, L, L and m L² (six times).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BeforeAndAfter {
    /// With the data sheets.
    pub data_sheet: f64,
    /// With the calibration.
    pub calibrated: f64,
}

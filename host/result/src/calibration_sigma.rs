//! What a calibration contributes to the error budget.

use massline_shared::calibration;
use serde::{Deserialize, Serialize};

/// Standard deviations of a calibration, relative to the sensitivities.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CalibrationSigma {
    /// Of the sensitivity of an axis.
    pub gain: f64,
    /// Of a cross-axis sensitivity.
    pub cross_axis: f64,
    /// Of the hammer's sensitivity.
    pub hammer_gain: f64,
}

impl From<calibration::CalibrationSigma> for CalibrationSigma {
    fn from(deviations: calibration::CalibrationSigma) -> Self {
        let [gain, cross_axis, hammer_gain] =
            [deviations.gain, deviations.cross_axis, deviations.hammer_gain].map(f64::from);
        Self { gain, cross_axis, hammer_gain }
    }
}

impl From<CalibrationSigma> for calibration::CalibrationSigma {
    fn from(deviations: CalibrationSigma) -> Self {
        let [gain, cross_axis, hammer_gain] =
            [deviations.gain, deviations.cross_axis, deviations.hammer_gain]
                .map(|sigma| sigma as f32);
        Self { gain, cross_axis, hammer_gain }
    }
}

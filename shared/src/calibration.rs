//! Calibration of sensors and hammer: compares their output with a known input.
//!
//! | module | test | gives |
//! | --- | --- | --- |
//! | [`tumble`] | each sensor axis up and down, without motion: ±1 g | zero and 3 × 3 sensitivity of every sensor |
//! | [`block`] | a hanging block of known mass, hit through its centre of mass | ratio of every sensor to the hammer; after a tumble test, the gain of the hammer alone |
//! | [`time_constant`] | the same hits | time constant of a sensor's low-pass against the hammer's |
//! | [`opposite_hits`] | the same hits, from both sides | what the channel after the hammer keeps of its voltage; asymmetry of the sensors |
//! | [`memory`] | the readings of the tumble test | what the hammer's channel keeps of the channel before it |
//!
//! The output of a sensor is `V = zero + S a`, S in V/(m/s²): the sensitivities are on its diagonal, the cross-axis
//! sensitivities off it. Theory, section 9.

pub mod block;
pub mod memory;
pub mod opposite_hits;
mod record;
pub mod time_constant;
pub mod tumble;

pub use record::{
    CalibrationMethod, CalibrationRecord, CalibrationSigma, GAIN_DRIFT_PER_MONTH,
    without_calibration,
};

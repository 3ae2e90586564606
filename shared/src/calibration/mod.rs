//! How sensors and hammer are calibrated: from what they read where the answer is known.
//!
//! | module | test | gives |
//! | --- | --- | --- |
//! | [`tumble`] | each axis of the sensors up and down, at rest: ±1 g | zero and 3 × 3 sensitivity of every sensor |
//! | [`block`] | a hanging block of known mass, hit through its centre of mass | ratio of every sensor to the hammer, and with a tumble test the hammer's own gain |
//! | [`time_constant`] | the same hits | time constant of a sensor's low-pass against the hammer's |
//!
//! A sensor puts out `V = zero + S a`, S in V/(m/s²): the sensitivities on its diagonal, the
//! cross-axis sensitivities beside it. Theory, section 9.

pub mod block;
mod record;
pub mod time_constant;
pub mod tumble;

pub use record::{CalibrationMethod, CalibrationRecord, CalibrationSigma};

#![doc = include_str!("../README.md")]
//!
//! ## Modules
//!
//! Everything here is a pure function: samples, bytes and time come in as arguments, and the crate has no
//! access to a chip, port, file or clock. All sizes are known at build time, so it runs on a microcontroller.
//!
//! | module | subject |
//! | --- | --- |
//! | [`units`] | newtypes of the physical quantities that cross an interface |
//! | [`Real`] | the floating-point type: `f32` on a rig, `f64` on the host |
//! | [`responses`] | vectors and matrices of the readings of all sensors |
//! | [`body`] | the ten rigid body properties and their transforms |
//! | [`capacity`] | how many sensors and hits there is room for: a fixed number, or any on a heap |
//! | [`layout`] | where sensors sit and hits land; kinematics; diagnosis of a layout |
//! | [`design`] | which sensors and hits to choose among candidates |
//! | `signal` | from ADC codes to spectra: trigger, grading, windows, FFT, H1, coherence |
//! | [`mass_line`] | the constant part of an accelerance, `A + B/s² + C s²` |
//! | [`identify`] | from mass lines to the ten properties with their covariance |
//! | `calibration` | sensitivities of sensors and hammer from their outputs under a known input |
//! | [`frequency_responses`] | accelerances of a whole test, bin by bin |
//! | [`modes`] | the six modes of a body on its suspension |
//! | `measurement` | from scans to a result: a state machine that does no input or output itself |
//! | [`diagnosis`] | the codes that name every problem |
//! | [`theory`] | the equations behind all of it, and the measured reasons for its default values |
//!
//! Examples that begin with `frame::` use test 1 of the three-bar frame ([`theory`], section 11).
#![no_std]
#![forbid(unsafe_code)]

#[cfg(any(test, feature = "alloc"))]
extern crate alloc;
#[cfg(test)]
extern crate std;

pub mod body;
#[cfg(feature = "signal")]
pub mod calibration;
pub mod capacity;
pub mod design;
pub mod diagnosis;
mod estimated;
pub mod frequency_responses;
pub mod identify;
pub mod layout;
mod linalg;
mod listed;
pub mod mass_line;
#[cfg(feature = "signal")]
pub mod measurement;
pub mod modes;
mod progress;
pub mod real;
pub mod responses;
#[cfg(feature = "signal")]
pub mod signal;
mod sorting;
pub mod theory;
pub mod units;

/// The linear algebra crate whose types appear in this interface, re-exported in the matching version.
pub use nalgebra;

pub use estimated::EstimatedValue;
pub use frequency_responses::FrequencyResponses;
pub use progress::Progress;
pub use real::Real;
pub use responses::{ResponseRows, ResponseSquare, Responses};
pub use units::STANDARD_GRAVITY;

//! What calibration tests say of a rig's sensors, hammer and electronics.
//!
//! | module | subject |
//! | --- | --- |
//! | [`block`] | the result of a block test |
//! | [`cutoffs`] | the low-passes of the sensors, from the spectra of a block test |
//! | [`capacitor`] | low-passes that are too slow: the breakout's own capacitor |
//! | [`electronics`] | what tumble and block test show of multiplexer and converter |
//! | [`plausible`] | the result of a block test against data sheet and tumble test |
//! | [`orientation`] | how sensors lie in a tumble test |
//! | [`verify`] | a block test that checks the calibration in force |
//!
//! The file format is in [`massline_files::calibration_file`], the mathematics in [`massline_shared::calibration`].

pub mod block;
pub mod capacitor;
pub mod cutoffs;
pub mod electronics;
pub mod orientation;
pub mod plausible;
pub mod verify;

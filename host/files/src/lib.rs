//! Files that people and other programs write, and how files are read and written at all. Whatever enters has its unit
//! stated or is asked for.
//!
//! | module | subject |
//! | --- | --- |
//! | [`file`](mod@file) | reading up to a limit, writing without losing what is there |
//! | [`encoding`] | bytes of a text file to text |
//! | [`limited`] | lists of a file with a largest length |
//! | [`units`] | units of force and motion, as people write them |
//! | [`npy`] | the header of a NumPy array |
//! | [`recording`] | hammer data of other systems: LVM, CSV, UFF, NumPy |
//! | [`layout_file`] | the layout TOML |
//! | [`calibration_file`] | the calibration TOML |
//! | [`tumble_file`] | the readings of a tumble test so far |
//! | [`dof_spectra`] | averaged spectra of a DOF, as a rig sends them |
//! | [`tape`] | recorded scans of a rig |
//! | [`archive`] | one file with everything that a test has measured |
//! | [`embedded`] | results inside an HTML report |
//! | [`day`], [`clock`] | calendar dates, the clock of this computer |
//! | [`toml_file`] | TOML files; the errors name file, line and key |
//! | [`uff`] | universal files, datasets 58, 151 and 164 |
#![deny(unsafe_code)]

pub mod archive;
pub mod calibration_file;
pub mod clock;
pub mod day;
pub mod dof_spectra;
pub mod embedded;
pub mod encoding;
pub mod file;
pub mod layout_file;
pub mod limited;
pub mod npy;
pub mod recording;
mod single;
pub mod tape;
pub mod toml_file;
pub mod tumble_file;
pub mod uff;
pub mod units;

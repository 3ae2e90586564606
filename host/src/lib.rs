//! The host side of the rig: talks to it, reads and writes files, solves, and prints results.
//!
//! | module | subject |
//! | --- | --- |
//! | [`error`] | the error type of all commands, and its exit codes |
//! | [`archive`] | one file with everything that a test has measured |
//! | [`client`] | the connection to a rig behind a serial port, a pty, a TCP address or a pipe |
//! | [`campaign`] | follows a campaign from its start to its result |
//! | `clock` | the clock of this computer |
//! | [`commands`] | what each subcommand does |
//! | [`interrupt`] | Ctrl-C |
//! | [`output`] | where a command writes: text or JSON, colour, progress |
//! | [`layout_file`] | the layout TOML |
//! | `typography` | signs of print in text that people read |
//! | `udev` | the rules by which Linux lets the user open a device |
//! | `limited` | lists of a file with a largest length |
//! | [`calibration`] | dates of calibrations, and the RC cutoffs from the spectra of a block test |
//! | [`calibration_file`] | the calibration TOML |
//! | [`uff`] | universal files, dataset 58 |
//! | [`export`] | results as files of other programs: URDF, Nastran, NumPy, … |
//! | [`units`] | units of force and motion, as people write them |
//! | [`identification`] | the ten properties in double precision, and the nuisance parameters of the fit |
//! | [`design`] | the predicted uncertainty of a layout, and better layouts |
//! | [`solve`] | the offline solver |
//! | [`plausibility`] | what in a layout or an answer looks like another unit |
//! | [`judgement`] | whether a result can be used, and why not |
//! | [`precision`] | how precise the answer of a campaign would be so far |
//! | `limits` | what limits an answer |
//! | [`solution`] | what this program finds from the data of a test, and the result that it makes of it |
//! | [`rig_solution`] | a rig's test, solved on the host |
//! | [`rig_lines`] | the lines of a rig's result in the suspension profile |
//! | [`single_fault`] | which mistake explains data that contradict their budget |
//! | [`monte_carlo`] | many simulated tests, compared with the truth and the Cramér-Rao bound |
//! | `embedded` | results inside an HTML report |
//! | [`encoding`] | bytes of a text file to text |
//! | [`html_report`] | results as a page for people |
//! | [`result_file`] | one result with its test, read from a file |
//! | [`report`] | results as text, diagnostics as sentences |
//! | [`hit_log`] | what became of every hit of a campaign |
//! | [`spectra`] | collects the spectra of a campaign, DOF by DOF |
//! | [`tape`] | recorded scans |
//! | [`recording`] | hammer data of other systems: LVM, CSV, UFF, NumPy |
//! | [`hits`] | grades the hits of a recording |
//! | [`rig`] | simulated rigs, virtual or emulated |
//! | `qemu` | the emulated rig, where the system has ptys |
//! | [`firmware`] | builds the firmware of a board |
//! | [`flash`] | writes firmware to a board |
#![deny(unsafe_code)]

pub mod archive;
pub mod calibration;
pub mod calibration_file;
pub mod campaign;
pub mod client;
mod clock;
pub mod commands;
pub mod design;
pub mod document;
mod embedded;
pub mod encoding;
pub mod error;
pub mod export;
pub mod file;
pub mod firmware;
pub mod flash;
pub mod followed;
pub mod hit_log;
pub mod hits;

pub mod html_report;
pub mod identification;
pub mod interrupt;
pub mod judgement;
pub mod layout_file;
mod limited;
mod limits;
pub mod modes_so_far;
pub mod monte_carlo;
mod npy;
pub mod output;
mod parallel;
pub mod picture;
pub mod plausibility;
pub mod precision;
mod projection;
#[cfg(unix)]
pub mod qemu;
mod readings;
pub mod recording;
pub mod report;
pub mod result_file;
pub mod rig;
mod rig_findings;
pub mod rig_lines;
pub mod rig_solution;
mod screen;
pub mod self_test;
pub mod single_fault;
pub mod solution;
pub mod solve;
pub mod spectra;
pub mod suspension;
pub mod tape;
mod terminal;
mod toml_file;
mod typography;
mod udev;
pub mod uff;
pub mod units;

pub use error::{Error, Result};

//! The host side of the rig: talks to it, reads and writes files, solves, and prints results.
//!
//! | module | subject |
//! | --- | --- |
//! | [`archive`] | one file with everything that a test has measured |
//! | `bench_error` | why a bench cannot be simulated |
//! | `clock` | the clock of this computer |
//! | [`commands`] | what each subcommand does |
//! | [`output`] | where a command writes: text or JSON, colour, progress |
//! | `typography` | signs of print in text that people read |
//! | [`calibration`] | dates of calibrations, and the RC cutoffs from the spectra of a block test |
//! | [`export`] | results as files of other programs: URDF, Nastran, NumPy, … |
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
//! | [`html_report`] | results as a page for people |
//! | [`result_file`] | one result with its test, read from a file |
//! | [`report`] | results as text, diagnostics as sentences |
//! | [`hit_log`] | what became of every hit of a campaign |
//! | [`spectra`] | collects the spectra of a campaign, DOF by DOF |
//! | [`tape_player`] | recorded scans, played to a rig |
//! | [`hits`] | grades the hits of a recording |
//! | [`rig`] | simulated rigs, virtual or emulated |
//! | `qemu` | the emulated rig, where the system has ptys |
#![deny(unsafe_code)]

pub mod archive;
mod bench_error;
pub mod calibration;
mod clock;
pub mod commands;
pub mod design;
pub mod document;
mod embedded;
pub mod export;
pub mod hit_log;
pub mod hits;

pub mod html_report;
pub mod identification;
pub mod judgement;
mod limits;
pub mod modes_so_far;
pub mod monte_carlo;
pub mod output;
mod parallel;
pub mod picture;
pub mod plausibility;
pub mod precision;
mod projection;
#[cfg(unix)]
pub mod qemu;
mod readings;
pub mod report;
pub mod result_file;
pub mod rig;
mod rig_findings;
pub mod rig_lines;
mod rig_settings;
pub mod rig_solution;
mod screen;
pub mod self_test;
pub mod single_fault;
pub mod solution;
pub mod solve;
pub mod spectra;
pub mod suspension;
pub mod tape_player;
mod terminal;
mod typography;

pub use massline_result::{Error, ErrorCode, ErrorKind, Result};

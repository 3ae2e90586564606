//! The host side of the rig: talks to it, reads and writes files, solves, and prints results.
//!
//! | module | subject |
//! | --- | --- |
//! | [`commands`] | what each subcommand does |
//! | [`output`] | where a command writes: text or JSON, colour, progress |
//! | [`archive_part`] | what an interrupted campaign has read for its archive |
//! | `hit_records` | records of single hits, read during a campaign |
//! | [`solve`] | the offline solver |
//! | [`rig_solution`] | a rig's test, solved on the host |
//! | [`measured`] | results that a rig has measured, for exports and pictures |
//! | [`rig_lines`] | the lines of a rig's result in the suspension profile |
//! | [`hit_log`] | what became of every hit of a campaign |
//! | [`spectra`] | collects the spectra of a campaign, DOF by DOF |
//! | [`tape_player`] | recorded scans, played to a rig |
//! | `screen`, `terminal` | the full screen of a campaign and of a tumble test |
//! | [`rig`] | simulated rigs, virtual or emulated |
//! | `qemu` | the emulated rig, where the system has ptys |
#![deny(unsafe_code)]

pub mod archive_part;
pub mod commands;
pub mod hit_log;
mod hit_records;
pub mod measured;
pub mod output;
#[cfg(unix)]
pub mod qemu;
pub mod rig;
pub mod rig_lines;
mod rig_settings;
pub mod rig_solution;
mod screen;
pub mod solve;
pub mod spectra;
pub mod tape_player;
mod terminal;

pub use massline_result::{Error, ErrorCode, ErrorKind, Result};

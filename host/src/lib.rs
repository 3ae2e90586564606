//! The host of the rig: talks to it, reads and writes files, solves, prints.
//!
//! | module | subject |
//! | --- | --- |
//! | [`error`] | one error, its exit codes |
//! | [`client`] | a rig behind a serial port, a pty or a pipe |
//! | [`campaign`] | follows a campaign from its start to its result |
//! | [`commands`] | what each subcommand does |
//! | [`interrupt`] | Ctrl-C |
//! | [`output`] | where a command writes: text or JSON, colour, progress |
//! | [`layout_file`] | the layout TOML |
//! | [`calibration_file`] | the calibration TOML |
//! | [`uff`] | universal files, dataset 58 |
//! | [`solve`] | the offline solver |
//! | [`report`] | results as JSON and tables, diagnostics as sentences |
//! | [`tape`] | recorded scans |
//! | [`rig`] | simulated rigs, virtual or emulated |
//! | [`qemu`] | the emulated rig |
#![deny(unsafe_code)]

mod bounded;
pub mod calibration_file;
pub mod campaign;
pub mod client;
pub mod commands;
pub mod error;
pub mod interrupt;
pub mod layout_file;
pub mod output;
pub mod qemu;
pub mod report;
pub mod rig;
pub mod solve;
pub mod tape;
mod toml_file;
pub mod uff;

pub use error::{Error, Result};

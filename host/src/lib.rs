//! The host side of the rig: talks to it, reads and writes files, solves, and prints results.
//!
//! | module | subject |
//! | --- | --- |
//! | [`commands`] | what each subcommand does, a file each |
//! | [`support`] | what several subcommands share |
//! | [`output`] | where a command writes: text or JSON, colour, progress |
//! | [`solve`] | the offline solver |
//! | [`rig_solution`] | a rig's test, solved on the host |
//! | [`rig_lines`] | the lines of a rig's result in the suspension profile |
//! | `screen`, `terminal` | the full screen of a campaign and of a tumble test |
//! | [`rig`] | simulated rigs, virtual or emulated |
//! | `qemu` | the emulated rig, where the system has ptys |
#![deny(unsafe_code)]

pub mod commands;
pub mod output;
#[cfg(unix)]
pub mod qemu;
pub mod rig;
pub mod rig_lines;
pub mod rig_solution;
mod screen;
pub mod solve;
pub mod support;
mod terminal;

pub use massline_result::{Error, ErrorCode, ErrorKind, Result};

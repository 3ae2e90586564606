//! The rig as a host process: the application of the real rig over a simulated bench.
//!
//! | module | subject |
//! | --- | --- |
//! | [`sampler`] | hands the scans out, in real or simulated time |
//! | [`clock`] | the time of the rig, its timers and its executor |
//! | [`pipe`] | the link as a pipe in memory, with faults on demand |
//! | [`flash`] | flash in memory or in a file |
//! | [`panel`] | what the rig shows and its buttons |
//! | [`framebuffer`] | the pixels of the panel |
//! | [`rig`] | a running rig |
//! | `pty` | a rig served on a pseudo-terminal, where the system has them |
//! | [`tcp`] | a rig served at a TCP address |
#![deny(unsafe_code)]

pub mod clock;
#[cfg(test)]
mod echo;
pub mod flash;
pub mod framebuffer;
pub mod panel;
pub mod pipe;
#[cfg(unix)]
pub mod pty;
pub mod rig;
pub mod sampler;
pub mod tcp;

pub use flash::FlashBacking;
pub use rig::{BOARD, RigPanicked, StartError, VirtualBoard, VirtualRig, VirtualRigOptions};
pub use sampler::Timing;

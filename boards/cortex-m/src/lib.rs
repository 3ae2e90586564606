//! Code common to the boards with a Cortex-M. The parts without hardware access also build on the host and
//! are tested there; the rest needs the chip.
#![cfg_attr(not(test), no_std)]

pub mod boot;
pub mod debounce;
pub mod flash;
pub mod frame;
pub mod gauge;
mod hardware_tests;
#[cfg_attr(
    not(target_os = "none"),
    allow(dead_code, reason = "used on the chip, tested on the host")
)]
mod kept;
pub mod light;
mod patience;
pub mod sampler;
pub mod screen;
pub mod sequence;
pub mod supply;
pub mod ticks;
pub mod twin;

#[cfg(target_os = "none")]
pub mod checks;
#[cfg(target_os = "none")]
pub mod hard_fault;
#[cfg(target_os = "none")]
pub mod last_words;
#[cfg(target_os = "none")]
pub mod panel;
#[cfg(target_os = "none")]
pub mod rig;
#[cfg(target_os = "none")]
pub mod stack;
#[cfg(target_os = "none")]
pub mod usb;

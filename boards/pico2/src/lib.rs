//! The board: what of it is mere arithmetic is tested on the host, the rest needs the chip.
#![cfg_attr(not(test), no_std)]

pub mod ads7953;
#[cfg(target_os = "none")]
pub mod chip;
pub mod frames;
pub mod plan;

/// Where the store starts in flash, and its end: the last 64 KiB of 4 MiB.
pub const STORE: core::ops::Range<u32> = 0x3F_0000..0x40_0000;

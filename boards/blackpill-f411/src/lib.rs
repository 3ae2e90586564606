//! The board: what of it is mere arithmetic is tested on the host, the rest needs the chip.
#![cfg_attr(not(test), no_std)]

#[cfg(target_os = "none")]
pub mod chip;
pub mod plan;
pub mod sequence;

/// Where the store starts in flash, and its end: sectors 1 to 3.
pub const STORE: core::ops::Range<u32> = 0x4000..0x1_0000;

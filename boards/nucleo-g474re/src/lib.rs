//! The board: what of it is mere arithmetic is tested on the host, the rest needs the chip.
#![cfg_attr(not(test), no_std)]

#[cfg(target_os = "none")]
pub mod chip;
pub mod ecc;
pub mod plan;
pub mod sequence;

/// Where the store starts in bank 2 of the flash, and its end: the last 64 KiB.
pub const STORE_IN_BANK_2: core::ops::Range<u32> = 0x3_0000..0x4_0000;

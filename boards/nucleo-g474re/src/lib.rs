//! What of the board is mere arithmetic, tested on the host: which registers the ADCs' sequences take,
//! and how much time they have.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

pub mod plan;
pub mod sequence;

/// Where the store starts in bank 2 of the flash, and its end: the last 64 KiB.
pub const STORE_IN_BANK_2: core::ops::Range<u32> = 0x3_0000..0x4_0000;

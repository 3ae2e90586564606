//! What of the board is mere arithmetic, tested on the host: which registers the ADC's sequence takes,
//! and how much time it has.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

pub mod plan;
pub mod sequence;

/// Where the store starts in flash, and its size: sectors 1 to 3.
pub const STORE: core::ops::Range<u32> = 0x4000..0x1_0000;

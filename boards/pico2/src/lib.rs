//! The board: what of it is mere arithmetic is tested on the host, the rest needs the chip.
#![cfg_attr(not(test), no_std)]

pub mod ads7953;
#[cfg(target_os = "none")]
pub mod chip;
pub mod frames;
pub mod plan;

/// What `board.toml` states.
pub mod facts {
    include!(concat!(env!("OUT_DIR"), "/facts.rs"));
}

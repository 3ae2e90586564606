//! The board: what of it is mere arithmetic is tested on the host, the rest needs the chip.
#![cfg_attr(not(test), no_std)]

#[cfg(target_os = "none")]
pub mod chip;
pub mod plan;
pub mod sequence;

/// What `board.toml` states.
pub mod facts {
    include!(concat!(env!("OUT_DIR"), "/facts.rs"));
}

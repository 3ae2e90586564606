//! The board. The parts without hardware access are tested on the host; the rest needs the chip.
#![cfg_attr(not(test), no_std)]

pub mod ads7953;
#[cfg(target_os = "none")]
pub mod chip;
pub mod frames;
pub mod plan;
pub mod transfer;

/// The facts from `board.toml`.
pub mod facts {
    include!(concat!(env!("OUT_DIR"), "/facts.rs"));
}

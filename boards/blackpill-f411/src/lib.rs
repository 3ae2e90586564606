//! The board. The parts without hardware access are tested on the host; the rest needs the chip.
#![cfg_attr(not(test), no_std)]

#[cfg(target_os = "none")]
pub mod chip;
pub mod plan;
pub mod sequence;

/// The facts from `board.toml`.
pub mod facts {
    include!(concat!(env!("OUT_DIR"), "/facts.rs"));
}

//! The board. The parts without hardware access are tested on the host; the rest needs the chip.
#![cfg_attr(not(test), no_std)]

#[cfg(target_os = "none")]
pub mod chip;
pub mod ecc;
pub mod plan;
pub mod sequence;

/// The facts from `board.toml`.
pub mod facts {
    include!(concat!(env!("OUT_DIR"), "/facts.rs"));
}

/// Start of bank 2 of the flash.
const BANK_2: u32 = facts::FLASH_BYTES / 2;
const _: () = assert!(facts::STORE.start >= BANK_2, "the store lies in bank 2");
/// Start and end of the store in bank 2.
pub const STORE_IN_BANK_2: core::ops::Range<u32> =
    facts::STORE.start - BANK_2..facts::STORE.end - BANK_2;

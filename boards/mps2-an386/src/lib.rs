//! Code shared by the emulated rig and the host that feeds it.
//!
//! QEMU backs the machine's PSRAM with a file that the host maps too. At its start is the [`ring`] of
//! scans, in place of the analogue front end of a real board; the [`flash`] is at a higher address.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

pub mod flash;
pub mod ring;

/// The facts from `board.toml`.
pub mod facts {
    include!(concat!(env!("OUT_DIR"), "/facts.rs"));
}

/// Start of the PSRAM in the machine's address space.
pub const PSRAM_ADDRESS: usize = 0x2100_0000;
/// Bytes of PSRAM, which is the size of the file.
pub const PSRAM_SIZE: usize = 16 << 20;

/// Offset of the ring in the PSRAM.
pub const RING_OFFSET: usize = 0;
/// Offset of the flash in the PSRAM.
pub const FLASH_OFFSET: usize = 8 << 20;
/// Bytes of flash.
pub const FLASH_SIZE: usize = 64 << 10;

const _: () = assert!(RING_OFFSET + size_of::<ring::Ring>() <= FLASH_OFFSET);
const _: () = assert!(FLASH_OFFSET + FLASH_SIZE <= PSRAM_SIZE);

//! What the emulated rig and the host that feeds it have in common.
//!
//! QEMU keeps the machine's PSRAM in a file that the host maps too. At its start lies the [`ring`]
//! of scans, where the analogue front end of a real board would be; further up lies the [`flash`].
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

pub mod flash;
pub mod ring;

/// What `board.toml` states.
pub mod facts {
    include!(concat!(env!("OUT_DIR"), "/facts.rs"));
}

/// Where the PSRAM starts in the machine's address space.
pub const PSRAM_ADDRESS: usize = 0x2100_0000;
/// Bytes of PSRAM: the size of the file.
pub const PSRAM_SIZE: usize = 16 << 20;

/// Where the ring starts in the PSRAM.
pub const RING_OFFSET: usize = 0;
/// Where the flash starts in the PSRAM.
pub const FLASH_OFFSET: usize = 8 << 20;
/// Bytes of flash.
pub const FLASH_SIZE: usize = 64 << 10;

const _: () = assert!(RING_OFFSET + size_of::<ring::Ring>() <= FLASH_OFFSET);
const _: () = assert!(FLASH_OFFSET + FLASH_SIZE <= PSRAM_SIZE);

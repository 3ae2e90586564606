//! The wire of massline: the same bytes over USB CDC-ACM, a UART, a pty or a pipe.
//!
//! ```text
//! frame = COBS( kind u16 LE ‖ sequence u16 LE ‖ postcard body ‖ CRC-32 u32 LE ) ‖ 0x00
//! ```
//! The host asks, the rig answers with the same sequence number; the rig also sends [`event`]s on
//! its own. Anything malformed is counted and dropped. A shipped message is never edited: new fields
//! mean a new message. Growable enums travel as numbers, of which an older
//! program passes on those that it does not know.
//!
//! The domain is in `massline-shared`, which knows nothing of this crate.

#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod boot_reason;
pub mod checksum;
pub mod diagnostic;
pub mod event;
pub mod frame;
mod layout;
pub mod message;
pub mod object;

pub use boot_reason::BootReason;
pub use checksum::{crc32, crc32_of_chunks};
pub use frame::{
    Deframer, Frame, FrameError, MAX_BODY, MAX_FRAME, PlainFrame, decode_frame, encode_frame,
};
pub use layout::{LayoutHash, MAX_LAYOUT};
pub use message::{Endpoint, Refusal};

/// A rig and a host understand each other when this is equal.
pub const PROTOCOL_MAJOR: u8 = 1;
/// Raised when messages are added.
pub const PROTOCOL_MINOR: u8 = 0;

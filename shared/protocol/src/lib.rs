//! The wire protocol of massline: the same bytes over USB CDC-ACM, a UART, a pty or a pipe.
//!
//! ```text
//! frame = COBS( kind u16 LE ‖ sequence u16 LE ‖ postcard body ‖ CRC-32 u32 LE ) ‖ 0x00
//! ```
//! The host sends requests, and the rig answers each with the same sequence number; the rig also sends
//! [`event`]s unasked. Anything malformed is counted and dropped. A shipped message is never edited: new
//! fields need a new message. Enums that may grow travel as numbers, so an older program can pass on values
//! that it does not know.
//!
//! The domain types are in `massline-shared`, which does not depend on this crate.

#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod boot_reason;
pub mod checksum;
mod clock;
mod converter_fault;
pub mod diagnostic;
pub mod event;
pub mod frame;
mod hardware;
mod layout;
pub mod lines;
pub mod lines_head;
pub mod message;
pub mod object;

pub use boot_reason::BootReason;
pub use checksum::{calibration_checksum, crc32, crc32_of_chunks};
pub use clock::Clock;
pub use converter_fault::ConverterFault;
pub use frame::{
    Deframer, Frame, FrameError, MAX_BODY, MAX_FRAME, PlainFrame, decode_frame, encode_frame,
};
pub use layout::{LayoutHash, MAX_LAYOUT};
pub use message::{Endpoint, Refusal};

/// Major version of the protocol. A rig and a host can work together only when theirs are equal.
pub const PROTOCOL_MAJOR: u8 = 1;
/// Minor version of the protocol, raised when messages or commands are added.
pub const PROTOCOL_MINOR: u8 = 0;

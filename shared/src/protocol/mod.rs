//! The wire protocol: the same bytes over USB CDC-ACM, a UART, a pty or a pipe.
//!
//! ```text
//! frame = COBS( kind u16 LE ‖ sequence u16 LE ‖ postcard body ‖ CRC-32 u32 LE ) ‖ 0x00
//! ```
//! The host asks, the rig answers with the same sequence number; the rig also sends [`event`]s on
//! its own. Anything malformed is counted and dropped. A shipped message is never edited: new fields
//! mean a new message. Growable enums travel as raw integers.

pub mod event;
pub mod frame;
pub mod message;
pub mod object;

pub use crate::checksum::{crc32, crc32_of_chunks};
pub use frame::{
    Deframer, Frame, FrameError, MAX_BODY, MAX_FRAME, PlainFrame, decode_frame, encode_frame,
};
pub use message::{Endpoint, Refusal};

/// A rig and a host understand each other when this is equal.
pub const PROTOCOL_MAJOR: u8 = 1;
/// Raised when messages are added.
pub const PROTOCOL_MINOR: u8 = 1;

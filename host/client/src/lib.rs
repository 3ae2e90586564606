//! The connection to a rig behind a serial port, a pty or a TCP address, and what flashes its board.
//!
//! [`Client`] sends requests and waits for the answers; it repeats a request that is not answered, reopens a
//! lost link, and resumes a download where it stopped. Repeating is safe, because the rig executes a request
//! that changes something at most once per sequence number. Events that the rig sends unasked wait in a queue
//! ([`Client::next_event`]).

#![deny(unsafe_code)]

pub mod campaign;
mod download;
mod error;
mod exchange;
pub mod firmware;
pub mod flash;
pub mod followed;
pub mod interrupt;
mod peer;
mod purpose;
mod request;
mod scans;
mod serial;
mod tcp;
mod transport;
pub mod udev;

pub use download::StoredDof;
pub use error::ClientError;
pub use exchange::{Client, Event, Timing};

pub use scans::scans_of;
pub use serial::{PORT_VARIABLE, PortFacts, SerialTransport, choose_port, list_ports};
pub use tcp::{TcpAddress, TcpTransport};
pub use transport::Transport;

/// Opens the port with this name: a TCP address, or else a serial port or pty.
///
/// # Errors
/// Exit 2 when the name is a malformed address, exit 4 when nothing is there or it is in use.
pub fn open(name: &str) -> massline_result::Result<Box<dyn Transport>> {
    match TcpAddress::parse(name) {
        Some(address) => Ok(Box::new(TcpTransport::open(address?)?)),
        None => Ok(Box::new(SerialTransport::open(name)?)),
    }
}

#[cfg(test)]
mod tests;

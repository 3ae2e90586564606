//! The client of a rig.
//!
//! [`Client`] sends requests and waits for the answers; it repeats a request that is not answered, reopens a
//! lost link, and resumes a download where it stopped. Repeating is safe, because the rig executes a request
//! that changes something at most once per sequence number. Events that the rig sends unasked wait in a queue
//! ([`Client::next_event`]).

mod download;
mod error;
mod pipe;
mod request;
mod scans;
mod serial;
mod spectra;
mod transport;

pub use error::ClientError;
pub use pipe::PipeTransport;
pub use request::{Client, Event, Timing};
pub use scans::scans_of;
pub use serial::{PortFacts, SerialTransport, choose_port, list_ports};
pub use spectra::{DofSpectra, SpectraError};
pub use transport::Transport;

#[cfg(test)]
mod tests;

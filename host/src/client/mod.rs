//! A rig at the other end of a link.
//!
//! [`Client`] asks and waits for the answer; it repeats a request that is not answered, opens the
//! link anew when it is lost, and goes on with a download where it stopped. The rig executes a
//! request that changes something at most once when it is repeated with the same sequence number,
//! so repeating is safe. What the rig says on its own waits in a queue ([`Client::next_event`]).

mod download;
mod error;
mod pipe;
mod request;
mod serial;
mod spectra;
mod transport;

pub use error::ClientError;
pub use pipe::PipeTransport;
pub use request::{Client, Event, Timing};
pub use serial::{PortFacts, SerialTransport, choose_port, list_ports};
pub use spectra::{DofSpectra, SpectraError};
pub use transport::Transport;

#[cfg(test)]
mod tests;

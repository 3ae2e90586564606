//! The `--port` argument, and the connection to the rig at that port.

use massline_protocol::message::Identity;

use crate::client::{Client, SerialTransport, choose_port};
use crate::error::Result;
use crate::output::Output;

/// The port of the rig.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct PortArgs {
    /// Serial port or pty of the rig; default: MASSLINE_PORT, else the only USB serial port.
    #[arg(long, value_name = "PATH")]
    pub port: Option<String>,
}

impl PortArgs {
    /// Opens the port and reads the rig's identity.
    ///
    /// # Errors
    /// When there is no rig, it does not answer, or its protocol is incompatible.
    pub fn connect(&self, output: &Output) -> Result<(Client, Identity)> {
        let path = choose_port(self.port.as_deref())?;
        let notes = output.notes();
        let client = Client::new(SerialTransport::open(path)?);
        let mut client = client.telling(move |text| notes.note(text));
        let identity = client.identify()?;
        Ok((client, identity))
    }
}

//! The `--port` argument and the way to the rig behind it.

use massline_protocol::message::Identity;

use crate::client::{Client, SerialTransport, choose_port};
use crate::error::Result;

/// Which rig.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct PortArgs {
    /// Serial port or pty of the rig; default: MASSLINE_PORT, else the only USB serial port.
    #[arg(long, value_name = "PATH")]
    pub port: Option<String>,
}

impl PortArgs {
    /// Opens the port and asks who is there.
    ///
    /// # Errors
    /// When there is no rig, it does not answer, or speaks another protocol.
    pub fn connect(&self) -> Result<(Client, Identity)> {
        let path = choose_port(self.port.as_deref())?;
        let mut client = Client::new(SerialTransport::open(path)?);
        let identity = client.identify()?;
        Ok((client, identity))
    }
}

//! The `--port` argument, and the connection to the rig at that port.

use massline_protocol::message::Identity;

use crate::Result;
use crate::output::{Output, shell_word};
use massline_client::{self, Client, choose_port};

/// The port of the rig.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct PortArgs {
    /// Port of the rig: /dev/ttyACM0, COM3, a pty or tcp://HOST:PORT; default: MASSLINE_PORT, else the only USB
    /// serial port.
    #[arg(long, value_name = "PORT")]
    pub port: Option<String>,
}

impl PortArgs {
    /// The option as a further command for the same rig needs it, with a blank before it; empty where none was given.
    pub fn as_typed(&self) -> String {
        self.port.as_ref().map_or_else(String::new, |port| format!(" --port {}", shell_word(port)))
    }

    /// Opens the port and reads the rig's identity.
    ///
    /// # Errors
    /// When there is no rig, it does not answer, or its protocol is incompatible.
    pub fn connect(&self, output: &Output) -> Result<(Client, Identity)> {
        let port = choose_port(self.port.as_deref())?;
        let notes = output.notes();
        let client = Client::new(massline_client::open(&port)?);
        let client = client.interrupted_by(output.interrupt().clone());
        let mut client = client.telling(move |text| notes.note(text));
        let identity = client.identify()?;
        Ok((client, identity))
    }
}

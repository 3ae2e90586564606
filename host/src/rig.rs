//! Simulated rigs: the virtual rig in this process, or the emulated rig in QEMU.

use std::fmt;
use std::path::{Path, PathBuf};

use massline_physics::source::ScanSource;
use massline_protocol::message::Identity;
use massline_virtual::rig::{VirtualRig, VirtualRigOptions};

use crate::{Error, Result};
use massline_client::Client;

// The emulated rig needs a pty and a file that two processes map: one file for each kind of system.
#[cfg_attr(unix, path = "rig/emulated_unix.rs")]
#[cfg_attr(not(unix), path = "rig/emulated_elsewhere.rs")]
mod emulated;
mod pipe;

pub use pipe::PipeTransport;

/// The kind of simulated rig.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum RigKind {
    /// The firmware application on a thread of this process.
    #[default]
    Virtual,
    /// The thumbv7em firmware in QEMU, over a pty.
    Qemu,
}

impl RigKind {
    /// The firmware image that this rig needs: `given`, or for QEMU without it one built from the checkout.
    ///
    /// # Errors
    /// When it cannot be built; the error names the command that installs what is missing.
    pub fn firmware(self, given: Option<&Path>) -> Result<Option<PathBuf>> {
        match (self, given) {
            (Self::Virtual, None) => Ok(None),
            (Self::Virtual, Some(_)) => Err(Error::input(
                "firmware_needs_qemu",
                "--firmware is an image for the emulated rig: add --rig qemu",
            )),
            (Self::Qemu, given) => emulated::firmware(given).map(Some),
        }
    }
}

/// What a simulated rig runs on.
trait Machine: fmt::Debug + Send {
    /// A client on the link of the rig.
    fn client(&self) -> Result<Client>;

    /// Notifies the bench that the rig waits for a hit at DOF `dof`.
    fn armed(&self, arming: u32, dof: usize);

    /// Makes the rig ask its source for scans again after the source had none.
    fn poke(&self);

    /// The cause of death when the rig has died, else `error`.
    fn explain(&mut self, error: Error) -> Error;
}

/// A simulated rig, which runs until it is dropped, and the source of its scans.
#[derive(Debug)]
pub struct SimulatedRig(Box<dyn Machine>);

impl SimulatedRig {
    /// Starts a rig that sees the scans of `source`. `firmware` is the return value of [`RigKind::firmware`].
    ///
    /// # Errors
    /// When it does not start, or this system cannot run it (`not_on_this_system`).
    pub fn start(
        kind: RigKind,
        firmware: Option<&Path>,
        source: Box<dyn ScanSource>,
    ) -> Result<Self> {
        match kind {
            RigKind::Virtual => {
                let rig = VirtualRig::start(VirtualRigOptions::new(source))
                    .map_err(|e| Error::internal("virtual_rig", e.to_string()))?;
                Ok(Self(Box::new(rig)))
            }
            RigKind::Qemu => emulated::start(firmware, source).map(Self),
        }
    }

    /// Connects over the link of the rig and reads its identity.
    ///
    /// # Errors
    /// When it does not answer.
    pub fn connect(&mut self) -> Result<(Client, Identity)> {
        let connected = self.try_connect();
        connected.map_err(|e| self.explain(e))
    }

    fn try_connect(&self) -> Result<(Client, Identity)> {
        let mut client = self.0.client()?;
        let identity = client.identify()?;
        Ok((client, identity))
    }

    /// Notifies the bench that the rig waits for a hit at DOF `dof`. Does nothing for the virtual rig, whose
    /// operator watches its panel.
    pub fn armed(&self, arming: u32, dof: usize) {
        self.0.armed(arming, dof);
    }

    /// Makes the rig ask its source for scans again after the source had none. The emulated rig's feeder does
    /// so by itself.
    pub fn poke(&self) {
        self.0.poke();
    }

    /// The reason why communication with the rig failed: its output when it has crashed, else `error`.
    pub fn explain(&mut self, error: Error) -> Error {
        self.0.explain(error)
    }
}

impl Machine for VirtualRig {
    fn client(&self) -> Result<Client> {
        Ok(Client::new(PipeTransport::new(self.link())))
    }

    fn armed(&self, _: u32, _: usize) {}

    fn poke(&self) {
        VirtualRig::poke(self);
    }

    fn explain(&mut self, error: Error) -> Error {
        match self.panicked() {
            Some(panic) => Error::internal("rig_panicked", panic.to_string()),
            None => error,
        }
    }
}

//! Simulated rigs: the virtual rig in this process, or the emulated rig in QEMU.

use std::path::{Path, PathBuf};

use massline_protocol::message::Identity;
use massline_virtual::rig::{VirtualRig, VirtualRigOptions};
use massline_virtual::source::ScanSource;

use crate::client::{Client, PipeTransport, SerialTransport};
use crate::error::{Error, Result};
use crate::qemu::{EmulatedRig, Feeder, build_firmware};

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
            (Self::Qemu, Some(path)) if path.is_file() => Ok(Some(path.to_owned())),
            (Self::Qemu, Some(path)) => Err(Error::input(
                "no_firmware",
                format!(
                    "{} is not a file; leave --firmware out to build the image",
                    path.display()
                ),
            )),
            (Self::Qemu, None) => build_firmware().map(Some),
        }
    }
}

/// A simulated rig, which runs until it is dropped, and the source of its scans.
#[derive(Debug)]
pub struct SimulatedRig(Machine);

#[derive(Debug)]
enum Machine {
    Virtual(VirtualRig),
    // The feeder is the first field, so that it is dropped before the machine that it feeds.
    Emulated(Feeder, EmulatedRig),
}

impl SimulatedRig {
    /// Starts a rig that sees the scans of `source`. `firmware` is the return value of [`RigKind::firmware`].
    ///
    /// # Errors
    /// When it does not start.
    pub fn start(
        kind: RigKind,
        firmware: Option<&Path>,
        source: Box<dyn ScanSource>,
    ) -> Result<Self> {
        match kind {
            RigKind::Virtual => {
                let rig = VirtualRig::start(VirtualRigOptions::new(source))
                    .map_err(|e| Error::internal("virtual_rig", e.to_string()))?;
                Ok(Self(Machine::Virtual(rig)))
            }
            RigKind::Qemu => {
                let image = firmware.map_or_else(build_firmware, |path| Ok(path.to_owned()))?;
                let rig = EmulatedRig::start(&image, &source.adc())?;
                let feeder = rig.feed(source);
                Ok(Self(Machine::Emulated(feeder, rig)))
            }
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
        let mut client = match &self.0 {
            Machine::Virtual(rig) => Client::new(PipeTransport::new(rig.link())),
            Machine::Emulated(_, rig) => Client::new(SerialTransport::open(rig.port_path())?),
        };
        let identity = client.identify()?;
        Ok((client, identity))
    }

    /// Notifies the bench that the rig waits for a hit at DOF `dof`. Does nothing for the virtual rig, whose
    /// operator watches its panel.
    pub fn armed(&self, arming: u32, dof: usize) {
        if let Machine::Emulated(feeder, _) = &self.0 {
            feeder.armed(arming, dof);
        }
    }

    /// Makes the rig ask its source for scans again after the source had none. The emulated rig's feeder does
    /// so by itself.
    pub fn poke(&self) {
        if let Machine::Virtual(rig) = &self.0 {
            rig.poke();
        }
    }

    /// The reason why communication with the rig failed: its output when it has crashed, else `error`.
    pub fn explain(&mut self, error: Error) -> Error {
        match &mut self.0 {
            Machine::Virtual(rig) => match rig.panicked() {
                Some(panic) => Error::internal("rig_panicked", panic.to_string()),
                None => error,
            },
            Machine::Emulated(_, rig) => rig.explain(error),
        }
    }
}

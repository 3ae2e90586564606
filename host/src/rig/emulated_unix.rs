//! The emulated rig behind [`SimulatedRig`](super::SimulatedRig).

use std::path::{Path, PathBuf};

use massline_physics::source::ScanSource;

use super::Machine;
use crate::qemu::{EmulatedRig, Feeder, build_firmware};
use crate::{Error, Result};
use massline_client::{Client, SerialTransport};

/// The firmware image: `given`, or one built from the checkout.
pub fn firmware(given: Option<&Path>) -> Result<PathBuf> {
    match given {
        None => build_firmware(),
        Some(path) if path.is_file() => Ok(path.to_owned()),
        Some(path) => Err(Error::input(
            "no_firmware",
            format!("{} is not a file; leave --firmware out to build the image", path.display()),
        )),
    }
}

/// Starts QEMU with the image that [`firmware`] returned.
pub fn start(image: Option<&Path>, source: Box<dyn ScanSource>) -> Result<Box<dyn Machine>> {
    let image = image.map_or_else(build_firmware, |path| Ok(path.to_owned()))?;
    let rig = EmulatedRig::start(&image, &source.adc())?;
    let feeder = rig.feed(source);
    Ok(Box::new(Emulated { feeder, rig }))
}

/// The feeder is the first field, so that it is dropped before the machine that it feeds.
#[derive(Debug)]
struct Emulated {
    feeder: Feeder,
    rig: EmulatedRig,
}

impl Machine for Emulated {
    fn client(&self) -> Result<Client> {
        Ok(Client::new(SerialTransport::open(self.rig.port_path())?))
    }

    fn armed(&self, arming: u32, dof: usize) {
        self.feeder.armed(arming, dof);
    }

    fn poke(&self) {}

    fn explain(&mut self, error: Error) -> Error {
        self.rig.explain(error)
    }
}

//! Systems without ptys have no emulated rig: its link is a pty, and QEMU has no option that ends there.

use std::path::{Path, PathBuf};

use massline_physics::source::ScanSource;

use super::Machine;
use crate::{Error, Result};

/// Refuses.
pub fn firmware(_: Option<&Path>) -> Result<PathBuf> {
    Err(not_on_this_system())
}

/// Refuses.
pub fn start(_: Option<&Path>, _: Box<dyn ScanSource>) -> Result<Box<dyn Machine>> {
    Err(not_on_this_system())
}

fn not_on_this_system() -> Error {
    Error::input(
        "not_on_this_system",
        "the emulated rig (--rig qemu) needs a pty and runs on Linux and macOS only; here use the virtual rig, which \
         runs the same firmware application (--rig virtual, the default)",
    )
}

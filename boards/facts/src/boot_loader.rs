//! Boot loaders: the ways to flash a chip that need only a cable.

use serde::Deserialize;

/// The boot loader of a board, and how the host finds it.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum BootLoader {
    /// A boot loader in the chip that speaks DFU over USB, with ST's extensions.
    Dfu(Dfu),
    /// A drive that takes a UF2 file.
    Uf2(Uf2),
    /// The drive of an ST-LINK, which takes a plain binary.
    StLink(StLink),
}

/// A boot loader that speaks DFU with ST's extensions.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Dfu {
    /// What the user must do so that it appears.
    pub steps: String,
    /// What to try when it does not appear.
    pub remedy: String,
    /// USB identifiers by which it is found.
    pub usb: UsbId,
}

/// A drive that takes a UF2 file.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Uf2 {
    /// What the user must do so that it appears.
    pub steps: String,
    /// Label of its file system.
    pub label: String,
    /// A word of its `INFO_UF2.TXT` that distinguishes it from others.
    pub model: String,
    /// Family ID of the blocks of the file.
    pub family: u32,
}

/// The drive of an ST-LINK.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StLink {
    /// What the user must do so that it appears.
    pub steps: String,
    /// End of the label of its file system.
    pub label: String,
}

/// Identifiers of a USB device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UsbId {
    /// Vendor ID.
    pub vendor: u16,
    /// Product ID.
    pub product: u16,
}

impl BootLoader {
    /// What the user must do so that it appears.
    pub fn steps(&self) -> &str {
        match self {
            Self::Dfu(dfu) => &dfu.steps,
            Self::Uf2(drive) => &drive.steps,
            Self::StLink(drive) => &drive.steps,
        }
    }
}

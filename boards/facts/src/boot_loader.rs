//! The ways into a chip that need nothing but a cable.

use serde::Deserialize;

/// What takes the firmware, and how it is found.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum BootLoader {
    /// In the chip, over USB: DFU with ST's extensions.
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
    /// What to do so that it shows itself.
    pub steps: String,
    /// What to try when it does not.
    pub remedy: String,
    /// By this it is found.
    pub usb: UsbId,
}

/// A drive that takes a UF2 file.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Uf2 {
    /// What to do so that it shows itself.
    pub steps: String,
    /// The label of its file system.
    pub label: String,
    /// A word of its `INFO_UF2.TXT` by which it is told from others.
    pub model: String,
    /// The family that the blocks of the file are for.
    pub family: u32,
}

/// The drive of an ST-LINK.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StLink {
    /// What to do so that it shows itself.
    pub steps: String,
    /// How the label of its file system ends.
    pub label: String,
}

/// What a USB device calls itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UsbId {
    /// Who has made it.
    pub vendor: u16,
    /// What it is.
    pub product: u16,
}

impl BootLoader {
    /// What to do so that it shows itself.
    pub fn steps(&self) -> &str {
        match self {
            Self::Dfu(dfu) => &dfu.steps,
            Self::Uf2(drive) => &drive.steps,
            Self::StLink(drive) => &drive.steps,
        }
    }
}

//! The facts of a board as they stand in its file.

use std::ops::Range;

use serde::Deserialize;

use crate::boot_loader::BootLoader;
use crate::wiring::Wiring;

/// A board. Sizes are in bytes.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Board {
    /// The folder under `boards/`; also the value of `--board` and the name in the rig's identity.
    #[serde(skip)]
    pub name: String,
    /// What people call it.
    pub title: String,
    /// The target of the Rust compiler.
    pub target: String,
    /// `None` for a board that is emulated.
    pub chip: Option<Chip>,
    /// All flash that there is.
    pub flash: Flash,
    /// All RAM that there is in one piece.
    pub ram: Ram,
    /// How much of both the firmware may use.
    pub image: Image,
    /// `massline-budgets` fails above these.
    pub budget: Budget,
    /// How firmware gets into the chip without a debug probe.
    pub boot_loader: Option<BootLoader>,
    /// Which pin goes where.
    pub wiring: Option<Wiring>,
}

/// A chip.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chip {
    /// As printed on it, without package and temperature range.
    pub name: String,
    /// As probe-rs calls it.
    pub probe_rs: String,
}

/// Flash.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Flash {
    /// Address of the first byte.
    pub origin: u32,
    /// What is erased at once, from the origin on.
    pub sectors: Vec<Sectors>,
    /// The part that the rig itself writes.
    pub store: Option<Region>,
}

/// Sectors of the same size, one after the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sectors {
    /// How many.
    pub count: u32,
    /// Size of each.
    pub bytes: u32,
}

/// A part of the address space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Region {
    /// Address of the first byte.
    pub origin: u32,
    /// Size.
    pub bytes: u32,
}

/// RAM.
pub type Ram = Region;

/// What the linker may fill, from the origins of flash and RAM on.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Image {
    /// Of flash. A store that lies within is left out: the vector table comes before it, the code behind it.
    pub flash_bytes: u32,
    /// Of RAM, for statics and stack.
    pub ram_bytes: u32,
    /// A linker script in the board's folder that is added to the memory map.
    pub sections: Option<String>,
}

/// Limits of what the firmware takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Budget {
    /// Everything that is loaded.
    pub flash_bytes: u64,
    /// Statics, the stack as measured on the emulated board and a quarter more, 2 KiB for interrupts.
    pub ram_bytes: u64,
}

impl Region {
    /// From the first address to the one behind the last.
    pub fn range(&self) -> Range<u32> {
        self.origin..self.origin + self.bytes
    }
}

impl Flash {
    /// All of it.
    pub fn range(&self) -> Range<u32> {
        self.origin..self.origin + self.bytes()
    }

    /// Size of all sectors.
    pub fn bytes(&self) -> u32 {
        self.sectors.iter().map(|sectors| sectors.count * sectors.bytes).sum()
    }

    /// Each sector, from the origin on.
    pub fn each_sector(&self) -> impl Iterator<Item = Range<u32>> {
        let sizes =
            self.sectors.iter().flat_map(|all| std::iter::repeat_n(all.bytes, all.count as usize));
        sizes.scan(self.origin, |start, size| {
            let sector = *start..*start + size;
            *start = sector.end;
            Some(sector)
        })
    }
}

impl Board {
    /// The package of its firmware.
    pub fn package(&self) -> String {
        format!("massline-{}", self.name)
    }

    /// The flash that the linker may fill.
    pub fn image_flash(&self) -> Range<u32> {
        self.flash.origin..self.flash.origin + self.image.flash_bytes
    }

    /// The RAM that the linker may fill.
    pub fn image_ram(&self) -> Range<u32> {
        self.ram.origin..self.ram.origin + self.image.ram_bytes
    }

    /// The store, if it lies within the flash that the linker may fill.
    pub fn hole(&self) -> Option<Range<u32>> {
        let store = self.flash.store?.range();
        (store.start < self.image_flash().end).then_some(store)
    }
}

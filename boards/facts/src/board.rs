//! The facts of a board as its file states them.

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
    /// Name of the board in texts for people.
    pub title: String,
    /// The target of the Rust compiler.
    pub target: String,
    /// `None` for a board that is emulated.
    pub chip: Option<Chip>,
    /// All flash of the board.
    pub flash: Flash,
    /// The largest contiguous RAM.
    pub ram: Ram,
    /// How much of flash and RAM the firmware may use.
    pub image: Image,
    /// How the chip is flashed without a debug probe.
    pub boot_loader: Option<BootLoader>,
    /// Use of the pins.
    pub wiring: Option<Wiring>,
    /// What is converted when.
    pub conversion: Option<Conversion>,
}

/// The conversions of a scan.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Conversion {
    /// For each converter, the channels in the order in which it converts them, over and over. A number after the
    /// last channel stands for an input that is none of the channels, such as the chip's reference.
    pub order: Vec<Vec<u8>>,
}

/// A chip.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chip {
    /// Name printed on the chip, without package and temperature range.
    pub name: String,
    /// Name of the chip in probe-rs.
    pub probe_rs: String,
    /// True when it has a level of the supply to set, below which it resets itself.
    #[serde(default)]
    pub brown_out: bool,
}

/// Flash.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Flash {
    /// Address of the first byte.
    pub origin: u32,
    /// Units of erasing, from the origin on.
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
    /// Bytes of flash. A store within this range is left out: the vector table comes before it, the code
    /// after it.
    pub flash_bytes: u32,
    /// Bytes of RAM, for stack and statics.
    pub ram_bytes: u32,
    /// Those of them that are the stack, below the statics.
    pub stack_bytes: u32,
    /// A linker script in the board's folder that is added to the memory map.
    pub sections: Option<String>,
}

impl Region {
    /// The addresses of the region.
    pub fn range(&self) -> Range<u32> {
        self.origin..self.origin + self.bytes
    }
}

impl Flash {
    /// The addresses of the whole flash.
    pub fn range(&self) -> Range<u32> {
        self.origin..self.origin + self.bytes()
    }

    /// Size of all sectors.
    pub fn bytes(&self) -> u32 {
        self.sectors.iter().map(|sectors| sectors.count * sectors.bytes).sum()
    }

    /// Each sector, from the origin on.
    pub fn each_sector(&self) -> impl Iterator<Item = Range<u32>> {
        let sizes = self
            .sectors
            .iter()
            .flat_map(|group| std::iter::repeat_n(group.bytes, group.count as usize));
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

    /// The RAM of the stack.
    pub fn stack(&self) -> Range<u32> {
        self.ram.origin..self.ram.origin + self.image.stack_bytes
    }

    /// The RAM that the linker may fill with statics.
    pub fn statics(&self) -> Range<u32> {
        self.stack().end..self.ram.origin + self.image.ram_bytes
    }

    /// The store, if it lies within the flash that the linker may fill.
    pub fn hole(&self) -> Option<Range<u32>> {
        let store = self.flash.store?.range();
        (store.start < self.image_flash().end).then_some(store)
    }

    /// The flash for code and constants: what the linker may fill, of a board with a hole only what lies behind it.
    pub fn code_flash(&self) -> Range<u32> {
        let flash = self.image_flash();
        self.hole().map_or(flash.start, |store| store.end)..flash.end
    }
}

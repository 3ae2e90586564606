//! The boards that can be flashed: what their chips' flash looks like, and the ways to it.

use std::ops::Range;

/// One kind of board.
#[derive(Debug, PartialEq, Eq)]
pub struct Board {
    /// As in `--board` and in the rig's identity.
    pub name: &'static str,
    /// The chip, as probe-rs calls it.
    pub chip: &'static str,
    /// The target of the Rust compiler.
    pub target: &'static str,
    /// Where flash begins.
    pub origin: u32,
    /// Sectors from the origin on: how many, of how many bytes.
    pub sectors: &'static [(u32, u32)],
    /// What the rig writes itself.
    pub store: Range<u32>,
    /// Where the stack may begin.
    pub ram: Range<u32>,
    /// The ways to its flash; the first is the usual one.
    pub ways: &'static [Way],
}

/// A way to the flash of a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Way {
    /// The USB boot loader in the chip (DfuSe).
    Dfu,
    /// The drive that the board shows on USB.
    Drive,
    /// A debug probe.
    Probe,
}

impl Way {
    /// As in `--via`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Dfu => "dfu",
            Self::Drive => "drive",
            Self::Probe => "probe",
        }
    }
}

/// Every board.
pub static BOARDS: [Board; 3] = [
    Board {
        name: "blackpill-f411",
        chip: "STM32F411CEUx",
        target: "thumbv7em-none-eabihf",
        origin: 0x0800_0000,
        sectors: &[(4, 16 << 10), (1, 64 << 10), (3, 128 << 10)],
        store: 0x0800_4000..0x0801_0000,
        ram: 0x2000_0000..0x2002_0000,
        ways: &[Way::Dfu, Way::Probe],
    },
    Board {
        name: "nucleo-g474re",
        chip: "STM32G474RETx",
        target: "thumbv7em-none-eabihf",
        origin: 0x0800_0000,
        sectors: &[(256, 2 << 10)],
        store: 0x0807_0000..0x0808_0000,
        ram: 0x2000_0000..0x2002_0000,
        ways: &[Way::Drive, Way::Probe],
    },
    Board {
        name: "pico2",
        chip: "RP235x",
        target: "thumbv8m.main-none-eabihf",
        origin: 0x1000_0000,
        sectors: &[(1024, 4 << 10)],
        store: 0x103F_0000..0x1040_0000,
        ram: 0x2000_0000..0x2008_2000,
        ways: &[Way::Drive, Way::Probe],
    },
];

impl Board {
    /// The board of this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        BOARDS.iter().find(|board| board.name == name)
    }

    /// The package of its firmware.
    pub fn package(&self) -> String {
        format!("massline-{}", self.name)
    }

    /// All flash.
    pub fn flash(&self) -> Range<u32> {
        self.origin
            ..self.origin + self.sectors.iter().map(|(count, size)| count * size).sum::<u32>()
    }

    /// Each sector, from the origin on.
    pub fn each_sector(&self) -> impl Iterator<Item = Range<u32>> {
        let sizes = self.sectors.iter().flat_map(|&(count, size)| (0..count).map(move |_| size));
        sizes.scan(self.origin, |start, size| {
            let sector = *start..*start + size;
            *start = sector.end;
            Some(sector)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn the_store_is_made_of_whole_sectors() {
        for board in &BOARDS {
            let starts: Vec<_> = board.each_sector().map(|sector| sector.start).collect();
            let ends: Vec<_> = board.each_sector().map(|sector| sector.end).collect();
            assert!(starts.contains(&board.store.start), "{}", board.name);
            assert!(ends.contains(&board.store.end), "{}", board.name);
        }
    }

    #[test]
    fn the_f411_has_eight_sectors_in_512_kib() {
        let board = Board::named("blackpill-f411").unwrap();
        assert_eq!(board.each_sector().count(), 8);
        assert_eq!(board.flash(), 0x0800_0000..0x0808_0000);
        assert_eq!(board.each_sector().nth(5), Some(0x0802_0000..0x0804_0000));
    }

    /// `memory.x` of each board states in its comment where the store lies: `0x0800_4000  … the store`.
    #[test]
    fn the_linker_scripts_put_the_store_at_the_same_place() {
        let boards = Path::new(env!("CARGO_MANIFEST_DIR")).join("../boards");
        for board in &BOARDS {
            let script = boards.join(board.name).join("memory.x");
            let text = std::fs::read_to_string(&script).unwrap();
            let line = text.lines().find(|line| line.contains("the store")).unwrap();
            let stated = line.split_whitespace().next().unwrap().replace('_', "");
            let stated = u32::from_str_radix(stated.trim_start_matches("0x"), 16).unwrap();
            assert_eq!(stated, board.store.start, "{}", script.display());
        }
    }
}

//! The boards that can be flashed: the layout of their chips' flash, and the ways to write it.
//!
//! The facts come from `boards/<name>/board.toml` at the time when this program was built.

use std::ops::Range;
use std::sync::LazyLock;

use massline_boards::BootLoader;
use massline_boards::board::Flash;
use massline_shared::signal::self_test::Circuit;

include!(concat!(env!("OUT_DIR"), "/boards.rs"));

/// One kind of board.
#[derive(Debug, PartialEq, Eq)]
pub struct Board {
    /// Name, as in `--board` and in the rig's identity.
    pub name: String,
    /// The chip, by its name in probe-rs.
    pub chip: String,
    /// True when its chip has a level of the supply to set, below which it resets itself.
    pub brown_out: bool,
    /// The package of its firmware.
    pub package: String,
    /// The target of the Rust compiler.
    pub target: String,
    /// The whole flash.
    pub flash: Flash,
    /// The store, which the rig itself writes.
    pub store: Range<u32>,
    /// Addresses at which the stack may begin.
    pub ram: Range<u32>,
    /// What accepts firmware without a debug probe.
    pub boot_loader: Option<BootLoader>,
}

/// A way to write the flash of a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum FlashMethod {
    /// The USB boot loader in the chip (DfuSe).
    Dfu,
    /// The drive that the board shows on USB.
    Drive,
    /// A debug probe.
    Probe,
}

impl FlashMethod {
    /// Name, as in `--via`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Dfu => "dfu",
            Self::Drive => "drive",
            Self::Probe => "probe",
        }
    }
}

/// Every board with a physical chip, by name.
pub static BOARDS: LazyLock<Vec<Board>> =
    LazyLock::new(|| facts().filter_map(Board::with_chip).collect());

/// The facts of every board.
fn facts() -> impl Iterator<Item = massline_boards::Board> {
    FILES.iter().map(|(name, text)| {
        massline_boards::Board::parse(name, text).expect("the build script has read the same text")
    })
}

/// For each converter of a board, the channels in the order of their conversion; `None` for a board without a chip.
pub fn conversion_order(name: &str) -> Option<Vec<Vec<u8>>> {
    facts().find(|facts| facts.name == name)?.conversion.map(|conversion| conversion.order)
}

/// What is special about the inputs of a board; nothing of a board that this program does not know.
pub fn circuit_of(name: &str) -> Circuit {
    let select = facts()
        .find(|facts| facts.name == name)
        .and_then(|facts| facts.wiring?.flash_select_channel());
    Circuit { flash_select: select }
}

impl Board {
    /// `None` when the board is emulated.
    fn with_chip(facts: massline_boards::Board) -> Option<Self> {
        let package = facts.package();
        let chip = facts.chip?;
        Some(Self {
            package,
            name: facts.name,
            chip: chip.probe_rs,
            brown_out: chip.brown_out,
            target: facts.target,
            store: facts.flash.store?.range(),
            flash: facts.flash,
            ram: facts.ram.range(),
            boot_loader: facts.boot_loader,
        })
    }

    /// The board of this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        BOARDS.iter().find(|board| board.name == name)
    }

    /// The ways to write its flash; the first is the default.
    pub fn ways(&self) -> Vec<FlashMethod> {
        let cable = self.boot_loader.as_ref().map(|boot_loader| match boot_loader {
            BootLoader::Dfu(_) => FlashMethod::Dfu,
            BootLoader::Uf2(_) | BootLoader::StLink(_) => FlashMethod::Drive,
        });
        cable.into_iter().chain([FlashMethod::Probe]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_boards_are_those_of_the_checkout_that_have_a_chip() {
        let root = crate::firmware::checkout().unwrap();
        let facts = massline_boards::boards(root).unwrap();
        let with_chip: Vec<_> = facts.into_iter().filter_map(Board::with_chip).collect();
        assert_eq!(*BOARDS, with_chip);
        assert!(Board::named("blackpill-f411").is_some() && Board::named("mps2-an386").is_none());
    }

    #[test]
    fn the_way_by_a_cable_comes_before_the_probe() {
        let ways = |name| Board::named(name).unwrap().ways();
        assert_eq!(ways("blackpill-f411"), [FlashMethod::Dfu, FlashMethod::Probe]);
        assert_eq!(ways("nucleo-g474re"), [FlashMethod::Drive, FlashMethod::Probe]);
        assert_eq!(ways("pico2"), [FlashMethod::Drive, FlashMethod::Probe]);
    }
}

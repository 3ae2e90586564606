//! What a board reports about itself.

use massline_protocol::message::Hardware;
use massline_protocol::{BootReason, Clock, ConverterFault};
pub use massline_shared::signal::self_test::Circuit;

/// What a board reports about itself.
#[derive(Clone, Copy, Debug)]
pub struct BoardInfo {
    /// Name of its folder under `boards/`.
    pub name: &'static str,
    /// Version of the firmware.
    pub firmware: &'static str,
    /// Commit that the firmware was built from.
    pub git_hash: &'static str,
    /// True when the working tree differed from that commit.
    pub git_dirty: bool,
    /// Why the board started.
    pub boot_reason: BootReason,
    /// What its clocks are derived from.
    pub clock: Clock,
    /// Its supply.
    pub supply: Supply,
    /// What is special about its inputs.
    pub circuit: Circuit,
    /// What is wrong with its external converter, and the channel in the first wrong frame.
    pub converter_fault: fn() -> (ConverterFault, u8),
    /// Message of the panic that ended the previous run; empty without one.
    pub last_panic: &'static str,
    /// Returns the stack's high-water mark and its size.
    pub stack: fn() -> StackUse,
}

/// Of a board whose converter is a part of its chip.
pub const NO_CONVERTER_FAULT: fn() -> (ConverterFault, u8) = || (ConverterFault::None, 0);

impl BoardInfo {
    /// State of clock, supply and converter.
    pub fn hardware(&self) -> Hardware {
        let Supply { is_low, brown_out, .. } = self.supply;
        let brown_out_mv = brown_out.map(|level| (level.read)());
        let (fault, wrong_tag) = (self.converter_fault)();
        Hardware {
            clock: self.clock.into(),
            brown_out_mv,
            supply_is_low: is_low(),
            converter: fault.into(),
            wrong_tag,
        }
    }
}

/// The supply of a board.
#[derive(Clone, Copy, Debug)]
pub struct Supply {
    /// True while it is too low to write flash.
    pub is_low: fn() -> bool,
    /// The level at which the chip resets itself; `None` when there is none to set.
    pub brown_out: Option<BrownOut>,
}

/// The level at which a chip holds itself in reset.
#[derive(Clone, Copy, Debug)]
pub struct BrownOut {
    /// Reads it, mV.
    pub read: fn() -> u16,
    /// Sets the highest that is below the supply of a rig. It may take effect at the next power-on.
    pub raise: fn(),
}

impl Supply {
    /// A supply that is never too low, as on a board without a chip.
    pub const STEADY: Self = Self { is_low: || false, brown_out: None };
}

/// Stack of the board, bytes; zeros when the board does not measure it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StackUse {
    /// Most bytes ever used.
    pub high_water: u32,
    /// Size.
    pub size: u32,
}

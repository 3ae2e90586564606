//! What the light says while no tone sounds: a number of flashes, over and over.

use massline_firmware::board::{BoardInfo, BootReason, Clock};

/// Flashes without a crystal.
pub const NO_CRYSTAL: u8 = 2;
/// Flashes in safe mode.
const SAFE_MODE: u8 = 3;
/// Flashes while the supply is too low to write flash.
const SUPPLY_LOW: u8 = 4;

/// Flashes of a rig; 0 when there is nothing to say.
pub fn flashes(info: &BoardInfo) -> u8 {
    if (info.supply.is_low)() {
        SUPPLY_LOW
    } else if info.boot_reason == BootReason::SafeMode {
        SAFE_MODE
    } else if info.clock == Clock::Internal {
        NO_CRYSTAL
    } else {
        0
    }
}

#[cfg(test)]
mod tests {
    use massline_firmware::board::{Circuit, NO_CONVERTER_FAULT, StackUse, Supply};

    use super::*;

    #[test]
    fn the_light_says_the_worst() {
        let healthy = BoardInfo {
            name: "a-board",
            firmware: "1.2.3",
            git_hash: "",
            git_dirty: false,
            boot_reason: BootReason::PowerOn,
            clock: Clock::Crystal,
            circuit: Circuit::default(),
            supply: Supply::STEADY,
            converter_fault: NO_CONVERTER_FAULT,
            last_panic: "",
            stack: StackUse::default,
        };
        let without_crystal = BoardInfo { clock: Clock::Internal, ..healthy };
        let safe = BoardInfo { boot_reason: BootReason::SafeMode, ..without_crystal };
        let low = BoardInfo { supply: Supply { is_low: || true, brown_out: None }, ..safe };
        assert_eq!([healthy, without_crystal, safe, low].map(|info| flashes(&info)), [0, 2, 3, 4]);
    }
}

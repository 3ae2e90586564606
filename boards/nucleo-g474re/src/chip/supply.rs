//! The supply: the detector that tells when it is too low, and the level at which the chip resets itself. Levels as in
//! RM0440, 6.4.2 and 5.4.1.

use embassy_stm32::pac::flash::Flash;
use embassy_stm32::pac::pwr::Pwr;
use embassy_stm32::pac::{FLASH, PWR};
use massline_cortex_m::gauge;
use massline_firmware::board::{BrownOut, Supply};

/// The detector's level of 2.9 V: above that at which the chip resets itself, so that the rig still notices.
const DETECTOR_LEVEL: u8 = 6;
/// Levels of the option bytes, mV.
const LEVELS_MV: [u16; 5] = [1700, 2000, 2200, 2500, 2800];
const HIGHEST: u8 = 4;
/// RM0440, 3.3.5 and 3.4.2.
const FLASH_KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];
const OPTION_KEYS: [u32; 2] = [0x0819_2A3B, 0x4C5D_6E7F];

/// The supply of this board.
pub const SUPPLY: Supply = Supply {
    is_low: || is_low(PWR),
    brown_out: Some(BrownOut { read: || brown_out_mv(FLASH), raise: || raise(FLASH) }),
    battery: Some(gauge::battery),
};

/// Switches the detector on. To be called after the clocks, which switch its registers on.
pub fn watch(power: Pwr) {
    power.cr2().modify(|w| {
        w.set_pls(DETECTOR_LEVEL);
        w.set_pvde(true);
    });
}

/// What the detector says.
pub fn is_low(power: Pwr) -> bool {
    power.sr2().read().pvdo()
}

/// The voltage below which the chip holds itself in reset, mV.
pub fn brown_out_mv(flash: Flash) -> u16 {
    let level = usize::from(flash.optr().read().bor_lev());
    LEVELS_MV.get(level).copied().unwrap_or_default()
}

/// Writes the highest level into the option bytes, unless it is there.
pub fn raise(flash: Flash) {
    if flash.optr().read().bor_lev() == HIGHEST {
        return;
    }
    for key in FLASH_KEYS {
        flash.keyr().write_value(key);
    }
    for key in OPTION_KEYS {
        flash.optkeyr().write_value(key);
    }
    while flash.sr().read().bsy() {}
    flash.optr().modify(|w| w.set_bor_lev(HIGHEST));
    flash.cr().modify(|w| w.set_optstrt(true));
    while flash.sr().read().bsy() {}
    flash.cr().modify(|w| {
        w.set_optlock(true);
        w.set_lock(true);
    });
}

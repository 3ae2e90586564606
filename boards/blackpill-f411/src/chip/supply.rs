//! The supply: the detector that tells when it is too low, and the level at which the chip resets itself. Levels as in
//! RM0383, 5.4.1 and 3.8.1.

use embassy_stm32::pac::flash::Flash;
use embassy_stm32::pac::pwr::Pwr;
use embassy_stm32::pac::{FLASH, PWR};
use massline_cortex_m::gauge;
use massline_firmware::board::{BrownOut, Supply};

/// The detector's level of 2.9 V: above that at which the chip resets itself, so that the rig still notices. Words of
/// 32 bits are written from 2.7 V on.
const DETECTOR_LEVEL: u8 = 7;
/// Levels of the option bytes, mV.
const LEVELS_MV: [u16; 4] = [2700, 2400, 2100, 1700];
const HIGHEST: u8 = 0;
/// RM0383, 3.6.2.
const KEYS: [u32; 2] = [0x0819_2A3B, 0x4C5D_6E7F];

/// The supply of this board.
pub const SUPPLY: Supply = Supply {
    is_low: || is_low(PWR),
    brown_out: Some(BrownOut { read: || brown_out_mv(FLASH), raise: || raise(FLASH) }),
    battery: Some(gauge::battery),
};

/// Switches the detector on. To be called after the clocks, which switch its registers on.
pub fn watch(power: Pwr) {
    power.cr1().modify(|w| {
        w.set_pls(DETECTOR_LEVEL);
        w.set_pvde(true);
    });
}

/// What the detector says.
pub fn is_low(power: Pwr) -> bool {
    power.csr1().read().pvdo()
}

/// The voltage below which the chip holds itself in reset, mV.
pub fn brown_out_mv(flash: Flash) -> u16 {
    LEVELS_MV[usize::from(flash.optcr().read().bor_lev() & 3)]
}

/// Writes the highest level into the option bytes, unless it is there.
pub fn raise(flash: Flash) {
    if flash.optcr().read().bor_lev() == HIGHEST {
        return;
    }
    for key in KEYS {
        flash.optkeyr().write_value(key);
    }
    while flash.sr().read().bsy() {}
    flash.optcr().modify(|w| w.set_bor_lev(HIGHEST));
    flash.optcr().modify(|w| w.set_optstrt(true));
    while flash.sr().read().bsy() {}
    flash.optcr().modify(|w| w.set_optlock(true));
}

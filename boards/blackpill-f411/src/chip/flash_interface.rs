//! The caches between flash and core. The clocks leave them off, and then every instruction waits for the flash.

use embassy_stm32::pac::flash::Flash;
use embassy_stm32::pac::flash::regs::Acr;

/// Switches on prefetch and both caches, empty. To be called after the clocks, which write the whole register.
pub fn enable_caches(flash: Flash) {
    flash.acr().modify(|w| w.set_prften(true));
    drop_cached(flash);
}

/// Empties both caches and has them on. To be called after a write or an erase, of which they know nothing: RM0383,
/// 3.4.2.
pub fn drop_cached(flash: Flash) {
    for step in empty_and_on(flash.acr().read()) {
        flash.acr().write_value(step);
    }
}

/// The values of the register one after the other: the caches can be emptied only while they are off.
pub fn empty_and_on(now: Acr) -> [Acr; 4] {
    let caches = |on, emptied| {
        let mut register = now;
        register.set_icen(on);
        register.set_dcen(on);
        register.set_icrst(emptied);
        register.set_dcrst(emptied);
        register
    };
    [caches(false, false), caches(false, true), caches(false, false), caches(true, false)]
}

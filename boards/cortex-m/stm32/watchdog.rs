//! The independent watchdog, which has an oscillator of its own. Each board with an STM32 includes this file.

use embassy_stm32::pac;
use embassy_stm32::pac::iwdg::Iwdg;
use embassy_stm32::pac::iwdg::vals::{Key, Pr};
use massline_cortex_m::rig::{self, WATCHDOG};

/// The oscillator's frequency.
const OSCILLATOR_HZ: u32 = 32_000;
const DIVIDER: (Pr, u32) = (Pr::DIVIDE_BY64, 64);
/// What the watchdog counts down from.
pub const RELOAD: u16 = {
    let counts = WATCHDOG.as_secs() as u32 * OSCILLATOR_HZ / DIVIDER.1;
    assert!(counts <= 0x1000, "the counter has 12 bits");
    (counts - 1) as u16
};

/// The independent watchdog.
pub struct Watchdog;

impl rig::Watchdog for Watchdog {
    fn start() {
        start(pac::IWDG);
    }

    fn feed() {
        pac::IWDG.kr().write(|w| w.set_key(Key::RESET));
    }
}

/// Starts it in the order of the reference manuals. Until the divider and the period are taken over, it counts from the
/// same value or a larger one.
pub fn start(watchdog: Iwdg) {
    watchdog.kr().write(|w| w.set_key(Key::START));
    watchdog.kr().write(|w| w.set_key(Key::ENABLE));
    watchdog.pr().write(|w| w.set_pr(DIVIDER.0));
    watchdog.rlr().write(|w| w.set_rl(RELOAD));
    watchdog.kr().write(|w| w.set_key(Key::RESET));
}

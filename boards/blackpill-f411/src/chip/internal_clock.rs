//! The clock of the chip after a reset. Its boot loader leaves another one when it starts a program that it has
//! written: the PLL runs, and while it does, the chip's voltage scale cannot be changed (RM0383, 5.4.1), so the core
//! would run at 96 MHz with the voltage for 84.

use embassy_stm32::pac::rcc::Rcc;
use embassy_stm32::pac::rcc::vals::Sw;

/// Times that the chip is looked at before a change is given up: at 16 MHz a tenth of a second at least. It takes
/// microseconds.
const LOOKS: u32 = 400_000;

/// Runs the core from the internal oscillator and stops the PLL. To be called before the clocks are set up.
pub fn select(rcc: Rcc) {
    rcc.cr().modify(|w| w.set_hsion(true));
    wait(|| rcc.cr().read().hsirdy());
    rcc.cfgr().modify(|w| w.set_sw(Sw::HSI));
    wait(|| rcc.cfgr().read().sws() == Sw::HSI);
    rcc.cr().modify(|w| w.set_pllon(false));
    wait(|| !rcc.cr().read().pllrdy());
}

fn wait(mut is_done: impl FnMut() -> bool) {
    let _ = (0..LOOKS).any(|_| is_done());
}

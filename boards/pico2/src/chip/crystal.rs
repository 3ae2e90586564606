//! A crystal that does not oscillate. The HAL would wait for it for ever, and without it there is no USB and no rate of
//! sampling.

use embassy_rp::clocks::ClockConfig;
use embassy_rp::config::Config;
use embassy_rp::gpio::{Level, Output};
use embassy_rp::pac::XOSC;
use embassy_rp::pac::xosc::vals::{CtrlFreqRange, Enable};
use massline_cortex_m::light::NO_CRYSTAL;
use massline_cortex_m::rig::Watchdog;

/// Times that the crystal is looked at before it is given up: a look takes six cycles or more, so these are 0.4 s at
/// 150 MHz and 6 s at 10 MHz, shorter than the period of the watchdog.
const LOOKS: u32 = 10_000_000;
/// Periods of the crystal until it counts as stable, in units of 256: 128 ms, as the HAL has it.
const DELAY: u16 = 6000;
/// About a tenth of a second by the ring oscillator, in core cycles.
const TENTH: u32 = 14_000_000;

/// Starts the crystal; false when it does not oscillate. To be called before the clocks are set up.
pub fn starts() -> bool {
    XOSC.startup().write(|w| w.set_delay(DELAY));
    XOSC.ctrl().write(|w| {
        w.set_freq_range(CtrlFreqRange::_1_15MHZ);
        w.set_enable(Enable::ENABLE);
    });
    (0..LOOKS).any(|_| XOSC.status().read().stable())
}

/// Says by the light that there is no crystal, for ever.
pub fn blink_forever<D: Watchdog>() -> ! {
    let p = embassy_rp::init(Config::new(ClockConfig::rosc()));
    let mut light = Output::new(p.PIN_25, Level::Low);
    loop {
        for _ in 0..NO_CRYSTAL {
            light.set_high();
            cortex_m::asm::delay(2 * TENTH);
            light.set_low();
            cortex_m::asm::delay(3 * TENTH);
        }
        D::feed();
        cortex_m::asm::delay(20 * TENTH);
    }
}

//! The independent watchdog. Each board with an STM32 includes this file.

use embassy_stm32::Peri;
use embassy_stm32::pac;
use embassy_stm32::pac::iwdg::vals::Key;
use embassy_stm32::peripherals::IWDG;
use embassy_stm32::wdg::IndependentWatchdog;
use massline_cortex_m::rig::{self, WATCHDOG};

/// The independent watchdog.
pub struct Watchdog(IndependentWatchdog<'static, IWDG>);

impl Watchdog {
    /// The watchdog, as it is.
    pub fn new(watchdog: Peri<'static, IWDG>) -> Self {
        Self(IndependentWatchdog::new(watchdog, WATCHDOG.as_micros() as u32))
    }
}

impl rig::Watchdog for Watchdog {
    fn start(&mut self) {
        self.0.unleash();
    }

    fn feed() {
        pac::IWDG.kr().write(|w| w.set_key(Key::RESET));
    }
}

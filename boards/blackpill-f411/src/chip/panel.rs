//! The panel's pins: screen on PB6 and PB7, buttons on PB12 to PB14, buzzer on PB8, light on PC13.

use embassy_stm32::gpio::{OutputOpenDrain, OutputType};
use embassy_stm32::i2c::{self, I2c, Master};
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::{DMA1_CH0, DMA1_CH6, I2C1, PB6, PB7, PB8, TIM4};
use embassy_stm32::time::khz;
use embassy_stm32::timer::Channel;
use embassy_stm32::timer::simple_pwm::{PwmPin, SimplePwm};
use embassy_stm32::{Peri, bind_interrupts, dma};
use massline_cortex_m::screen::ScreenBus;
pub use shared::{Buzzer, button};
use shared::{bus_config, line};

#[path = "../../../cortex-m/stm32/panel.rs"]
mod shared;

bind_interrupts!(struct Interrupts {
    I2C1_EV => i2c::EventInterruptHandler<I2C1>;
    I2C1_ER => i2c::ErrorInterruptHandler<I2C1>;
    DMA1_STREAM6 => dma::InterruptHandler<DMA1_CH6>;
    DMA1_STREAM0 => dma::InterruptHandler<DMA1_CH0>;
});

/// The bus of the screen.
pub struct Bus {
    /// Its peripheral.
    pub i2c: Peri<'static, I2C1>,
    /// Clock.
    pub clock: Peri<'static, PB6>,
    /// Data.
    pub data: Peri<'static, PB7>,
    /// Transfer to the screen.
    pub tx: Peri<'static, DMA1_CH6>,
    /// Transfer from it.
    pub rx: Peri<'static, DMA1_CH0>,
}

impl ScreenBus for Bus {
    type Open<'a> = I2c<'a, Async, Master>;
    type Line<'a> = OutputOpenDrain<'a>;

    fn open(&mut self) -> Self::Open<'_> {
        let Self { i2c, clock, data, tx, rx } = self;
        I2c::new(
            i2c.reborrow(),
            clock.reborrow(),
            data.reborrow(),
            tx.reborrow(),
            rx.reborrow(),
            Interrupts,
            bus_config(),
        )
    }

    fn lines(&mut self) -> [Self::Line<'_>; 2] {
        [line(self.clock.reborrow()), line(self.data.reborrow())]
    }
}

/// A passive piezo buzzer, silent.
pub fn buzzer(timer: Peri<'static, TIM4>, pin: Peri<'static, PB8>) -> Buzzer {
    let pin = PwmPin::new(pin, OutputType::PushPull);
    let pwm = SimplePwm::new(timer, None, None, Some(pin), None, khz(2), Default::default());
    Buzzer::new(pwm, Channel::Ch3)
}

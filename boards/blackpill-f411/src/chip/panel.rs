//! The panel's pins: screen on PB6 and PB7, buttons on PB12 to PB14, buzzer on PB8, light on PC13.

use embassy_stm32::gpio::OutputType;
use embassy_stm32::i2c;
use embassy_stm32::peripherals::{DMA1_CH0, DMA1_CH6, I2C1, PB6, PB7, PB8, TIM4};
use embassy_stm32::time::khz;
use embassy_stm32::timer::Channel;
use embassy_stm32::timer::simple_pwm::{PwmPin, SimplePwm};
use embassy_stm32::{Peri, bind_interrupts, dma};
pub use shared::{Buzzer, button};

#[path = "../../../cortex-m/stm32/panel.rs"]
mod shared;

bind_interrupts!(pub struct Interrupts {
    I2C1_EV => i2c::EventInterruptHandler<I2C1>;
    I2C1_ER => i2c::ErrorInterruptHandler<I2C1>;
    DMA1_STREAM6 => dma::InterruptHandler<DMA1_CH6>;
    DMA1_STREAM0 => dma::InterruptHandler<DMA1_CH0>;
});

/// The bus of the screen.
pub type Bus = shared::Bus<PB6, PB7, DMA1_CH6, DMA1_CH0, Interrupts>;

/// Takes the bus of the screen.
pub fn screen(
    i2c: Peri<'static, I2C1>,
    clock: Peri<'static, PB6>,
    data: Peri<'static, PB7>,
    tx: Peri<'static, DMA1_CH6>,
    rx: Peri<'static, DMA1_CH0>,
) -> Bus {
    Bus { i2c, clock, data, tx, rx, interrupts: Interrupts }
}

/// The HAL's transfers wait for the bus by interrupts.
fn is_free() -> bool {
    true
}

/// A passive piezo buzzer, silent.
pub fn buzzer(timer: Peri<'static, TIM4>, pin: Peri<'static, PB8>) -> Buzzer {
    let pin = PwmPin::new(pin, OutputType::PushPull);
    let pwm = SimplePwm::new(timer, None, None, Some(pin), None, khz(2), Default::default());
    Buzzer::new(pwm, Channel::Ch3)
}

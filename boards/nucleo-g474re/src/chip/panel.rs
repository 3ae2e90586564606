//! The panel's pins: screen on PA15 and PB7, buttons on PB4, PB5 and PB10, buzzer on PB6, light on PA5.

use embassy_stm32::gpio::OutputType;
use embassy_stm32::i2c;
use embassy_stm32::pac::I2C1 as I2C1_REGISTERS;
use embassy_stm32::peripherals::{DMA1_CH4, DMA1_CH5, I2C1, PA15, PB6, PB7, TIM4};
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
    DMA1_CHANNEL4 => dma::InterruptHandler<DMA1_CH4>;
    DMA1_CHANNEL5 => dma::InterruptHandler<DMA1_CH5>;
});

/// The bus of the screen.
pub type Bus = shared::Bus<PA15, PB7, DMA1_CH4, DMA1_CH5, Interrupts>;

/// Takes the bus of the screen.
pub fn screen(
    i2c: Peri<'static, I2C1>,
    clock: Peri<'static, PA15>,
    data: Peri<'static, PB7>,
    tx: Peri<'static, DMA1_CH4>,
    rx: Peri<'static, DMA1_CH5>,
) -> Bus {
    Bus { i2c, clock, data, tx, rx, interrupts: Interrupts }
}

/// True when a transfer can begin: the HAL's waits for it in a loop.
fn is_free() -> bool {
    !I2C1_REGISTERS.isr().read().busy()
}

/// A passive piezo buzzer, silent.
pub fn buzzer(timer: Peri<'static, TIM4>, pin: Peri<'static, PB6>) -> Buzzer {
    let pin = PwmPin::new(pin, OutputType::PushPull);
    let pwm = SimplePwm::new(timer, Some(pin), None, None, None, khz(2), Default::default());
    Buzzer::new(pwm, Channel::Ch1)
}

//! The panel's wires: screen on PB6 and PB7, buttons on PB12 to PB14, buzzer on PB8, light on PC13.

use embassy_stm32::gpio::{Input, OutputType, Pin, Pull};
use embassy_stm32::i2c::{self, I2c, Master};
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::{DMA1_CH0, DMA1_CH6, I2C1, PB6, PB7, PB8, TIM4};
use embassy_stm32::time::{Hertz, khz};
use embassy_stm32::timer::simple_pwm::{PwmPin, SimplePwm};
use embassy_stm32::{Peri, bind_interrupts, dma};
use massline_cortex_m::panel::Tone;

bind_interrupts!(struct Interrupts {
    I2C1_EV => i2c::EventInterruptHandler<I2C1>;
    I2C1_ER => i2c::ErrorInterruptHandler<I2C1>;
    DMA1_STREAM6 => dma::InterruptHandler<DMA1_CH6>;
    DMA1_STREAM0 => dma::InterruptHandler<DMA1_CH0>;
});

/// The bus of the screen.
pub type Bus = I2c<'static, Async, Master>;

/// Opens it.
pub fn screen(
    i2c: Peri<'static, I2C1>,
    clock: Peri<'static, PB6>,
    data: Peri<'static, PB7>,
    tx: Peri<'static, DMA1_CH6>,
    rx: Peri<'static, DMA1_CH0>,
) -> Bus {
    let mut config = i2c::Config::default();
    config.frequency = khz(400);
    // Modules have their own; without a module these keep the bus quiet.
    config.scl_pullup = true;
    config.sda_pullup = true;
    I2c::new(i2c, clock, data, tx, rx, Interrupts, config)
}

/// A button to ground.
pub fn button(pin: Peri<'static, impl Pin>) -> Input<'static> {
    Input::new(pin, Pull::Up)
}

/// A passive piezo buzzer.
pub struct Buzzer(SimplePwm<'static, TIM4>);

/// Silent.
pub fn buzzer(timer: Peri<'static, TIM4>, pin: Peri<'static, PB8>) -> Buzzer {
    let pin = PwmPin::new(pin, OutputType::PushPull);
    Buzzer(SimplePwm::new(timer, None, None, Some(pin), None, khz(2), Default::default()))
}

impl Tone for Buzzer {
    fn sound(&mut self, hertz: Option<u32>) {
        if let Some(hertz) = hertz {
            self.0.set_frequency(Hertz(hertz));
        }
        let mut channel = self.0.ch3();
        channel.set_duty_cycle_percent(if hertz.is_some() { 50 } else { 0 });
        channel.enable();
    }
}

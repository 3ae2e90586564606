//! The part of the panel's wiring that does not depend on the pins. Each board with an STM32 includes this
//! file, because the chip is a feature of the HAL.

use embassy_stm32::Peri;
use embassy_stm32::gpio::{Input, Level, OutputOpenDrain, Pin, Pull, Speed};
use embassy_stm32::i2c;
use embassy_stm32::peripherals::TIM4;
use embassy_stm32::time::{Hertz, khz};
use embassy_stm32::timer::Channel;
use embassy_stm32::timer::simple_pwm::SimplePwm;
use massline_cortex_m::panel::Tone;

/// Configuration of the screen's bus.
pub fn bus_config() -> i2c::Config {
    let mut config = i2c::Config::default();
    config.frequency = khz(400);
    // Screen modules have their own pull-ups; without a module these keep the bus idle.
    config.scl_pullup = true;
    config.sda_pullup = true;
    config
}

/// A line of the screen's bus without the peripheral, let go; pulled up as [`bus_config`] does.
pub fn line<'a>(pin: Peri<'a, impl Pin>) -> OutputOpenDrain<'a> {
    OutputOpenDrain::new_pull(pin, Level::High, Speed::Low, Pull::Up)
}

/// Input for a button to ground.
pub fn button(pin: Peri<'static, impl Pin>) -> Input<'static> {
    Input::new(pin, Pull::Up)
}

/// A passive piezo buzzer on a channel of TIM4.
pub struct Buzzer {
    pwm: SimplePwm<'static, TIM4>,
    channel: Channel,
}

impl Buzzer {
    /// A silent buzzer.
    pub fn new(pwm: SimplePwm<'static, TIM4>, channel: Channel) -> Self {
        Self { pwm, channel }
    }
}

impl Tone for Buzzer {
    fn sound(&mut self, hertz: Option<u32>) {
        if let Some(hertz) = hertz {
            self.pwm.set_frequency(Hertz(hertz));
        }
        let mut channel = self.pwm.channel(self.channel);
        channel.set_duty_cycle_percent(if hertz.is_some() { 50 } else { 0 });
        channel.enable();
    }
}

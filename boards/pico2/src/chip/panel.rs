//! The panel's hardware: I2C0 for the screen, a slice of the PWM for the buzzer.

use embassy_rp::gpio::{Input, Level, OutputOpenDrain, Pin, Pull};
use embassy_rp::i2c::{self, Async, I2c};
use embassy_rp::peripherals::{I2C0, PIN_4, PIN_5, PIN_14, PWM_SLICE7};
use embassy_rp::pwm::{self, Pwm};
use embassy_rp::{Peri, bind_interrupts};
use massline_cortex_m::panel::Tone;
use massline_cortex_m::screen::ScreenBus;

use crate::plan::CORE_HZ;

bind_interrupts!(struct Interrupts {
    I2C0_IRQ => i2c::InterruptHandler<I2C0>;
});

/// Core cycles per PWM cycle, so that the period of a 100 Hz tone fits the counter.
const DIVIDER: u8 = 100;

/// The bus of the screen.
pub struct Bus {
    /// Its peripheral.
    pub i2c: Peri<'static, I2C0>,
    /// Clock.
    pub clock: Peri<'static, PIN_5>,
    /// Data.
    pub data: Peri<'static, PIN_4>,
}

impl ScreenBus for Bus {
    type Open<'a> = I2c<'a, I2C0, Async>;
    type Line<'a> = OutputOpenDrain<'a>;

    fn open(&mut self) -> Self::Open<'_> {
        let mut config = i2c::Config::default();
        config.frequency = 400_000;
        // Screen modules have their own pull-ups; without a module these keep the bus idle.
        config.scl_pullup = true;
        config.sda_pullup = true;
        let Self { i2c, clock, data } = self;
        I2c::new_async(i2c.reborrow(), clock.reborrow(), data.reborrow(), Interrupts, config)
    }

    fn lines(&mut self) -> [Self::Line<'_>; 2] {
        [line(self.clock.reborrow()), line(self.data.reborrow())]
    }
}

/// A line of the bus without the peripheral, let go and pulled up.
fn line<'a>(pin: Peri<'a, impl Pin>) -> OutputOpenDrain<'a> {
    let mut line = OutputOpenDrain::new(pin, Level::High);
    line.set_pullup(true);
    line
}

/// Input for a button to ground.
pub fn button(pin: Peri<'static, impl Pin>) -> Input<'static> {
    Input::new(pin, Pull::Up)
}

/// A passive piezo buzzer.
pub struct Buzzer(Pwm<'static>);

/// A silent buzzer.
pub fn buzzer(slice: Peri<'static, PWM_SLICE7>, pin: Peri<'static, PIN_14>) -> Buzzer {
    Buzzer(Pwm::new_output_a(slice, pin, config(None)))
}

impl Tone for Buzzer {
    fn sound(&mut self, hertz: Option<u32>) {
        self.0.set_config(&config(hertz));
    }
}

/// PWM settings for a tone, with a duty cycle of one half, or for silence.
fn config(hertz: Option<u32>) -> pwm::Config {
    let mut config = pwm::Config::default();
    config.divider = DIVIDER.into();
    let period = CORE_HZ / u32::from(DIVIDER) / hertz.unwrap_or(1000);
    config.top = u16::try_from(period - 1).unwrap_or(u16::MAX);
    config.compare_a = if hertz.is_some() { config.top / 2 } else { 0 };
    config
}

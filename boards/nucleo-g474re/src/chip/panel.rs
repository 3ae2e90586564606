//! The panel's wires: screen on PA15 and PB7, buttons on PB4, PB5 and PB10, buzzer on PB6, light on PA5.

use embassy_stm32::gpio::{Input, Level, Output, OutputType, Pull, Speed};
use embassy_stm32::i2c::{self, I2c, Master};
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::{
    DMA1_CH4, DMA1_CH5, I2C1, PA5, PA15, PB4, PB5, PB6, PB7, PB10, TIM4,
};
use embassy_stm32::time::{Hertz, khz};
use embassy_stm32::timer::simple_pwm::{PwmPin, SimplePwm};
use embassy_stm32::{Peri, bind_interrupts, dma};
use massline_cortex_m::panel::{self, Contacts, Sounder, Wires};

bind_interrupts!(struct Interrupts {
    I2C1_EV => i2c::EventInterruptHandler<I2C1>;
    I2C1_ER => i2c::ErrorInterruptHandler<I2C1>;
    DMA1_CHANNEL4 => dma::InterruptHandler<DMA1_CH4>;
    DMA1_CHANNEL5 => dma::InterruptHandler<DMA1_CH5>;
});

static WIRES: Wires = Wires::new();

/// Between the application and the tasks of the panel.
pub fn wires() -> &'static Wires {
    &WIRES
}

type Bus = I2c<'static, Async, Master>;

/// The bus of the screen.
pub fn screen(
    i2c: Peri<'static, I2C1>,
    clock: Peri<'static, PA15>,
    data: Peri<'static, PB7>,
    tx: Peri<'static, DMA1_CH4>,
    rx: Peri<'static, DMA1_CH5>,
) -> Bus {
    let mut config = i2c::Config::default();
    config.frequency = khz(400);
    // Modules have their own; without a module these keep the bus quiet.
    config.scl_pullup = true;
    config.sda_pullup = true;
    I2c::new(i2c, clock, data, tx, rx, Interrupts, config)
}

/// Three buttons to ground.
pub struct Buttons([Input<'static>; 3]);

/// Ok, back, next.
pub fn contacts(
    ok: Peri<'static, PB4>,
    back: Peri<'static, PB5>,
    next: Peri<'static, PB10>,
) -> Buttons {
    Buttons([Input::new(ok, Pull::Up), Input::new(back, Pull::Up), Input::new(next, Pull::Up)])
}

impl Contacts for Buttons {
    fn down(&self) -> [bool; 3] {
        self.0.each_ref().map(Input::is_low)
    }
}

/// A passive piezo buzzer and the board's own light, LD2.
pub struct Buzzer {
    tone: SimplePwm<'static, TIM4>,
    light: Output<'static>,
}

/// Silent and dark.
pub fn sounder(
    timer: Peri<'static, TIM4>,
    buzzer: Peri<'static, PB6>,
    light: Peri<'static, PA5>,
) -> Buzzer {
    let pin = PwmPin::new(buzzer, OutputType::PushPull);
    let tone = SimplePwm::new(timer, Some(pin), None, None, None, khz(2), Default::default());
    Buzzer { tone, light: Output::new(light, Level::Low, Speed::Low) }
}

impl Sounder for Buzzer {
    fn tone(&mut self, hertz: Option<u32>) {
        let Some(hertz) = hertz else {
            self.tone.ch1().disable();
            self.light.set_low();
            return;
        };
        self.tone.set_frequency(Hertz(hertz));
        let mut channel = self.tone.ch1();
        channel.set_duty_cycle_percent(50);
        channel.enable();
        self.light.set_high();
    }
}

/// Brings pages to the glass.
#[embassy_executor::task]
pub async fn show(bus: Bus) {
    panel::drive_screen(bus, &WIRES).await;
}

/// Tells presses.
#[embassy_executor::task]
pub async fn watch(buttons: Buttons) {
    panel::watch_buttons(buttons, &WIRES).await;
}

/// Plays cues.
#[embassy_executor::task]
pub async fn play(buzzer: Buzzer) {
    panel::play_cues(buzzer, &WIRES).await;
}

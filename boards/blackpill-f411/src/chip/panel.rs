//! The panel's wires: screen on PB6 and PB7, buttons on PB12 to PB14, buzzer on PB8, light on PC13.

use embassy_stm32::gpio::{Input, Level, Output, OutputType, Pull, Speed};
use embassy_stm32::i2c::{self, I2c, Master};
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::{
    DMA1_CH0, DMA1_CH6, I2C1, PB6, PB7, PB8, PB12, PB13, PB14, PC13, TIM4,
};
use embassy_stm32::time::{Hertz, khz};
use embassy_stm32::timer::simple_pwm::{PwmPin, SimplePwm};
use embassy_stm32::{Peri, bind_interrupts, dma};
use massline_cortex_m::panel::{self, Contacts, Sounder, Wires};

bind_interrupts!(struct Interrupts {
    I2C1_EV => i2c::EventInterruptHandler<I2C1>;
    I2C1_ER => i2c::ErrorInterruptHandler<I2C1>;
    DMA1_STREAM6 => dma::InterruptHandler<DMA1_CH6>;
    DMA1_STREAM0 => dma::InterruptHandler<DMA1_CH0>;
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

/// Three buttons to ground.
pub struct Buttons([Input<'static>; 3]);

/// Ok, back, next.
pub fn contacts(
    ok: Peri<'static, PB12>,
    back: Peri<'static, PB13>,
    next: Peri<'static, PB14>,
) -> Buttons {
    Buttons([Input::new(ok, Pull::Up), Input::new(back, Pull::Up), Input::new(next, Pull::Up)])
}

impl Contacts for Buttons {
    fn down(&self) -> [bool; 3] {
        self.0.each_ref().map(Input::is_low)
    }
}

/// A passive piezo buzzer and the board's own light, which shines when its pin is low.
pub struct Buzzer {
    tone: SimplePwm<'static, TIM4>,
    light: Output<'static>,
}

/// Silent and dark.
pub fn sounder(
    timer: Peri<'static, TIM4>,
    buzzer: Peri<'static, PB8>,
    light: Peri<'static, PC13>,
) -> Buzzer {
    let pin = PwmPin::new(buzzer, OutputType::PushPull);
    let tone = SimplePwm::new(timer, None, None, Some(pin), None, khz(2), Default::default());
    Buzzer { tone, light: Output::new(light, Level::High, Speed::Low) }
}

impl Sounder for Buzzer {
    fn tone(&mut self, hertz: Option<u32>) {
        let Some(hertz) = hertz else {
            self.tone.ch3().disable();
            self.light.set_high();
            return;
        };
        self.tone.set_frequency(Hertz(hertz));
        let mut channel = self.tone.ch3();
        channel.set_duty_cycle_percent(50);
        channel.enable();
        self.light.set_low();
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

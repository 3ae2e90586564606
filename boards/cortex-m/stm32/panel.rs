//! The part of the panel's wiring that does not depend on the pins. Each board with an STM32 includes this
//! file, because the chip is a feature of the HAL.

use embassy_stm32::gpio::{Input, Level, OutputOpenDrain, Pin, Pull, Speed};
use embassy_stm32::i2c::{
    self, ErrorInterruptHandler, EventInterruptHandler, I2c, Master, RxDma, SclPin, SdaPin, TxDma,
};
use embassy_stm32::interrupt::typelevel::{Binding, I2C1_ER, I2C1_EV};
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::{I2C1, TIM4};
use embassy_stm32::time::{Hertz, khz};
use embassy_stm32::timer::Channel;
use embassy_stm32::timer::simple_pwm::SimplePwm;
use embassy_stm32::{Peri, PeripheralType, dma};
use massline_cortex_m::panel::Tone;
use massline_cortex_m::screen::ScreenBus;

/// The bus of the screen: I2C1 on the pins and with the transfers of a board, whose interrupts `I` binds.
pub struct Bus<C, D, T, R, I>
where
    C: PeripheralType + 'static,
    D: PeripheralType + 'static,
    T: PeripheralType + 'static,
    R: PeripheralType + 'static,
{
    /// The peripheral.
    pub i2c: Peri<'static, I2C1>,
    /// Clock.
    pub clock: Peri<'static, C>,
    /// Data.
    pub data: Peri<'static, D>,
    /// Transfer to the screen.
    pub tx: Peri<'static, T>,
    /// Transfer from it.
    pub rx: Peri<'static, R>,
    /// Its interrupts.
    pub interrupts: I,
}

impl<C, D, T, R, I> ScreenBus for Bus<C, D, T, R, I>
where
    C: SclPin<I2C1> + 'static,
    D: SdaPin<I2C1> + 'static,
    T: TxDma<I2C1> + 'static,
    R: RxDma<I2C1> + 'static,
    I: Binding<I2C1_EV, EventInterruptHandler<I2C1>>
        + Binding<I2C1_ER, ErrorInterruptHandler<I2C1>>
        + Binding<T::Interrupt, dma::InterruptHandler<T>>
        + Binding<R::Interrupt, dma::InterruptHandler<R>>
        + Copy
        + 'static,
{
    type Open<'a> = I2c<'a, Async, Master>;
    type Line<'a> = OutputOpenDrain<'a>;

    fn open(&mut self) -> Self::Open<'_> {
        let mut config = i2c::Config::default();
        config.frequency = khz(400);
        // Screen modules have their own pull-ups; without a module these keep the bus idle.
        config.scl_pullup = true;
        config.sda_pullup = true;
        let Self { i2c, clock, data, tx, rx, interrupts } = self;
        I2c::new(
            i2c.reborrow(),
            clock.reborrow(),
            data.reborrow(),
            tx.reborrow(),
            rx.reborrow(),
            *interrupts,
            config,
        )
    }

    fn is_free() -> bool {
        super::is_free()
    }

    fn lines(&mut self) -> [Self::Line<'_>; 2] {
        [line(self.clock.reborrow()), line(self.data.reborrow())]
    }
}

/// A line of the bus without the peripheral, let go; pulled up as with it.
fn line<'a>(pin: Peri<'a, impl Pin>) -> OutputOpenDrain<'a> {
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

//! The supply: a third of VSYS, which the Pico 2 connects to GP29. Its regulator makes 3.3 V of 1.8 to 5.5 V; the chip
//! resets itself only when its core voltage fails, at a level that the HAL sets.

use embassy_rp::Peri;
use embassy_rp::adc::{Adc, Blocking, Channel, Config};
use embassy_rp::gpio::{Level, Output, Pull};
use embassy_rp::pac;
use embassy_rp::peripherals::{ADC, PIN_23, PIN_29};
use massline_cortex_m::gauge;
use massline_firmware::board::Supply;
use static_cell::StaticCell;

/// The converter's input of GP29.
const INPUT: u8 = 3;
/// Above the 2.4 V at which the protection of the cell switches off without a warning.
const LOW: u16 = code_of(3.0);
/// Times that the converter is looked at before it is given up; it takes 2 µs.
const LOOKS: u32 = 10_000;

/// Code of the converter, 12 bits of 3.3 V, at this voltage of VSYS.
const fn code_of(volts: f32) -> u16 {
    (volts / 3.0 / 3.3 * 4096.0) as u16
}

/// The supply of this board.
pub const SUPPLY: Supply = Supply { is_low, brown_out: None, battery: Some(gauge::battery) };

/// The parts of the chip and the board that concern the supply.
pub struct Parts {
    /// The converter.
    pub adc: Peri<'static, ADC>,
    /// A third of VSYS.
    pub vsys: Peri<'static, PIN_29>,
    /// High: the regulator switches at a constant rate, and its ripple stays out of the band. Low, it saves power in
    /// bursts.
    pub constant_rate: Peri<'static, PIN_23>,
}

/// Makes the regulator quiet and the converter ready.
pub fn watch(parts: Parts) {
    static KEPT: StaticCell<(Adc<'static, Blocking>, Channel<'static>, Output<'static>)> =
        StaticCell::new();
    KEPT.init((
        Adc::new_blocking(parts.adc, Config::default()),
        Channel::new_pin(parts.vsys, Pull::None),
        Output::new(parts.constant_rate, Level::High),
    ));
}

/// True when VSYS is low, or cannot be read.
fn is_low() -> bool {
    pac::ADC.cs().modify(|w| {
        w.set_ainsel(INPUT);
        w.set_start_once(true);
    });
    let is_read = (0..LOOKS).any(|_| pac::ADC.cs().read().ready());
    !is_read || pac::ADC.result().read().result() < LOW
}

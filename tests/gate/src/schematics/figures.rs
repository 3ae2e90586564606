//! Figures of the circuit, computed from the values of its parts. Units are SI.

use std::f64::consts::{PI, TAU};

use anyhow::Context;
use massline_boards::part::in_si;

use crate::source::{DrawnBoard, Parts};

/// Mains, V and Hz, and the coupling to it for which the circuit is made, F.
const MAINS: (f64, f64) = (230.0, 50.0);
const COUPLING: f64 = 1e-12;
/// Output resistance of an ADXL326, Ω, and its sensitivity at 3 V, V per g; both by its data sheet.
const SENSOR_OHM: f64 = 32e3;
pub const VOLT_PER_G: f64 = 0.057;
/// Picture frequency of an SSD1306, Hz, at which its current changes most, and by how much: peak to peak, A.
const PICTURE_HZ: f64 = 105.0;
const PICTURE_A: f64 = 0.010;
/// Gain-bandwidth product of an MCP6004, Hz, and its output resistance, Ω: with 500 pF the phase margin is 45°, says
/// its data sheet, so the pole of both lies where the open loop, with the pole, has the gain 1: at 1 MHz/√2.
const GAIN_BANDWIDTH: f64 = 1e6;
const OUTPUT_OHM: f64 = std::f64::consts::SQRT_2 / (TAU * GAIN_BANDWIDTH * 500e-12);
/// Capacitance of 1 m of cable, F.
const CABLE: f64 = 150e-12;
/// Supply of the circuit, V.
const SUPPLY: f64 = 3.3;

/// What the values of the parts give.
pub struct Figures {
    /// Acceleration that 1 pF to mains pretends, g rms: with 32 kΩ at the end of the cable, and as it is.
    pub mains_before: f64,
    pub mains: f64,
    /// The same for the few millimetres between sensor and follower.
    pub mains_at_sensor: f64,
    /// What the screen's ripple pretends, g rms: screen on the board's supply, and on its own regulator.
    pub ripple_before: f64,
    pub ripple: f64,
    /// Phase margin of a follower with resistor, cable and capacitor at the input, degrees.
    pub phase_margin: f64,
    /// Delay of that resistor and capacitor, s.
    pub delay: f64,
    /// Largest share of the difference to the channel before that an input keeps.
    pub kept: f64,
    /// Largest current of the buzzer's pin, A.
    pub buzzer: f64,
    /// Mean current out of the cell, A, and time until it is at 3.5 V, hours.
    pub current: f64,
    pub hours: f64,
    /// Price of all parts without hammer, euro.
    pub euro: f64,
}

/// Computes the figures of a rig with this board.
///
/// # Errors
/// When a part has no value with a unit.
pub fn figures(parts: &Parts, board: &DrawnBoard) -> anyhow::Result<Figures> {
    let value = |name: &str| in_si(&parts.value(board, name)).with_context(|| name.to_owned());
    let (filter, resistor, input) = (value("C11")?, value("R11")?, value("C41")?);
    let at_sensor = SENSOR_OHM / (TAU * MAINS.1 * SENSOR_OHM * filter).hypot(1.0);
    let current = current(parts, board);
    let charge = f64::from(parts.cell.milliamp_hours * parts.cell.usable_percent) / 100e3;
    let count = parts.sensor.count;
    Ok(Figures {
        mains_before: mains(COUPLING, at_sensor),
        mains: mains(COUPLING, resistor),
        mains_at_sensor: mains(at_trace(), at_sensor),
        ripple_before: ripple(0.5, filter),
        ripple: ripple(1.0 * 0.01, filter),
        phase_margin: phase_margin(resistor, input),
        delay: resistor * input,
        kept: 15e-12 / input,
        buzzer: SUPPLY / value("R5")?,
        current,
        hours: charge / current,
        euro: parts.bill(board).map(|p| f64::from(p.count(count) * p.cents)).sum::<f64>() / 100.0,
    })
}

/// Acceleration that the current through a capacitance to mains pretends, g rms.
fn mains(farad: f64, ohm: f64) -> f64 {
    TAU * MAINS.1 * farad * MAINS.0 * ohm / VOLT_PER_G
}

/// Capacitance from a conductor of 10 mm × 1 mm over a ground plane to a mains wire 0.1 m away, F. The field of a wire
/// of 1 mm radius, 1 m from ground, is V/(r ln(2h/a)); three times that at edges. Its flux through the area is the
/// charge.
fn at_trace() -> f64 {
    const VACUUM: f64 = 8.854e-12;
    3.0 * VACUUM * (0.010 * 0.001) / (0.1 * (2.0_f64 / 0.001).ln())
}

/// What the screen's ripple pretends, g rms, when its current passes a resistance into the sensors' supply. A sensor at
/// half of the supply follows it through the filter, the converter at once; what differs is x/√(1 + x²) of half of it.
fn ripple(ohm: f64, filter: f64) -> f64 {
    let x = PICTURE_HZ * TAU * SENSOR_OHM * filter;
    let volt = PICTURE_A / 8.0_f64.sqrt() * ohm;
    0.5 * volt * x / x.hypot(1.0) / VOLT_PER_G
}

/// Phase margin of a follower that drives a resistor with a capacitor behind it, degrees.
fn phase_margin(ohm: f64, farad: f64) -> f64 {
    let farad = farad + CABLE;
    let (pole, zero) = (1.0 / (TAU * (OUTPUT_OHM + ohm) * farad), 1.0 / (TAU * ohm * farad));
    let gain = |f: f64| GAIN_BANDWIDTH / f * (f / zero).hypot(1.0) / (f / pole).hypot(1.0);
    let (mut low, mut high) = (1.0_f64, GAIN_BANDWIDTH);
    for _ in 0..100 {
        let middle = (low * high).sqrt();
        if gain(middle) > 1.0 { low = middle } else { high = middle }
    }
    90.0 + ((low / zero).atan() - (low / pole).atan()) * 180.0 / PI
}

/// Mean current out of the cell, A.
fn current(parts: &Parts, board: &DrawnBoard) -> f64 {
    let count = parts.sensor.count;
    let amperes = |panel: bool| {
        let parts = parts.bill(board).filter(|part| part.panel == panel);
        parts.map(|part| f64::from(part.count(count) * part.microamps)).sum::<f64>() / 1e6
    };
    let gain = board.wiring.power.efficiency_percent.map_or(1.0, |percent| {
        let cell = f64::from(parts.cell.millivolts) / 1e3;
        SUPPLY / cell * 100.0 / f64::from(percent)
    });
    amperes(false) * gain + amperes(true)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: 2π · 50 Hz · 1 pF · 230 V = 72.26 nA; in 32 kΩ beside 10 nF, 31.84 kΩ, 2.301 mV, 40.4 mg.
    #[test]
    fn the_pick_up_is_that_of_a_calculation_by_hand() {
        let at_sensor = 32e3 / (TAU * 50.0 * 32e3 * 1e-8_f64).hypot(1.0);
        assert!((mains(1e-12, at_sensor) - 0.04036).abs() < 1e-5);
    }

    /// By the data sheet: 45° with 500 pF and no resistor. Its value is stated in whole degrees.
    #[test]
    fn the_phase_margin_is_that_of_the_data_sheet() {
        assert!((phase_margin(1e-3, 500e-12 - CABLE) - 45.0).abs() < 0.5);
    }
}

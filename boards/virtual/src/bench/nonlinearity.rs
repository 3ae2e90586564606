//! The integral nonlinearity of the converter.

use std::f64::consts::TAU;

use super::Bench;
use super::errors::TestErrors;

/// Periods of the sine over the full scale.
const PERIODS: f64 = 3.0;

/// How far the converter's characteristic lies from a straight line: a sine and a parabola.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nonlinearity {
    /// Peak of the sine, LSB.
    sine_lsb: f64,
    /// Phase of the sine at code zero, rad.
    phase: f64,
    /// The parabola at mid scale, LSB.
    bow_lsb: f64,
    /// Codes from one end of the scale to the other.
    codes: f64,
}

impl Nonlinearity {
    pub(super) fn new(bench: &Bench, errors: &TestErrors) -> Self {
        let adc = &bench.adc;
        Self {
            sine_lsb: adc.inl_lsb,
            phase: errors.inl_phase,
            bow_lsb: adc.bow_lsb,
            codes: f64::from(1_u32 << adc.bits),
        }
    }

    /// The deviation at a position on the scale, both in LSB.
    pub(super) fn at(&self, code: f64) -> f64 {
        let share = (code / self.codes).clamp(0.0, 1.0);
        self.sine_lsb * (TAU * PERIODS * share + self.phase).sin()
            + self.bow_lsb * 4.0 * share * (1.0 - share)
    }
}

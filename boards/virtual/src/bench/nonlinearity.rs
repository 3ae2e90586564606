//! The integral and the differential nonlinearity of the converter.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::Bench;
use super::errors::TestErrors;

/// Periods of the sine over the full scale.
const PERIODS: f64 = 3.0;

/// How far the converter's characteristic lies from a straight line: a sine and a parabola, and steps of unequal width.
#[derive(Clone, Debug)]
pub(super) struct Nonlinearity {
    /// Peak of the sine, LSB.
    sine_lsb: f64,
    /// Phase of the sine at code zero, rad.
    phase: f64,
    /// The parabola at mid scale, LSB.
    bow_lsb: f64,
    /// Codes from one end of the scale to the other.
    codes: f64,
    /// How far the transition to each code from the one below is displaced, LSB; empty without differential
    /// nonlinearity.
    displaced: Vec<f32>,
}

impl Nonlinearity {
    pub(super) fn new(bench: &Bench, errors: &TestErrors) -> Self {
        let adc = &bench.adc;
        let codes = 1_u32 << adc.bits;
        let displaced = if adc.dnl_lsb > 0.0 {
            let mut rng = ChaCha8Rng::seed_from_u64(errors.dnl_seed);
            let mut draw = || adc.dnl_lsb * (rng.random::<f64>() - 0.5);
            (0..codes).map(|_| draw() as f32).collect()
        } else {
            Vec::new()
        };
        Self {
            sine_lsb: adc.inl_lsb,
            phase: errors.inl_phase,
            bow_lsb: adc.bow_lsb,
            codes: f64::from(codes),
            displaced,
        }
    }

    /// The code of a position on the scale, LSB.
    pub(super) fn code(&self, position: f64) -> u16 {
        let position = position + self.at(position);
        let last = self.codes - 1.0;
        let nearest = position.round().clamp(0.0, last);
        let displaced = |code: f64| self.displaced.get(code as usize).copied().map(f64::from);
        // No transition is displaced by more than half an LSB, so that the code is the nearest one or next to it.
        let below = |code: f64| displaced(code).is_some_and(|d| position < code - 0.5 + d);
        let above = |code: f64| displaced(code).is_some_and(|d| position >= code - 0.5 + d);
        if nearest > 0.0 && below(nearest) {
            (nearest - 1.0) as u16
        } else if nearest < last && above(nearest + 1.0) {
            (nearest + 1.0) as u16
        } else {
            nearest as u16
        }
    }

    /// The integral deviation at a position on the scale, both in LSB.
    pub(super) fn at(&self, code: f64) -> f64 {
        if self.sine_lsb == 0.0 && self.bow_lsb == 0.0 {
            return 0.0;
        }
        let share = (code / self.codes).clamp(0.0, 1.0);
        self.sine_lsb * (TAU * PERIODS * share + self.phase).sin()
            + self.bow_lsb * 4.0 * share * (1.0 - share)
    }
}

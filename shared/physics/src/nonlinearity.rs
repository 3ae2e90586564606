//! The integral and the differential nonlinearity of the converter.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::errors::TestErrors;
use crate::bench::Bench;

/// Periods of the sine over the full scale.
const PERIODS: f64 = 3.0;

/// How far the converter's characteristic lies from a straight line: a sine and a parabola, and steps of unequal
/// width.
#[derive(Clone, Debug)]
pub(super) struct Nonlinearity {
    /// The integral deviation at each code and at the end of the scale, LSB, straight in between; empty when there is
    /// none.
    curve: Vec<f64>,
    /// Where each code begins, LSB, and an end that is never reached; empty when all codes have the same width.
    begins: Vec<f64>,
    /// The last code.
    last: f64,
}

impl Nonlinearity {
    pub(super) fn new(bench: &Bench, errors: &TestErrors) -> Self {
        let adc = &bench.adc;
        let codes = 1_u32 << adc.bits;
        let deviation = |code: u32| {
            let share = f64::from(code) / f64::from(codes);
            adc.inl_lsb * (TAU * PERIODS * share + errors.inl_phase).sin()
                + adc.bow_lsb * 4.0 * share * (1.0 - share)
        };
        let straight = adc.inl_lsb == 0.0 && adc.bow_lsb == 0.0;
        Self {
            curve: if straight { Vec::new() } else { (0..=codes).map(deviation).collect() },
            begins: if adc.dnl_lsb > 0.0 {
                begins(codes, adc.dnl_lsb, errors.dnl_seed)
            } else {
                Vec::new()
            },
            last: f64::from(codes - 1),
        }
    }

    /// The integral deviation at a position on the scale, both in LSB.
    pub(super) fn at(&self, position: f64) -> f64 {
        let position = position.clamp(0.0, self.last + 1.0);
        let below = position as usize;
        match self.curve.get(below..) {
            Some([here, next, ..]) => here + (next - here) * (position - below as f64),
            Some([end]) => *end,
            _ => 0.0,
        }
    }

    /// The code of a position on the scale, LSB.
    pub(super) fn code(&self, position: f64) -> u16 {
        let position = position + self.at(position);
        // Half up, which is the nearest for all that is not negative.
        let nearest = (position + 0.5).clamp(0.0, self.last) as u16;
        match self.begins.get(usize::from(nearest)..) {
            // No code begins more than half an LSB from its place, so that it is the nearest or next to it.
            Some([begins, ends, ..]) => {
                nearest + u16::from(position >= *ends) - u16::from(position < *begins)
            }
            _ => nearest,
        }
    }
}

/// Where each code begins: half an LSB below it, displaced evenly by up to half of `dnl_lsb`.
fn begins(codes: u32, dnl_lsb: f64, seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut displaced = || dnl_lsb * (rng.random::<f64>() - 0.5);
    let first = std::iter::once(f64::NEG_INFINITY);
    let others = (1..codes).map(|code| f64::from(code) - 0.5 + displaced());
    first.chain(others).chain(std::iter::once(f64::INFINITY)).collect()
}

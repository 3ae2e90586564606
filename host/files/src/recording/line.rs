//! The straight line on which the times of even samples lie.

use std::ops::Range;

/// Largest deviation of a step from the mean, relative to it, at which the steps count as even.
pub(super) const EVEN: f64 = 1e-2;
/// How many last digits a rounded or truncated time may be away from its line.
const DIGITS: f64 = 1.05;

/// A straight line through times over their rows.
#[derive(Clone, Debug)]
pub(super) struct Line {
    rows: Range<usize>,
    /// Mean row and mean time, which the line goes through.
    center: [f64; 2],
    /// The step from row to row.
    pub(super) step: f64,
    /// Relative uncertainty of the step.
    pub(super) uncertainty: f64,
}

impl Line {
    /// The line of least squares, weighted by the digits of the times.
    pub(super) fn through(values: &[f64], digits: &[f64], rows: Range<usize>) -> Self {
        let first = values.get(rows.start).copied().unwrap_or_default();
        let last = rows.end.checked_sub(1).and_then(|k| values.get(k)).copied().unwrap_or(first);
        let mean = (last - first) / rows.len().saturating_sub(1).max(1) as f64;
        let points = || {
            rows.clone().zip(values.get(rows.clone()).unwrap_or_default()).map(|(k, value)| {
                let digit = digits.get(k).copied().unwrap_or_default();
                let weight = mean * mean / (digit * digit + EVEN * EVEN * mean * mean);
                let weight = if weight.is_finite() { weight } else { 1.0 };
                (weight, (k - rows.start) as f64, value - first)
            })
        };
        let total: f64 = points().map(|(w, ..)| w).sum();
        let row = points().map(|(w, k, _)| w * k).sum::<f64>() / total;
        let time = points().map(|(w, _, t)| w * t).sum::<f64>() / total;
        let square: f64 = points().map(|(w, k, _)| w * (k - row) * (k - row)).sum();
        let product: f64 = points().map(|(w, k, t)| w * (k - row) * (t - time)).sum();
        let step = if square > 0.0 { product / square } else { mean };
        // The weights are those of deviations of a digit, in steps.
        let uncertainty = if square > 0.0 { square.sqrt().recip() } else { 1.0 };
        Self { center: [rows.start as f64 + row, first + time], rows, step, uncertainty }
    }

    /// The line through the same centre with the step of another.
    pub(super) fn with_step_of(self, other: &Self) -> Self {
        Self { step: other.step, ..self }
    }

    /// Whether all times lie on this line to within their digits.
    pub(super) fn fits(&self, values: &[f64], digits: &[f64]) -> bool {
        self.is_near(values, digits, EVEN)
    }

    /// Whether all times lie within so many steps of this line, and their digits.
    pub(super) fn is_near(&self, values: &[f64], digits: &[f64], steps: f64) -> bool {
        let [row, time] = self.center;
        self.rows.clone().all(|k| {
            let (value, digit) = (
                values.get(k).copied().unwrap_or(f64::NAN),
                digits.get(k).copied().unwrap_or_default(),
            );
            let deviation = (value - time - (k as f64 - row) * self.step).abs();
            deviation <= DIGITS * digit + steps * self.step.abs()
        })
    }
}

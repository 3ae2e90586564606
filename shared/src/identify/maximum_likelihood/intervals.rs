//! Interval widths under a learned budget: wider by what learning does not know (theory, section 12).

use nalgebra::SVector;

use crate::identify::budget::LearnedBudget;
use crate::real::Real;

/// An interval is wider by this number times the squared relative standard deviation of its own width.
pub(super) const WIDENING: f64 = 1.4;

/// How much of the variance of each property comes from what stays the same over the test.
#[derive(Clone, Debug)]
pub(super) struct Shares<R> {
    /// Variance of theta, balanced.
    pub(super) variance: SVector<R, 10>,
    /// The part of the sensors and the marks, balanced.
    pub(super) constant: SVector<R, 10>,
}

impl<R: Real> Shares<R> {
    pub(super) fn none() -> Self {
        Self { variance: SVector::zeros(), constant: SVector::zeros() }
    }

    /// Factors on the half widths of the intervals of theta, at least one.
    pub(super) fn widening(&self, learned: &LearnedBudget<R>) -> SVector<R, 10> {
        let freedom = learned.scatter_degrees_of_freedom;
        let of_scatter = match freedom {
            0 => R::zero(),
            _ => R::of(1.0 / (2.0 * f64::from(freedom))),
        };
        self.constant.zip_map(&self.variance, |part, whole| {
            let share = if whole > R::zero() { part / whole } else { R::zero() };
            let others = R::one() - share;
            let squared =
                share * share * learned.constant_log_variance + others * others * of_scatter;
            R::one() + R::of(WIDENING) * squared
        })
    }
}

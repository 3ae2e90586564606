//! Whether the methods agree, and the best estimate of all of them.
//!
//! All methods use the same data, so their errors are not independent: adding variances makes a blind test, and means
//! that are weighted with single variances have intervals that cover 75 % instead of 95 %. [`Propagation`] puts the
//! same small changes of data and layout through every method, from which the covariance of each answer and of every
//! pair follows. [`Agreement`] judges the differences with it and combines the answers by generalised least squares.

mod combination;
mod difference;
mod propagation;
#[cfg(test)]
mod tests;

use super::METHODS;

pub use combination::{Agreement, Outcome};
pub use difference::{Difference, MOST_PAIRS};
pub use propagation::{Answers, NOISE_DRAWS, Propagation, ask, changes};

/// Most methods that are compared: all of them.
pub const MOST_METHODS: usize = METHODS;

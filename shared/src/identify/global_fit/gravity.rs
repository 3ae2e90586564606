//! Where gravity points: the layout's direction with the errors that the readings give it.

use nalgebra::{Matrix2, Vector2, Vector3};

use super::FittedGravity;
use super::fit::Fit;
use crate::capacity::Capacity;
use crate::estimated::EstimatedValue;
use crate::layout::GRAVITY_QUANTITIES;
use crate::real::Real;

impl<R: Real, C: Capacity> Fit<'_, '_, '_, R, C> {
    /// Gravity with its errors, when the layout states it and a sensor senses it.
    pub(super) fn fitted_gravity(&mut self) -> Option<FittedGravity<R>> {
        let layout = self.problem.layout;
        let stated = layout.gravity.filter(|_| layout.senses_gravity())?;
        let slopes = layout.gravity_slopes();
        let (errors, covariance) = self.gravity_errors();
        let change = slopes[0] * errors[0] + slopes[1] * errors[1];
        let components = core::array::from_fn(|axis| {
            let slope = Vector2::new(slopes[0][axis], slopes[1][axis]);
            let sigma = (covariance * slope).dot(&slope).max(R::zero()).sqrt();
            EstimatedValue { value: stated[axis] + change[axis], sigma }
        });
        // Both rotations are across gravity.
        let angle = (change.norm() / Vector3::from(stated).norm()).atan();
        Some(FittedGravity { components, angle, pull: errors.norm() })
    }

    /// The errors of the direction in their standard deviations, with their covariance; zero without an error budget.
    fn gravity_errors(&mut self) -> (Vector2<R>, Matrix2<R>) {
        if !self.unknowns.budget {
            return (Vector2::zeros(), Matrix2::zeros());
        }
        let (first, len) = (self.unknowns.gravity(), self.unknowns.len());
        let errors = Vector2::from_column_slice(&self.memory.x[first..][..GRAVITY_QUANTITIES]);
        let columns = [0, 1].map(|k| {
            let column = self.covariances_with(first + k, len);
            Vector2::from_column_slice(&column[first..][..GRAVITY_QUANTITIES])
        });
        (errors, Matrix2::from_columns(&columns))
    }
}

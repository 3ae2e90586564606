//! The pulls: how far the errors must have moved to explain the readings, which sensor or hit is the first suspect, and
//! where gravity points.

use core::array::from_fn;

use heapless::Vec;
use nalgebra::{Matrix2, Vector2, Vector3};

use super::FittedGravity;
use super::fit::Fit;
use super::memory::Memory;
use super::packed::solve;
use crate::Real;
use crate::diagnosis::{Code, Diagnostic, Severity, Subject};
use crate::estimated::Estimated;
use crate::identify::maximum_likelihood::model::SENSOR_NUISANCES;
use crate::identify::maximum_likelihood::pulls::{SUSPICIOUS, root_mean_square};
use crate::layout::{GRAVITY_QUANTITIES, HIT_QUANTITIES};

/// The length of a force is suspect from so many of the standard deviations that its error has under the model, which chance
/// exceeds once in 400 tests of five hits; that counts as a pull of [`SUSPICIOUS`].
const SUSPECT_LENGTH: f64 = 3.5;

impl<R: Real, const S: usize, const H: usize> Fit<'_, '_, '_, R, S, H> {
    /// Gravity with its errors, when the layout states it and a sensor senses it.
    pub(super) fn fitted_gravity(&mut self) -> Option<FittedGravity<R>> {
        let (problem, unknowns) = (self.problem, &self.unknowns);
        let stated = problem.layout.gravity.filter(|_| problem.layout.senses_gravity())?;
        let (first, len) = (unknowns.gravity(), unknowns.len());
        let errors = unknowns.budget.then_some(first..first + GRAVITY_QUANTITIES);
        let u: [R; GRAVITY_QUANTITIES] =
            from_fn(|k| errors.as_ref().map_or(R::zero(), |all| self.memory.x[all.start + k]));
        let slopes = problem.layout.gravity_slopes();
        let covariance = match errors {
            Some(_) => Matrix2::from_columns(&[0, 1].map(|k| {
                let column = self.covariances_with(first + k, len);
                Vector2::new(column[first], column[first + 1])
            })),
            None => Matrix2::zeros(),
        };
        let change = slopes[0] * u[0] + slopes[1] * u[1];
        let components = from_fn(|axis| {
            let slope = Vector2::new(slopes[0][axis], slopes[1][axis]);
            let sigma = (covariance * slope).dot(&slope).max(R::zero()).sqrt();
            Estimated { value: stated[axis] + change[axis], sigma }
        });
        // Both rotations are across gravity.
        let angle = (change.norm() / Vector3::from(stated).norm()).atan();
        Some(FittedGravity { components, angle, pull: (u[0] * u[0] + u[1] * u[1]).sqrt() })
    }

    /// Covariances of all unknowns, of this many, with one of them.
    fn covariances_with(&mut self, place: usize, len: usize) -> &[R] {
        let Memory { factor, scale, scratch, .. } = &mut self.memory;
        let column = &mut scratch[..len];
        column.fill(R::zero());
        column[place] = scale[place];
        solve(factor, column);
        for (value, scale) in column.iter_mut().zip(&**scale) {
            *value *= *scale;
        }
        column
    }

    /// The error of the length of a hit's force in the standard deviations that it has under the model: those of the budget,
    /// less what the data leave open.
    fn pull_of_length(&mut self, hit: usize) -> R {
        let place = self.unknowns.hit(hit) + HIT_QUANTITIES - 1;
        let value = self.memory.x[place].abs();
        let open = self.covariances_with(place, self.unknowns.len())[place];
        let sigma = (R::one() - open).max(R::zero()).sqrt();
        // Without an error in the budget there is neither value nor deviation.
        if value > R::zero() { value / sigma } else { R::zero() }
    }

    /// The sensor or hit with the largest pull, as in maximum likelihood; `None` when no pull is large enough.
    pub(super) fn suspect(&mut self) -> Option<Diagnostic> {
        if self.unknowns.nuisances() == 0 {
            return None;
        }
        let hits = 0..self.problem.layout.hits.len();
        let lengths: Vec<R, H> = hits.map(|hit| self.pull_of_length(hit)).collect();
        let Self { problem, unknowns, .. } = self;
        let pull = |first: usize, count: usize| root_mean_square(&self.memory.x[first..][..count]);
        let of_sensors = (0..problem.layout.sensors.len()).map(|i| {
            let pull = pull(unknowns.sensor(i), SENSOR_NUISANCES);
            (pull, Code::LargeSensorPull, Subject::sensor(i))
        });
        let of_hits = lengths.iter().enumerate().map(|(j, length)| {
            let across = pull(unknowns.hit(j), HIT_QUANTITIES - 1);
            let pull = across.max(*length * R::of(SUSPICIOUS / SUSPECT_LENGTH));
            (pull, Code::LargeHitPull, Subject::hit(j))
        });
        let all = of_sensors.chain(of_hits).filter(|(pull, ..)| *pull > R::of(SUSPICIOUS));
        let (pull, code, subject) = all.reduce(|a, b| if b.0 > a.0 { b } else { a })?;
        Some(Diagnostic::about(code, Severity::Warning, subject, pull.to_f32()))
    }
}

//! Determines which part of the variances comes from the sensors and the marks (theory, section 12).

use nalgebra::SVector;

use super::fit::Fit;
use super::fit_problem::FitProblem;
use super::model::{Model, SENSOR_NUISANCES};
use super::normal_equations::NormalEquations;
use super::undetermined;
use crate::capacity::Capacity;
use crate::diagnosis::Diagnostics;
use crate::identify::{DofMassLines, Progress};
use crate::real::Real;

impl<R: Real> Fit<R> {
    /// Adds the shares of the sensors (`place` is `None`) or of the mark of one DOF, from completed equations.
    ///
    /// # Errors
    /// When the model cannot be evaluated.
    pub(super) fn add_shares<C: Capacity>(
        &mut self,
        place: Option<usize>,
        problem: &FitProblem<'_, R, C>,
        dofs: &[DofMassLines<R, C>],
        equations: &mut NormalEquations<'_, R>,
    ) -> Result<Progress, Diagnostics> {
        let object = self.object().ok_or_else(undetermined)?;
        let slopes = object.dtheta_dphi();
        let nuisances = problem.nuisances();
        let of_sensors = SENSOR_NUISANCES * problem.layout.sensors.len();
        let Some(place) = place else {
            for k in 0..10 {
                let slope = slopes.row(k);
                let solved = equations.solve(|right| {
                    right[nuisances..].iter_mut().zip(slope.iter()).for_each(|(to, v)| *to = *v);
                });
                let inertial = &solved[nuisances..];
                self.shares.variance[k] =
                    slope.iter().zip(inertial).fold(R::zero(), |sum, (d, y)| sum + *d * *y);
                self.shares.constant[k] =
                    solved[..of_sensors].iter().fold(R::zero(), |sum, y| sum + *y * *y);
            }
            return Ok(Progress::Going);
        };
        let Some((index, lines)) = dofs.get(place) else { return Ok(Progress::Done) };
        let body = problem.body_of(&object.phi()).ok_or_else(undetermined)?;
        let model = Model::new(problem.layout, &problem.balance, &body).ok_or_else(undetermined)?;
        let errors = equations.hit_errors(place);
        let terms = problem.terms(&model, *index, lines, &errors).ok_or_else(undetermined)?;
        let marks = problem.hit_uncertainty(*index).ok_or_else(undetermined)?;
        let (position, direction) = marks.of_mean(lines.hits);
        let part = |mark: R, whole: R| {
            if whole > R::zero() { (mark / whole) * (mark / whole) } else { R::zero() }
        };
        let parts = [part(marks.node_position, position), part(marks.node_direction, direction)];
        problem.with_rows(&model, &terms, |rows| {
            for (k, spread) in terms.model.spread.0.iter().enumerate() {
                let weighted = terms.weight.times(spread);
                let solved = equations.solve_readings(rows, &weighted);
                let inertial = SVector::<R, 10>::from_fn(|i, _| solved[nuisances + i]);
                let moved = slopes * inertial;
                self.shares.constant += moved.component_mul(&moved) * parts[k / 2];
            }
        });
        Ok(if place + 1 < dofs.len() { Progress::Going } else { Progress::Done })
    }
}

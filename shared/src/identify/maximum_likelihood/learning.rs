//! Learns the error budget from the data, with the stated budget as prior (theory, section 12).
//!
//! Two things can be learned: the scatter of the hits, from the differences between repeat hits, and one scale
//! for everything that stays the same over the test, from the residuals of the fit.

use nalgebra::{Matrix4, SMatrix};

use super::fit::Fit;
use super::fit_problem::FitProblem;
use super::model::{HIT_NUISANCES, Model, SENSOR_NUISANCES};
use super::normal_equations::NormalEquations;
use super::undetermined;
use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostics, Severity};
use crate::identify::budget::{BudgetScales, LearnedBudget, LearnedFrom};
use crate::identify::{DofMassLines, MassLines, Progress};
use crate::layout::{HitUncertainty, Layout};
use crate::linalg::cholesky;
use crate::real::Real;
use crate::responses::{ResponseRows, Responses};

/// Weight of the stated scatter, in degrees of freedom.
const PRIOR_FREEDOM: f64 = 2.0;
/// Fewest degrees of freedom from which a scatter is learned.
const LEAST_SCATTER_FREEDOM: u16 = 4;
/// Fewest degrees of freedom of the residuals from which the constant scale is learned.
pub(super) const LEAST_RESIDUAL_FREEDOM: u16 = 8;
/// Prior standard deviation of the logarithm of the constant scale, ln 3: the stated standard deviations are
/// right within a factor of three.
pub(super) const LOG_SCALE_SIGMA: f64 = 1.098_612_288_668_109_8;
/// Standard deviation of the hits' directions from which terms of higher order count, rad.
pub(super) const MOST_SCATTER: f64 = 0.08;
/// Longest step of the logarithm.
pub(super) const LONGEST_STEP: f64 = 0.7;
/// The iteration ends with a step shorter than this part of the standard deviation of the logarithm. Each step
/// is many times shorter than the one before.
pub(super) const SHORT_STEP: f64 = 0.05;
/// Largest number of steps; four are usual.
const MOST_STEPS: u8 = 12;

/// Sums over the repeat hits of all DOFs, for position or direction.
#[derive(Clone, Copy, Debug)]
struct Scatter<R> {
    /// Squared distances from the mean, beyond noise, relative to the stated variance.
    squares: R,
    /// Degrees of freedom: two for each hit but the first.
    freedom: u16,
}

impl<R: Real> Scatter<R> {
    fn none() -> Self {
        Self { squares: R::zero(), freedom: 0 }
    }

    fn add(&mut self, squares: R, stated: R, hits: u16) {
        if stated > R::zero() {
            self.squares += squares / (stated * stated);
            self.freedom = self.freedom.saturating_add((hits - 1).saturating_mul(2));
        }
    }

    /// Learned over stated standard deviation, and the degrees of freedom that taught it; the stated one when
    /// there are too few.
    fn scale(&self) -> (R, u16) {
        if self.freedom < LEAST_SCATTER_FREEDOM {
            return (R::one(), 0);
        }
        let (prior, freedom) = (R::of(PRIOR_FREEDOM), R::of(f64::from(self.freedom)));
        let variance = (prior + self.squares.max(R::zero())) / (prior + freedom);
        (variance.sqrt(), self.freedom)
    }
}

/// Squared distances of the repeat hits from their mean position (m²) and direction (rad²) beyond what noise
/// explains; `None` when the scatter is unknown or a displacement and a rotation look alike.
fn scatter_of<R: Real, C: Capacity>(
    problem: &FitProblem<'_, R, C>,
    model: &Model<R, C>,
    index: usize,
    lines: &MassLines<R, C>,
) -> Option<[R; 2]> {
    let known = (0..problem.channels).any(|k| lines.scatter[(k, k)] > R::zero());
    if lines.hits < 2 || !known {
        return None;
    }
    // The readings for a displacement of one metre and a rotation of one radian.
    let unit = HitUncertainty { position: R::one(), direction: R::one(), ..HitUncertainty::none() };
    let hit = problem.layout.hits.get(index)?;
    let errors = [R::zero(); HIT_NUISANCES];
    let columns = model.hit(hit, &unit, &problem.balance, 1, &errors)?.spread;
    let inverse = pseudo_inverse(&columns)?;
    let freedom = R::of(f64::from(lines.hits - 1));
    let hits = R::of(f64::from(lines.hits));
    let mut squares = [R::zero(); 2];
    for (k, row) in inverse.0.iter().enumerate() {
        let measured = row.dot(&lines.scatter.times(row));
        let noise = row.zip_map(&lines.noise, |r: R, sigma: R| r * r * sigma * sigma).sum() * hits;
        squares[k / 2] += (measured - noise) * freedom;
    }
    Some(squares)
}

/// `(UᵀU)⁻¹ Uᵀ` of four columns; `None` when they are linearly dependent.
fn pseudo_inverse<R: Real, C: Capacity>(
    columns: &ResponseRows<R, C, HIT_NUISANCES>,
) -> Option<ResponseRows<R, C, HIT_NUISANCES>> {
    let scale = columns.0.each_ref().map(Responses::norm);
    let products: Matrix4<R> =
        SMatrix::from_fn(|i, j| columns.0[i].dot(&columns.0[j]) / (scale[i] * scale[j]));
    let factor = cholesky(&products)?;
    let mut inverse = ResponseRows::<R, C, HIT_NUISANCES>::zeros(columns.sensors());
    for i in 0..HIT_NUISANCES {
        let mut unit = nalgebra::SVector::<R, HIT_NUISANCES>::zeros();
        unit[i] = R::one();
        crate::linalg::forward_substitute(&factor, &mut unit);
        crate::linalg::back_substitute_transposed(&factor, &mut unit);
        for (k, column) in columns.0.iter().enumerate() {
            inverse.0[i].add_multiple(column, unit[k] / (scale[i] * scale[k]));
        }
    }
    Some(inverse)
}

impl<R: Real> Fit<R> {
    /// Learns the scatter of the hits.
    ///
    /// # Errors
    /// When the model cannot be evaluated.
    // Never inlined: this saves with the other steps of learning and the refinement 2.3 KB of the firmware's deepest
    // stack.
    #[inline(never)]
    pub(super) fn learn_scatter<C: Capacity>(
        &mut self,
        problem: &FitProblem<'_, R, C>,
        dofs: &[DofMassLines<R, C>],
    ) -> Result<(), Diagnostics> {
        let body = problem.body_of(&self.parameters.phi()).ok_or_else(undetermined)?;
        let model = Model::new(problem.layout, &problem.balance, &body).ok_or_else(undetermined)?;
        let (mut position, mut direction) = (Scatter::none(), Scatter::none());
        for (index, lines) in dofs {
            let Some(squares) = scatter_of(problem, &model, *index, lines) else { continue };
            let Some(hit) = problem.layout.hits.get(*index) else { continue };
            position.add(squares[0], hit.uncertainty.position, lines.hits);
            direction.add(squares[1], hit.uncertainty.direction, lines.hits);
        }
        let (hit_position, of_position) = position.scale();
        let (hit_direction, of_direction) = direction.scale();
        self.learned = Some(LearnedBudget {
            scales: BudgetScales { hit_position, hit_direction, constant: R::one() },
            scatter_degrees_of_freedom: of_position.max(of_direction),
            learned_from: LearnedFrom::RepeatHits,
            constant_log_variance: R::zero(),
            widening: [R::one(); 10],
        });
        Ok(())
    }

    /// Says what could not be learned, and that hits scatter more than the fit can follow.
    pub(super) fn judge_learning<C: Capacity>(&mut self, problem: &FitProblem<'_, R, C>) {
        let Some(learned) = self.learned else { return };
        if learned.scatter_degrees_of_freedom == 0 {
            self.push_diagnostic(Code::ScatterNotLearned, Severity::Note, R::zero());
        }
        if learned.constant_log_variance == R::zero() {
            let freedom = R::of(f64::from(self.consistency().degrees_of_freedom));
            self.push_diagnostic(Code::ScaleNotLearned, Severity::Note, freedom);
        }
        let directions = problem.layout.hits.iter().map(|hit| hit.uncertainty.direction);
        let largest = directions.fold(R::zero(), R::max) * learned.scales.hit_direction;
        if learned.scatter_degrees_of_freedom > 0 && largest > R::of(MOST_SCATTER) {
            let milliradians = largest * R::of(1e3);
            self.push_diagnostic(Code::HitsScatterMuch, Severity::Warning, milliradians);
        }
    }

    /// Expresses the errors of the hits, which do not change, in the standard deviations of the learned budget.
    pub(super) fn rescale_hit_errors<C: Capacity>(
        &self,
        before: &FitProblem<'_, R, C>,
        layout: &Layout<R, C>,
        dofs: &[DofMassLines<R, C>],
        equations: &mut NormalEquations<'_, R>,
    ) {
        let now = self.problem(layout);
        for (place, (index, lines)) in dofs.iter().enumerate() {
            let of_mean = |problem: &FitProblem<'_, R, C>| {
                let uncertainty = problem.hit_uncertainty(*index)?;
                let (position, direction) = uncertainty.of_mean(lines.hits);
                Some([position, position, direction, direction])
            };
            let (Some(before), Some(now)) = (of_mean(before), of_mean(&now)) else { continue };
            let errors = equations.hit_errors(place);
            let rescaled = core::array::from_fn(|k| {
                if now[k] > R::zero() { errors[k] * before[k] / now[k] } else { R::zero() }
            });
            equations.set_hit_errors(place, rescaled);
        }
    }

    /// True when the residuals are enough to learn the scale of what stays the same over the test.
    pub(super) fn can_learn_scale<C: Capacity>(&self, problem: &FitProblem<'_, R, C>) -> bool {
        let stated = |sensor: &crate::layout::Sensor<R>| {
            let u = &sensor.uncertainty;
            u.gain.max(u.cross_axis).max(u.rotation).max(u.position) > R::zero()
        };
        self.consistency().degrees_of_freedom >= LEAST_RESIDUAL_FREEDOM
            && problem.layout.sensors.iter().any(stated)
    }

    /// One step of the constant scale by restricted maximum likelihood with a log-normal prior, from the
    /// evaluated equations. Afterwards the equations cannot be used.
    ///
    /// # Errors
    /// When the equations cannot be solved.
    // Never inlined: this saves with the other steps of learning and the refinement 2.3 KB of the firmware's deepest
    // stack.
    #[inline(never)]
    pub(super) fn learn_scale<C: Capacity>(
        &mut self,
        steps: u8,
        problem: &FitProblem<'_, R, C>,
        equations: &mut NormalEquations<'_, R>,
    ) -> Result<Progress, Diagnostics> {
        let Some(learned) = &mut self.learned else { return Ok(Progress::Done) };
        let count = SENSOR_NUISANCES * problem.layout.sensors.len();
        equations.complete().ok_or_else(undetermined)?;
        let pulls = equations.solution()[..count].iter().fold(R::zero(), |sum, u| sum + *u * *u);
        let (trace, squares) = equations.shrinkage(count);
        let prior = R::of(1.0 / (LOG_SCALE_SIGMA * LOG_SCALE_SIGMA));
        // In double precision of one library, so that every machine takes the same steps to the last bit.
        let log_scale = R::of(libm::log(learned.scales.constant.to_f64()));
        let score = pulls - trace - log_scale * prior;
        let information = squares * R::of(2.0) + prior;
        let longest = R::of(LONGEST_STEP);
        let step = (score / information).max(-longest).min(longest);
        if !step.finite() {
            return Err(undetermined());
        }
        learned.scales.constant = R::of(libm::exp((log_scale + step).to_f64()));
        learned.constant_log_variance = information.recip();
        let short = step * step * information < R::of(SHORT_STEP * SHORT_STEP);
        Ok(if short || steps >= MOST_STEPS { Progress::Done } else { Progress::Going })
    }
}

#[cfg(test)]
pub(super) mod tests;

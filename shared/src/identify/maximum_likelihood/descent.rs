//! Descent to a minimum: one damped step of Levenberg and Marquardt after the other.

use nalgebra::{SMatrix, SVector};

use super::fatal;
use super::fit::{Fit, STEADY_STEPS, Stage};
use super::fit_problem::FitProblem;
use super::normal_equations::NormalEquations;
use super::parameters::Parameters;
use crate::body::RigidBody;
use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostics};
use crate::identify::budget::ErrorBudget;
use crate::identify::{DofMassLines, by_reference};
use crate::progress::Progress;
use crate::real::Real;

/// The fit ends with a step that lowers the cost by less than this fraction of χ² over its degrees of
/// freedom, or of one if that is larger: the square of a shift in standard deviations. In single precision
/// the limit is a hundred roundings.
const CLOSE: f64 = 1e-10;
/// The same limit where only physical bodies are admitted: on the way from a crude start, and at the boundary
/// of the physical bodies, along which the fit goes in short steps.
const NEAR: f64 = 1e-3;
/// Number of dampings tried before a step is given up.
const MOST_TRIALS: u8 = 20;
/// Below this, a damping does not shorten a step noticeably.
const UNDAMPED: f64 = 1e-2;

impl<R: Real> Fit<R> {
    /// Information and gradient with respect to the varied parameters, from the equations that
    /// [`Fit::evaluate`] leaves.
    fn slope(&self, equations: &NormalEquations<'_, R>) -> (SMatrix<R, 10, 10>, SVector<R, 10>) {
        match self.parameters.slopes() {
            None => (equations.information(), equations.gradient()),
            Some(slopes) => (
                slopes.transpose() * equations.information() * slopes,
                slopes.transpose() * equations.gradient(),
            ),
        }
    }

    /// Tries the next damping and takes the step if it lowers the cost. Done when this is the minimum.
    // Never inlined: this saves 0.5 KB of the firmware's deepest stack.
    #[inline(never)]
    pub(super) fn descend<C: Capacity>(
        &mut self,
        problem: &FitProblem<'_, R, C>,
        dofs: &[DofMassLines<R, C>],
        equations: &mut NormalEquations<'_, R>,
        trials: u8,
    ) -> Result<Progress, Diagnostics> {
        let (information, gradient) = self.slope(equations);
        let gain = |step: &SVector<R, 10>| {
            step.dot(&gradient) * R::of(2.0) - step.dot(&(information * step))
        };
        if trials >= MOST_TRIALS {
            // No step lowers the cost: this is the minimum within the precision.
            let undamped = self.parameters.step(&information, &gradient, R::zero());
            return match undamped.map(|step| gain(&step)) {
                Some(gain) if gain < R::of(1e-2) => Ok(Progress::Done),
                _ => Err(fatal(Code::NotConverged, f32::from(self.steps))),
            };
        }
        let close = self.close();
        let step = self.parameters.step(&information, &gradient, self.damping);
        // Where the data contradict their budget, the covariance may change so much with the body that full
        // steps go back and forth.
        let part = R::of(if self.steps > STEADY_STEPS { 0.5 } else { 1.0 });
        if let Some(step) = step
            && let Some(moved) = self.parameters.moved(&(step * part))
        {
            if gain(&step) < close && self.damping <= R::of(UNDAMPED) {
                self.parameters = moved;
                return Ok(Progress::Done);
            }
            let body = problem.body_of(&moved.phi());
            let cost = body.and_then(|body| self.trial(problem, dofs, equations, &body));
            if let Some(cost) = cost.filter(|cost| *cost <= self.cost + self.rounding) {
                self.parameters = moved;
                self.damping = (self.damping * R::of(0.1)).max(R::of(1e-9));
                self.stage = Stage::Arrived;
                let is_minimum =
                    self.parameters.are_physical() && self.cost - cost < close + self.rounding;
                return Ok(if is_minimum { Progress::Done } else { Progress::Going });
            }
        }
        self.damping *= R::of(10.0);
        self.stage = Stage::Evaluated { trials: trials + 1 };
        Ok(Progress::Going)
    }

    /// The cost of another body under the covariance of the present one.
    fn trial<C: Capacity>(
        &self,
        problem: &FitProblem<'_, R, C>,
        dofs: &[DofMassLines<R, C>],
        equations: &mut NormalEquations<'_, R>,
        body: &RigidBody<R>,
    ) -> Option<R> {
        let present = problem.body_of(&self.parameters.phi())?;
        let squares = problem.assemble_second(&present, body, by_reference(dofs), equations)?;
        let object = RigidBody::from_phi(&(body.phi() - problem.attached_sum()))?;
        let cost = squares + problem.cost_of_priors(&object) - equations.explained_second();
        cost.finite().then_some(cost)
    }

    /// The smallest gain that justifies another step of first order.
    fn close(&self) -> R {
        let least = match self.parameters {
            // The refinement goes on from here.
            Parameters::Free(_) if self.budget != ErrorBudget::FirstOrder => R::of(NEAR),
            Parameters::Free(_) => return self.short().max(self.rounding),
            Parameters::Bounded(_) | Parameters::OnTheWay(_) => R::of(NEAR),
        };
        let least = least * self.consistency().reduced().max(R::one());
        least.max(self.rounding)
    }

    /// A full step that gains less is the last one.
    pub(super) fn short(&self) -> R {
        // The budget is about to be learned.
        let passing = self.budget == ErrorBudget::Learned && self.learned.is_none();
        let limit = if passing { NEAR } else { CLOSE };
        let least = R::of(limit).max(R::default_epsilon() * R::of(100.0));
        least * self.consistency().reduced().max(R::one())
    }
}

//! Refinement of a minimum by the terms of second order in the errors of the hits (theory, section 12).
//!
//! The derivatives of the readings are evaluated at the force that the hits probably had, which the previous
//! step estimates. The full steps of Gauss and Newton from a minimum of first order are a fraction of a
//! standard deviation long and shrink quickly.

use nalgebra::SVector;

use super::fit::{Fit, Refinement};
use super::fit_problem::FitProblem;
use super::model::Model;
use super::normal_equations::NormalEquations;
use super::parameters::Parameters;
use super::pulls::{HitPull, UnknownValues};
use super::{fatal, undetermined};
use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostics};
use crate::identify::{DofMassLines, Progress};
use crate::real::Real;

/// Largest number of steps; four are usual.
const MOST_STEPS: u8 = 30;
/// A refinement that does not end is accepted when the last step changes χ² by less: a tenth of a standard
/// deviation.
const TOLERATED: f64 = 1e-2;

impl<R: Real> Fit<R> {
    /// Takes a step from the evaluated equations and estimates the errors of the hits.
    ///
    /// # Errors
    /// When the equations cannot be solved, or the steps do not become shorter.
    // Never inlined: this saves with the steps of learning 2.3 KB of the firmware's deepest stack.
    #[inline(never)]
    pub(super) fn refine<C: Capacity>(
        &mut self,
        refinement: &mut Refinement<R>,
        problem: &FitProblem<'_, R, C>,
        dofs: &[DofMassLines<R, C>],
        equations: &mut NormalEquations<'_, R>,
    ) -> Result<Progress, Diagnostics> {
        let phi = self.parameters.phi();
        let gradient = equations.gradient();
        equations.complete().ok_or_else(undetermined)?;
        let nuisances = problem.nuisances();
        let solution = equations.solution();
        let step = SVector::<R, 10>::from_fn(|k, _| solution[nuisances + k]);
        let unknowns = UnknownValues::<R, C>::of(problem.layout.sensors.len(), solution);
        let unknowns = unknowns.ok_or_else(undetermined)?;
        let body = problem.body_of(&phi).ok_or_else(undetermined)?;
        let model = Model::new(problem.layout, &problem.balance, &body).ok_or_else(undetermined)?;
        for (place, (index, lines)) in dofs.iter().enumerate() {
            let terms = problem.terms(&model, *index, lines, &equations.hit_errors(place));
            let terms = terms.ok_or_else(undetermined)?;
            let left = unknowns.residual(problem, &model, &terms);
            equations.set_hit_errors(place, HitPull::of(&terms, &left, problem.channels).values);
        }
        let gain = step.dot(&gradient);
        if refinement.steps > 1 && gain > refinement.gain {
            refinement.fraction *= R::of(0.5);
        }
        refinement.steps += 1;
        refinement.gain = gain;
        self.parameters = Parameters::Free(phi + step * refinement.fraction);
        // The first step does not know the errors of the hits yet.
        if refinement.steps > 1 && gain < self.short() {
            return Ok(Progress::Done);
        }
        match refinement.steps < MOST_STEPS {
            true => Ok(Progress::Going),
            false if gain < R::of(TOLERATED) => Ok(Progress::Done),
            false => Err(fatal(Code::NotConverged, f32::from(refinement.steps))),
        }
    }
}

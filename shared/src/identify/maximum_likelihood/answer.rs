//! The answer of a fit that has converged.

use nalgebra::{SMatrix, SVector};

use super::damped_step::damped_step;
use super::fit::{Fit, Stage};
use super::fit_problem::FitProblem;
use super::normal_equations::NormalEquations;
use super::{MaximumLikelihoodSolution, equations_in, fatal, nuisances, undetermined};
use crate::body::RigidBody;
use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostics, Severity};
use crate::identify::budget::LearnedBudget;
use crate::identify::{DofMassLines, Estimate, Method};
use crate::layout::Layout;
use crate::linalg::{all_finite, congruence};
use crate::real::Real;

impl<R: Real> Fit<R> {
    /// The answer without the nuisance parameters; `workspace` must be as the last step left it.
    ///
    /// # Errors
    /// When the information about the ten properties is not positive definite, a number is not finite, or the
    /// fit needs further steps.
    pub fn answer<C: Capacity>(
        &mut self,
        layout: &Layout<R, C>,
        workspace: &mut [R],
    ) -> Result<Estimate<R>, Diagnostics> {
        let problem = self.problem(layout);
        let equations = equations_in(workspace, &problem)?;
        self.conclude(&problem, &equations)
    }

    /// The answer and the nuisance parameters; `workspace` must be as the last step left it.
    ///
    /// # Errors
    /// As [`Self::answer`].
    pub fn finish<C: Capacity>(
        mut self,
        layout: &Layout<R, C>,
        dofs: &[DofMassLines<R, C>],
        workspace: &mut [R],
    ) -> Result<MaximumLikelihoodSolution<R, C>, Diagnostics> {
        let problem = self.problem(layout);
        let mut equations = equations_in(workspace, &problem)?;
        let body = problem.body_of(&self.parameters.phi()).ok_or_else(undetermined)?;
        let estimate = self.conclude(&problem, &equations)?;
        let nuisances = nuisances::estimate_nuisances(&problem, dofs, &body, &mut equations);
        Ok(MaximumLikelihoodSolution { estimate, nuisances: nuisances.ok_or_else(undetermined)? })
    }

    fn conclude<C: Capacity>(
        &mut self,
        problem: &FitProblem<'_, R, C>,
        equations: &NormalEquations<'_, R>,
    ) -> Result<Estimate<R>, Diagnostics> {
        let Stage::Done = self.stage else {
            return Err(fatal(Code::NotConverged, f32::from(self.steps())));
        };
        let object = self.object().ok_or_else(undetermined)?;
        if object.mass <= R::zero() {
            let code = if problem.layout.attached.is_empty() {
                Code::MassNotPositive
            } else {
                Code::AttachedTooHeavy
            };
            return Err(fatal(code, object.mass.to_f32()));
        }
        let covariance = covariance_of(&equations.information(), &object);
        let covariance = covariance.ok_or_else(undetermined)?;
        if problem.layout.lacks_gravity() {
            self.push_diagnostic(Code::GravityNotGiven, Severity::Note, R::zero());
        }
        Ok(Estimate {
            method: Method::MaximumLikelihood,
            body: problem.balance.body_back(&object),
            covariance: Some(problem.balance.covariance_back(&covariance)),
            condition: self.condition,
            consistency: Some(self.consistency()),
            learned: self.learned.map(|learned| {
                let widening = self.shares.widening(&learned).into();
                LearnedBudget { widening, ..learned }
            }),
            diagnostics: core::mem::take(&mut self.diagnostics),
        })
    }
}

/// Covariance of theta from the information about phi.
pub(super) fn covariance_of<R: Real>(
    information: &SMatrix<R, 10, 10>,
    object: &RigidBody<R>,
) -> Option<SMatrix<R, 10, 10>> {
    let mut covariance = SMatrix::<R, 10, 10>::zeros();
    for k in 0..10 {
        let mut unit = SVector::<R, 10>::zeros();
        unit[k] = R::one();
        covariance.set_column(k, &damped_step(information, &unit, R::zero(), &SVector::zeros())?);
    }
    congruence(&object.dtheta_dphi(), &mut covariance);
    all_finite(&covariance).then_some(covariance)
}

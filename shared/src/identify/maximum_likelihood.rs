//! Maximum likelihood with the complete covariance: the estimator that reaches the Cramér-Rao bound.
//!
//! The errors of the accelerances come from noise, from the position and direction of the hits, from
//! sensitivity, rotation and position of every sensor, and from the hammer's gain. All of them are part of
//! the model, with the standard deviations of the layout, so every reading gets the weight that it deserves
//! and the covariance covers the whole error budget (theory, section 4).
//!
//! The augmented form is used: every error source that stays the same over the test is an unknown with a
//! prior. This leaves one small covariance per hit DOF and one normal matrix of a fixed size. The fit also
//! estimates the nuisance parameters ([`NuisanceEstimates`]). Steps are those of Levenberg and Marquardt; the
//! covariance of the readings is evaluated anew after every step.
//!
//! [`solve`] runs everything at once; a rig calls [`Fit::step`] repeatedly, with other work in between:
//!
//! ```text
//! start ─▶ step ─▶ step ─▶ … ─▶ answer, or finish
//! ```
//! A step is an *evaluation* of model, covariance and equations, or the *trial* of one damping.

mod answer;
pub(super) mod balance;
mod band_shift;
mod bound;
mod changes;
mod crosstalk;
mod damped_step;
mod descent;
mod fit;
mod fit_problem;
mod intervals;
mod learning;
mod linearity;
pub(super) mod model;
mod nearest_body;
mod normal_equations;
mod nuisances;
mod parameters;
pub(super) mod pulls;
mod refinement;
mod score;
mod score_test;
mod shares;
mod start;
pub mod without_repeats;

pub use super::budget::{BudgetScales, ErrorBudget, LearnedBudget, LearnedFrom};
pub use bound::{Bound, bound, readings_covariance};
pub use changes::ChangeSizes;
pub use fit::{Fit, Start};
pub use nuisances::{HitNuisances, NuisanceEstimates, SensorNuisances};
pub use pulls::SUSPICIOUS as SUSPICIOUS_PULL;

use super::method::{self, Entry, Observable};
use super::observations::{Observations, SpectrumBins};
use super::{DofMassLines, Estimate};
use crate::body::RigidBody;
use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostics, fatal};
use crate::layout::{Layout, MAX_ATTACHED, RIG_HITS, RIG_SENSORS, is_finite};
use crate::progress::Progress;
use crate::real::Real;
use fit_problem::FitProblem;
use model::SENSOR_NUISANCES;
use normal_equations::NormalEquations;

/// Description of the method for the registry.
pub const ENTRY: Entry = Entry {
    name: "maximum-likelihood",
    short_name: "ml",
    title: "Maximum likelihood",
    summary: "Maximum likelihood with the complete error budget",
    observes: Observable::MassLines,
    uses_priors: true,
    off_when: "the suspension or an elastic mode is near the band of the mass lines",
    doubted_by: &[],
    is_blocked,
    workspace,
};

/// The method compares readings, so the sensors need not determine all motions, and priors can replace hits.
fn is_blocked(code: Code, prior_of_inertia: bool) -> bool {
    match code {
        Code::FewerThanThreeSensors | Code::SensorsCollinear | Code::ResponseRankDeficient => false,
        Code::FewerThanThreeHits
        | Code::HitsAllParallel
        | Code::HitsConcurrent
        | Code::HitsThroughCentreOfMass
        | Code::TenParametersNotIdentifiable => !prior_of_inertia,
        // Invalid numbers rule out every method.
        _ => true,
    }
}

/// Runs the method behind [`identify`](super::identify).
pub(super) type Solver<R> = Fit<R>;

impl<R: Real> method::Solver<R> for Fit<R> {
    fn start<C: Capacity, L: SpectrumBins<R>>(
        observed: &Observations<'_, R, C, L>,
        settings: &super::IdentifySettings<R>,
        start: Option<&RigidBody<R>>,
    ) -> Result<Self, Diagnostics> {
        let start = start.map_or(Start::InertiaRestraint, Start::At);
        let budget = settings.error_budget.permitted_by(observed.layout);
        Self::start(observed.layout, observed.mass_lines, start, budget)
    }

    fn step<C: Capacity, L: SpectrumBins<R>>(
        &mut self,
        observed: &Observations<'_, R, C, L>,
        workspace: &mut [R],
    ) -> Result<Progress, Diagnostics> {
        Self::step(self, observed.layout, observed.mass_lines, workspace)
    }

    fn finish<C: Capacity, L: SpectrumBins<R>>(
        &mut self,
        observed: &Observations<'_, R, C, L>,
        workspace: &mut [R],
    ) -> Result<Estimate<R>, Diagnostics> {
        self.answer(observed.layout, workspace)
    }
}

/// Size of the workspace for a layout with this number of sensors and hits.
pub const fn workspace(sensors: usize, hits: usize) -> usize {
    normal_equations::workspace(unknowns(sensors), hits)
}

/// Largest number of unknowns of a layout with this number of sensors.
const fn unknowns(sensors: usize) -> usize {
    SENSOR_NUISANCES * sensors + 1 + MAX_ATTACHED + 10
}

/// Size of the workspace on the rig.
pub const RIG_WORKSPACE: usize = workspace(RIG_SENSORS, RIG_HITS);

/// Result of the fit.
#[derive(Clone, Debug, PartialEq)]
pub struct MaximumLikelihoodSolution<R: Real, C: Capacity> {
    /// The ten properties with their covariance and χ².
    pub estimate: Estimate<R>,
    /// Estimated errors of sensors, hammer and hits.
    pub nuisances: NuisanceEstimates<R, C>,
}

/// Determines the ten properties from the mass lines.
///
/// `workspace` needs the length that [`workspace`] gives for the layout's sensors.
///
/// # Errors
/// As [`Fit::start`].
///
/// Residuals are weighted by the complete covariance of the error budget (theory, section 4). The covariance
/// of the ten properties is in the units and the order of [`RigidBody::theta`].
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::identify::maximum_likelihood::{ErrorBudget, Start, solve, workspace};
/// let layout = frame::layout();
/// let mut memory = vec![0.0; workspace(layout.sensors.len(), layout.hits.len())];
/// let dofs = frame::mass_lines(&layout);
/// let solution = solve(&layout, &dofs, Start::InertiaRestraint, ErrorBudget::FirstOrder, &mut memory).unwrap();
/// let estimate = &solution.estimate;
/// assert!((estimate.body.center_of_mass.x - 0.169).abs() < 1e-6);
/// // The hammer gain of 2 % and the rest of the budget make the mass uncertain by 2 to 3 %.
/// let relative = estimate.sigma().unwrap()[0] / estimate.body.mass;
/// assert!(0.02 < relative && relative < 0.03);
/// // Exact readings agree with any budget.
/// assert!(estimate.consistency.unwrap().reduced() < 0.01);
/// ```
pub fn solve<R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    dofs: &[DofMassLines<R, C>],
    start: Start<'_, R>,
    budget: ErrorBudget,
    workspace: &mut [R],
) -> Result<MaximumLikelihoodSolution<R, C>, Diagnostics> {
    let mut fit = Fit::start(layout, dofs, start, budget)?;
    while fit.step(layout, dofs, workspace)? == Progress::Going {}
    fit.finish(layout, dofs, workspace)
}

/// Refuses a layout or data that are not finite, and hits that the layout does not have.
fn check_data<R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    dofs: &[DofMassLines<R, C>],
) -> Result<(), Diagnostics> {
    if !is_finite(layout) {
        return Err(fatal(Code::LayoutNotFinite, 0.0));
    }
    super::check_mass_lines(layout, dofs)
}

/// The equations as the previous step left them.
fn equations_in<'w, R: Real, C: Capacity>(
    workspace: &'w mut [R],
    problem: &FitProblem<'_, R, C>,
) -> Result<NormalEquations<'w, R>, Diagnostics> {
    let hits = problem.layout.hits.len();
    NormalEquations::with_hit_errors(workspace, problem.nuisances(), hits).ok_or_else(undetermined)
}

/// The problem was identifiable at the start, so a failure to compute means that the fit has diverged.
fn undetermined() -> Diagnostics {
    fatal(Code::NotConverged, 0.0)
}

#[cfg(test)]
pub(super) mod tests;

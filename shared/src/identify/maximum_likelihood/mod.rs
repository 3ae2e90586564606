//! Maximum likelihood with the complete covariance: the estimator that reaches the Cramér-Rao bound.
//!
//! The accelerances are wrong by noise, by where and how the hammer landed, by the sensitivity,
//! rotation and place of every sensor, and by the hammer's gain. All of it is part of the model, with
//! the standard deviations that the layout carries, so the fit weighs every reading by what it is
//! worth and the covariance covers everything in the budget (theory, section 4).
//!
//! The augmented form is used: every cause that stays the same over the test is an unknown with a
//! prior, which leaves one small covariance per hit DOF and one normal matrix of a fixed size. The
//! nuisance parameters come out with the answer ([`NuisanceEstimates`]). Steps are those of Levenberg and Marquardt; the
//! covariance of the readings is evaluated anew after every step.
//!
//! [`solve`] does it all; a rig takes [`Fit::step`] by step, with other work between:
//!
//! ```text
//! start ─▶ step ─▶ step ─▶ … ─▶ answer, or finish
//! ```
//! A step is an *evaluation* of model, covariance and equations, or a *trial* of one damping.

mod answer;
mod balance;
mod bound;
mod fit;
mod fit_problem;
mod model;
mod normal_equations;
mod nuisances;
mod parameters;
mod pulls;
mod start;

pub use bound::{Bound, bound, readings_covariance};
pub use fit::{Fit, Start};
pub use nuisances::{HitNuisances, NuisanceEstimates, SensorNuisances};

use super::method::{self, Entry, Observable, Progress};
use super::observations::{Observations, SpectrumBins};
use super::{DofMassLines, Estimate};
use crate::Real;
use crate::body::RigidBody;
use crate::diagnosis::{Code, Diagnostics, fatal};
use crate::layout::{Layout, MAX_ATTACHED, RIG_SENSORS, is_finite};
use fit_problem::FitProblem;
use model::SENSOR_NUISANCES;
use normal_equations::NormalEquations;

/// What this file states about the method.
pub const ENTRY: Entry = Entry {
    name: "maximum-likelihood",
    short_name: "ml",
    title: "Maximum likelihood",
    summary: "Maximum likelihood with the complete error budget",
    observes: Observable::MassLines,
    on_request: false,
    is_blocked,
    workspace: |sensors, _| workspace(sensors),
};

/// It compares readings, so the sensors need not tell all motions; priors can make up for hits.
fn is_blocked(code: Code, rescued: bool) -> bool {
    match code {
        Code::FewerThanThreeSensors | Code::SensorsCollinear | Code::ResponseRankDeficient => false,
        Code::FewerThanThreeHits
        | Code::HitsAllParallel
        | Code::HitsConcurrent
        | Code::HitsThroughCentreOfMass
        | Code::TenParametersNotIdentifiable => !rescued,
        // Numbers that are wrong, whatever the method.
        _ => true,
    }
}

/// The method as the door carries it out.
pub(super) type Solver<R> = Fit<R>;

impl<R: Real> method::Solver<R> for Fit<R> {
    fn start<const S: usize, const H: usize, L: SpectrumBins<R>>(
        observed: &Observations<'_, R, S, H, L>,
        _settings: &super::IdentifySettings<R>,
        start: Option<&RigidBody<R>>,
    ) -> Result<Self, Diagnostics> {
        let start = start.map_or(Start::InertiaRestraint, Start::At);
        Self::start(observed.layout, observed.mass_lines, start)
    }

    fn step<const S: usize, const H: usize, L: SpectrumBins<R>>(
        &mut self,
        observed: &Observations<'_, R, S, H, L>,
        workspace: &mut [R],
    ) -> Result<Progress, Diagnostics> {
        Self::step(self, observed.layout, observed.mass_lines, workspace)
    }

    fn finish<const S: usize, const H: usize, L: SpectrumBins<R>>(
        &mut self,
        observed: &Observations<'_, R, S, H, L>,
        workspace: &mut [R],
    ) -> Result<Estimate<R>, Diagnostics> {
        self.answer(observed.layout, workspace)
    }
}

/// Numbers of workspace for a layout of so many sensors.
pub const fn workspace(sensors: usize) -> usize {
    normal_equations::workspace(SENSOR_NUISANCES * sensors + 1 + MAX_ATTACHED + 10)
}

/// Numbers of workspace on the rig.
pub const RIG_WORKSPACE: usize = workspace(RIG_SENSORS);

/// What the fit answers.
#[derive(Clone, Debug, PartialEq)]
pub struct MaximumLikelihoodSolution<R, const S: usize, const H: usize> {
    /// The ten with their covariance, and χ² with its verdict.
    pub estimate: Estimate<R>,
    /// What the fit found out about sensors, hammer and hits.
    pub nuisances: NuisanceEstimates<R, S, H>,
}

/// The ten properties from the mass lines, by as many steps as it takes.
///
/// `workspace` has [`workspace`] numbers for the layout's sensors.
///
/// # Errors
/// As [`Fit::start`].
///
/// Residuals are weighted by the complete covariance of the budget (theory, section 4). The covariance of the ten
/// is in the units of [`RigidBody::theta`], in its order.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::identify::maximum_likelihood::{Start, solve, workspace};
/// let layout = frame::layout();
/// let mut memory = vec![0.0; workspace(layout.sensors.len())];
/// let solution = solve(&layout, &frame::mass_lines(&layout), Start::InertiaRestraint, &mut memory).unwrap();
/// let estimate = &solution.estimate;
/// assert!((estimate.body.center_of_mass.x - 0.169).abs() < 1e-6);
/// // 2 % of hammer gain, and what else the budget has, make the mass uncertain by 2 to 3 %.
/// let relative = estimate.sigma().unwrap()[0] / estimate.body.mass;
/// assert!(0.02 < relative && relative < 0.03);
/// // Exact readings agree with any budget.
/// assert!(estimate.consistency.unwrap().reduced() < 0.01);
/// ```
pub fn solve<R: Real, const S: usize, const H: usize>(
    layout: &Layout<R, S, H>,
    dofs: &[DofMassLines<R, S>],
    start: Start<'_, R>,
    workspace: &mut [R],
) -> Result<MaximumLikelihoodSolution<R, S, H>, Diagnostics> {
    let mut fit = Fit::start(layout, dofs, start)?;
    while fit.step(layout, dofs, workspace)? == Progress::Going {}
    fit.finish(layout, dofs, workspace)
}

/// Refuses what no arithmetic can repair.
fn check_data<R: Real, const S: usize, const H: usize>(
    layout: &Layout<R, S, H>,
    dofs: &[DofMassLines<R, S>],
) -> Result<(), Diagnostics> {
    if !is_finite(layout) {
        return Err(fatal(Code::LayoutNotFinite, 0.0));
    }
    super::check_mass_lines(layout, dofs)
}

/// The equations as a step before has left them.
fn equations_in<'w, R: Real, const S: usize, const H: usize>(
    workspace: &'w mut [R],
    problem: &FitProblem<'_, R, S, H>,
) -> Result<NormalEquations<'w, R>, Diagnostics> {
    NormalEquations::new(workspace, problem.nuisances()).ok_or_else(undetermined)
}

/// The start was identifiable, so what cannot be computed any more is a fit that went astray.
fn undetermined() -> Diagnostics {
    fatal(Code::NotConverged, 0.0)
}

#[cfg(test)]
pub(super) mod tests;

//! The global fit: one body on one suspension is fitted to all frequency responses of a test, by maximum
//! likelihood with the complete error budget.
//!
//! ```text
//! H(s) = G(s) (M + C/s + K/s² [+ R s² + Q s⁴])⁻¹ f [+ E s²]        s = σ + iω
//! ```
//! Mass lines have a B of their own for every channel. Here, one stiffness K (21 numbers) and, optionally, one
//! damping C (21) serve all channels and hits, and gravity is in `G(s)`, so the band may contain the suspension
//! modes. R and Q stand for a flexible mode above the band: a mass m₂ on a spring with the natural frequency Ω
//! adds `s² m₂/(1 + s²/Ω²) = s² m₂ − s⁴ m₂/Ω² + s⁶ m₂/Ω⁴ …` to the dynamic stiffness. Whether they are needed is
//! tested. E is the residual of the elastic modes of a mass-line band, one number per channel and hit, and is
//! eliminated. Theory, section 5.
//!
//! The errors of sensors, hits, hammer and attached bodies are unknowns with the standard deviations of the
//! layout as priors, with the definitions of [maximum likelihood](super::maximum_likelihood) (theory, section
//! 4). The noise of a reading is unknown and comes from the residuals.
//!
//! Variables are balanced: lengths over L about the sensors' centroid, frequencies over the highest one. The
//! steps solve normal equations with unit columns. What the other columns leave of a column of K is 0.005 or more
//! of it with three hits just above the suspension modes, and the refusal is at 1e-5, so a factor in double
//! precision keeps six digits; the residuals of every step are exact, so that rounding costs steps and not
//! accuracy. Single precision is not enough.

mod answer;
mod apparatus;
mod bin_model;
mod elastic;
mod equations;
mod extra_terms;
mod fit;
mod gravity;
mod memory;
mod problem;
mod pulls;
mod start;
mod unknowns;
mod weighted;

use nalgebra::{Complex, Matrix6, SVector};

use self::elastic::Elastic;
use self::fit::Fit;
use self::memory::Memory;
use self::problem::Problem;
use super::maximum_likelihood::model::SENSOR_NUISANCES;
use super::method::{self, Entry, Observable};
use super::observations::{Observations, SpectrumBins};
use super::suspension::is_blocked;
use super::{Estimate, inertia_restraint};
use crate::body::RigidBody;
use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostics, fatal};
use crate::estimated::EstimatedValue;
use crate::frequency_responses::FrequencyResponses;
use crate::layout::{GRAVITY_QUANTITIES, HIT_QUANTITIES, Layout};
use crate::mass_line::Terms;
use crate::progress::Progress;
use crate::real::Real;

pub use memory::workspace;
pub use unknowns::MOST_EXTRA_TERMS;

/// Description of the method for the registry.
pub const ENTRY: Entry = Entry {
    name: "global-fit",
    short_name: "global-fit",
    title: "Global fit",
    summary: "Body and suspension fitted to all bins of the band",
    observes: Observable::SpectrumBins,
    uses_priors: true,
    off_when: "the object is not rigid or the suspension not linear in the band",
    doubted_by: &[],
    is_blocked,
    workspace,
};

/// Runs the method behind [`identify`](super::identify). Its single step is the whole fit, since spectral
/// bins are stored only where there is time for it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solver<R> {
    start: RigidBody<R>,
    settings: GlobalFitSettings,
}

impl<R: Real> method::Solver<R> for Solver<R> {
    fn start<C: Capacity, L: SpectrumBins<R>>(
        observed: &Observations<'_, R, C, L>,
        settings: &super::IdentifySettings<R>,
        start: Option<&RigidBody<R>>,
    ) -> Result<Self, Diagnostics> {
        if observed.spectrum_bins.responses().is_none() {
            return Err(fatal(Code::FrfMissing, 0.0));
        }
        let start = match start {
            Some(body) => *body,
            None => {
                let Observations { layout, mass_lines, .. } = *observed;
                inertia_restraint::solve(layout, mass_lines, settings.inertia_restraint)?.body
            }
        };
        let elastic = observed.layout.test.terms == Terms::Abc;
        Ok(Self { start, settings: GlobalFitSettings { elastic, ..Default::default() } })
    }

    fn step<C: Capacity, L: SpectrumBins<R>>(
        &mut self,
        _observed: &Observations<'_, R, C, L>,
        _workspace: &mut [R],
    ) -> Result<Progress, Diagnostics> {
        Ok(Progress::Done)
    }

    fn finish<C: Capacity, L: SpectrumBins<R>>(
        &mut self,
        observed: &Observations<'_, R, C, L>,
        workspace: &mut [R],
    ) -> Result<Estimate<R>, Diagnostics> {
        let Some(responses) = observed.spectrum_bins.responses() else {
            return Err(fatal(Code::FrfMissing, 0.0));
        };
        let solution = solve(observed.layout, responses, &self.start, &self.settings, workspace)?;
        Ok(solution.estimate)
    }
}

/// The damping of a suspension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Damping {
    /// None is fitted; without an exponential window on the records, only the real parts of the readings count.
    None,
    /// `C s`: a force in proportion to the velocity, as of a dashpot.
    Viscous,
    /// `i D`: a force in phase with the velocity and in proportion to the displacement, as of rubber.
    Structural,
}

/// Settings of the global fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlobalFitSettings {
    /// The damping of the suspension that is fitted.
    pub damping: Damping,
    /// Eliminates a residual of the elastic modes, `E s²`, for every channel and hit.
    pub elastic: bool,
    /// Uses the error budget of the layout; otherwise all errors are noise.
    pub budget: bool,
    /// Most extra terms of the dynamic stiffness, 0 to [`MOST_EXTRA_TERMS`]; how many of them are used is
    /// tested.
    pub most_extra_terms: usize,
    /// Standard deviation of the directions of the hits that shortens their mean, over the stated one. The other
    /// effects of the directions are those of the budget.
    pub direction_scale: f64,
}

impl Default for GlobalFitSettings {
    /// Damping, error budget and as many extra terms as the test asks for.
    fn default() -> Self {
        Self {
            damping: Damping::Viscous,
            elastic: false,
            budget: true,
            most_extra_terms: MOST_EXTRA_TERMS,
            direction_scale: 1.0,
        }
    }
}

impl GlobalFitSettings {
    /// Body and stiffness alone, with equal weights.
    pub const PLAIN: Self = Self {
        damping: Damping::None,
        elastic: false,
        budget: false,
        most_extra_terms: 0,
        direction_scale: 1.0,
    };
}

/// Result of the global fit.
#[derive(Clone, Debug, PartialEq)]
pub struct GlobalFitSolution<R> {
    /// The ten properties; their covariance contains the noise, estimated from the scatter of the bins about
    /// the model, and the error budget. There is no χ², since the noise is estimated.
    pub estimate: Estimate<R>,
    /// K about the origin: N/m, N/rad, N m/m, N m/rad.
    pub stiffness: Matrix6<R>,
    /// C about the origin, when it was fitted: N s/m, …; or D, for structural damping: N/m, …
    pub damping: Option<Matrix6<R>>,
    /// Number of extra terms: none, `s⁴ R`, or also `s⁶ Q`.
    pub extra_terms: usize,
    /// What the tests for the first and the second extra term found: standard normal deviates, above
    /// [`REJECTION_Z`](super::REJECTION_Z) for a term that is needed. `None` for a test that was not made.
    pub extra_terms_z: [Option<R>; MOST_EXTRA_TERMS],
    /// Gravity as the budget and the data have it, when the layout states it and a sensor senses it.
    pub gravity: Option<FittedGravity<R>>,
    /// Standard deviation of the real and of the imaginary part of a reading, (m/s²)/N; over the precision of its bin,
    /// for responses that are weighted.
    pub noise: R,
}

/// Gravity with the direction that the data give it within the budget.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedGravity<R> {
    /// In the body frame, m/s², with their standard deviations.
    pub components: [EstimatedValue<R>; 3],
    /// Its angle to that of the layout, rad.
    pub angle: R,
    /// The angle in standard deviations of the budget; zero without one.
    pub pull: R,
}

/// How the answer depends on data and layout, to first order: the slices are written by
/// [`solve_with_sensitivities`].
#[derive(Debug)]
pub struct Sensitivities<'a, R> {
    /// For each accelerance `[bin][channel][hit]`, in the order of [`FrequencyResponses::new`], the vector g of
    /// `δtheta = Σ Re(ḡ δH)`; [`gains`] gives the length. SI units.
    pub gain: &'a mut [SVector<Complex<R>, 10>],
    /// For each nuisance parameter the change of theta when the nominal layout is shifted by one standard deviation of
    /// it and the data stay, which is the covariance of theta with the parameter in standard deviations; [`nuisances`]
    /// gives the length. The order is: for each sensor nine sensitivities row by row, three rotations, three
    /// displacements; two rotations of gravity; for each hit DOF two displacements, two rotations and its length; the
    /// hammer's gain; the mass of each attached body. Without a budget nothing is written.
    pub nuisances: &'a mut [SVector<R, 10>],
    /// For each accelerance, in the same order, what the fit leaves of it, (m/s²)/N.
    pub left: &'a mut [Complex<R>],
    /// The nuisance parameters of that order at the minimum, in standard deviations.
    pub pulls: &'a mut [R],
    /// Their covariance under the model, row by row: a square of that length.
    pub posterior: &'a mut [R],
}

/// Number of accelerances of this many bins, sensors and hit DOFs.
pub const fn gains(bins: usize, sensors: usize, hits: usize) -> usize {
    3 * bins * sensors * hits
}

/// Number of nuisance parameters of this many sensors, hit DOFs and attached bodies.
pub const fn nuisances(sensors: usize, hits: usize, attached: usize) -> usize {
    SENSOR_NUISANCES * sensors + GRAVITY_QUANTITIES + HIT_QUANTITIES * hits + 1 + attached
}

/// Fits body and suspension to the frequency responses of all sensors and hits of the layout, in this order,
/// starting from the body `start` (without the attached bodies, as is the answer). `workspace` needs the length
/// that [`workspace`] gives.
///
/// # Errors
/// `data_not_finite`, `layout_not_finite`, `frf_missing` when channels or hits are not those of the
/// layout, `band_too_narrow` with fewer independent readings than unknowns or too small a workspace,
/// `ten_parameters_not_identifiable` when layout and band do not determine the ten properties (value: their rank)
/// or K (value: the number of its 21 elements that they determine), `not_converged`, `attached_too_heavy`,
/// `mass_not_positive`.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::FrequencyResponses;
/// # use massline_shared::identify::global_fit;
/// # use massline_shared::nalgebra::{Complex, Matrix6, Vector3};
/// let layout = frame::layout();
/// # let real = |value: f64| Complex::new(value, 0.0);
/// # let stiffness = Matrix6::from_diagonal_element(2.0);
/// # let frequencies: Vec<f64> = (5..60).map(|k| 2.0 * f64::from(k)).collect();
/// # let mut measured = Vec::new();
/// # for f in &frequencies {
/// #     let s = Complex::new(0.0, std::f64::consts::TAU * f);
/// #     let dynamic = frame::body().mass_matrix().map(real) + stiffness.map(|k| real(k) / (s * s));
/// #     let inverse = dynamic.try_inverse().unwrap();
/// #     for channel in 0..9 {
/// #         let response = layout.response_row_at(channel, s);
/// #         let force = |hit: &massline_shared::layout::Hit<f64>| hit.unit_force(&Vector3::zeros()).map(real);
/// #         measured.extend(layout.hits.iter().map(|hit| response.dot(&(inverse * force(hit)))));
/// #     }
/// # }
/// // 55 bins, nine channels and three hits of a body on springs of 2 N/m and 2 N m/rad.
/// let responses = FrequencyResponses::new(&frequencies, &measured, 9, 3).unwrap();
/// let mut start = frame::body();
/// start.mass *= 1.02;
/// let settings = global_fit::GlobalFitSettings::PLAIN;
/// let mut memory = vec![0.0; global_fit::workspace(3, 3)];
/// let solution = global_fit::solve(&layout, &responses, &start, &settings, &mut memory).unwrap();
/// assert!((solution.estimate.body.mass - 1.23).abs() < 1e-6);
/// assert!((solution.stiffness[(2, 2)] - 2.0).abs() < 1e-3);
/// ```
pub fn solve<R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    responses: &FrequencyResponses<'_, R>,
    start: &RigidBody<R>,
    settings: &GlobalFitSettings,
    workspace: &mut [R],
) -> Result<GlobalFitSolution<R>, Diagnostics> {
    let problem = Problem::new(layout, responses, settings);
    Ok(fit_problem(&problem, start, workspace)?.0)
}

/// As [`solve`], and writes how the answer depends on data and layout.
///
/// # Errors
/// As [`solve`]; `band_too_narrow` also when a slice is too short.
pub fn solve_with_sensitivities<R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    responses: &FrequencyResponses<'_, R>,
    start: &RigidBody<R>,
    settings: &GlobalFitSettings,
    workspace: &mut [R],
    sensitivities: &mut Sensitivities<'_, R>,
) -> Result<GlobalFitSolution<R>, Diagnostics> {
    let bins = responses.frequencies().len();
    let short = || fatal(Code::BandTooNarrow, bins as f32);
    let problem = Problem::new(layout, responses, settings);
    let (solution, mut fit) = fit_problem(&problem, start, workspace)?;
    fit.write_sensitivities(sensitivities).ok_or_else(short)?;
    Ok(solution)
}
/// The answer and the fit at its minimum.
fn fit_problem<'p, 'a, 'w, R: Real, C: Capacity>(
    problem: &'p Problem<'a, R, C>,
    start: &RigidBody<R>,
    workspace: &'w mut [R],
) -> Result<(GlobalFitSolution<R>, Fit<'p, 'a, 'w, R, C>), Diagnostics> {
    check(problem, start)?;
    let (sensors, hits) = (problem.layout.sensors.len(), problem.layout.hits.len());
    let narrow = || fatal(Code::BandTooNarrow, problem.bins() as f32);
    let memory = Memory::new(workspace, sensors, hits, problem.settings.elastic);
    let mut fit = Fit::new(problem, memory.ok_or_else(narrow)?);
    if fit.degrees_of_freedom() <= R::zero() {
        return Err(narrow());
    }
    fit.begin(start)?;
    let (extra_terms, extra_terms_z) = fit.descend_with_extra_terms()?;
    let solution = GlobalFitSolution { extra_terms, extra_terms_z, ..fit.answer()? };
    Ok((solution, fit))
}

/// Refuses numbers that are not finite, and responses that are not those of the layout.
fn check<R: Real, C: Capacity>(
    problem: &Problem<'_, R, C>,
    start: &RigidBody<R>,
) -> Result<(), Diagnostics> {
    problem.responses.check(problem.layout)?;
    if start.is_finite() { Ok(()) } else { Err(fatal(Code::DataNotFinite, 0.0)) }
}

#[cfg(test)]
pub(in crate::identify) mod tests;

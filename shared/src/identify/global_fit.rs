//! The global fit: one body on one suspension is fitted to all frequency responses of a test.
//!
//! ```text
//! H(s) = G(s) (M₀ + C₀/s + K₀/s²)⁻¹ f₀ [+ E s²]        s = σ + iω
//! ```
//! Mass lines have a B of their own for every channel. Here, one stiffness K₀ (21 numbers) and, optionally,
//! one damping C₀ (21) serve all channels and hits, and gravity is in `G(s)`. So the band may begin nearer to
//! the suspension modes, which helps with heavy objects on cords and where the modes leave little room. E is
//! the residual of the elastic modes, one number per channel and hit, and is eliminated. Theory, section 5.
//!
//! Levenberg-Marquardt steps start from the answer of another method; derivatives are analytical,
//! `∂H/∂K_k = −G D⁻¹ E_k D⁻¹ f₀ / s²`. The method needs double precision.

mod problem;

use nalgebra::Matrix6;

use self::problem::{GlobalFitProblem, WITH_DAMPING, WITH_STIFFNESS};
use super::method::{self, Entry, Observable, Progress};
use super::observations::{FrequencyResponses, Observations, SpectrumBins};
use super::{Estimate, inertia_restraint};
use crate::Real;
use crate::body::RigidBody;
use crate::diagnosis::{Code, Diagnostics, fatal};
use crate::layout::{Layout, is_finite};
use crate::mass_line::Terms;

/// Description of the method for the registry.
pub const ENTRY: Entry = Entry {
    name: "global-fit",
    short_name: "global-fit",
    title: "Global fit",
    summary: "Body and suspension fitted to all bins of the band",
    observes: Observable::SpectrumBins,
    on_request: true,
    // The method starts from the answer of the inertia restraint method.
    is_blocked: |_, _| true,
    workspace: |_, bins| workspace(bins),
};

/// Real numbers in a complex 6 × 6 matrix.
const INVERSE: usize = 72;

/// Size of the workspace for this number of bins.
pub const fn workspace(bins: usize) -> usize {
    INVERSE * bins
}

/// Runs the method behind [`identify`](super::identify). Its single step is the whole fit, since spectral
/// bins are stored only where there is time for it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solver<R> {
    start: RigidBody<R>,
    settings: GlobalFitSettings,
}

impl<R: Real> method::Solver<R> for Solver<R> {
    fn start<const S: usize, const H: usize, L: SpectrumBins<R>>(
        observed: &Observations<'_, R, S, H, L>,
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
        Ok(Self { start, settings: GlobalFitSettings { damping: false, elastic } })
    }

    fn step<const S: usize, const H: usize, L: SpectrumBins<R>>(
        &mut self,
        _observed: &Observations<'_, R, S, H, L>,
        _workspace: &mut [R],
    ) -> Result<Progress, Diagnostics> {
        Ok(Progress::Done)
    }

    fn finish<const S: usize, const H: usize, L: SpectrumBins<R>>(
        &mut self,
        observed: &Observations<'_, R, S, H, L>,
        workspace: &mut [R],
    ) -> Result<Estimate<R>, Diagnostics> {
        let Some(responses) = observed.spectrum_bins.responses() else {
            return Err(fatal(Code::FrfMissing, 0.0));
        };
        let found = solve(observed.layout, responses, &self.start, &self.settings, workspace)?;
        Ok(found.estimate)
    }
}

/// Settings of the global fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GlobalFitSettings {
    /// Fits the damping of the suspension as well. Without it and without an exponential window on the
    /// records, only the real parts are fitted.
    pub damping: bool,
    /// Eliminates a residual of the elastic modes, `E s²`, for every channel and hit.
    pub elastic: bool,
}

/// Result of the global fit.
#[derive(Clone, Debug, PartialEq)]
pub struct GlobalFitSolution<R> {
    /// The ten properties; their covariance comes from the scatter of the bins about the model.
    pub estimate: Estimate<R>,
    /// K₀ about the origin: N/m, N/rad, N m/m, N m/rad.
    pub stiffness: Matrix6<R>,
    /// C₀ about the origin, when it was fitted: N s/m, …
    pub damping: Option<Matrix6<R>>,
}

/// Fits body and suspension to the frequency responses of all sensors and hits of the layout, in this order
/// and with equal weights, starting from the body `start`. `workspace` needs the length that [`workspace`]
/// gives.
///
/// # Errors
/// `data_not_finite`, `layout_not_finite`, `frf_missing` when channels or hits are not those of the
/// layout, `band_too_narrow` with fewer equations than unknowns or too small a workspace,
/// `ten_parameters_not_identifiable`, `not_converged`.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::identify::{FrequencyResponses, global_fit};
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
/// let settings = global_fit::GlobalFitSettings { damping: false, elastic: false };
/// let mut memory = vec![0.0; global_fit::workspace(frequencies.len())];
/// let solution = global_fit::solve(&layout, &responses, &start, &settings, &mut memory).unwrap();
/// assert!((solution.estimate.body.mass - 1.23).abs() < 1e-6);
/// assert!((solution.stiffness[(2, 2)] - 2.0).abs() < 1e-3);
/// ```
pub fn solve<R: Real, const S: usize, const H: usize>(
    layout: &Layout<R, S, H>,
    responses: &FrequencyResponses<'_, R>,
    start: &RigidBody<R>,
    settings: &GlobalFitSettings,
    workspace: &mut [R],
) -> Result<GlobalFitSolution<R>, Diagnostics> {
    let bins = responses.frequencies().len();
    if !is_finite(layout) {
        return Err(fatal(Code::LayoutNotFinite, 0.0));
    }
    if !(responses.is_finite() && start.is_finite()) {
        return Err(fatal(Code::DataNotFinite, 0.0));
    }
    if responses.channels() != 3 * layout.sensors.len() || responses.hits() != layout.hits.len() {
        return Err(fatal(Code::FrfMissing, 0.0));
    }
    let (inverses, _) = workspace.as_chunks_mut::<INVERSE>();
    let Some(inverses) = inverses.get_mut(..bins) else {
        return Err(fatal(Code::BandTooNarrow, bins as f32));
    };
    let problem = GlobalFitProblem { layout, responses, settings };
    if settings.damping {
        problem.fit::<WITH_DAMPING>(start, inverses)
    } else {
        problem.fit::<WITH_STIFFNESS>(start, inverses)
    }
}

#[cfg(test)]
mod tests;

//! The ten properties in double precision: the answers of the methods, and the nuisance parameters of the
//! maximum-likelihood fit.

mod priors;
mod rigidity;

use massline_protocol::object::{DofResult, MeasurementResult};
use massline_shared::body::RigidBody;
use massline_shared::calibration::CalibrationSigma;
use massline_shared::capacity::Unbounded;
use massline_shared::diagnosis::{Code, Diagnostic, Diagnostics, Severity};
use massline_shared::identify::influence::{Influence, influences};
use massline_shared::identify::maximum_likelihood::{
    self, ErrorBudget, MaximumLikelihoodSolution, NuisanceEstimates, Start, without_repeats,
};
use massline_shared::identify::{
    self as solvers, DofMassLines, Estimate, IdentifySettings, Method, Methods, Observable,
    Observations, SpectrumBins,
};
use massline_shared::layout::HostLayout;

pub use priors::contradicted;
use priors::inconsistent_priors;
pub use rigidity::sensors_not_rigid;

/// Mass lines of the measured hit DOFs, with the index of each DOF in the layout.
pub type MeasuredLines = Vec<DofMassLines<f64, Unbounded>>;

/// Observations in the capacity and precision of the host.
pub type HostObservations<'a, L> = Observations<'a, f64, Unbounded, L>;

/// Selected methods.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Selection {
    /// All methods, the best first.
    #[default]
    All,
    /// One method.
    Only(Method),
}

impl Selection {
    /// The selected methods, the best first.
    pub fn methods(self) -> Methods {
        match self {
            Self::All => Method::ALL.into_iter().collect(),
            Self::Only(method) => [method].into_iter().collect(),
        }
    }

    /// Those of them that use the suspension modes.
    pub fn modal_methods(self) -> Methods {
        let uses_modes = |method: &Method| method.entry().observes != Observable::MassLines;
        self.methods().into_iter().filter(uses_modes).collect()
    }

    /// True for a selected method.
    pub fn contains(self, method: Method) -> bool {
        self.methods().contains(&method)
    }
}

/// The result of an identification.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Identification {
    /// The answers, one per method, the best first.
    pub estimates: Vec<Estimate<f64>>,
    /// The methods without an answer, the best first, and the reasons.
    pub not_applicable: Vec<(Method, Diagnostics)>,
    /// Nuisance parameters and influences of the maximum-likelihood fit.
    pub details: Option<Details>,
    /// Priors of the object's properties that contradict the data.
    pub priors: Vec<Diagnostic>,
}

/// Nuisance parameters and influences of the maximum-likelihood fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Details {
    /// Estimated nuisance parameters.
    pub nuisances: NuisanceEstimates<f64, Unbounded>,
    /// Influence of each hit DOF and sensor on the answer.
    pub influences: Vec<Influence<f64>>,
}

impl Identification {
    /// Diagnostics: why methods are missing, which other methods make up for them, and which priors
    /// contradict the data.
    pub fn warnings(&self) -> Vec<Diagnostic> {
        let reasons = self.not_applicable.iter().flat_map(|(_, reasons)| reasons);
        reasons
            .chain(&self.priors)
            .map(|d| Diagnostic { severity: Severity::Warning, ..*d })
            .collect()
    }

    /// The methods without an answer, each with every reason.
    pub fn refusals(&self) -> Vec<(Method, Diagnostic)> {
        let refused = self.not_applicable.iter();
        refused
            .flat_map(|(method, reasons)| reasons.iter().map(|reason| (*method, *reason)))
            .collect()
    }

    /// Calls `act` with the diagnostics of each answer.
    pub fn each_diagnostics(&mut self, mut act: impl FnMut(&mut [Diagnostic])) {
        self.estimates.iter_mut().for_each(|estimate| act(&mut estimate.diagnostics));
    }

    /// Puts the best methods first.
    pub fn sort(&mut self) {
        let place = |method: Method| Method::ALL.iter().position(|other| *other == method);
        self.estimates.sort_by_key(|estimate| place(estimate.method));
        self.not_applicable.sort_by_key(|(method, _)| place(*method));
    }

    /// Returns `self` when at least one method has an answer.
    ///
    /// # Errors
    /// The reasons of the best method when no method has an answer.
    pub fn answered(self) -> Result<Self, Diagnostics> {
        match self.not_applicable.first() {
            Some((_, reasons)) if self.estimates.is_empty() => Err(reasons.clone()),
            _ => Ok(self),
        }
    }
}

/// Applies the selected methods to the observations.
pub fn identify<L: SpectrumBins<f64>>(
    observed: &HostObservations<'_, L>,
    selection: Selection,
    settings: &IdentifySettings<f64>,
) -> Identification {
    let Observations { layout, mass_lines, .. } = observed;
    let wanted = match selection {
        Selection::All => observed.methods(),
        Selection::Only(_) => selection.methods(),
    };
    let mut identification = answers(observed, &wanted, settings);
    let likelihood = |estimate: &&mut Estimate<f64>| estimate.method == Method::MaximumLikelihood;
    if let Some(estimate) = identification.estimates.iter_mut().find(likelihood) {
        identification.priors = suspect_priors(estimate, layout, mass_lines);
        identification.details = details(&learned(layout, estimate), mass_lines, &estimate.body);
    }
    for (method, reasons) in &mut identification.not_applicable {
        if *method == Method::MaximumLikelihood {
            let priors = inconsistent_priors(layout, mass_lines).into_iter();
            let grave = |d| Diagnostic { severity: Severity::Error, ..d };
            // Reasons beyond the fixed capacity are dropped; a fit has few.
            reasons.extend(priors.map(grave).take(reasons.capacity() - reasons.len()));
        }
    }
    identification
}

/// The answers of these methods, without details. Where no repeat hits show their scatter, maximum likelihood learns
/// its error budget from the residuals.
pub fn answers<L: SpectrumBins<f64>>(
    observed: &HostObservations<'_, L>,
    wanted: &[Method],
    settings: &IdentifySettings<f64>,
) -> Identification {
    let Observations { layout, mass_lines, .. } = observed;
    let from_residuals = layout.learn_budget
        && settings.error_budget == ErrorBudget::Learned
        && !without_repeats::have_repeats(mass_lines);
    let is_apart = |method: &Method| from_residuals && *method == Method::MaximumLikelihood;
    let together: Vec<Method> = wanted.iter().copied().filter(|m| !is_apart(m)).collect();
    let (sensors, hits) = (layout.sensors.len(), layout.hits.len());
    let mut memory = vec![0.0; solvers::workspace(&together, sensors, hits)];
    let identified = solvers::identify(observed, &together, settings, &mut memory);
    let (estimates, refusals) = identified.into_parts();
    let mut answered = Identification {
        estimates: estimates.into_iter().collect(),
        not_applicable: refusals.into_iter().collect(),
        ..Identification::default()
    };
    if wanted.iter().any(is_apart) {
        // It starts from the best of the others, as where all run together.
        let best = answered.estimates.first().map(|estimate| estimate.body);
        let start = best.as_ref().map_or(Start::InertiaRestraint, Start::At);
        match solve_learned(layout, mass_lines, start) {
            Ok(solution) => answered.estimates.insert(0, solution.estimate),
            Err(reasons) => {
                answered.not_applicable.insert(0, (Method::MaximumLikelihood, reasons));
            }
        }
    }
    let is_lost = |(method, reasons): &(Method, Diagnostics)| {
        *method == Method::MaximumLikelihood
            && reasons.iter().any(|reason| reason.code == Code::NotConverged)
    };
    // On the way from the mass-line answer a fit may get lost: a crude start leads through physical bodies.
    if let Some(place) = answered.not_applicable.iter().position(is_lost)
        && let Ok(solution) = solve_learned(layout, mass_lines, Start::Crude)
    {
        answered.not_applicable.remove(place);
        answered.estimates.insert(0, solution.estimate);
    }
    answered
}

/// Maximum likelihood that learns its error budget: from repeat hits, or from the residuals where there are none.
///
/// # Errors
/// As [`maximum_likelihood::solve`].
pub fn solve_learned(
    layout: &HostLayout,
    lines: &[DofMassLines<f64, Unbounded>],
    start: Start<'_, f64>,
) -> Result<MaximumLikelihoodSolution<f64, Unbounded>, Diagnostics> {
    let (sensors, hits) = (layout.sensors.len(), layout.hits.len());
    let mut memory = vec![0.0; without_repeats::workspace(sensors, hits)];
    if without_repeats::have_repeats(lines) {
        let room = &mut memory[..maximum_likelihood::workspace(sensors, hits)];
        maximum_likelihood::solve(layout, lines, start, ErrorBudget::Learned, room)
    } else {
        without_repeats::solve(layout, lines, start, &mut memory)
    }
}

/// The priors that contradict the data, searched for only where the data contradict the budget. If there are
/// any, the diagnostic of the sensor or hit with the largest pull is removed from the estimate, as that
/// subject is no longer the first suspect.
fn suspect_priors(
    estimate: &mut Estimate<f64>,
    layout: &HostLayout,
    lines: &[DofMassLines<f64, Unbounded>],
) -> Vec<Diagnostic> {
    let is = |d: &Diagnostic, code: Code| d.code == code;
    if !estimate.diagnostics.iter().any(|d| is(d, Code::DataInconsistentWithBudget)) {
        return Vec::new();
    }
    let priors = inconsistent_priors(layout, lines);
    if !priors.is_empty() {
        let suspect = |d: &Diagnostic| is(d, Code::LargeSensorPull) || is(d, Code::LargeHitPull);
        estimate.diagnostics.retain(|d| !suspect(d));
    }
    priors
}

/// The layout with the budget that the fit has used; where it was learned, nothing is left to be learned.
pub fn learned(layout: &HostLayout, estimate: &Estimate<f64>) -> HostLayout {
    let mut layout = layout.clone();
    if let Some(learned) = &estimate.learned {
        learned.apply_to(&mut layout);
        layout.learn_budget = false;
    }
    layout
}

/// Nuisance parameters of sensors, hammer and hits at the fit's answer, and the influence of each on the
/// answer.
fn details(
    layout: &HostLayout,
    lines: &[DofMassLines<f64, Unbounded>],
    answer: &RigidBody<f64>,
) -> Option<Details> {
    let (sensors, hits) = (layout.sensors.len(), layout.hits.len());
    let mut memory = vec![0.0; maximum_likelihood::workspace(sensors, hits)];
    let whole = maximum_likelihood::solve(
        layout,
        lines,
        Start::At(answer),
        ErrorBudget::Stated,
        &mut memory,
    );
    let whole = whole.ok()?;
    let mut of_each = Vec::new();
    influences(layout, lines, &whole, &mut memory, |influence| of_each.push(influence));
    Some(Details { nuisances: whole.nuisances, influences: of_each })
}

/// The mass lines of a rig's result for the sensors of its layout, in double precision; DOFs with inconsistent numbers
/// of values are left out.
pub fn lines_of(result: &MeasurementResult, layout: &HostLayout) -> MeasuredLines {
    lines_of_dofs(&result.dofs, layout)
}

/// As [`lines_of`], of single DOFs.
pub fn lines_of_dofs(dofs: &[DofResult], layout: &HostLayout) -> MeasuredLines {
    let of_rig = dofs.iter().filter_map(DofResult::mass_lines);
    let sensors = layout.sensors.len();
    of_rig.map(|(index, lines)| (index, lines.cast::<f64>().resized(sensors))).collect()
}

/// The layout with the standard deviations that the calibration of a result contributed.
pub fn layout_of(result: &MeasurementResult, layout: &HostLayout) -> HostLayout {
    with_gains(layout, result.head.gains)
}

/// The layout with the standard deviations that a calibration contributes, if it contributes any.
pub fn with_gains(layout: &HostLayout, gains: Option<CalibrationSigma>) -> HostLayout {
    let mut layout = layout.clone();
    if let Some(gains) = gains {
        gains.apply_to(&mut layout);
    }
    layout
}

//! The ten properties in double precision: what the methods answer, and what the fit of maximum likelihood
//! found out on the way.

mod priors;
mod report;

use massline_protocol::object::{DofResult, MeasurementResult};
use massline_shared::body::RigidBody;
use massline_shared::diagnosis::{Code, Diagnostic, Diagnostics, Severity};
use massline_shared::identify::influence::{Influence, influences};
use massline_shared::identify::maximum_likelihood::{self, NuisanceEstimates, Start};
use massline_shared::identify::{
    self as solvers, DofMassLines, Estimate, IdentifySettings, Method, Methods, Observations,
    SpectrumBins,
};
use massline_shared::layout::{HOST_HITS, HOST_SENSORS, HostLayout};

use priors::inconsistent_priors;

/// Mass lines of the hit DOFs that were measured, with their index in the layout.
pub type MeasuredLines = Vec<DofMassLines<f64, HOST_SENSORS>>;

/// What the host has observed.
pub type HostObservations<'a, L> = Observations<'a, f64, HOST_SENSORS, HOST_HITS, L>;

/// Which methods are wanted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Selection {
    /// All that answer without being asked for by name, the best first.
    #[default]
    All,
    /// One.
    Only(Method),
}

impl Selection {
    /// The methods, the best first.
    pub fn methods(self) -> Methods {
        match self {
            Self::All => Method::usual().collect(),
            Self::Only(method) => [method].into_iter().collect(),
        }
    }

    /// True for a method that is wanted.
    pub fn contains(self, method: Method) -> bool {
        self.methods().contains(&method)
    }
}

/// What was identified.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Identification {
    /// The answers, one a method, the best first.
    pub estimates: Vec<Estimate<f64>>,
    /// The methods without an answer, the best first, and why.
    pub not_applicable: Vec<(Method, Diagnostics)>,
    /// What the fit of maximum likelihood found out.
    pub details: Option<Details>,
    /// What was said to be known of the object and contradicts the data.
    pub priors: Vec<Diagnostic>,
}

/// What the fit of maximum likelihood found out.
#[derive(Clone, Debug, PartialEq)]
pub struct Details {
    /// Causes of error.
    pub nuisances: NuisanceEstimates<f64, HOST_SENSORS, HOST_HITS>,
    /// What each hit DOF and sensor does to the answer.
    pub influences: Vec<Influence<f64>>,
}

impl Identification {
    /// Why methods are missing, which others make up for, and which priors contradict the data.
    pub fn warnings(&self) -> Vec<Diagnostic> {
        let reasons = self.not_applicable.iter().flat_map(|(_, reasons)| reasons);
        reasons
            .chain(&self.priors)
            .map(|d| Diagnostic { severity: Severity::Warning, ..*d })
            .collect()
    }

    /// The same when at least one method has an answer.
    ///
    /// # Errors
    /// The reasons of the best method, when none has.
    pub fn answered(self) -> Result<Self, Diagnostics> {
        match self.not_applicable.first() {
            Some((_, reasons)) if self.estimates.is_empty() => Err(reasons.clone()),
            _ => Ok(self),
        }
    }
}

/// What the selected methods make of what was observed.
pub fn identify<L: SpectrumBins<f64>>(
    observed: &HostObservations<'_, L>,
    selection: Selection,
    settings: &IdentifySettings<f64>,
) -> Identification {
    let Observations { layout, mass_lines, spectrum_bins } = observed;
    let wanted = match selection {
        Selection::All => observed.methods(),
        Selection::Only(_) => selection.methods(),
    };
    let lines = spectrum_bins.responses().map_or(0, |responses| responses.frequencies().len());
    let mut memory = vec![0.0; solvers::workspace(&wanted, layout.sensors.len(), lines)];
    let found = solvers::identify(observed, &wanted, settings, &mut memory);
    let (estimates, refusals) = found.into_parts();
    let mut found = Identification {
        estimates: estimates.into_iter().collect(),
        not_applicable: refusals.into_iter().collect(),
        ..Identification::default()
    };
    let likelihood = |estimate: &&mut Estimate<f64>| estimate.method == Method::MaximumLikelihood;
    if let Some(estimate) = found.estimates.iter_mut().find(likelihood) {
        found.priors = suspect_priors(estimate, layout, mass_lines);
        found.details = details(layout, mass_lines, &estimate.body);
    }
    for (method, reasons) in &mut found.not_applicable {
        if *method == Method::MaximumLikelihood {
            let priors = inconsistent_priors(layout, mass_lines).into_iter();
            let grave = |d| Diagnostic { severity: Severity::Error, ..d };
            // What there is no room for beside the few reasons of a fit is left out.
            reasons.extend(priors.map(grave).take(reasons.capacity() - reasons.len()));
        }
    }
    found
}

/// Where the data contradict the budget: the priors that contradict the data. The sensor or hit that
/// pulls the budget most is then no longer the first to be suspected, and leaves the estimate's
/// diagnostics.
fn suspect_priors(
    estimate: &mut Estimate<f64>,
    layout: &HostLayout,
    lines: &[DofMassLines<f64, HOST_SENSORS>],
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

/// What the fit found out about sensors, hammer and hits at its answer, and what each of them does to that.
fn details(
    layout: &HostLayout,
    lines: &[DofMassLines<f64, HOST_SENSORS>],
    answer: &RigidBody<f64>,
) -> Option<Details> {
    let mut memory = vec![0.0; maximum_likelihood::workspace(layout.sensors.len())];
    let whole = maximum_likelihood::solve(layout, lines, Start::At(answer), &mut memory);
    let whole = whole.ok()?;
    let mut of_each = Vec::new();
    influences(layout, lines, &whole, &mut memory, |influence| of_each.push(influence));
    Some(Details { nuisances: whole.nuisances, influences: of_each })
}

/// The mass lines of a rig's result in double precision; DOFs whose numbers do not fit together are left
/// out.
pub fn lines_of(result: &MeasurementResult) -> MeasuredLines {
    let of_rig = result.dofs.iter().filter_map(DofResult::mass_lines);
    of_rig.map(|(index, lines)| (index, lines.cast::<f64>().resized())).collect()
}

//! The ten properties from mass lines in double precision: every method that the layout admits, and
//! what the fit found out on the way.

mod priors;

use massline_protocol::object::{DofResult, MeasurementResult};
use massline_shared::diagnosis::{Diagnostic, Diagnostics, Severity, Subject};
use massline_shared::identify::inertia_restraint::{self, Settings};
use massline_shared::identify::influence::{Influence, influences};
use massline_shared::identify::maximum_likelihood::{self, Learned, workspace};
use massline_shared::identify::{MassLines, Method};
use massline_shared::layout::{HOST_HITS, HOST_SENSORS, HostLayout};

pub use priors::{contradicted_priors, in_place_of_suspects, priors_of_result};

use crate::report::Answer;

/// Channels that the host solves for.
pub const CHANNELS: usize = 3 * HOST_SENSORS;

/// Mass lines of the hit DOFs that were measured, with their index in the layout.
pub type MeasuredLines = Vec<(usize, MassLines<f64, CHANNELS>)>;

/// Which methods are wanted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Selection {
    /// All that answer from mass lines, the best first.
    #[default]
    All,
    /// One.
    Only(Method),
}

impl Selection {
    /// The methods, the best first.
    pub fn methods(&self) -> &[Method] {
        match self {
            Self::All => &[Method::MaximumLikelihood, Method::InertiaRestraint],
            Self::Only(method) => core::slice::from_ref(method),
        }
    }
}

/// How to identify.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// The methods.
    pub selection: Selection,
    /// How the inertia restraint method sets up its equations.
    pub inertia_restraint: Settings<f64>,
}

/// The answers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Identification {
    /// One a method, in the order that was asked for.
    pub answers: Vec<Answer>,
    /// The methods without an answer, and why.
    pub not_applicable: Vec<(Method, Diagnostics)>,
    /// What the fit of maximum likelihood found out.
    pub details: Option<Details>,
    /// What was said to be known of the object and contradicts the data.
    pub priors: Vec<Diagnostic>,
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
}

/// What the fit of maximum likelihood found out.
#[derive(Clone, Debug, PartialEq)]
pub struct Details {
    /// Causes of error.
    pub learned: Learned<f64, HOST_SENSORS, HOST_HITS>,
    /// What each hit DOF and sensor does to the answer.
    pub influences: Vec<Influence<f64>>,
}

/// Every method that is wanted and admitted.
///
/// # Errors
/// When none has an answer: the diagnostics of the method that asks for least.
pub fn identify(
    layout: &HostLayout,
    lines: &MeasuredLines,
    options: &Options,
) -> Result<Identification, Diagnostics> {
    let dofs = || lines.iter().map(|(index, lines)| (*index, lines));
    let linear = inertia_restraint::solve(layout, dofs(), options.inertia_restraint);
    let mut found = Identification::default();
    let mut refusal = None;
    for &method in options.selection.methods() {
        let answer = match method {
            // It answers from spectral lines.
            Method::GlobalFit => continue,
            Method::InertiaRestraint => linear.as_ref().map_err(Clone::clone).map(|estimate| {
                found.answers.push(Answer::of(method, estimate));
            }),
            Method::MaximumLikelihood => {
                let mut memory = vec![0.0; workspace(HOST_SENSORS)];
                let start = linear.as_ref().ok().map(|estimate| &estimate.body);
                maximum_likelihood::solve(layout, dofs(), start, &mut memory).map(|solution| {
                    let mut answer = Answer::of(method, &solution.estimate);
                    let named = in_place_of_suspects(&answer.diagnostics, layout, lines);
                    if let Some((others, priors)) = named {
                        (answer.diagnostics, found.priors) = (others, priors);
                    }
                    found.answers.push(answer);
                    let mut of_each = Vec::new();
                    influences(layout, dofs(), &solution, &mut memory, |i| of_each.push(i));
                    let learned = solution.learned;
                    found.details = Some(Details { learned, influences: of_each });
                })
            }
        };
        if let Err(mut reasons) = answer {
            if method == Method::MaximumLikelihood {
                let priors = contradicted_priors(layout, lines).into_iter();
                let grave = |d| Diagnostic { severity: Severity::Error, ..d };
                // What there is no room for beside the few reasons of a fit is left out.
                reasons.extend(priors.map(grave).take(reasons.capacity() - reasons.len()));
            }
            refusal.get_or_insert_with(|| reasons.clone());
            found.not_applicable.push((method, reasons));
        }
    }
    match refusal {
        Some(reasons) if found.answers.is_empty() => Err(reasons),
        _ => Ok(found),
    }
}

/// The methods that a rig's result has no answer of, and why. A rig says why without saying of which
/// method, so its mass lines are solved again; where double precision has an answer, the reasons are
/// what the rig says of the test as a whole.
pub fn refused(
    result: &MeasurementResult,
    layout: &HostLayout,
    selection: Selection,
) -> Vec<(Method, Diagnostics)> {
    let lines = lines_of(result, layout);
    let answered = |method: Method| result.estimates.iter().any(|e| e.method == method as u8);
    let missing = selection.methods().iter().filter(|&&method| !answered(method));
    let reasons = |&method: &Method| {
        let options =
            Options { selection: Selection::Only(method), inertia_restraint: Settings::weighted() };
        let said = result.diagnostics.iter().filter(|d| d.subject == Subject::Whole);
        let grave = said.filter(|d| d.severity > Severity::Note);
        match identify(layout, &lines, &options) {
            Err(reasons) => (method, reasons),
            Ok(_) => (method, grave.copied().collect()),
        }
    };
    missing.map(reasons).collect()
}

/// The mass lines of a stored result; DOFs whose numbers do not fit together are left out.
pub fn lines_of(result: &MeasurementResult, layout: &HostLayout) -> MeasuredLines {
    let channels = 3 * layout.sensors.len();
    let wide = |values: &[f32]| values.iter().copied().map(f64::from).collect::<Vec<_>>();
    let of_dof = |dof: &DofResult| {
        let accelerance = wide(dof.accelerance.get(..channels)?);
        let noise = wide(dof.noise.get(..channels)?);
        // The first rows of the triangle are those of the channels in use.
        let scatter = wide(dof.scatter.get(..channels * (channels + 1) / 2).unwrap_or_default());
        let hits = u16::from(dof.hits);
        let lines = MassLines::from_parts(&accelerance, &noise, &scatter, hits)?;
        Some((usize::from(dof.index), lines))
    };
    result.dofs.iter().filter_map(of_dof).collect()
}

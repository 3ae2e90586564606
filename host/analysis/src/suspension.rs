//! The methods that use the suspension modes, on the frequency responses of a test: all of them at once, their
//! uncertainty and their agreement.

mod adequacy;
mod alternatives;
mod comparison;
mod directions;
mod explained;
mod first_look;
mod global;
mod gravity;
mod linear_fit;
mod mass_lines;
mod methods;
mod modal_gains;
mod modes;
mod noise;
mod reciprocity;
mod rigidity;
mod small_faults;
mod survey;
mod test_lines;
#[cfg(test)]
mod test_wheel;

use massline_shared::FrequencyResponses;
use massline_shared::body::{RigidBody, scale};
use massline_shared::capacity::Unbounded;
use massline_shared::diagnosis::{Code, Diagnostic, Diagnostics, Severity};
use massline_shared::identify::global_fit::{GlobalFitSettings, GlobalFitSolution};
use massline_shared::identify::suspension::{
    FEWEST_MODES, SuspensionFit, add_doubts, mode_findings, refusal_of_property,
    undetermined_property,
};
use massline_shared::identify::{Estimate, Method};
use massline_shared::layout::HostLayout;
use massline_shared::modes::{LinesPerSide, Reduction};

use crate::score_tests::ScoreTests;
use adequacy::{Adequacy, GlobalFitJudgement, judge, refuse_misfit, warn_of_misfit};
pub use comparison::{Comparison, compare};
use first_look::modal_fit;
pub use first_look::{FirstLook, find_modes};
pub use global::GlobalAnswer;
pub use mass_lines::MassLineAnswers;
pub use methods::{ModalAnswers, ModeChoice, Variant, answered};
pub use modes::{ModeRow, OrderRow, PoleRow, SuspensionModes};
pub use reciprocity::reciprocity_of_mass_lines;
use rigidity::not_rigid;
pub use survey::{Survey, SurveyedAnswer};
pub use test_lines::{DofLines, TestLines};

/// A fit with the capacity of the host.
pub type HostFit<'a> = SuspensionFit<'a, f64, Unbounded>;

/// How the suspension modes are used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ModalSettings {
    /// The modes that the methods get.
    pub choice: ModeChoice,
    /// Lines about each mode for the direct methods.
    pub lines: LinesPerSide,
    /// The user has asked for one method by its name.
    pub named: bool,
}

/// The answers of all methods to a test.
#[derive(Clone, Debug)]
pub struct SuspensionSolution {
    /// The modes.
    pub modes: SuspensionModes,
    /// The answers, best method first; those that were given are not among them.
    pub estimates: Vec<Estimate<f64>>,
    /// The methods without an answer, and why.
    pub not_applicable: Vec<(Method, Diagnostics)>,
    /// What all methods say together.
    pub comparison: Comparison,
    /// The global fit, where it has an answer, also if it was not asked for.
    pub global: Option<GlobalFitSolution<f64>>,
    /// The tests of the global fit for small faults, where it was asked for and leaves little but noise.
    pub score_tests: ScoreTests,
}

/// Solves the readings of the suspension band by these methods; any that do not use the suspension modes are left out.
/// `mass_lines` has the answers of other methods to the same test, to compare with. `progress` is told how many of all
/// changes are done.
///
/// # Errors
/// Those of [`SuspensionFit::new`].
pub fn solve(
    layout: &HostLayout,
    readings: &FrequencyResponses<'_, f64>,
    wanted: &[Method],
    settings: ModalSettings,
    mass_lines: Option<&MassLineAnswers<'_>>,
    progress: impl FnMut(u32, u32) + Send,
) -> Result<SuspensionSolution, Diagnostics> {
    // Sensors and hits have the errors that the mass lines have shown, where there are any.
    let layout = mass_lines.map_or(layout, |answers| &answers.budget);
    let upright;
    let mut memory = Box::new(Reduction::new());
    let default = GlobalFitSettings::default();
    let mut first = FirstAnswers::of(layout, readings, settings, &default, &mut memory)?;
    let mut adequacy = first.judged(readings)?;
    if let Adequacy::Tilted(tilted) = adequacy {
        upright = tilted.upright(layout);
        let rigid = GlobalFitSettings { most_extra_terms: 0, ..default };
        first = FirstAnswers::of(&upright, readings, settings, &rigid, &mut memory)?;
        first.findings.push(tilted.warning());
        // Structural damping or disturbed lines may be there besides.
        adequacy = first.judged(readings)?.under(tilted);
    }
    refuse_misfit(&mut first.global, adequacy);
    Ok(first.surveyed(wanted, mass_lines, adequacy, progress))
}

/// Modes and answers without uncertainty.
struct FirstAnswers<'a> {
    fit: HostFit<'a>,
    findings: Vec<Diagnostic>,
    modal: ModalAnswers,
    global: Result<GlobalAnswer, Diagnostics>,
}

impl<'a> FirstAnswers<'a> {
    /// # Errors
    /// Those of [`SuspensionFit::new`], and when one more mode rules out an answer.
    fn of(
        layout: &'a HostLayout,
        readings: &'a FrequencyResponses<'a, f64>,
        settings: ModalSettings,
        of_global: &GlobalFitSettings,
        memory: &mut Reduction<f64>,
    ) -> Result<Self, Diagnostics> {
        let fit = modal_fit(layout, readings, memory)?.with_lines(settings.lines);
        let findings = findings(&fit, readings, memory)?;
        match fit.one_more() {
            Some(error) if error.is_error() => Err(Diagnostics::from_array([error])),
            _ => Ok(Self::from_fit(fit, findings, readings, settings, of_global, memory)),
        }
    }

    fn from_fit(
        fit: HostFit<'a>,
        findings: Vec<Diagnostic>,
        readings: &FrequencyResponses<'_, f64>,
        settings: ModalSettings,
        of_global: &GlobalFitSettings,
        memory: &mut Reduction<f64>,
    ) -> Self {
        // The modal answers are where the global fit starts, also when it is the only method that is wanted.
        let choice = settings.choice;
        let variants: Vec<_> =
            Method::of_modes().map(|method| Variant { method, choice }).collect();
        let modal = answered(&fit, &variants, settings.named, memory);
        // The global fit also tells the other methods whether a flexible mode is near.
        let global = global_fit(&fit, readings, best(&modal), of_global);
        Self { fit, findings, modal, global }
    }

    /// How well a body on its suspension explains the readings. The global fit takes the form that explains them.
    ///
    /// # Errors
    /// As [`judge`].
    fn judged(&mut self, readings: &FrequencyResponses<'_, f64>) -> Result<Adequacy, Diagnostics> {
        let GlobalFitJudgement { adequacy, instead } =
            judge(&self.fit, readings, best(&self.modal), &self.global)?;
        if let Some(instead) = instead {
            self.global = Ok(instead);
        }
        Ok(adequacy)
    }

    /// The answers that are wanted, with their uncertainty and agreement.
    fn surveyed(
        self,
        wanted: &[Method],
        mass_lines: Option<&MassLineAnswers<'_>>,
        adequacy: Adequacy,
        progress: impl FnMut(u32, u32) + Send,
    ) -> SuspensionSolution {
        let Self { fit, findings, mut modal, global } = self;
        let layout = fit.layout();
        modal.keep(wanted);
        let global_wanted = wanted.contains(&Method::GlobalFit);
        if let (Err(reasons), true) = (&global, global_wanted) {
            modal.not_applicable.insert(0, (Method::GlobalFit, reasons.clone()));
        }
        let global = global.ok();
        let compared = global.as_ref().filter(|_| global_wanted);
        let score_tests = compared.filter(|answer| answer.leaves_little(&fit));
        let score_tests = score_tests.map(|answer| answer.score_tests(layout));
        let of_lines = mass_lines
            .into_iter()
            .flat_map(|answers| answers.estimates.iter().map(move |e| (answers, e)));
        let asked: Vec<SurveyedAnswer<'_>> = (compared.into_iter().map(SurveyedAnswer::Global))
            .chain(modal.answers.iter().map(|(variant, _)| SurveyedAnswer::Modal(*variant)))
            .chain(
                of_lines
                    .clone()
                    .map(|(answers, estimate)| SurveyedAnswer::MassLines(estimate.method, answers)),
            )
            .collect();
        let survey = Survey::of(layout, Some(&fit), &asked, progress);
        let first = usize::from(compared.is_some());
        let mut estimates: Vec<(usize, Estimate<f64>)> =
            compared.map(|answer| (0, answer.solution.estimate.clone())).into_iter().collect();
        estimates.extend(survey.estimates(&mut modal, first, layout.characteristic_length()));
        let of_lines = (first + modal.answers.len()..).zip(of_lines.map(|(_, estimate)| estimate));
        let answers = estimates.iter().map(|(place, estimate)| (*place, estimate)).chain(of_lines);
        let mut of_modes = findings.clone();
        if adequacy == Adequacy::Flexible {
            of_modes.extend(adequacy.finding_of_modes());
        }
        SuspensionSolution {
            comparison: Comparison::of(&survey, answers, adequacy.doubt()),
            estimates: warned(estimates, adequacy, &findings),
            modes: SuspensionModes {
                fitted_gravity: adequacy.fitted_gravity(),
                ..SuspensionModes::new(&fit, &survey, of_modes)
            },
            not_applicable: modal.not_applicable,
            global: global.map(|answer| answer.solution),
            score_tests: score_tests.unwrap_or_default(),
        }
    }
}

/// The suspension modes with their uncertainty, without any method. What speaks against a body on its suspension is a
/// warning.
///
/// # Errors
/// Those of [`SuspensionFit::new`].
pub fn modes(
    layout: &HostLayout,
    readings: &FrequencyResponses<'_, f64>,
    progress: impl FnMut(u32, u32) + Send,
) -> Result<SuspensionModes, Diagnostics> {
    let mut memory = Box::new(Reduction::new());
    let fit = modal_fit(layout, readings, &mut memory)?;
    let findings = findings(&fit, readings, &memory)?;
    let ruled_out = fit.one_more().is_some_and(|one_more| one_more.is_error());
    let (settings, of_global) = (ModalSettings::default(), GlobalFitSettings::default());
    let mut first =
        FirstAnswers::from_fit(fit, findings, readings, settings, &of_global, &mut memory);
    // One more mode leaves no answers to judge.
    let adequacy = if ruled_out { Ok(Adequacy::Unknown) } else { first.judged(readings) };
    let survey = Survey::of(layout, Some(&first.fit), &[], progress);
    let mut modes = SuspensionModes::new(&first.fit, &survey, first.findings);
    // A frequency that is less certain than the peak is wide is that of noise.
    let is_noise = |row: &ModeRow| {
        let width = 2.0 * row.damping_ratio[0] * row.frequency_hz[0];
        row.frequency_hz[1] > width
    };
    if modes.rows.iter().all(is_noise) {
        let missing = Diagnostic::whole(Code::SuspensionModesMissing, Severity::Error, 0.0);
        return Err(Diagnostics::from_array([missing]));
    }
    match adequacy {
        Ok(adequacy) => {
            modes.diagnostics.extend(adequacy.finding_of_modes());
            modes.fitted_gravity = adequacy.fitted_gravity();
        }
        Err(reasons) => modes.diagnostics.extend(reasons),
    }
    for finding in &mut modes.diagnostics {
        finding.severity = Severity::Warning;
    }
    Ok(modes)
}

/// The best modal answer.
fn best(modal: &ModalAnswers) -> Option<&RigidBody<f64>> {
    modal.answers.first().map(|(_, answer)| &answer.body)
}

/// Warnings about modes, sensors and hits.
///
/// # Errors
/// When the sensors contradict each other.
fn findings(
    fit: &HostFit<'_>,
    readings: &FrequencyResponses<'_, f64>,
    memory: &Reduction<f64>,
) -> Result<Vec<Diagnostic>, Diagnostics> {
    let mut diagnostics = mode_findings(fit.modes(), &memory.responses()).to_vec();
    diagnostics.extend(fit.one_more());
    diagnostics.extend(reciprocity::reciprocity_of_modes(fit, readings));
    if fit.layout().lacks_gravity() {
        diagnostics.push(Diagnostic::whole(Code::GravityNotGiven, Severity::Warning, 0.0));
    }
    match not_rigid(fit, readings) {
        Some(error) if error.is_error() => return Err(Diagnostics::from_array([error])),
        warning => diagnostics.extend(warning),
    }
    Ok(diagnostics)
}

/// The global fit from a modal answer.
fn global_fit(
    fit: &HostFit<'_>,
    readings: &FrequencyResponses<'_, f64>,
    start: Option<&RigidBody<f64>>,
    settings: &GlobalFitSettings,
) -> Result<GlobalAnswer, Diagnostics> {
    let (layout, count) = (fit.layout(), fit.modes().modes.len());
    let few = || {
        let code = Code::SuspensionModesMissing;
        Diagnostics::from_array([Diagnostic::whole(code, Severity::Error, count as f32)])
    };
    let start = start.filter(|_| count > 0).ok_or_else(few)?;
    let answer = GlobalAnswer::of_real_converter(layout, readings, start, settings)
        .map_err(|reasons| if count < FEWEST_MODES { few() } else { reasons })?;
    let estimate = &answer.solution.estimate;
    let length = layout.characteristic_length();
    let undetermined =
        estimate.sigma().and_then(|sigma| undetermined_property(&estimate.theta(), &sigma, length));
    match undetermined {
        None => Ok(answer),
        Some(_) if count < FEWEST_MODES => Err(few()),
        Some((property, share)) => Err(refusal_of_property(property, share)),
    }
}

/// The estimates alone, with warnings of a misfit and of what was found about modes that they use.
fn warned(
    estimates: Vec<(usize, Estimate<f64>)>,
    adequacy: Adequacy,
    findings: &[Diagnostic],
) -> Vec<Estimate<f64>> {
    let mut answers: Vec<_> = estimates.into_iter().map(|(_, estimate)| estimate).collect();
    for estimate in &mut answers {
        add_doubts(estimate, findings);
    }
    warn_of_misfit(&mut answers, adequacy);
    answers
}

/// Warns every other method of a flexible mode above the band where the global fit has found one, with the largest
/// distance of its answer from the global fit's, in parts of scale.
pub fn warn_of_flexible_mode(
    estimates: &mut [Estimate<f64>],
    global: &GlobalFitSolution<f64>,
    layout: &HostLayout,
) {
    if global.extra_terms == 0 {
        return;
    }
    let scale = scale(global.estimate.body.mass, layout.characteristic_length());
    for estimate in estimates.iter_mut().filter(|e| e.method != Method::GlobalFit) {
        let off = (estimate.theta() - global.estimate.theta()).component_div(&scale).amax();
        let code = Code::FlexibleModeAboveBand;
        // There is room for sixteen diagnostics; any others are dropped.
        let _ = estimate.diagnostics.push(Diagnostic::whole(code, Severity::Warning, off as f32));
    }
}

//! The methods that use the suspension modes, on the frequency responses of a test: all of them at once, their
//! uncertainty and their agreement.

mod global;
mod mass_lines;
mod modes;
mod reciprocity;

use massline_shared::FrequencyResponses;
use massline_shared::body::{RigidBody, scale};
use massline_shared::diagnosis::{Code, Diagnostic, Diagnostics, Severity, Subject};
use massline_shared::identify::agreement::{Agreement, Propagation, propagate};
use massline_shared::identify::global_fit::GlobalFitSolution;
use massline_shared::identify::suspension::{Answer, SuspensionFit, mode_findings, truncated_mode};
use massline_shared::identify::{Estimate, METHODS, Method, Observable, Perturbation};
use massline_shared::layout::{HOST_HITS, HOST_SENSORS, HostLayout};
use massline_shared::modes::{LinesPerSide, Modes, Reduction};
use nalgebra::SVector;

pub use global::GlobalAnswer;
pub use mass_lines::MassLineAnswers;
pub use modes::{ModeRow, OrderRow, PoleRow, SuspensionModes};
pub use reciprocity::reciprocity_of_mass_lines;

/// A fit with the capacity of the host.
pub type HostFit<'a> = SuspensionFit<'a, f64, HOST_SENSORS, HOST_HITS>;

/// The two forms of the direct method: when one fits worse than the other by this factor, it has no answer unless it is
/// asked for.
const CLEARLY_WORSE: f64 = 1.2;

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

/// A method with a choice of modes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Variant {
    /// The method.
    pub method: Method,
    /// The modes.
    pub choice: ModeChoice,
}

/// The modes that a method gets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ModeChoice {
    /// All suspension modes, with shapes from all forces.
    #[default]
    All,
    /// The five of lowest frequency.
    Five,
    /// All of them, each with its shape from the force that shows it best.
    BestForce,
}

impl ModeChoice {
    fn of(self, modes: &Modes<f64>, memory: &Reduction<f64>) -> Option<Modes<f64>> {
        match self {
            Self::All => Some(modes.clone()),
            Self::Five => Some(modes.clone().first(5)),
            Self::BestForce => modes.of_best_forces(&memory.responses()),
        }
    }
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
    /// The global fit, where it has an answer.
    pub global: Option<GlobalFitSolution<f64>>,
}

/// What all methods say together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// The methods that were compared.
    pub methods: Vec<Method>,
    /// How they agree; `None` with fewer than two of them.
    pub agreement: Option<Agreement<f64>>,
}

/// Solves the readings of the suspension band by these methods; any that do not use the suspension modes are left out.
/// `mass_lines` has the answers of other methods to the
/// same test, to compare with. `progress` is told how many of all changes are done.
///
/// # Errors
/// Those of [`SuspensionFit::new`].
pub fn solve(
    layout: &HostLayout,
    readings: &FrequencyResponses<'_, f64>,
    wanted: &[Method],
    settings: ModalSettings,
    mass_lines: Option<&MassLineAnswers<'_>>,
    progress: impl FnMut(u32, u32),
) -> Result<SuspensionSolution, Diagnostics> {
    let mut memory = Box::new(Reduction::new());
    let fit = HostFit::new(layout, readings, &mut memory)?.with_lines(settings.lines);
    let findings = findings(&fit, readings, &memory);
    // The modal answers are where the global fit starts, also when it is the only method that is wanted.
    let modal = Method::ALL.into_iter().filter(|m| m.entry().observes == Observable::Suspension);
    let variants: Vec<Variant> =
        modal.map(|method| Variant { method, choice: settings.choice }).collect();
    let Answered { mut answers, mut not_applicable } =
        answered(&fit, &variants, settings.named, &mut memory);
    let start = answers.first().map(|(_, answer)| answer.body);
    answers.retain(|(variant, _)| wanted.contains(&variant.method));
    not_applicable.retain(|(method, _)| wanted.contains(method));
    let mut global = None;
    if wanted.contains(&Method::GlobalFit) {
        match global_fit(layout, &fit, readings, start.as_ref()) {
            Ok(found) => global = Some(found),
            Err(reasons) => not_applicable.insert(0, (Method::GlobalFit, reasons)),
        }
    }
    let mut asked: Vec<Asked<'_>> = global.iter().map(Asked::Global).collect();
    let first = asked.len();
    asked.extend(answers.iter().map(|(variant, _)| Asked::Modal(*variant)));
    let others = mass_lines.map_or(&[][..], |of| of.estimates);
    asked.extend(
        mass_lines.iter().flat_map(|of| others.iter().map(|e| Asked::MassLines(e.method, of))),
    );
    // The global fit has its own covariance: alone, it needs no perturbations.
    let alone = asked.len() == first && first == 1;
    let survey = if alone {
        Survey::none()
    } else {
        Survey::of(layout, Some(&fit), &asked, &mut memory, progress)
    };
    let mut estimates: Vec<Estimate<f64>> =
        global.iter().map(|found| found.solution.estimate.clone()).collect();
    for (place, (variant, answer)) in answers.iter().enumerate() {
        estimates.push(survey.estimate(first + place, variant, answer));
    }
    let flexible = global.as_ref().filter(|found| found.solution.extra_terms > 0);
    if let Some(found) = flexible {
        warn_of_flexible_mode(&mut estimates, &found.solution.estimate, layout);
    }
    let mut thetas = [None; METHODS];
    for (to, estimate) in thetas.iter_mut().zip(estimates.iter().chain(others)) {
        // With a flexible mode above the band the other methods are known to be off.
        *to = flexible.is_none().then(|| estimate.theta());
    }
    let methods = estimates.iter().chain(others).map(|estimate| estimate.method).collect();
    Ok(SuspensionSolution {
        modes: SuspensionModes::new(&fit, &survey, findings),
        comparison: Comparison { methods, agreement: survey.agreement(&thetas) },
        estimates,
        not_applicable,
        global: global.map(|found| found.solution),
    })
}

/// Frequencies, Hz, and damping ratios of the suspension modes that a first look at the readings shows; the records are
/// taken to be this long, s, unless they had an exponential window.
///
/// # Errors
/// Those of [`SuspensionFit::new`], and `record_too_short_for_damping`.
pub fn find_modes(
    layout: &HostLayout,
    readings: &FrequencyResponses<'_, f64>,
    record_s: f64,
) -> Result<Vec<(f64, f64)>, Diagnostics> {
    let fit = HostFit::new(layout, readings, &mut Reduction::new())?;
    let truncated = truncated_mode(fit.modes(), record_s).filter(|_| readings.decay == 0.0);
    if let Some((place, left)) = truncated {
        let subject = Subject::mode(place);
        let reason = Diagnostic::about(Code::RecordTooShort, Severity::Error, subject, left as f32);
        return Err(Diagnostics::from_array([reason]));
    }
    let modes = fit.modes().modes.iter();
    Ok(modes.map(|mode| (mode.frequency_hz, mode.damping_ratio)).collect())
}

/// The suspension modes with their uncertainty, without any method.
///
/// # Errors
/// Those of [`SuspensionFit::new`].
pub fn modes(
    layout: &HostLayout,
    readings: &FrequencyResponses<'_, f64>,
    progress: impl FnMut(u32, u32),
) -> Result<SuspensionModes, Diagnostics> {
    let mut memory = Box::new(Reduction::new());
    let fit = HostFit::new(layout, readings, &mut memory)?;
    let findings = findings(&fit, readings, &memory);
    let survey = Survey::of(layout, Some(&fit), &[], &mut memory, progress);
    Ok(SuspensionModes::new(&fit, &survey, findings))
}

/// Warnings about modes and about hits that are not reciprocal.
fn findings(
    fit: &HostFit<'_>,
    readings: &FrequencyResponses<'_, f64>,
    memory: &Reduction<f64>,
) -> Vec<Diagnostic> {
    let mut all = mode_findings(fit.modes(), &memory.responses()).to_vec();
    all.extend(reciprocity::reciprocity_of_modes(fit, readings));
    all
}

/// How the answers to mass lines alone agree.
pub fn compare(layout: &HostLayout, answers: &MassLineAnswers<'_>) -> Comparison {
    let methods: Vec<Method> = answers.estimates.iter().map(|estimate| estimate.method).collect();
    if methods.len() < 2 {
        return Comparison { methods, agreement: None };
    }
    let asked: Vec<Asked<'_>> =
        methods.iter().map(|&method| Asked::MassLines(method, answers)).collect();
    let survey = Survey::of(layout, None, &asked, &mut Reduction::new(), |_, _| ());
    let mut thetas = [None; METHODS];
    for (to, estimate) in thetas.iter_mut().zip(answers.estimates) {
        *to = Some(estimate.theta());
    }
    Comparison { methods, agreement: survey.agreement(&thetas) }
}

/// The global fit from a modal answer.
fn global_fit(
    layout: &HostLayout,
    fit: &HostFit<'_>,
    readings: &FrequencyResponses<'_, f64>,
    start: Option<&RigidBody<f64>>,
) -> Result<GlobalAnswer, Diagnostics> {
    let Some(start) = start else {
        let count = fit.modes().modes.len() as f32;
        let reason = Diagnostic::whole(Code::SuspensionModesMissing, Severity::Error, count);
        return Err(Diagnostics::from_array([reason]));
    };
    GlobalAnswer::of(layout, readings, start)
}

/// Warns every other method of a flexible mode above the band, with the largest distance of its answer from the global
/// fit's, in parts of scale.
fn warn_of_flexible_mode(
    estimates: &mut [Estimate<f64>],
    global: &Estimate<f64>,
    layout: &HostLayout,
) {
    let scale = scale(global.body.mass, layout.characteristic_length());
    for estimate in estimates.iter_mut().filter(|e| e.method != Method::GlobalFit) {
        let off = (estimate.theta() - global.theta()).component_div(&scale).amax();
        let code = Code::FlexibleModeAboveBand;
        // There is room for sixteen diagnostics; any others are dropped.
        let _ = estimate.diagnostics.push(Diagnostic::whole(code, Severity::Warning, off as f32));
    }
}

/// Answers, and reasons where there is none.
pub struct Answered {
    /// The answers.
    pub answers: Vec<(Variant, Answer<f64>)>,
    /// The methods without an answer.
    pub not_applicable: Vec<(Method, Diagnostics)>,
}

/// Asks every variant. Of the two forms of the direct method, the one that fits clearly worse is refused unless it is asked
/// for by name.
pub fn answered(
    fit: &HostFit<'_>,
    variants: &[Variant],
    named: bool,
    memory: &mut Reduction<f64>,
) -> Answered {
    let mut all = Answered { answers: Vec::new(), not_applicable: Vec::new() };
    for variant in variants {
        match answer(fit, fit.layout(), variant, memory, fit.modes()) {
            Ok(answer) => all.answers.push((*variant, answer)),
            Err(reasons) => all.not_applicable.push((variant.method, reasons)),
        }
    }
    if !named {
        refuse_other_damping(&mut all);
    }
    all
}

fn refuse_other_damping(all: &mut Answered) {
    let misfit = |method: Method| {
        let found = all.answers.iter().find(|(variant, _)| variant.method == method);
        found.and_then(|(_, answer)| answer.misfit)
    };
    let pair = misfit(Method::Dppim).zip(misfit(Method::DppimStructural));
    let Some((viscous, structural)) = pair else { return };
    let (worse, code, times) = if viscous > structural * CLEARLY_WORSE {
        (Method::Dppim, Code::DampingNotViscous, viscous / structural)
    } else if structural > viscous {
        (Method::DppimStructural, Code::DampingNotStructural, structural / viscous)
    } else {
        return;
    };
    all.answers.retain(|(variant, _)| variant.method != worse);
    let reason = Diagnostic::whole(code, Severity::Error, times as f32);
    all.not_applicable.push((worse, Diagnostics::from_array([reason])));
}

fn answer(
    fit: &HostFit<'_>,
    layout: &HostLayout,
    variant: &Variant,
    memory: &Reduction<f64>,
    modes: &Modes<f64>,
) -> Result<Answer<f64>, Diagnostics> {
    let modes = variant.choice.of(modes, memory).ok_or_else(Diagnostics::new)?;
    fit.answer(variant.method, layout, memory, &modes)
}

/// A method that small changes of data and layout are put through.
#[derive(Clone, Copy)]
pub enum Asked<'a> {
    /// One that uses the suspension modes.
    Modal(Variant),
    /// The global fit.
    Global(&'a GlobalAnswer),
    /// One that uses mass lines.
    MassLines(Method, &'a MassLineAnswers<'a>),
}

/// What small changes of the data and the layout do to answers and modes.
pub struct Survey {
    propagation: Propagation<f64, METHODS>,
    modes: modes::Deviations,
}

impl Survey {
    /// A survey of nothing: no covariance is known.
    fn none() -> Self {
        Self { propagation: Propagation::empty(), modes: modes::Deviations::new() }
    }

    /// Puts the changes through these methods, at most [`METHODS`] of them. Without a modal fit, only those that use mass
    /// lines answer.
    pub fn of(
        layout: &HostLayout,
        fit: Option<&HostFit<'_>>,
        asked: &[Asked<'_>],
        memory: &mut Reduction<f64>,
        progress: impl FnMut(u32, u32),
    ) -> Self {
        let mut of_modes = modes::Deviations::new();
        let ask = |perturbation: &Perturbation<'_, f64, HOST_SENSORS, HOST_HITS>| {
            let modes = fit.and_then(|fit| fit.changed(perturbation, memory));
            if let Some(modes) = &modes {
                of_modes.add(modes, perturbation.draw.is_some());
            }
            let mut thetas = [None; METHODS];
            for (to, asked) in thetas.iter_mut().zip(asked) {
                *to = match asked {
                    Asked::Modal(variant) => fit.zip(modes.as_ref()).and_then(|(fit, modes)| {
                        let found = answer(fit, perturbation.layout, variant, memory, modes);
                        found.ok().map(|answer| answer.body.theta())
                    }),
                    Asked::Global(global) => fit.map(|fit| global.perturbed(fit, perturbation)),
                    Asked::MassLines(method, answers) => answers.perturbed(*method, perturbation),
                };
            }
            thetas
        };
        let propagation = propagate(layout, ask, progress);
        Self { propagation, modes: of_modes }
    }

    /// The answer with the covariance of the method at this place; none when the method is not stable under the noise.
    pub fn estimate(&self, place: usize, variant: &Variant, answer: &Answer<f64>) -> Estimate<f64> {
        let mut diagnostics = Diagnostics::new();
        if !answer.body.is_physically_consistent() {
            let margin = answer.body.physical_margin().unwrap_or(0.0) as f32;
            let code = Code::NotPhysicallyConsistent;
            // The list is empty.
            let _ = diagnostics.push(Diagnostic::whole(code, Severity::Warning, margin));
        }
        let stable = self.propagation.is_stable(place);
        Estimate {
            method: variant.method,
            body: answer.body,
            covariance: stable.then(|| self.propagation.covariance(place, place)),
            condition: answer.condition,
            consistency: None,
            learned: None,
            diagnostics,
        }
    }

    /// How these answers agree, by their places.
    pub fn agreement(
        &self,
        answers: &[Option<SVector<f64, 10>>; METHODS],
    ) -> Option<Agreement<f64>> {
        Agreement::of(answers, &self.propagation)
    }
}

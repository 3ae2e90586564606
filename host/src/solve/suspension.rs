//! The suspension modes of a universal file, and the methods that use them.

use massline_shared::FrequencyResponses;
use massline_shared::diagnosis::{Code, Diagnostic, Severity};
use massline_shared::identify::Method;
use massline_shared::layout::HostLayout;
use massline_shared::modes::MOST_FORCES;

use super::frfs::{LayoutResponses, LinesOfBand};
use super::suspension_lines::FEWEST_LINES;
use super::{Options, first_error, undetermined};
use crate::{Error, ErrorKind, Result};
use massline_analysis::identification::{Selection, contradicted};
use massline_analysis::modes_so_far::lacking_modes;
use massline_analysis::suspension::{
    FirstLook, MassLineAnswers, ModalSettings, ModeChoice, SuspensionModes, SuspensionSolution,
    find_modes, modes, solve,
};
use massline_analysis::where_to_hit::new_direction;
use massline_report::words::{message_in, modes_so_far};

/// The answers from the suspension modes.
pub(super) struct ModalPart {
    pub(super) solution: SuspensionSolution,
    pub(super) band_hz: [f64; 2],
    /// Warnings about modes and lines.
    pub(super) diagnostics: Vec<Diagnostic>,
}

/// The lines of the suspension band, and what a first look at them shows.
pub(super) struct Look {
    lines: LinesOfBand,
    first: FirstLook,
}

impl Look {
    /// The frequency of the highest mode that is excited well, Hz.
    pub(super) fn highest_hz(&self) -> Option<f64> {
        self.first.highest_hz
    }
}

/// What a file has of the suspension band.
pub(super) enum LookOutcome {
    /// Lines that may show the modes.
    Seen(Result<Look>),
    /// Too few of them, as files of mass lines have; what to say of it.
    TooFewLines(Error),
}

impl LookOutcome {
    /// The look, whose absence is an error.
    pub(super) fn needed(self) -> Result<Look> {
        match self {
            Self::Seen(look) => look,
            Self::TooFewLines(error) => Err(error),
        }
    }
}

/// Looks for the suspension modes, which mass lines have to keep clear of.
pub(super) fn look(
    layout: &HostLayout,
    responses: &LayoutResponses,
    options: &Options,
) -> LookOutcome {
    let band = options.suspension_band();
    let lines = match responses.spectrum_bins(layout, band, options.decay) {
        Ok(lines) => lines,
        Err(error) => return LookOutcome::Seen(Err(error)),
    };
    if lines.len() < FEWEST_LINES {
        return LookOutcome::TooFewLines(too_few(&lines, band));
    }
    let first = lines.thinned().responses().and_then(|responses| {
        find_modes(layout, &responses, lines.record_s())
            .map_err(|reasons| no_modal_answer(layout, &reasons, None))
    });
    LookOutcome::Seen(first.map(|first| Look { lines, first }))
}

fn too_few(lines: &LinesOfBand, [low, high]: [f64; 2]) -> Error {
    let text = format!(
        "the file has {} lines from {low} to {high} Hz, too few to show the suspension modes ({FEWEST_LINES} are \
         needed); export lines from below the lowest to above the highest mode (--suspension-band), or rely on mass \
         lines",
        lines.len()
    );
    Error::undetermined(Code::SuspensionModesMissing.name(), text)
}

/// Solves what a look has shown. `answers` are those of other methods to the same test.
pub(super) fn part(
    layout: &HostLayout,
    look: &Look,
    options: &Options,
    wanted: &[Method],
    answers: Option<&MassLineAnswers<'_>>,
    progress: impl FnMut(u32, u32) + Send,
) -> Result<ModalPart> {
    let too_many = layout.hits.len() > MOST_FORCES;
    if options.mode_choice == ModeChoice::BestForce && too_many {
        let text = format!(
            "--shapes best takes each shape from one hit, of at most {MOST_FORCES}; the layout has {}: choose some \
             with --hits",
            layout.hits.len()
        );
        return Err(Error::input("too_many_hits", text));
    }
    let settings = ModalSettings {
        choice: options.mode_choice,
        lines: options.lines,
        named: matches!(options.selection, Selection::Only(_)),
    };
    let chosen = look.lines.about(&look.first.modes);
    let readings = chosen.responses()?;
    let no_answer = |reasons: &[Diagnostic]| {
        no_modal_answer(layout, reasons, lacking(layout, &readings, reasons).as_deref())
    };
    let solution = solve(layout, &readings, wanted, settings, answers, progress)
        .map_err(|reasons| no_answer(&reasons))?;
    if let (true, Some((_, reasons))) =
        (solution.estimates.is_empty(), solution.not_applicable.first())
    {
        return Err(no_answer(reasons));
    }
    let mut diagnostics = solution.modes.diagnostics.clone();
    let without_priors = solution.estimates.iter().find(|e| !e.method.entry().uses_priors);
    diagnostics.extend(without_priors.iter().flat_map(|e| contradicted(&layout.priors, e)));
    diagnostics.extend(look.first.diagnostics.iter().copied());
    diagnostics.extend(gap(look));
    Ok(ModalPart { solution, band_hz: options.suspension_band(), diagnostics })
}

/// The modes without the methods that use them.
pub(super) fn modes_alone(
    layout: &HostLayout,
    responses: &LayoutResponses,
    options: &Options,
    progress: impl FnMut(u32, u32) + Send,
) -> Result<SuspensionModes> {
    let look = look(layout, responses, options).needed()?;
    let chosen = look.lines.about(&look.first.modes);
    let mut modes = modes(layout, &chosen.responses()?, progress)
        .map_err(|reasons| no_modal_answer(layout, &reasons, None))?;
    modes.diagnostics.extend(look.first.diagnostics.iter().copied());
    modes.diagnostics.extend(gap(&look));
    Ok(modes)
}

/// A warning about lines that are missing.
fn gap(look: &Look) -> Option<Diagnostic> {
    let begin = look.lines.gap()?;
    Some(Diagnostic::whole(Code::FrequencyGap, Severity::Warning, begin as f32))
}

/// Which modes a fit that has not converged lacks; `None` where the reasons are others.
pub(crate) fn lacking(
    layout: &HostLayout,
    readings: &FrequencyResponses<'_, f64>,
    reasons: &[Diagnostic],
) -> Option<String> {
    let not_converged = |reason: &Diagnostic| reason.code == Code::NotConverged;
    let lacking = reasons.iter().any(not_converged).then(|| lacking_modes(layout, readings))??;
    Some(modes_so_far::lacking(&lacking))
}

/// The errors of a method, and which hit would show what is missing; what the fit is `lacking` is said first.
pub(crate) fn no_modal_answer(
    layout: &HostLayout,
    reasons: &[Diagnostic],
    lacking: Option<&str>,
) -> Error {
    let error = first_error(reasons, |d| message_in(d, layout)).unwrap_or_else(undetermined);
    let more_hits = [
        Code::SuspensionModesMissing,
        Code::SixModesNeeded,
        Code::ResponsesDoNotSpanSix,
        Code::PropertyUndetermined,
    ];
    // Where no mode shows at all, another hit would not help.
    let nothing = |d: &Diagnostic| d.code == Code::SuspensionModesMissing && d.value == 0.0;
    let missing = reasons.iter().any(|d| more_hits.contains(&d.code) && !nothing(d));
    match (error, new_direction(layout).filter(|_| missing)) {
        (Error { kind: ErrorKind::Undetermined, code, message }, Some(dof)) => Error::undetermined(
            code,
            format!("{message}; a hit at {dof} would be a force unlike those of the hits so far"),
        ),
        (Error { kind: ErrorKind::Undetermined, code, message }, None) => {
            let lacking = lacking.map_or_else(String::new, |modes| format!("{modes}; "));
            Error::undetermined(code, lacking + &message)
        }
        (error, _) => error,
    }
}

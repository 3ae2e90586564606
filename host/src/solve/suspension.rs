//! The suspension modes of a universal file, and the methods that use them.

use massline_shared::diagnosis::{Code, Diagnostic, Severity};
use massline_shared::identify::{Method, toivola_nuutila};
use massline_shared::layout::HostLayout;

use super::frfs::{LayoutResponses, LinesOfBand};
use super::suspension_lines::FEWEST_LINES;
use super::{Options, first_error, undetermined};
use crate::identification::Selection;
use crate::report::message_in;
use crate::suspension::{
    MassLineAnswers, ModalSettings, SuspensionModes, SuspensionSolution, find_modes, modes, solve,
};
use crate::{Error, Result};

/// The answers from the suspension modes.
pub(super) struct ModalPart {
    pub(super) solution: SuspensionSolution,
    pub(super) band_hz: [f64; 2],
    /// Warnings about modes and lines.
    pub(super) diagnostics: Vec<Diagnostic>,
}

/// The lines of the suspension band, and the modes that a first look shows.
pub(super) struct Look {
    all: LinesOfBand,
    /// Frequencies, Hz, and damping ratios.
    modes: Vec<(f64, f64)>,
}

impl Look {
    /// The frequency of the highest mode, Hz, when at least five show.
    pub(super) fn highest_hz(&self) -> Option<f64> {
        let enough = self.modes.len() >= toivola_nuutila::FEWEST_MODES;
        self.modes.last().map(|(frequency, _)| *frequency).filter(|_| enough)
    }
}

/// Looks for the suspension modes; `None` when no method that uses them is wanted, or when the file has no lines for them
/// and none was asked for by name.
pub(super) fn look(
    layout: &HostLayout,
    responses: &LayoutResponses,
    options: &Options,
    wanted: &[Method],
) -> Option<Result<Look>> {
    if wanted.is_empty() {
        return None;
    }
    let named = matches!(options.selection, Selection::Only(_));
    let band = options.suspension_band_hz;
    let all = match responses.spectrum_bins(layout, band, options.decay) {
        Ok(lines) => lines,
        Err(error) => return Some(Err(error)),
    };
    if all.len() < FEWEST_LINES {
        let [low, high] = band;
        let text = format!(
            "the file has {} lines from {low} to {high} Hz, too few to show the suspension modes; export lines from \
             below the lowest to above the highest mode (--suspension-band), or rely on mass lines",
            all.len()
        );
        let error = Error::undetermined(Code::SuspensionModesMissing.name(), text);
        return named.then_some(Err(error));
    }
    let modes = all.thinned().responses().and_then(|responses| {
        find_modes(layout, &responses, all.record_s()).map_err(|found| said(layout, &found))
    });
    Some(modes.map(|modes| Look { all, modes }))
}

/// Solves what a look has shown. `answers` are those of other methods to the same test.
pub(super) fn part(
    layout: &HostLayout,
    look: &Look,
    options: &Options,
    wanted: &[Method],
    answers: Option<&MassLineAnswers<'_>>,
    progress: impl FnMut(u32, u32),
) -> Result<ModalPart> {
    let settings = ModalSettings {
        choice: options.mode_choice,
        lines: options.lines,
        named: matches!(options.selection, Selection::Only(_)),
    };
    let chosen = look.all.about(&look.modes);
    let solution = solve(layout, &chosen.responses()?, wanted, settings, answers, progress)
        .map_err(|found| said(layout, &found))?;
    if let (true, Some((_, reasons))) =
        (solution.estimates.is_empty(), solution.not_applicable.first())
    {
        return Err(said(layout, reasons));
    }
    let mut diagnostics = solution.modes.diagnostics.clone();
    diagnostics.extend(gap(look));
    Ok(ModalPart { solution, band_hz: options.suspension_band_hz, diagnostics })
}

/// The modes without the methods that use them.
pub(super) fn modes_alone(
    layout: &HostLayout,
    responses: &LayoutResponses,
    options: &Options,
    progress: impl FnMut(u32, u32),
) -> Result<SuspensionModes> {
    let named = Options { selection: Selection::Only(Method::ToivolaNuutila), ..*options };
    let look = look(layout, responses, &named, &[Method::ToivolaNuutila]);
    let look = look.unwrap_or_else(|| Err(undetermined()))?;
    let chosen = look.all.about(&look.modes);
    let mut modes =
        modes(layout, &chosen.responses()?, progress).map_err(|found| said(layout, &found))?;
    modes.diagnostics.extend(gap(&look));
    Ok(modes)
}

/// A warning about lines that are missing.
fn gap(look: &Look) -> Option<Diagnostic> {
    let begin = look.all.gap()?;
    Some(Diagnostic::whole(Code::FrequencyGap, Severity::Warning, begin as f32))
}

fn said(layout: &HostLayout, found: &[Diagnostic]) -> Error {
    first_error(found, |d| message_in(d, layout)).unwrap_or_else(undetermined)
}

//! Results and diagnostics as the commands print them.

use std::path::{Path, PathBuf};

use massline_protocol::message::Status;
use massline_protocol::object::MeasurementResult;
use massline_result::TestResult;
use massline_shared::diagnosis::{Diagnostic, Severity};
use serde_json::json;

use crate::output::{Output, Tone, shell_path, this_command_with};
use crate::rig_solution::nothing_measured;
pub(crate) use crate::solve::first_error;
use crate::{Error, Result};
use massline_files::embedded;
use massline_report::solution::Solution;
use massline_report::words::{self, Extent, corrected_text, result_text, sentences};

/// The option for how much of a result is printed.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct DetailsArgs {
    /// Print everything: all methods and how they agree, the corrections that the fit made, what each hit and sensor
    /// weighs, the settings, and what the test cannot see.
    #[arg(long)]
    details: bool,
}

impl DetailsArgs {
    /// How much is printed.
    pub fn extent(self) -> Extent {
        if self.details { Extent::Details } else { Extent::Brief }
    }
}

/// The next step that a person would take.
#[derive(Clone, Debug)]
pub enum NextStep<'a> {
    /// To see the rest of the result.
    Details,
    /// To make a page of an archive.
    Page(&'a Path),
    /// Another one, in a sentence.
    Other(String),
}

impl NextStep<'_> {
    /// The step as a command that works as it is printed; empty without one.
    pub fn text(&self, extent: Extent) -> String {
        match self {
            Self::Other(text) => text.clone(),
            Self::Page(archive) if !page_of(archive).exists() => {
                format!(
                    "next: `massline report {}` makes a page with pictures",
                    shell_path(archive)
                )
            }
            _ if extent == Extent::Details => String::new(),
            _ => format!("next: `{}` shows all that was found", this_command_with("--details")),
        }
    }
}

/// Prints the result of a solution, and `next`, the next step that a person would take.
///
/// # Errors
/// Exit 3 when the solution has no answer, with the mistakes that may have prevented it.
pub fn print(
    solution: &Solution,
    result: &TestResult,
    (extent, next): (Extent, &NextStep<'_>),
    output: &mut Output,
) -> Result<()> {
    if let Some(error) = &solution.no_answer {
        explain(result, output);
        return Err(error.clone());
    }
    print_result(result, (extent, next), output)
}

/// The same of a result that has an answer.
///
/// # Errors
/// When stdout cannot be written.
pub fn print_result(
    result: &TestResult,
    (extent, next): (Extent, &NextStep<'_>),
    output: &mut Output,
) -> Result<()> {
    output.answer(result, |_| {
        (result_text(result, extent) + &next.text(extent)).trim_end().to_owned()
    })
}

/// Adds to the error that follows what was found of the data, above all a single mistake that may have prevented an
/// answer.
fn explain(result: &TestResult, output: &mut Output) {
    output.explain(&json!({
        "single_faults": result.single_faults,
        "diagnostics": result.diagnostics,
        "not_applicable": result.not_applicable,
        "modes_after_each_dof": result.modes_after_each_dof,
    }));
    if !output.json() {
        let text = sentences(&result.diagnostics)
            + &result.notes.iter().map(|note| format!("note: {note}\n")).collect::<String>()
            + &result
                .single_faults
                .as_ref()
                .map_or_else(String::new, |faults| corrected_text(faults, 1));
        if !text.is_empty() {
            output.note(text.trim_end());
        }
    }
}

/// Returns an error with the reasons when a result has no answer.
///
/// # Errors
/// Exit 3 when the result has no answer by a method that this program knows.
pub fn require_answer(result: &MeasurementResult) -> Result<()> {
    let (known, unknown) = result.estimates();
    if !known.is_empty() {
        return Ok(());
    }
    if let Some(number) = unknown.first() {
        return Err(Error::undetermined(
            "unknown_method",
            format!(
                "result {} has an answer by method {number} alone, which this program does not know; update it",
                result.head.number,
            ),
        ));
    }
    if !result.lines.is_empty() {
        let text = format!(
            "result {number} has the lines of {} DOFs, and the rig has no longer their layout: `massline results get \
             {number} --layout FILE` solves them with the layout of the test, and --output keeps both",
            result.lines.len(),
            number = result.head.number,
        );
        return Err(Error::undetermined("no_answer", text));
    }
    if result.dofs.is_empty() {
        return Err(nothing_measured(result));
    }
    Err(first_error(&result.diagnostics, words::message).unwrap_or_else(|| {
        Error::undetermined(
            "no_answer",
            format!(
                "result {} has mass lines of {} DOFs and no ten properties; three independent hits are needed",
                result.head.number,
                result.dofs.len(),
            ),
        )
    }))
}

/// The error for a campaign that the rig interrupted by itself.
pub fn stopped(status: &Status) -> Error {
    let reasons: Vec<_> =
        status.diagnostics.iter().filter(|d| d.interrupts()).map(words::message).collect();
    let code = status.diagnostics.iter().find(|d| d.interrupts()).map(|d| d.code);
    Error::device(
        code.map_or("campaign_stopped", |code| code.name()),
        format!(
            "the rig has interrupted the campaign: {}; accepted hits stay stored",
            reasons.join("; ")
        ),
    )
}

/// Prints every diagnostic on stderr, as the sentence that `message_of` returns.
pub fn list(
    diagnostics: &[Diagnostic],
    message_of: impl Fn(&Diagnostic) -> String,
    output: &mut Output,
) {
    for d in diagnostics {
        let tone = match d.severity {
            Severity::Note => Tone::Strong,
            Severity::Warning => Tone::Warning,
            Severity::Error => Tone::Bad,
        };
        let head = output.toned(&format!("{}:", d.severity.name()), tone);
        output.note(format!("{head} {}", message_of(d)));
    }
}

/// Prints every diagnostic that is more than a note on stderr.
pub fn warn(
    diagnostics: &[Diagnostic],
    message_of: impl Fn(&Diagnostic) -> String,
    output: &mut Output,
) {
    let grave: Vec<_> =
        diagnostics.iter().filter(|d| d.severity > Severity::Note).copied().collect();
    list(&grave, message_of, output);
}

/// The page of an archive that is given no other name.
fn page_of(archive: &Path) -> PathBuf {
    page_called(&embedded::stem(archive))
}

/// The page of a result with this name.
pub fn page_called(stem: &str) -> PathBuf {
    format!("{stem}.html").into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use massline_shared::diagnosis::Code;

    #[test]
    fn collinear_sensors_cannot_determine_the_answer_and_an_unknown_node_is_bad_input() {
        let exit = |code| {
            let diagnostics = [Diagnostic::whole(code, Severity::Error, 0.0)];
            first_error(&diagnostics, words::message).unwrap().exit_code()
        };
        assert_eq!(exit(Code::SensorsCollinear), 3);
        assert_eq!(exit(Code::UnknownNode), 2);
    }

    #[test]
    fn warnings_are_no_error() {
        let diagnostics = [Diagnostic::whole(Code::IllConditioned, Severity::Warning, 1e4)];
        assert_eq!(first_error(&diagnostics, words::message), None);
    }
}

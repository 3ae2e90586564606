//! Results and diagnostics as the commands print them.

use massline_protocol::message::Status;
use massline_protocol::object::MeasurementResult;
use massline_shared::diagnosis::{Diagnostic, Severity};
use massline_shared::layout::TestProfile;
use serde_json::json;

use crate::document::Measurement;
use crate::error::{Error, Result};
use crate::host_solution::HostSolution;
use crate::identification::Selection;
use crate::judgement::{state_verdict_of_rig, verdict_on_rig};
use crate::output::{Output, Tone};
use crate::report::{self, SolvedHere};
use crate::rig_lines::StoredTest;
use crate::single_fault::NominalTest;
pub(crate) use crate::solve::first_error;

/// A result as it is printed.
pub struct Shown {
    /// The document for `--json`.
    pub value: Measurement,
    /// The first line, which states the verdict; empty without an answer.
    verdict_line: String,
    text: String,
}

impl Shown {
    /// A rig's result as it is stored.
    fn of_rig(result: &MeasurementResult, here: &SolvedHere) -> Self {
        let mut value = report::measurement_json(result);
        state_verdict_of_rig(&mut value, result);
        Self {
            value,
            verdict_line: verdict_on_rig(result).map_or(String::new(), |(_, line)| line),
            text: report::measurement_text(result, here),
        }
    }

    /// The same with what the host has found.
    fn with_host(result: &MeasurementResult, again: &HostSolution<'_>) -> Self {
        let mut shown = Self::of_rig(result, &again.here());
        shown.add(again);
        shown
    }

    /// Adds what the host has found.
    fn add(&mut self, again: &HostSolution<'_>) {
        again.add_to(&mut self.value);
        self.verdict_line = again.verdict().map_or(String::new(), |(_, line)| line);
        let unseen = again.cannot_see();
        self.text += &format!("\n{}{}", again.to_text(), report::cannot_see_text(&unseen));
        self.value.cannot_see = Some(unseen);
    }

    /// Prints the document, or the text.
    ///
    /// # Errors
    /// When stdout cannot be written.
    pub fn print(self, output: &mut Output) -> Result<()> {
        output.answer(&self.value, |output| match self.value.verdict {
            Some(verdict) => {
                format!("{}\n{}", output.verdict_line(verdict, &self.verdict_line), self.text)
            }
            None => self.text,
        })
    }
}

/// A rig's result as the rig stored it. With the nominal test it is solved again in double precision, and the answer is that
/// of the host.
///
/// # Errors
/// Exit 3 when the result has no answer by the selected methods.
pub fn document(
    test: StoredTest<'_>,
    nominal: Option<&NominalTest>,
    selection: Selection,
    output: &mut Output,
) -> Result<Shown> {
    if let (TestProfile::Suspension, Some(nominal)) = (test.profile(), nominal) {
        return of_lines(test, nominal, selection, output);
    }
    let result = selected(test.result, selection);
    if let Err(error) = require_answer(&result) {
        if let Some(nominal) = nominal {
            look_for_mistakes(&result, nominal, output);
        }
        return Err(error);
    }
    let Some(nominal) = nominal else {
        return Ok(Shown::of_rig(&result, &SolvedHere::default()));
    };
    let of_rig = StoredTest { result: &result, ..test };
    Ok(Shown::with_host(&result, &HostSolution::new(of_rig, nominal, selection)))
}

/// The same of a test whose lines are solved here; a rig answers by some of the methods, or by none.
fn of_lines(
    test: StoredTest<'_>,
    nominal: &NominalTest,
    selection: Selection,
    output: &mut Output,
) -> Result<Shown> {
    let result = selected(test.result, selection);
    let of_rig = StoredTest { result: &result, ..test };
    let again = HostSolution::new(of_rig, nominal, selection);
    if result.estimates.is_empty() {
        again.error().map_or(Ok(()), Err)?;
    } else if let Some(error) = again.error() {
        output.warn(error.to_string());
    }
    Ok(Shown::with_host(&result, &again))
}

/// Prints a result that the host solves again, perhaps with a layout that was corrected after the test. The answer is the
/// host's, and that of the rig, which knows the layout of the measurement only, is compared with it in a line.
///
/// # Errors
/// Exit 3 when the host has no answer by the selected methods.
pub fn solved_again(
    test: StoredTest<'_>,
    nominal: &NominalTest,
    selection: Selection,
    output: &mut Output,
) -> Result<()> {
    let result = selected(test.result, selection);
    let of_rig = StoredTest { result: &result, ..test };
    let again = HostSolution::new(of_rig, nominal, selection);
    if let Some(error) = again.error() {
        if test.profile() == TestProfile::MassLine {
            look_for_mistakes(&result, nominal, output);
        }
        return Err(error);
    }
    let mut shown = Shown::with_host(&result, &again);
    shown.value.results = again.identification.results_json();
    output.conclude(shown.value.verdict);
    shown.print(output)
}

/// Adds to the error that follows which single mistake may have prevented an answer.
pub fn look_for_mistakes(result: &MeasurementResult, nominal: &NominalTest, output: &mut Output) {
    let examination = nominal.examine_result(result);
    let mut details = json!({});
    examination.add_to(&mut details, &nominal.layout);
    output.explain(&details);
    if !output.json() {
        output.note(examination.to_text(&nominal.layout).trim_end());
    }
}

/// The result reduced to the answers of the selected methods.
fn selected(result: &MeasurementResult, selection: Selection) -> MeasurementResult {
    let mut result = result.clone();
    if let Selection::Only(method) = selection {
        result.estimates.retain(|estimate| estimate.method == method.number());
    }
    result
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
            "result {number} has the lines of {} DOFs, and the rig has no longer their layout: `massline results get {number} \
             --layout FILE` solves them with the layout of the test, and --output keeps both",
            result.lines.len(),
            number = result.head.number,
        );
        return Err(Error::undetermined("no_answer", text));
    }
    if result.dofs.is_empty() {
        let text = format!("result {} has no hits: every DOF was skipped", result.head.number);
        return Err(Error::undetermined("nothing_measured", text));
    }
    Err(first_error(&result.diagnostics, report::message).unwrap_or_else(|| {
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
        status.diagnostics.iter().filter(|d| d.interrupts()).map(report::message).collect();
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
pub fn list(found: &[Diagnostic], message_of: impl Fn(&Diagnostic) -> String, output: &mut Output) {
    for d in found {
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
pub fn warn(found: &[Diagnostic], message_of: impl Fn(&Diagnostic) -> String, output: &mut Output) {
    let grave: Vec<_> = found.iter().filter(|d| d.severity > Severity::Note).copied().collect();
    list(&grave, message_of, output);
}

#[cfg(test)]
mod tests {
    use super::*;
    use massline_shared::diagnosis::Code;

    #[test]
    fn collinear_sensors_cannot_determine_the_answer_and_an_unknown_node_is_bad_input() {
        let exit = |code| {
            let found = [Diagnostic::whole(code, Severity::Error, 0.0)];
            first_error(&found, report::message).unwrap().exit_code()
        };
        assert_eq!(exit(Code::SensorsCollinear), 3);
        assert_eq!(exit(Code::UnknownNode), 2);
    }

    #[test]
    fn warnings_are_no_error() {
        let found = [Diagnostic::whole(Code::IllConditioned, Severity::Warning, 1e4)];
        assert_eq!(first_error(&found, report::message), None);
    }
}

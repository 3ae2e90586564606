//! The verdict on a result as a rig stored it, where the program does not know its layout.

use massline_protocol::object::MeasurementResult;
use massline_shared::diagnosis::Diagnostic;
use massline_shared::identify::Method;
use massline_shared::layout::{HostLayout, TestProfile};

use super::{Evidence, Judgement, verdict_line, verdict_reasons};
use crate::document::Measurement;
use crate::report::{estimates_of, message_of_result};
use crate::verdict::Verdict;

/// The verdict on a result as the rig stored it; `None` without an answer.
fn judgement_of(result: &MeasurementResult) -> Option<Judgement> {
    let estimates = estimates_of(result);
    let missing = Method::of_mass_lines()
        .filter(|method| !estimates.iter().any(|estimate| estimate.method == *method));
    // A rig does not store to which method of mass lines a reason belongs.
    let reasons = |method| result.diagnostics.iter().map(move |reason| (method, *reason));
    let of_mass_lines = missing.flat_map(reasons);
    let of_modes = result
        .refusals
        .iter()
        .filter_map(|refusal| Some((Method::from_number(refusal.method)?, refusal.reason.into())));
    let refusals: Vec<_> = match result.profile() {
        TestProfile::MassLine => of_mass_lines.collect(),
        TestProfile::Suspension => of_modes.collect(),
    };
    let diagnostics = result.diagnostics.to_vec();
    Some(Evidence { refusals, diagnostics, ..Evidence::of(estimates.first()?) }.judge())
}

/// The verdict on a result as the rig stored it, and the first line of the text that states it.
pub fn verdict_on_rig(result: &MeasurementResult) -> Option<(Verdict, String)> {
    let judgement = judgement_of(result)?;
    let message_of = |diagnostic: &Diagnostic| message_of_result(diagnostic, result);
    Some((judgement.verdict(), verdict_line(&judgement, &HostLayout::default(), message_of)))
}

/// States the verdict in the document of a result as the rig stored it.
pub fn state_verdict_of_rig(document: &mut Measurement, result: &MeasurementResult) {
    let Some(judgement) = judgement_of(result) else { return };
    let message_of = |diagnostic: &Diagnostic| message_of_result(diagnostic, result);
    document.verdict = Some(judgement.verdict());
    document.verdict_reasons = verdict_reasons(&judgement, &HostLayout::default(), message_of);
}

//! A result as text: in brief what a person wants to know, and all the rest where it is asked for.

use massline_result::{
    ErrorSource, Estimate, FaultOutcome, Finding, FindingCode, RigAnswer, SingleFaults, SolvedBy,
    Suspect, TestResult, Verdict, VerdictReason,
};
use massline_shared::body::{INERTIAL_PARAMETERS, InertialParameter};
use massline_shared::diagnosis::Code;
use massline_shared::layout::TestProfile;

use super::modes::shows_flexible_mode;
use super::table::{principal_text, scale_text, table};
use super::{
    INERTIA_CONVENTION, agreement_text, as_exact_as, budget_text, cannot_see_text, details_text,
    global_fit_text, line_of, modes_text, refusals_text, score_tests_text, two_digits,
    with_half_width,
};
use crate::tone::Tone;
use crate::words::counted;

/// Most warnings that a brief text has.
const MOST_WARNINGS: usize = 3;

/// How much of a result is told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Extent {
    /// At most forty lines.
    #[default]
    Brief,
    /// Everything.
    Details,
}

/// The verdict on a result; what it is of, in a second line.
pub fn heading_text(result: &TestResult) -> String {
    verdict_text(result) + &title_text(result)
}

/// A result as text, its verdict first.
pub fn result_text(result: &TestResult, extent: Extent) -> String {
    let mut text = heading_text(result);
    if let Some(answer) = result.answer() {
        text += &answer_text(result, answer);
    }
    text += &limits_text(result);
    text += &result.rig.as_ref().map_or_else(String::new, rig_text);
    text += &warnings_text(result, extent);
    if let Some(faults) = &result.single_faults {
        text += &match (extent, result.verdict) {
            (Extent::Details, _) => corrected_text(faults, usize::MAX),
            (Extent::Brief, Some(Verdict::DoNotUse)) => corrected_text(faults, 1),
            (Extent::Brief, _) => String::new(),
        };
    }
    if extent == Extent::Details {
        text += &rest_text(result);
    }
    text
}

/// The verdict on an answer with how many reasons it has, and the gravest of them.
pub fn headline(verdict: Verdict, reasons: &[VerdictReason]) -> String {
    let head = match verdict {
        Verdict::Good => return "Good: nothing puts this answer in doubt".into(),
        Verdict::UseWithCare => "Use with care",
        Verdict::DoNotUse => "Do not use this answer",
    };
    match reasons {
        [] => head.into(),
        [one] => format!("{head}: {}", reason_text(one)),
        [first, ..] => format!("{head}, for {} reasons: {}", reasons.len(), reason_text(first)),
    }
}

/// A reason of a verdict, with how many more there are like it.
pub fn reason_text(reason: &VerdictReason) -> String {
    match reason.alike {
        0 => reason.message.clone(),
        more => format!("{} ({more} more like this)", reason.message),
    }
}

/// The same as text; empty without an answer.
fn verdict_text(result: &TestResult) -> String {
    let Some(verdict) = result.verdict else { return String::new() };
    Tone::from(verdict).mark(headline(verdict, &result.verdict_reasons)) + "\n"
}

/// Title, method, and what was measured.
fn title_text(result: &TestResult) -> String {
    let title = match (result.title.as_str(), result.number) {
        ("", Some(number)) => format!("result {number}"),
        ("", None) => "result".into(),
        (title, _) => title.to_owned(),
    };
    let mut parts = Vec::new();
    parts.extend(result.answer().map(|answer| answer.method.to_string()));
    let dofs = result.measured_dofs();
    let of_modes = result.suspension.as_ref().and_then(|modes| modes.modes.first());
    if let (true, Some(mode)) = (dofs.is_empty(), of_modes) {
        parts.push(counted(mode.norm_indicators.len(), "DOF"));
    }
    if !dofs.is_empty() {
        let hits: Option<u32> = dofs.iter().map(|dof| dof.hits.map(u32::from)).sum();
        let hits = hits.map(|hits| format!(", {}", counted(hits, "hit")));
        parts.push(counted(dofs.len(), "DOF") + &hits.unwrap_or_default());
    }
    let minutes = result.measured.as_ref().and_then(|time| time.get(..16));
    parts.extend(minutes.map(|time| time.replace('T', " ") + " UTC"));
    if result.solved_by == SolvedBy::Rig {
        parts.push("solved by the rig: its layout is not known here".into());
    }
    format!("{}\n", Tone::Strong.mark(title) + ": " + &parts.join(", "))
}

/// The ten properties, the conventions, and the principal moments.
fn answer_text(result: &TestResult, answer: &Estimate) -> String {
    let expected = result.expected();
    let length = result.characteristic_length_m;
    let mut text = format!("{}\n{INERTIA_CONVENTION}\n", table(answer, &expected, length));
    text +=
        &length.map_or_else(String::new, |length| scale_text(length, expected[0].is_some()) + "\n");
    text += &principal_text(answer);
    if answer.covers_scatter_only() {
        text += "± is not known from these data: the scatter between hits covers the truth in 64 of 100 tests only\n";
    }
    text
}

/// Most sources of error that a brief text names.
const MOST_SOURCES: usize = 3;

/// The smallest share that is told.
const LEAST_SHARE: f64 = 0.005;

/// What the uncertainty of the answer comes from; empty where that is not known.
pub fn limits_text(result: &TestResult) -> String {
    if result.answer().is_none_or(|answer| answer.complete_sigma().is_none()) {
        return String::new();
    }
    let is_told = |error_source: &&ErrorSource| error_source.share >= LEAST_SHARE;
    let mut sources: Vec<_> = result.error_sources.iter().filter(is_told).collect();
    sources.sort_by(|a, b| b.share.total_cmp(&a.share));
    let source = |error_source: &&ErrorSource| {
        format!("{} {:.0} %", source_words(&error_source.source), 100.0 * error_source.share)
    };
    match sources.as_slice() {
        [] => hammer_limit(result)
            .map_or_else(String::new, |message| format!("what limits it: {message}\n")),
        sources => {
            let named: Vec<_> = sources.iter().take(MOST_SOURCES).map(source).collect();
            format!("what limits it: {}\n", named.join(", "))
        }
    }
}

/// What the hammer's gain alone accounts for, where that is most.
pub fn hammer_limit(result: &TestResult) -> Option<&str> {
    let is_of_hammer = |finding: &&Finding| finding.code == FindingCode::HammerGainLimits;
    result.diagnostics.iter().find(is_of_hammer).map(|finding| finding.message.as_str())
}

/// A source of error in words, by its name.
pub fn source_words(name: &str) -> String {
    match name {
        "gain" => "sensor gain".into(),
        other => other.replace('_', " "),
    }
}

/// The rig's answer beside that of the program.
fn rig_text(rig: &RigAnswer) -> String {
    let far = match rig.difference_sigma {
        Some(sigma) => format!("{:.2} sd", sigma.abs().max(0.01)),
        None => {
            format!(
                "{} % of scale",
                two_digits(rig.difference_percent_of_scale.unwrap_or(f64::NAN).abs().max(0.001))
            )
        }
    };
    if rig.agrees {
        return format!("rig: agrees within {far} ({})\n", rig.method);
    }
    format!(
        "rig: its {} differs by {far} ({}); it solves in single precision, with the layout that it was sent\n",
        rig.property, rig.method
    )
}

/// The reasons of the verdict but the gravest, which the first line has said; in brief only some of them.
fn warnings_text(result: &TestResult, extent: Extent) -> String {
    let most = match extent {
        Extent::Brief => MOST_WARNINGS,
        Extent::Details => usize::MAX,
    };
    let mut text = String::new();
    let reasons = result.verdict_reasons.iter().skip(1);
    for reason in reasons.clone().take(most) {
        text += &format!("{} {}\n", Tone::Warning.mark("warning:"), reason_text(reason));
    }
    let more = reasons.len().saturating_sub(most);
    if more > 0 {
        text += &format!("and {}: --details has all\n", counted(more, "more warning"));
    }
    text
}

/// What the ten properties would be without each of the mistakes that explain the data, of which at most so many are
/// told; empty without such a mistake.
pub fn corrected_text(faults: &SingleFaults, most: usize) -> String {
    let count = faults.suspects.len();
    let first =
        if most < count { format!("; the first of {count} mistakes") } else { String::new() };
    let suspects = faults.suspects.iter().take(most);
    suspects.filter_map(|suspect| {
        let corrected = suspect.corrected.as_ref()?;
        let condition = suspected_text(suspect);
        Some(format!(
            "if {condition}, the ten properties would be (not the answer of this test; ± 95 %{first}):\n{}",
            corrected_lines(corrected)
        ))
    })
    .collect()
}

/// What a correction takes for true, as a clause.
pub fn suspected_text(suspect: &Suspect) -> &str {
    // Of what can be wrong, the correction leaves [prior] right.
    match suspect.fault.code == Code::CommonScale {
        true => "[prior] is right, and the hammer or the sensors are wrong",
        false => &suspect.fault.message,
    }
}

fn corrected_lines(corrected: &Estimate) -> String {
    let (theta, half) = (corrected.theta(), corrected.half_widths());
    let line = |(k, parameter): (usize, &InertialParameter)| {
        let factor = parameter.table_factor;
        let number = match half {
            Some(half) => with_half_width(theta[k] * factor, half[k] * factor),
            None => as_exact_as(theta[k] * factor, None),
        };
        format!("  {:<5}{number} {}\n", parameter.symbol, parameter.table_unit)
    };
    INERTIAL_PARAMETERS.iter().enumerate().map(line).collect()
}

/// Everything else.
fn rest_text(result: &TestResult) -> String {
    let mut text = String::from("\n");
    text += &agreement_text(result);
    text += &refusals_text(&result.not_applicable);
    if let Some(modes) = &result.suspension {
        text += &modes_text(modes, shows_flexible_mode(&result.diagnostics));
    }
    text += &result.global_fit.as_ref().map_or_else(String::new, global_fit_text);
    if let Some(details) = &result.details {
        let learned = result.results.iter().find_map(|estimate| estimate.learned_budget.as_ref());
        if let (Some(budget), Some(learned)) = (&details.error_budget, learned) {
            text += &budget_text(budget, learned);
        }
        text += &details_text(details);
    }
    text += &result.single_faults.as_ref().map_or_else(String::new, faults_text);
    text += &score_tests_text(&result.score_tests);
    text += &settings_text(result);
    let is_reason =
        |finding: &Finding| result.verdict_reasons.iter().any(|reason| reason.says(finding));
    let limits = hammer_limit(result).filter(|_| result.error_sources.is_empty());
    let is_left =
        |finding: &&Finding| !is_reason(finding) && Some(finding.message.as_str()) != limits;
    text.extend(result.findings().into_iter().filter(is_left).map(line_of));
    for other in result.results.iter().skip(1) {
        for finding in &other.diagnostics {
            text += &format!("{} about {}: {}\n", finding.severity, other.method, finding.message);
        }
    }
    for note in &result.notes {
        text += &format!("note: {note}\n");
    }
    text + &cannot_see_text(&result.cannot_see)
}

/// What the search for single mistakes has found, where that is nothing.
fn faults_text(faults: &SingleFaults) -> String {
    match (faults.outcome, faults.chi_squared, faults.degrees_of_freedom) {
        (FaultOutcome::NothingSuspicious, Some(chi_squared), Some(degrees_of_freedom)) => {
            format!(
                "single mistakes: nothing suspicious (χ² {chi_squared:.1} of {degrees_of_freedom})\n"
            )
        }
        _ => String::new(),
    }
}

/// What the answer was found from.
fn settings_text(result: &TestResult) -> String {
    let mut parts = Vec::new();
    let of_modes = result.profile.is_some_and(|profile| profile == TestProfile::Suspension);
    if let Some(terms) = result.terms.filter(|_| !result.mass_lines.is_empty()) {
        parts.push(format!("mass lines ({terms}){}", bands_text(result)));
    } else if of_modes {
        parts.push(format!("frequency responses{}", bands_text(result)));
    }
    parts.extend(result.frf_estimator.map(|estimator| format!("estimator {estimator}")));
    parts.extend(
        result.reference_point.as_ref().map(|point| format!("linear equations about the {point}")),
    );
    let condition = result.answer().and_then(|answer| answer.condition);
    parts.extend(condition.map(|condition| format!("condition {condition:.3}")));
    parts.extend(result.layout_hash.as_ref().map(|hash| format!("layout {hash}")));
    parts.extend(result.calibration.as_ref().map(|checksum| format!("calibration {checksum}")));
    parts.extend(result.firmware.as_ref().map(|version| format!("firmware {version}")));
    if parts.is_empty() { String::new() } else { parts.join(", ") + "\n" }
}

/// The band, or the bands of the DOFs.
fn bands_text(result: &TestResult) -> String {
    let ends = |[low, high]: [f64; 2]| format!("{low:.1} to {high:.1} Hz");
    let origin = if result.band_automatic { ", found from the data" } else { "" };
    let dofs = result.measured_dofs();
    let bands: Vec<_> = dofs.iter().filter_map(|dof| Some((&dof.dof, dof.band_hz?))).collect();
    match (result.band_hz, bands.first()) {
        (Some(band), _) => format!(" over {}{origin}", ends(band)),
        (None, Some((_, band))) if bands.iter().all(|(_, other)| other == band) => {
            format!(" over {}{origin}", ends(*band))
        }
        (None, Some(_)) => {
            let each = bands.iter().map(|(dof, band)| format!("{dof} {}", ends(*band)));
            format!(" over {}{origin}", each.collect::<Vec<_>>().join("; "))
        }
        (None, None) => String::new(),
    }
}

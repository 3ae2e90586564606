//! Results as text, diagnostics as sentences: what the solvers have found becomes part of a
//! [`TestResult`](massline_result::TestResult) here, and a result becomes text.

mod budget;
mod cannot_see;
mod comparison;
mod details;
mod digits;
mod estimate;
mod global_fit;
mod hammer;
mod hit;
mod identification;
pub mod layout_check;
mod masses;
mod meaning;
mod measurement;
mod message;
mod modes;
pub mod modes_so_far;
pub mod monte_carlo;
mod of_rig;
pub mod precision;
mod refusals;
mod result;
mod score_tests;
mod single_fault;
mod summary;
mod suspects;
mod table;
mod verdict;
mod where_to_hit;

use std::fmt::Display;

use massline_shared::diagnosis::Diagnostic;

use massline_result::Finding;

pub use budget::{budget_text, error_budget};
pub use cannot_see::{cannot_see, cannot_see_text, glued, has_undeclared_mass};
pub use comparison::{agreement, agreement_text};
pub use details::{details_text, fit_details};
pub use digits::{
    as_exact_as, deviation, in_interval, known, two_digits, with_half_width, with_interval,
    with_sigma,
};
pub use estimate::estimate_of;
pub use global_fit::{global_fit, global_fit_text};
pub use hammer::{calibrate_hammer, hammer_text};
pub use hit::{HitAssessment, swing_words};
pub use identification::{details_in, estimates_in, refusals_in};
pub use masses::{mass_warning, masses_text};
pub use measurement::{answered_by_rig, estimates_of, measured};
pub use message::{
    by_code, channel_name, code_name, message, message_in, message_of_result, messages,
};
pub use modes::{
    assurance_text, better_hits_text, indicators_text, modes_text, orders_text, shapes_text,
    shows_flexible_mode, suspension_mode, suspension_modes,
};
pub use of_rig::result_of_rig;
pub use refusals::{refusals, refusals_text};
pub use result::{
    Extent, corrected_text, hammer_limit, heading_text, headline, limits_text, reason_text,
    result_text, source_words, suspected_text,
};
pub use score_tests::{BEGINS_TO_SHOW, fault_name, in_unit, score_tests_in, score_tests_text};
pub use single_fault::{findings_in, single_faults_in};
pub use summary::{ResultVerdict, Summary};
pub use table::{INERTIA_CONVENTION, error_percent, scale_of, scale_text, table};
pub use verdict::{UNCERTAINTY_UNKNOWN, verdict_reasons};
pub use where_to_hit::{hardly_shown, not_shown};

/// The text of a layout's hash or a calibration's checksum; `None` for 0, which means that there is none.
pub fn hash_text(hash: u32) -> Option<String> {
    (hash != 0).then(|| format!("{hash:08x}"))
}

/// Diagnostics as findings of a result; `message_of` makes their sentences.
pub fn findings(
    diagnostics: &[Diagnostic],
    message_of: impl Fn(&Diagnostic) -> String,
) -> Vec<Finding> {
    let entry = |d: &Diagnostic| Finding {
        code: d.code.into(),
        severity: d.severity.into(),
        message: message_of(d),
    };
    diagnostics.iter().map(entry).collect()
}

/// Most findings with one code that are printed.
const MOST_ALIKE: usize = 4;

/// Findings as lines of text. Of many with the same code only the first are printed.
pub fn sentences<'f>(findings: impl IntoIterator<Item = &'f Finding>) -> String {
    let mut text = String::new();
    let findings: Vec<&Finding> = findings.into_iter().collect();
    for (place, one) in findings.iter().enumerate() {
        let alike = |other: &&&Finding| (&other.code, other.severity) == (&one.code, one.severity);
        let before = findings[..place].iter().filter(alike).count();
        if before < MOST_ALIKE {
            text += &line_of(one);
        } else if before == MOST_ALIKE {
            let more = findings[place..].iter().filter(alike).count();
            text += &format!("{}: {more} more of {}; --json has all\n", one.severity, one.code);
        }
    }
    text
}

/// A finding as a line of text.
fn line_of(finding: &Finding) -> String {
    format!("{}: {}\n", finding.severity, finding.message)
}

/// A number of things that are named by a noun with a regular plural: `1 run`, `2 runs`.
pub fn counted(count: impl Display, noun: &str) -> String {
    let count = count.to_string();
    let ending = if count == "1" { "" } else { "s" };
    format!("{count} {noun}{ending}")
}

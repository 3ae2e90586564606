//! The verdict on a result in words.

use massline_shared::diagnosis::{Diagnostic, SubjectKind};
use massline_shared::layout::HostLayout;

use massline_analysis::judgement::{Concern, Judgement};

use super::single_fault::{advice_on, chi_squared_text};
use super::suspects::suspect_clause;
use super::{score_tests, two_digits};
use massline_result::VerdictReason;

/// What is said of an answer whose standard deviations, if it has any, do not cover all that they should.
pub const UNCERTAINTY_UNKNOWN: &str = "the 95 % intervals of the answer are not known";

/// As many warnings about single responses with one code are a reason each; of more, the one with the largest value
/// stands for all. There are dozens of responses, and what is wrong with one of them is mostly wrong with many.
const MOST_ALIKE: usize = 2;

/// The reasons of a verdict, the gravest first; `message_of` makes the sentence of a finding.
pub fn verdict_reasons(
    judgement: &Judgement,
    layout: &HostLayout,
    message_of: impl Fn(&Diagnostic) -> String,
) -> Vec<VerdictReason> {
    let reason = |concern: &Concern| {
        let alike = match concern {
            Concern::Warning(warning) => others_alike(judgement, warning)?,
            _ => 0,
        };
        Some(VerdictReason {
            code: concern.code(),
            verdict: concern.verdict(),
            message: clause(concern, layout, &message_of) + remedy(concern),
            alike,
        })
    };
    judgement.concerns.iter().filter_map(reason).collect()
}

/// How many other warnings a warning stands for; `None` where another one stands for it.
fn others_alike(judgement: &Judgement, warning: &Diagnostic) -> Option<usize> {
    let alike = judgement.concerns.iter().filter_map(|concern| match concern {
        Concern::Warning(other) if other.code == warning.code => Some(other),
        _ => None,
    });
    let others = alike.clone().count() - 1;
    if warning.code.subject_kind() != SubjectKind::Response || others < MOST_ALIKE {
        return Some(0);
    }
    let largest = alike.max_by(|a, b| a.value.abs().total_cmp(&b.value.abs()))?;
    std::ptr::eq(largest, warning).then_some(others)
}

/// A concern as a clause; `say` names a finding.
fn clause(concern: &Concern, layout: &HostLayout, say: impl Fn(&Diagnostic) -> String) -> String {
    match concern {
        Concern::Unphysical => "no real body has these properties".into(),
        Concern::PreferredMethodFailed(method, reason) => format!(
            "{}, the better method, has no answer from the same data: {}",
            method.name(),
            say(reason)
        ),
        Concern::Contradicted(consistency) => format!(
            "the data contradict the layout and its error budget ({})",
            chi_squared_text(consistency)
        ),
        Concern::LargerErrors(_) => {
            "the errors of hits or sensors are larger than stated; the intervals are as large as these errors".into()
        }
        Concern::Unexplained(consistency) => {
            let fit = consistency.as_ref().map_or("no fit at all".into(), chi_squared_text);
            format!("the data contradict the layout ({fit}), and no single mistake that was tried explains them")
        }
        Concern::SingleMistake { suspects, .. } => {
            let clauses: Vec<_> =
                suspects.iter().map(|suspect| suspect_clause(suspect, layout)).collect();
            match clauses.as_slice() {
                [one] => format!("one mistake explains the data: {one}"),
                [first, second, third, rest @ ..] if !rest.is_empty() => format!(
                    "one of {} mistakes that the data cannot tell apart explains them: {first}; or {second}; or \
                     {third}; or {} more",
                    clauses.len(),
                    rest.len()
                ),
                several => {
                    format!("one of these mistakes explains the data: {}", several.join("; or "))
                }
            }
        }
        Concern::SmallFault { tests, .. } => {
            let clauses: Vec<_> =
                tests.iter().map(|test| score_tests::clause(test, layout)).collect();
            let shift = tests.iter().map(|test| test.found_shift).fold(0.0, f64::max);
            let statement = match clauses.as_slice() {
                [one] => format!("the data show a small fault: {one}; it moves"),
                [first, second, third, rest @ ..] if !rest.is_empty() => format!(
                    "the data show one of {} small faults that they cannot tell apart: {first}; or {second}; or \
                     {third}; or {} more; it moves",
                    clauses.len(),
                    rest.len()
                ),
                several => {
                    format!("the data show one of these small faults: {}; it moves", several.join("; or "))
                }
            };
            format!("{statement} a property by up to {} of its standard deviations", two_digits(shift))
        }
        Concern::ModelMisfit => "no body on its suspension fits the responses".into(),
        Concern::FlexibleMode => {
            "a flexible mode above the band puts every method off but the global fit".into()
        }
        Concern::MethodsDiffer => "the methods differ by more than chance".into(),
        Concern::MethodOff(method) => {
            format!("{} differs from the other methods by more than chance", method.name())
        }
        Concern::UncertaintyUnknown => UNCERTAINTY_UNKNOWN.into(),
        Concern::Warning(diagnostic) => say(diagnostic),
        Concern::Stated(_, message) => message.clone(),
    }
}

/// What to do about a concern whose sentence does not say so, as a further clause.
fn remedy(concern: &Concern) -> &'static str {
    match concern {
        Concern::SingleMistake { suspects, .. } => advice_on(suspects),
        Concern::SmallFault { tests, .. } => score_tests::advice_on(tests),
        Concern::LargerErrors(_) => {
            "; hit more carefully, check how the sensors are mounted, or state the larger errors in [uncertainty]"
        }
        Concern::Unexplained(_) => "; look for several mistakes, or widen [uncertainty]",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use massline_analysis::judgement::Evidence;
    use massline_shared::body::RigidBody;
    use massline_shared::diagnosis::{Code, Diagnostics, Severity, Subject};
    use massline_shared::identify::{Estimate, Method};
    use nalgebra::{SMatrix, SVector};

    use super::*;

    /// A sound answer.
    fn estimate() -> Estimate<f64> {
        let theta = [2.0, 0.1, 0.2, 0.3, 0.03, 0.02, 0.04, 0.0, 0.0, 0.001];
        Estimate {
            method: Method::MaximumLikelihood,
            body: RigidBody::from_theta(&SVector::from(theta)),
            covariance: Some(SMatrix::identity()),
            condition: 8.0,
            consistency: None,
            learned: None,
            diagnostics: Diagnostics::new(),
        }
    }

    #[test]
    fn of_many_warnings_alike_the_largest_stands_for_all() {
        let mut estimate = estimate();
        let line = |response: u8, value| {
            let subject = Subject::Response { hit: 0, response };
            Diagnostic::about(Code::NoPlateau, Severity::Warning, subject, value)
        };
        let reasons = |judged: &Estimate<f64>| {
            let judgement = Evidence::of(judged).judge();
            let entries =
                verdict_reasons(&judgement, &HostLayout::default(), |d| d.value.to_string());
            entries.into_iter().map(|reason| (reason.message, reason.alike)).collect::<Vec<_>>()
        };
        estimate.diagnostics.extend([line(1, 0.02), line(2, 0.04)]);
        assert_eq!(reasons(&estimate), [("0.02".into(), 0), ("0.04".into(), 0)]);
        estimate.diagnostics.extend([
            line(3, 0.03),
            Diagnostic::whole(Code::IllConditioned, Severity::Warning, 1.0),
        ]);
        assert_eq!(reasons(&estimate), [("0.04".into(), 2), ("1".into(), 0)]);
    }
}

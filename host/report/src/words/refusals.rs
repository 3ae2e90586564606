//! Methods without an answer, and the reasons: one wording for all commands.

use massline_result::Refusal;
use massline_shared::diagnosis::{Code, Diagnostic};
use massline_shared::identify::Method;

use super::code_name;

/// The code of a method that has no answer and gives no reason.
const NO_ANSWER: &str = "no_answer";

/// The refusals as part of a result; `code` is the first reason's, the message states all reasons.
pub fn refusals<R: AsRef<[Diagnostic]>>(
    refused: &[(Method, R)],
    message_of: impl Fn(&Diagnostic) -> String,
) -> Vec<Refusal> {
    let refusal = |(method, reasons): &(Method, R)| {
        let codes: Vec<String> = reasons.as_ref().iter().map(code_name).collect();
        Refusal {
            method: (*method).into(),
            code: codes.first().map_or(NO_ANSWER, String::as_str).to_owned(),
            message: joined(reasons.as_ref(), &message_of),
            codes,
        }
    };
    refused.iter().map(refusal).collect()
}

/// The refusals as lines: `maximum-likelihood: not applicable: <reason>`. Methods with the same reasons share one.
pub fn refusals_text(refused: &[Refusal]) -> String {
    let mut lines: Vec<(String, String)> = Vec::new();
    for Refusal { method, code, message, .. } in refused {
        let outcome = if is_failure(code) { "no answer" } else { "not applicable" };
        let reason = format!("{outcome}: {message}");
        match lines.iter_mut().find(|(_, earlier)| *earlier == reason) {
            Some((methods, _)) => *methods += &format!(", {method}"),
            None => lines.push((method.to_string(), reason)),
        }
    }
    lines.iter().map(|(methods, reason)| format!("{methods}: {reason}\n")).collect()
}

/// True for a failure on the way to an answer, as opposed to a reason why the method is not applicable.
fn is_failure(code: &str) -> bool {
    const FAILURES: [Code; 7] = [
        Code::NotConverged,
        Code::NotPhysicallyConsistent,
        Code::IllConditioned,
        Code::AttachedTooHeavy,
        Code::MassNotPositive,
        Code::ModelDoesNotFit,
        Code::PriorInconsistentWithData,
    ];
    code == NO_ANSWER || FAILURES.iter().any(|failure| failure.name() == code)
}

fn joined(reasons: &[Diagnostic], message_of: impl Fn(&Diagnostic) -> String) -> String {
    if reasons.is_empty() {
        return "no reason is reported".into();
    }
    reasons.iter().map(message_of).collect::<Vec<_>>().join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::message;
    use massline_shared::diagnosis::Severity;

    fn refused(code: Code) -> [(Method, [Diagnostic; 1]); 1] {
        [(Method::MaximumLikelihood, [Diagnostic::whole(code, Severity::Error, 0.0)])]
    }

    fn text_of(refused: &[(Method, [Diagnostic; 1])]) -> String {
        refusals_text(&refusals(refused, message))
    }

    #[test]
    fn a_layout_that_does_not_admit_a_method_is_told_from_a_fit_that_failed() {
        let text = text_of(&refused(Code::HitsConcurrent));
        assert!(text.starts_with("maximum-likelihood: not applicable: "), "{text}");
        let text = text_of(&refused(Code::NotConverged));
        assert!(text.starts_with("maximum-likelihood: no answer: "), "{text}");
    }

    #[test]
    fn methods_with_one_reason_share_a_line() {
        let [concurrent] = refused(Code::HitsConcurrent);
        let (_, reasons) = concurrent;
        let [other] = refused(Code::NotConverged);
        let refused_methods = [concurrent, (Method::GlobalFit, other.1), (Method::Dppim, reasons)];
        let text = text_of(&refused_methods);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 2, "{text}");
        let both = "maximum-likelihood, dppim: not applicable: ";
        assert!(lines[0].starts_with(both), "{text}");
        assert!(lines[1].starts_with("global-fit: no answer: "), "{text}");
    }

    #[test]
    fn programs_read_method_code_and_message() {
        let refusals = refusals(&refused(Code::NotConverged), message);
        assert_eq!(refusals[0].method, Method::MaximumLikelihood);
        assert_eq!(refusals[0].code, "not_converged");
        assert_eq!(refusals[0].codes, ["not_converged"]);
        assert!(refusals[0].message.contains("did not converge"), "{refusals:?}");
    }
}

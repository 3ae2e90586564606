//! Methods without an answer, and the reasons: one wording for all commands.

use massline_shared::diagnosis::{Code, Diagnostic};
use massline_shared::identify::Method;

use super::code_name;
use crate::document::Refusal;

/// The refusals as JSON; `code` is the first reason's, the message states all reasons.
pub fn refusals_json<R: AsRef<[Diagnostic]>>(
    refused: &[(Method, R)],
    message_of: impl Fn(&Diagnostic) -> String,
) -> Vec<Refusal> {
    let refusal = |(method, reasons): &(Method, R)| {
        let codes: Vec<String> = reasons.as_ref().iter().map(code_name).collect();
        Refusal {
            method: method.name(),
            code: codes.first().map_or("no_answer", String::as_str).to_owned(),
            message: joined(reasons.as_ref(), &message_of),
            codes,
        }
    };
    refused.iter().map(refusal).collect()
}

/// The refusals as lines: `maximum-likelihood: not applicable: <code>: <reason>`. Methods with the same reasons share one.
pub fn refusals_text<R: AsRef<[Diagnostic]>>(
    refused: &[(Method, R)],
    message_of: impl Fn(&Diagnostic) -> String,
) -> String {
    let coded = |d: &Diagnostic| format!("{}: {}", code_name(d), message_of(d));
    let mut all: Vec<(String, String)> = Vec::new();
    for (method, reasons) in refused {
        let reasons = reasons.as_ref();
        let failed = reasons.first().is_none_or(|d| is_failure(d.code));
        let what = if failed { "gave no answer" } else { "not applicable" };
        let said = format!("{what}: {}", joined(reasons, coded));
        match all.iter_mut().find(|(_, of)| *of == said) {
            Some((methods, _)) => *methods += &format!(", {}", method.name()),
            None => all.push((method.name().into(), said)),
        }
    }
    all.iter().map(|(methods, said)| format!("{methods}: {said}\n")).collect()
}

/// True for a failure on the way to an answer, as opposed to a reason why the method is not applicable.
fn is_failure(code: Code) -> bool {
    matches!(
        code,
        Code::NotConverged
            | Code::NotPhysicallyConsistent
            | Code::IllConditioned
            | Code::AttachedTooHeavy
            | Code::MassNotPositive
            | Code::ModelDoesNotFit
            | Code::PriorInconsistentWithData
    )
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
    use crate::report::message;
    use massline_shared::diagnosis::Severity;

    fn refused(code: Code) -> [(Method, [Diagnostic; 1]); 1] {
        [(Method::MaximumLikelihood, [Diagnostic::whole(code, Severity::Error, 0.0)])]
    }

    #[test]
    fn a_layout_that_does_not_admit_a_method_is_told_from_a_fit_that_failed() {
        let text = refusals_text(&refused(Code::HitsConcurrent), message);
        assert!(
            text.starts_with("maximum-likelihood: not applicable: hits_concurrent: "),
            "{text}"
        );
        let text = refusals_text(&refused(Code::NotConverged), message);
        assert!(text.starts_with("maximum-likelihood: gave no answer: not_converged: "), "{text}");
    }

    #[test]
    fn methods_with_one_reason_share_a_line() {
        let [concurrent] = refused(Code::HitsConcurrent);
        let (_, reasons) = concurrent;
        let [other] = refused(Code::NotConverged);
        let all = [concurrent, (Method::GlobalFit, other.1), (Method::Dppim, reasons)];
        let text = refusals_text(&all, message);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 2, "{text}");
        let both = "maximum-likelihood, dppim: not applicable: hits_concurrent: ";
        assert!(lines[0].starts_with(both), "{text}");
        assert!(lines[1].starts_with("global-fit: gave no answer: not_converged: "), "{text}");
    }

    #[test]
    fn programs_read_method_code_and_message() {
        let json = refusals_json(&refused(Code::NotConverged), message);
        assert_eq!(json[0].method, "maximum-likelihood");
        assert_eq!(json[0].code, "not_converged");
        assert_eq!(json[0].codes, ["not_converged"]);
        assert!(json[0].message.contains("did not converge"), "{json:?}");
    }
}

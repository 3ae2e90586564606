//! The verdict on a result as a rig stored it, where the program does not know its layout.

use massline_protocol::object::MeasurementResult;
use massline_shared::diagnosis::Diagnostic;
use massline_shared::identify::Method;
use massline_shared::layout::HostLayout;

use massline_analysis::judgement::{Evidence, Judgement};

use super::{answered_by_rig, estimates_of, message_of_result, verdict_reasons};
use massline_result::TestResult;

/// The verdict on a result as the rig stored it; `None` without an answer.
fn judgement_of(result: &MeasurementResult) -> Option<Judgement> {
    let estimates = estimates_of(result);
    let missing = Method::of_mass_lines()
        .filter(|method| !estimates.iter().any(|estimate| estimate.method == *method));
    // A rig does not store to which method of mass lines a reason belongs.
    let reasons = |method| result.diagnostics.iter().map(move |reason| (method, *reason));
    let refusals = missing.flat_map(reasons).collect();
    let diagnostics = result.diagnostics.to_vec();
    Some(Evidence { refusals, diagnostics, ..Evidence::of(estimates.first()?) }.judge())
}

/// A result as the rig stored it: its own answer with the verdict on it.
pub fn result_of_rig(result: &MeasurementResult) -> TestResult {
    let message_of = |diagnostic: &Diagnostic| message_of_result(diagnostic, result);
    let judgement = judgement_of(result);
    let reasons =
        |judgement: &Judgement| verdict_reasons(judgement, &HostLayout::default(), message_of);
    TestResult {
        verdict: judgement.as_ref().map(Judgement::verdict),
        verdict_reasons: judgement.as_ref().map(reasons).unwrap_or_default(),
        ..answered_by_rig(result)
    }
}

#[cfg(test)]
mod tests {
    use massline_protocol::object::{COVARIANCE, ResultHead, StoredEstimate};
    use massline_result::Verdict;
    use massline_shared::diagnosis::{Code, Severity, Subject};
    use massline_shared::identify::{self, Consistency};
    use massline_shared::layout::FrfEstimator;
    use massline_shared::mass_line::Terms;

    use super::*;
    use massline_analysis::judgement::is_of_other_form;

    fn result(methods: &[Method], chi_squared: f32, mass: f32) -> MeasurementResult {
        let estimate = |method: &Method| StoredEstimate {
            method: method.number(),
            properties: [mass, 0.17, -0.09, 0.02, 0.011, 0.007, 0.014, 0.004, -0.001, 0.003],
            covariance: (0..COVARIANCE).map(|_| 0.0).collect(),
            condition: 8.5,
            learned: None,
            consistency: Some(Consistency { chi_squared, degrees_of_freedom: 17 }),
            diagnostics: Default::default(),
        };
        MeasurementResult {
            head: ResultHead {
                number: 1,
                layout_hash: 0,
                title: Default::default(),
                started_unix_s: 0,
                calibration: 0,
                gains: None,
                firmware: Default::default(),
                frf_estimator: FrfEstimator::Hv,
                terms: Terms::A,
                band_automatic: true,
            },
            dofs: Default::default(),
            lines: Default::default(),
            estimates: methods.iter().map(estimate).collect(),
            diagnostics: Default::default(),
        }
    }

    /// The panel of a rig and the program state the same verdict on what the rig has found, whatever that is.
    #[test]
    fn a_rig_s_own_verdict_is_that_of_the_program() {
        let all_methods = [Method::MaximumLikelihood, Method::InertiaRestraint];
        for methods in [&all_methods[..], &all_methods[..1], &all_methods[1..]] {
            for (chi_squared, mass) in [(17.0, 1.23), (60.0, 1.23), (272.0, 1.23), (17.0, -1.23)] {
                let mut result = result(methods, chi_squared, mass);
                let answer = result.estimates[0].estimate().unwrap();
                let is_complete = methods.len() == all_methods.len();
                // Which form of damping fits, a rig never says.
                for code in Code::ALL.iter().filter(|code| !is_of_other_form(**code)) {
                    for severity in [Severity::Note, Severity::Warning, Severity::Error] {
                        let diagnostic = Diagnostic::about(*code, severity, Subject::Whole, 4.0);
                        result.diagnostics.clear();
                        result.diagnostics.push(diagnostic).unwrap();
                        let verdict = judgement_of(&result).unwrap().verdict();
                        let of_rig =
                            identify::Verdict::on(&answer, &result.diagnostics, is_complete);
                        assert_eq!(Verdict::from(of_rig), verdict, "{methods:?} {diagnostic:?}");
                    }
                }
            }
        }
    }
}

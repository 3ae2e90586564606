//! What a rig has measured, and its own answer.

use massline_protocol::lines_head::LinesHead;
use massline_protocol::object::{DofResult, MeasurementResult};
use massline_result::{MassLine, MeasuredDof, SolvedBy, TestResult};
use massline_shared::identify::Estimate;

use super::message::message_of_result;
use super::{estimate_of, findings, hash_text, known};
use massline_files::clock;

/// The rig's estimates by the methods that this program knows, the best first, converted to double precision.
pub fn estimates_of(result: &MeasurementResult) -> Vec<Estimate<f64>> {
    let (known, _) = result.estimates();
    known.iter().map(Estimate::cast).collect()
}

/// What a rig has measured, without any answer and without findings.
pub fn measured(result: &MeasurementResult) -> TestResult {
    let head = &result.head;
    TestResult {
        number: Some(head.number),
        title: head.title.as_str().to_owned(),
        measured: clock::moment(head.started_unix_s),
        layout_hash: hash_text(head.layout_hash),
        calibration: hash_text(head.calibration),
        calibration_sigma: head.gains.map(Into::into),
        firmware: Some(head.firmware.as_str().to_owned()),
        frf_estimator: Some(head.frf_estimator.into()),
        terms: Some(head.terms.into()),
        band_automatic: head.band_automatic,
        profile: Some(result.profile().into()),
        mass_lines: result.dofs.iter().map(mass_line).collect(),
        lines: result.lines.iter().map(measured_dof).collect(),
        notes: notes(result),
        ..TestResult::default()
    }
}

/// A result of a rig with the rig's own answer, as it is stored, without a verdict.
pub fn answered_by_rig(result: &MeasurementResult) -> TestResult {
    let message_of = |d: &_| message_of_result(d, result);
    let estimates = estimates_of(result);
    TestResult {
        solved_by: SolvedBy::Rig,
        results: estimates.iter().map(|estimate| estimate_of(estimate, message_of)).collect(),
        diagnostics: findings(&result.diagnostics, message_of),
        ..measured(result)
    }
}

fn mass_line(dof: &DofResult) -> MassLine {
    MassLine {
        dof: dof.dof.to_string(),
        hits: Some(dof.hits.into()),
        band_hz: Some(dof.band_hz.map(f64::from)),
        accelerance_m_per_s2_per_n: dof.accelerance.map(f64::from).to_vec(),
        noise_m_per_s2_per_n: dof.noise.iter().map(|noise| known(f64::from(*noise))).collect(),
        coherence: dof.coherence.map(|coherence| coherence.map(f64::from).to_vec()),
    }
}

fn measured_dof(head: &LinesHead) -> MeasuredDof {
    MeasuredDof {
        dof: head.dof.to_string(),
        hits: Some(head.hits),
        band_hz: Some(head.band_hz.map(f64::from)),
        coherence: head.coherence.map(|coherence| coherence.map(f64::from).to_vec()),
    }
}

/// Notes on values that the result lacks, with the reasons.
fn notes(result: &MeasurementResult) -> Vec<String> {
    let mut notes = Vec::new();
    let (_, unknown) = result.estimates();
    for number in unknown {
        notes.push(format!(
            "the rig has an answer by method {number}, which this program does not know; update it"
        ));
    }
    let of_lines = result.lines.iter().map(|dof| (dof.dof, dof.coherence));
    let coherence = result.dofs.iter().map(|dof| (dof.dof, dof.coherence)).chain(of_lines);
    let single: Vec<String> = coherence
        .filter(|(_, coherence)| coherence.is_none())
        .map(|(dof, _)| dof.to_string())
        .collect();
    if !single.is_empty() {
        notes.push(format!(
            "no coherence is given for {}: of a single hit it is 1 by definition and says nothing",
            single.join(", ")
        ));
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::*;
    use massline_protocol::object::{ResultHead, StoredEstimate};
    use massline_shared::diagnosis::{Code, Diagnostic, Severity};
    use massline_shared::identify::Method;
    use massline_shared::layout::FrfEstimator;
    use massline_shared::mass_line::Terms;
    use serde_json::json;

    fn stored() -> StoredEstimate {
        let mut covariance = heapless::Vec::new();
        for row in 0..10_u8 {
            for column in 0..=row {
                let value = if row == column { f32::from(row + 1).powi(2) } else { 0.0 };
                covariance.push(value).unwrap();
            }
        }
        let scatter = Diagnostic::whole(Code::SigmaCoversScatterOnly, Severity::Note, 0.0);
        StoredEstimate {
            method: Method::InertiaRestraint.number(),
            properties: [2.0, 0.5, 0.25, -0.125, 3.0, 2.0, 4.0, 0.0, 0.0, 0.0],
            covariance,
            condition: 8.0,
            consistency: None,
            learned: None,
            diagnostics: [scatter].into_iter().collect(),
        }
    }

    fn measurement(estimates: &[StoredEstimate]) -> MeasurementResult {
        MeasurementResult {
            head: ResultHead {
                title: "frame".try_into().unwrap(),
                started_unix_s: 1_795_000_000,
                number: 7,
                layout_hash: 0xABCD,
                calibration: 3,
                gains: None,
                firmware: "0.1.0".try_into().unwrap(),
                frf_estimator: FrfEstimator::H1,
                terms: Terms::Abc,
                band_automatic: false,
            },
            dofs: heapless::Vec::new(),
            lines: Default::default(),
            estimates: estimates.iter().cloned().collect(),
            diagnostics: heapless::Vec::new(),
        }
    }

    #[test]
    fn the_json_has_its_stable_shape() {
        let json = json!(answered_by_rig(&measurement(&[stored()])));
        assert_eq!(json["layout_hash"], "0000abcd");
        assert_eq!(json["title"], "frame");
        assert_eq!(json["measured"], "2026-11-18T11:06:40Z");
        assert_eq!(json["calibration"], "00000003");
        assert_eq!(json["firmware"], "0.1.0");
        let result = &json["results"][0];
        assert_eq!(result["method"], "inertia-restraint");
        assert_eq!(result["mass_kg"], json!({"value": 2.0, "sigma": 1.0}));
        assert_eq!(result["center_of_mass_m"]["value"], json!([0.5, 0.25, -0.125]));
        assert_eq!(result["center_of_mass_m"]["sigma"], json!([2.0, 3.0, 4.0]));
        let inertia = &result["inertia_kg_m2"];
        assert_eq!(inertia["value"], json!([[3.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 4.0]]));
        assert_eq!(inertia["sigma"], json!([[5.0, 8.0, 9.0], [8.0, 6.0, 10.0], [9.0, 10.0, 7.0]]));
        assert_eq!(result["covariance"].as_array().unwrap().len(), 10);
        assert_eq!(result["covariance"][9][9], 100.0);
        assert_eq!(result["physically_consistent"], true);
        assert_eq!(result["diagnostics"][0]["code"], "sigma_covers_scatter_only");
        assert_eq!(result["diagnostics"][0]["severity"], "note");
        assert!(!result["diagnostics"][0]["message"].as_str().unwrap().is_empty());
    }

    #[test]
    fn an_answer_by_an_unknown_method_is_named_with_its_number() {
        let result = measurement(&[StoredEstimate { method: 99, ..stored() }, stored()]);
        let json = json!(answered_by_rig(&result));
        assert_eq!(json["results"].as_array().unwrap().len(), 1);
        assert!(json["notes"][0].as_str().unwrap().contains("method 99"), "{json}");
    }
}

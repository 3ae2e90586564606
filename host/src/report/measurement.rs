//! A rig's stored result, unchanged.

use massline_protocol::lines_head::LinesHead;
use massline_protocol::object::{DofResult, MeasurementResult};
use massline_shared::identify::{Estimate, Method};
use massline_shared::layout::TestProfile;

use super::message::message_of_result;
use super::{diagnostics_json, estimate_json, hash_text, sentences, table};
use crate::clock;
use crate::document::{Marked, MeasuredDof, MeasuredMassLine, Measurement};
use crate::rig_findings::of_measuring;

/// The rig's estimates by the methods that this program knows, the best first, converted to double precision.
pub fn estimates_of(result: &MeasurementResult) -> Vec<Estimate<f64>> {
    let (known, _) = result.estimates();
    known.iter().map(Estimate::cast).collect()
}

/// A result of a rig as JSON, without findings of the host and without its verdict.
pub fn measurement_json(result: &MeasurementResult) -> Measurement {
    let head = &result.head;
    let found = diagnostics_json(&result.diagnostics, |d| message_of_result(d, result));
    Measurement {
        verdict: None,
        verdict_reasons: Vec::new(),
        results: estimates_of(result).iter().map(estimate_json).collect(),
        number: head.number,
        title: head.title.as_str().to_owned(),
        measured: clock::moment(head.started_unix_s),
        layout_hash: hash_text(head.layout_hash),
        calibration: hash_text(head.calibration),
        calibration_sigma: head.gains.map(Into::into),
        firmware: head.firmware.as_str().to_owned(),
        frf_estimator: head.frf_estimator.name(),
        terms: head.terms.name(),
        band_automatic: head.band_automatic,
        profile: result.profile().name(),
        mass_lines: result.dofs.iter().map(dof_json).collect(),
        lines: result.lines.iter().map(lines_json).collect(),
        notes: notes(result),
        diagnostics: found.into_iter().map(Marked::stored).collect(),
        not_applicable: None,
        details: None,
        suspension: None,
        global_fit: None,
        agreement: None,
        single_faults: None,
        host: None,
        cannot_see: None,
        archive: None,
        after_each_dof: None,
        modes_after_each_dof: None,
        hit_log: None,
    }
}

fn dof_json(dof: &DofResult) -> MeasuredMassLine {
    MeasuredMassLine {
        dof: dof.dof.to_string(),
        hits: dof.hits,
        band_hz: dof.band_hz,
        accelerance_m_per_s2_per_n: dof.accelerance,
        noise_m_per_s2_per_n: dof.noise,
        coherence: dof.coherence,
    }
}

fn lines_json(head: &LinesHead) -> MeasuredDof {
    MeasuredDof {
        dof: head.dof.to_string(),
        hits: head.hits,
        band_hz: head.band_hz,
        coherence: head.coherence,
    }
}

/// What the host has found of a result, for the text about the rig's.
#[derive(Clone, Debug, Default)]
pub struct SolvedHere {
    /// The text about the answer to use, which stands before all others.
    pub answer: String,
    /// The methods with an answer here. With one, no answer of the rig has a table, and what the rig concluded is not said.
    pub answered: Vec<Method>,
}

/// A result of a rig as text.
pub fn measurement_text(result: &MeasurementResult, here: &SolvedHere) -> String {
    let head = &result.head;
    let hits: Vec<String> =
        result.measured().map(|(dof, _, hits)| format!("{dof} ({hits} hits)")).collect();
    let origin = [Some(head.title.to_string()), clock::moment(head.started_unix_s)];
    let origin: Vec<String> = origin.into_iter().flatten().filter(|of| !of.is_empty()).collect();
    let mut text = format!(
        "Result {}{}{} (layout {:08x}, calibration {:08x}, firmware {}): {}\n",
        head.number,
        if origin.is_empty() { "" } else { ": " },
        origin.join(", "),
        head.layout_hash,
        head.calibration,
        head.firmware,
        hits.join(", ")
    );
    text += &here.answer;
    if here.answered.is_empty() {
        for estimate in estimates_of(result) {
            text += &table(&estimate, None);
        }
    }
    let estimator = head.frf_estimator.name();
    text += &match result.profile() {
        TestProfile::MassLine => format!("mass lines ({}) of {estimator}, ", head.terms.name()),
        TestProfile::Suspension => format!("frequency responses by {estimator}, "),
    };
    text += &bands_text(result);
    for note in notes(result) {
        text += &format!("note: {note}\n");
    }
    let stands = if here.answered.is_empty() {
        result.diagnostics.to_vec()
    } else {
        of_measuring(&result.diagnostics)
    };
    text + &sentences(&stands, |d| message_of_result(d, result))
}

/// The band of every DOF; a single band when all are equal.
fn bands_text(result: &MeasurementResult) -> String {
    let ends = |[low, high]: [f32; 2]| format!("{low:.1} to {high:.1} Hz");
    let origin = if result.head.band_automatic { "found from the data" } else { "as set" };
    let of_lines = result.lines.iter().map(|dof| (dof.dof, dof.band_hz));
    let bands: Vec<_> =
        result.dofs.iter().map(|dof| (dof.dof, dof.band_hz)).chain(of_lines).collect();
    match bands.first() {
        Some((_, band)) if bands.iter().all(|(_, of)| of == band) => {
            format!("over {}, {origin}\n", ends(*band))
        }
        Some(_) => {
            let each = bands.iter().map(|(dof, band)| format!("{dof} {}", ends(*band)));
            format!("{origin} over {}\n", each.collect::<Vec<_>>().join(", "))
        }
        None => format!("band {origin}\n"),
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
        let json = json!(measurement_json(&measurement(&[stored()])));
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
        let json = json!(measurement_json(&result));
        assert_eq!(json["results"].as_array().unwrap().len(), 1);
        assert!(json["notes"][0].as_str().unwrap().contains("method 99"), "{json}");
        assert!(
            measurement_text(&result, &SolvedHere::default())
                .contains("note: the rig has an answer by method 99")
        );
    }

    #[test]
    fn the_text_names_the_result_and_what_its_sigma_covers() {
        let text = measurement_text(&measurement(&[stored()]), &SolvedHere::default());
        let first = "Result 7: frame, 2026-11-18T11:06:40Z (layout 0000abcd, calibration 00000003, firmware";
        assert!(text.starts_with(first), "{text}");
        // An answer that was found here stands in the place of all that the rig has, whatever their methods.
        let result = measurement(&[stored()]);
        for answered in [Method::InertiaRestraint, Method::MaximumLikelihood] {
            let answer = "the one to use\n".into();
            let here = SolvedHere { answer, answered: vec![answered] };
            let text = measurement_text(&result, &here);
            assert_eq!(text.lines().nth(1), Some("the one to use"), "{text}");
            assert!(!text.contains("J_xz"), "{text}");
        }
        let text = measurement_text(&result, &SolvedHere::default());
        assert!(text.contains("scatter between hits only"), "{text}");
        assert!(text.contains("J_xz"), "{text}");
    }
}

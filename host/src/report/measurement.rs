//! A rig's stored result, unchanged.

use massline_protocol::lines_head::LinesHead;
use massline_protocol::modes::{StoredAgreement, StoredDifference, StoredMode, StoredRefusal};
use massline_protocol::object::{DofResult, MeasurementResult};
use massline_shared::body::INERTIAL_PARAMETERS;
use massline_shared::diagnosis::Diagnostic;
use massline_shared::identify::agreement::{Difference, Outcome};
use massline_shared::identify::{Estimate, Method};
use massline_shared::layout::TestProfile;

use super::comparison::{difference_json, difference_text, listed};
use super::digits::{as_exact_as, two_digits};
use super::message::message_of_result;
use super::refusals::{refusals_json, refusals_text};
use super::{diagnostics_json, estimate_json, hash_text, sentences, table};
use crate::clock;
use crate::document::{
    Marked, MeasuredDof, MeasuredMassLine, Measurement, Properties, Refusal, RigAgreement, RigMode,
    Spread,
};
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
        modes_of_rig: result.modes.iter().map(mode_json).collect(),
        agreement_of_rig: result.agreement.as_ref().map(agreement_json),
        notes: notes(result),
        diagnostics: found.into_iter().map(Marked::stored).collect(),
        not_applicable: not_applicable_json(result),
        details: None,
        suspension: None,
        global_fit: None,
        agreement: None,
        single_faults: None,
        host: None,
        cannot_see: None,
        archive: None,
        after_each_dof: None,
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

fn mode_json(mode: &StoredMode) -> RigMode {
    let number = |value: f32, sigma: f32| {
        let sigma = known(sigma).map(f64::from);
        Spread { value: value.into(), sigma }
    };
    let [_, _, shape @ ..] = mode.sigma;
    let is_known = shape.iter().all(|sigma| *sigma > 0.0);
    RigMode {
        frequency_hz: number(mode.frequency_hz, mode.sigma[0]),
        damping_ratio: number(mode.damping_ratio, mode.sigma[1]),
        shape: Spread {
            value: mode.shape.map(f64::from),
            sigma: is_known.then(|| shape.map(f64::from)),
        },
        complexity: mode.complexity.into(),
    }
}

/// A standard deviation, unless it is stored as unknown.
fn known(sigma: f32) -> Option<f32> {
    Some(sigma).filter(|sigma| *sigma > 0.0)
}

fn agreement_json(agreement: &StoredAgreement) -> RigAgreement {
    let largest = agreement.largest.as_ref().map(|largest| {
        let name = |number| Method::from_number(number).map(Method::name);
        difference_json(&difference_of(largest), largest.methods.map(name))
    });
    RigAgreement {
        outcome: agreement.outcome().name(),
        off: methods(&agreement.off).map(Method::name).collect(),
        verdict: verdict_of_rig(agreement),
        largest,
        combined: Spread {
            value: Properties::of(agreement.properties.map(f64::from)),
            sigma: Some(Properties::of(agreement.sigma.map(f64::from))),
        },
    }
}

/// The largest difference of a rig's methods. Its methods are named by their numbers.
fn difference_of(stored: &StoredDifference) -> Difference<f64> {
    Difference {
        methods: stored.methods.map(usize::from),
        property: usize::from(stored.property).min(INERTIAL_PARAMETERS.len() - 1),
        difference: stored.difference.into(),
        sigma: stored.sigma.into(),
        significant: stored.significant,
    }
}

/// Whether the methods of a rig agree, and where they differ most.
fn verdict_of_rig(agreement: &StoredAgreement) -> String {
    let off: Vec<Method> = methods(&agreement.off).collect();
    let verdict = match agreement.outcome() {
        Outcome::Agree => "the methods of the rig agree".to_owned(),
        Outcome::SomeOff => format!("methods of the rig that are off: {}", listed(&off)),
        Outcome::Differ => "the methods of the rig differ by more than chance".to_owned(),
    };
    let Some(largest) = &agreement.largest else { return verdict };
    let name = |number| Method::from_number(number).map_or("a method", Method::name);
    let difference = difference_text(&difference_of(largest), largest.methods.map(name));
    format!("{verdict}; at most, {difference}")
}

fn methods(numbers: &[u8]) -> impl Iterator<Item = Method> + '_ {
    numbers.iter().filter_map(|number| Method::from_number(*number))
}

/// The methods that the rig had no answer by, each with its reason.
fn refusals_of(result: &MeasurementResult) -> Vec<(Method, [Diagnostic; 1])> {
    let reason = |of: &StoredRefusal| Some((Method::from_number(of.method)?, [of.reason.into()]));
    result.refusals.iter().filter_map(reason).collect()
}

fn not_applicable_json(result: &MeasurementResult) -> Option<Vec<Marked<Refusal>>> {
    let refusals = refusals_json(&refusals_of(result), |d| message_of_result(d, result));
    (!refusals.is_empty()).then(|| refusals.into_iter().map(Marked::stored).collect())
}

/// The modes of a rig, how its methods agree, and which of them have no answer.
fn modes_text(result: &MeasurementResult, here: &SolvedHere) -> String {
    let mut text = String::new();
    for (place, mode) in result.modes.iter().enumerate() {
        let spread = |value: f32, sigma: f32| {
            let (value, sigma) = (f64::from(value), known(sigma).map(f64::from));
            let error = sigma.map_or_else(String::new, |sigma| format!(" ± {}", two_digits(sigma)));
            format!("{}{error}", as_exact_as(value, sigma))
        };
        text += &format!(
            "mode {} of the rig: {} Hz, damping {} %\n",
            place + 1,
            spread(mode.frequency_hz, mode.sigma[0]),
            spread(100.0 * mode.damping_ratio, 100.0 * mode.sigma[1]),
        );
    }
    if let Some(agreement) = &result.agreement {
        text += &verdict_of_rig(agreement);
        let (mass, sigma) = (f64::from(agreement.properties[0]), f64::from(agreement.sigma[0]));
        let mass = as_exact_as(mass, Some(sigma));
        text += &format!("; the combined mass is {mass} ± {} kg\n", two_digits(sigma));
    }
    let said_here =
        |method: &Method| [&here.answered, &here.refused].iter().any(|of| of.contains(method));
    let mut refused = refusals_of(result);
    refused.retain(|(method, _)| !said_here(method));
    text + &refusals_text(&refused, |d| message_of_result(d, result))
}

/// What the host has found of a result, for the text about the rig's.
#[derive(Clone, Debug, Default)]
pub struct SolvedHere {
    /// The text about the answer to use, which stands before all others.
    pub answer: String,
    /// The methods with an answer here. With one, no answer of the rig has a table, and what the rig concluded is not said.
    pub answered: Vec<Method>,
    /// The methods without one, whose reasons are given here.
    pub refused: Vec<Method>,
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
    text += &modes_text(result, here);
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
    use massline_shared::diagnosis::{Code, Severity};
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
            modes: Default::default(),
            refusals: Default::default(),
            agreement: None,
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
    fn modes_refusals_and_agreement_of_the_rig_are_told() {
        let reason = Diagnostic::whole(Code::DampingNotViscous, Severity::Error, 3.0);
        let mut result = measurement(&[]);
        let mode = StoredMode {
            frequency_hz: 2.875,
            damping_ratio: 0.015625,
            shape: [0.25; 6],
            // That of the damping is not known.
            sigma: [0.03125, 0.0, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5],
            complexity: 0.0,
        };
        result.modes.push(mode).unwrap();
        let (method, reason) = (Method::Dppim.number(), (&reason).into());
        result.refusals.push(StoredRefusal { method, reason }).unwrap();
        result.agreement = Some(StoredAgreement {
            properties: [17.25; 10],
            sigma: [0.25; 10],
            off: [Method::ContiBretl.number()].into_iter().collect(),
            differ: false,
            largest: Some(StoredDifference {
                methods: [Method::ContiBretl.number(), Method::ToivolaNuutila.number()],
                property: 0,
                difference: -1.5,
                sigma: 0.25,
                significant: true,
            }),
        });
        let json = json!(measurement_json(&result));
        let mode = &json["modes_of_rig"][0];
        assert_eq!(mode["frequency_hz"], json!({"value": 2.875, "sigma": 0.03125}));
        assert_eq!(mode["damping_ratio"], json!({"value": 0.015625, "sigma": null}));
        assert_eq!(mode["shape"]["sigma"][5], 0.5);
        assert_eq!(json["agreement_of_rig"]["off"], json!(["conti-bretl"]));
        assert_eq!(json["agreement_of_rig"]["outcome"], "some_off");
        let largest = &json["agreement_of_rig"]["largest"];
        assert_eq!(largest["methods"], json!(["conti-bretl", "toivola-nuutila"]));
        assert_eq!((&largest["property"], &largest["difference"]), (&json!("mass"), &json!(-1.5)));
        assert_eq!(json["agreement_of_rig"]["combined"]["value"]["mass"], 17.25);
        assert_eq!(json["not_applicable"][0]["method"], "dppim");
        let text = measurement_text(&result, &SolvedHere::default());
        assert!(text.contains("mode 1 of the rig: 2.875 ± 0.031 Hz, damping 1.562"), "{text}");
        let verdict = "off: conti-bretl; at most, m of conti-bretl and toivola-nuutila differ by 1.5 kg, 6.0 standard \
                       deviations of the difference; the combined mass is 17.25 ± 0.25 kg";
        assert!(text.contains(verdict), "{text}");
        assert!(json["agreement_of_rig"]["verdict"].as_str().is_some_and(|of| text.contains(of)));
        assert!(text.contains("dppim: not applicable: damping_not_viscous"), "{text}");
        // The host's reason may differ, and is the one to read.
        let here = SolvedHere { refused: vec![Method::Dppim], ..SolvedHere::default() };
        assert!(!measurement_text(&result, &here).contains("not applicable"));
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
            let here = SolvedHere { answer, answered: vec![answered], refused: Vec::new() };
            let text = measurement_text(&result, &here);
            assert_eq!(text.lines().nth(1), Some("the one to use"), "{text}");
            assert!(!text.contains("J_xz"), "{text}");
        }
        let text = measurement_text(&result, &SolvedHere::default());
        assert!(text.contains("scatter between hits only"), "{text}");
        assert!(text.contains("J_xz"), "{text}");
    }
}

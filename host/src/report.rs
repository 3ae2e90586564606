//! Results as JSON and tables, diagnostics as sentences.
//!
//! The JSON of a result is stable: other programs are written against it. The inertia is about the
//! centre of mass in body axes, tensor elements; the covariance is in the order
//! [m, cx, cy, cz, Jxx, Jyy, Jzz, Jxy, Jxz, Jyz], SI.

mod details;
mod message;
mod refusals;
mod table;

use massline_protocol::object::{COVARIANCE, DofResult, MeasurementResult, StoredEstimate};
use massline_shared::body::{Principal, RigidBody};
use massline_shared::diagnosis::Diagnostic;
use massline_shared::identify::{Consistency, Estimate, Method};
use massline_shared::layout::{HostLayout, PROPERTIES};
use nalgebra::{Matrix3, SMatrix, SVector};
use serde_json::{Map, Value, json};

use crate::identification::Identification;

pub use details::{details_json, details_text};
pub use message::{code_name, message, message_in};
pub use refusals::{refusals_json, refusals_text};
pub(crate) use table::ROWS;
pub use table::{Truth, scale_of, table};

/// Half of a 95 % interval of a normal variable, in standard deviations.
pub const HALF_WIDTH_95: f64 = 1.959_963_985;

/// One method's answer in double precision.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// Name of the method.
    pub method: &'static str,
    /// The ten.
    pub body: RigidBody<f64>,
    /// Covariance of the ten; `None` when it cannot be told.
    pub covariance: Option<SMatrix<f64, 10, 10>>,
    /// Condition of the balanced regression matrix.
    pub condition: f64,
    /// Whether the data agree with their error budget, for a method that knows one.
    pub consistency: Option<Consistency<f64>>,
    /// What is to be said about it.
    pub diagnostics: Vec<Diagnostic>,
}

impl Answer {
    /// Of an estimate.
    pub fn of(method: Method, estimate: &Estimate<f64>) -> Self {
        Self {
            method: method.name(),
            body: estimate.body,
            covariance: estimate.covariance,
            condition: estimate.condition,
            consistency: estimate.consistency,
            diagnostics: estimate.diagnostics.to_vec(),
        }
    }

    /// From what a rig has stored.
    pub fn from_stored(stored: &StoredEstimate) -> Self {
        let theta = SVector::from(stored.properties.map(f64::from));
        let lower: Vec<f64> = stored.covariance.iter().map(|&v| f64::from(v)).collect();
        Self {
            method: Method::from_raw(stored.method).map_or("unknown", Method::name),
            body: RigidBody::from_theta(&theta),
            covariance: symmetric(&lower),
            condition: f64::from(stored.condition),
            consistency: stored.consistency.map(|c| Consistency {
                chi_squared: f64::from(c.chi_squared),
                degrees_of_freedom: c.degrees_of_freedom,
            }),
            diagnostics: stored.diagnostics.to_vec(),
        }
    }

    /// [m, cx, cy, cz, Jxx, Jyy, Jzz, Jxy, Jxz, Jyz].
    pub fn properties(&self) -> [f64; 10] {
        self.body.theta().into()
    }

    /// Standard deviations of the ten.
    pub fn sigma(&self) -> Option<[f64; 10]> {
        self.covariance.map(|c| c.diagonal().map(|v| v.max(0.0).sqrt()).into())
    }

    /// Principal moments and axes; `None` when a number is not finite.
    pub fn principal(&self) -> Option<Principal<f64>> {
        self.body.principal()
    }

    /// Lower and upper end of the 95 % interval of each of the ten.
    pub fn intervals(&self) -> Option<[[f64; 2]; 10]> {
        let (values, sigma) = (self.properties(), self.sigma()?);
        let ends = |k: usize| {
            let half = HALF_WIDTH_95 * sigma[k];
            [values[k] - half, values[k] + half]
        };
        Some(std::array::from_fn(ends))
    }

    /// An entry of `results`.
    pub fn to_json(&self) -> Value {
        let sigma = self.sigma();
        let principal = self.principal();
        let moment_sigma = principal
            .as_ref()
            .zip(self.covariance.as_ref())
            .map(|(principal, covariance)| <[f64; 3]>::from(principal.moment_sigmas(covariance)));
        let sigma_tensor = sigma.map(|s| {
            let [.., xx, yy, zz, xy, xz, yz] = s;
            [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
        });
        json!({
            "method": self.method,
            "mass_kg": { "value": self.body.mass, "sigma": sigma.map(|s| s[0]) },
            "center_of_mass_m": {
                "value": <[f64; 3]>::from(self.body.center_of_mass),
                "sigma": sigma.map(|s| [s[1], s[2], s[3]]),
            },
            "inertia_kg_m2": { "value": rows(&self.body.inertia), "sigma": sigma_tensor },
            "interval95": self.intervals().map(|ends| {
                PROPERTIES.iter().map(|name| (*name).to_owned()).zip(ends.map(|e| json!(e))).collect::<Map<_, _>>()
            }),
            "covariance": self.covariance.map(|c| {
                (0..10).map(|i| c.row(i).iter().copied().collect::<Vec<_>>()).collect::<Vec<_>>()
            }),
            "principal_moments_kg_m2": {
                "value": principal.map(|p| <[f64; 3]>::from(p.moments)),
                "sigma": moment_sigma,
            },
            "principal_axes": principal.map(|p| rows(&p.axes)),
            "physically_consistent": self.body.is_physically_consistent(),
            "condition": self.condition,
            "chi_squared": self.consistency.map(|c| json!({
                "value": c.chi_squared,
                "degrees_of_freedom": c.degrees_of_freedom,
                "reduced": c.reduced(),
            })),
            "diagnostics": diagnostics_json(&self.diagnostics, message),
        })
    }
}

/// Diagnostics as JSON: `[{"code":…,"severity":…,"message":…}]`.
pub fn diagnostics_json(found: &[Diagnostic], say: impl Fn(&Diagnostic) -> String) -> Vec<Value> {
    found
        .iter()
        .map(|d| {
            json!({
                "code": code_name(d),
                "severity": d.severity.name(),
                "message": say(d),
            })
        })
        .collect()
}

/// Puts what was identified into an object of results: the methods without an answer as
/// `not_applicable` and as warnings of `diagnostics`, what was found out as `details`.
pub fn add_identification(value: &mut Value, found: &Identification, layout: &HostLayout) {
    let say = |d: &Diagnostic| message_in(d, layout);
    value["not_applicable"] = refusals_json(&found.not_applicable, say);
    let mut diagnostics = diagnostics_json(&found.warnings(), say);
    if let Some(Value::Array(others)) = value.get("diagnostics") {
        diagnostics.extend(others.iter().cloned());
    }
    value["diagnostics"] = json!(diagnostics);
    value["details"] = json!(found.details.as_ref().map(|d| details_json(d, layout)));
}

/// Every answer as a table, why others are missing, and what was found out.
pub fn identification_text(
    found: &Identification,
    layout: &HostLayout,
    truth: Option<&Truth>,
) -> String {
    let mut text: String = found.answers.iter().map(|answer| table(answer, truth) + "\n").collect();
    text += &found_out_text(found, layout);
    text
}

/// Why answers are missing, and what was found out.
pub fn found_out_text(found: &Identification, layout: &HostLayout) -> String {
    let say = |d: &Diagnostic| message_in(d, layout);
    let mut text = refusals_text(&found.not_applicable, say);
    text += &sentences(&found.priors, say);
    if let Some(details) = &found.details {
        text += &details_text(details, layout);
    }
    text
}

/// A result of a rig as JSON: `results` with one entry a method, the layout's hash, the
/// calibration's checksum, the firmware's version, the mass lines.
pub fn measurement_json(result: &MeasurementResult) -> Value {
    let results: Vec<Value> =
        result.estimates.iter().map(|e| Answer::from_stored(e).to_json()).collect();
    json!({
        "results": results,
        "number": result.number,
        "layout_hash": result.layout_hash,
        "calibration": result.calibration,
        "firmware": result.firmware.as_str(),
        "frf_estimator": result.frf_estimator.name(),
        "terms": result.terms.name(),
        "band_automatic": result.band_automatic,
        "mass_lines": result.dofs.iter().map(dof_json).collect::<Vec<_>>(),
        "notes": notes(result),
        "diagnostics": diagnostics_json(&result.diagnostics, message),
    })
}

fn dof_json(dof: &DofResult) -> Value {
    json!({
        "dof": dof.dof.to_string(),
        "hits": dof.hits,
        "band_hz": dof.band_hz,
        "accelerance_m_per_s2_per_n": dof.accelerance,
        "noise_m_per_s2_per_n": dof.noise,
        // Null for a single hit, where it is one by definition.
        "coherence": dof.coherence,
    })
}

/// A result of a rig for people.
pub fn measurement_text(result: &MeasurementResult) -> String {
    let hits: Vec<String> =
        result.dofs.iter().map(|d| format!("{} ({} hits)", d.dof, d.hits)).collect();
    let mut text = format!(
        "Result {} (layout {:08x}, calibration {:08x}, firmware {}): {}\n",
        result.number,
        result.layout_hash,
        result.calibration,
        result.firmware,
        hits.join(", ")
    );
    for estimate in &result.estimates {
        text += &table(&Answer::from_stored(estimate), None);
    }
    text += &format!("mass lines ({}) of {}, ", result.terms.name(), result.frf_estimator.name());
    text += &bands_text(result);
    for note in notes(result) {
        text += &format!("note: {note}\n");
    }
    text += &sentences(&result.diagnostics, message);
    text
}

/// The band of every DOF, once when they are alike.
fn bands_text(result: &MeasurementResult) -> String {
    let ends = |[low, high]: [f32; 2]| format!("{low:.1} to {high:.1} Hz");
    let origin = if result.band_automatic { "found from the data" } else { "as set" };
    let first = result.dofs.first().map(|dof| dof.band_hz);
    match first {
        Some(band) if result.dofs.iter().all(|dof| dof.band_hz == band) => {
            format!("over {}, {origin}\n", ends(band))
        }
        Some(_) => {
            let each = result.dofs.iter().map(|dof| format!("{} {}", dof.dof, ends(dof.band_hz)));
            format!("{origin} over {}\n", each.collect::<Vec<_>>().join(", "))
        }
        None => format!("band {origin}\n"),
    }
}

/// What is missing in the numbers and why.
fn notes(result: &MeasurementResult) -> Vec<String> {
    let single: Vec<String> = result
        .dofs
        .iter()
        .filter(|dof| dof.coherence.is_none())
        .map(|dof| dof.dof.to_string())
        .collect();
    if single.is_empty() {
        return Vec::new();
    }
    vec![format!(
        "no coherence is given for {}: of a single hit it is 1 by definition and says nothing",
        single.join(", ")
    )]
}

/// Diagnostics as lines of text.
pub(crate) fn sentences(found: &[Diagnostic], say: impl Fn(&Diagnostic) -> String) -> String {
    found.iter().map(|d| format!("{}: {}\n", d.severity.name(), say(d))).collect()
}

/// The symmetric matrix of a lower triangle row by row; `None` unless it is complete.
fn symmetric(lower: &[f64]) -> Option<SMatrix<f64, 10, 10>> {
    (lower.len() == COVARIANCE).then(|| {
        SMatrix::from_fn(|i, j| {
            let (row, column) = (i.max(j), i.min(j));
            lower.get(row * (row + 1) / 2 + column).copied().unwrap_or(0.0)
        })
    })
}

/// A matrix row by row.
fn rows(matrix: &Matrix3<f64>) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| matrix[(i, j)]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use massline_shared::diagnosis::{Code, Severity};
    use massline_shared::layout::FrfEstimator;
    use massline_shared::mass_line::Terms;

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
            method: 1,
            // A body with the principal moments 2, 3, 4 about the axes y, x, z.
            properties: [2.0, 0.5, 0.25, -0.125, 3.0, 2.0, 4.0, 0.0, 0.0, 0.0],
            covariance,
            condition: 8.0,
            consistency: None,
            diagnostics: [scatter].into_iter().collect(),
        }
    }

    fn measurement() -> MeasurementResult {
        MeasurementResult {
            number: 7,
            layout_hash: 0xABCD,
            calibration: 3,
            firmware: "0.1.0".try_into().unwrap(),
            frf_estimator: FrfEstimator::H1,
            terms: Terms::Abc,
            band_automatic: false,
            dofs: heapless::Vec::new(),
            estimates: [stored()].into_iter().collect(),
            diagnostics: heapless::Vec::new(),
        }
    }

    #[test]
    fn the_json_has_its_stable_shape() {
        let json = measurement_json(&measurement());
        assert_eq!(json["layout_hash"], 0xABCD);
        assert_eq!(json["calibration"], 3);
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
    fn principal_moments_ascend_and_axes_are_columns() {
        let json = Answer::from_stored(&stored()).to_json();
        let moments = &json["principal_moments_kg_m2"];
        for (k, (value, sigma)) in [(2.0, 6.0), (3.0, 5.0), (4.0, 7.0)].into_iter().enumerate() {
            // Rounding of an eigenvalue problem in double precision.
            assert!((moments["value"][k].as_f64().unwrap() - value).abs() < 1e-12);
            assert!((moments["sigma"][k].as_f64().unwrap() - sigma).abs() < 1e-12);
        }
        let element = |i: usize, j: usize| json["principal_axes"][i][j].as_f64().unwrap().abs();
        // The first axis is y: the first column has its one in the second row.
        assert!((element(1, 0) - 1.0).abs() < 1e-12 && element(0, 0) < 1e-12);
    }

    #[test]
    fn without_covariance_there_is_no_sigma() {
        let mut stored = stored();
        stored.covariance.clear();
        let json = Answer::from_stored(&stored).to_json();
        assert!(json["covariance"].is_null());
        assert!(json["mass_kg"]["sigma"].is_null());
        assert!(json["principal_moments_kg_m2"]["sigma"].is_null());
        assert_eq!(json["mass_kg"]["value"], 2.0);
    }

    #[test]
    fn the_text_names_the_result_and_what_its_sigma_covers() {
        let text = measurement_text(&measurement());
        assert!(text.contains("Result 7") && text.contains("0000abcd"), "{text}");
        assert!(text.contains("scatter between hits only"), "{text}");
        assert!(text.contains("J_xz"), "{text}");
    }
}

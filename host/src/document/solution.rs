//! The solution of frequency responses.

use schemars::JsonSchema;
use serde::Serialize;

use super::{
    Agreement, Details, Estimate, Finding, Modes, Refusal, SingleFaults, Unseen, VerdictReason,
};
use crate::verdict::Verdict;

/// What `massline solve` finds from frequency responses.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "solution")]
pub struct Solution {
    /// Whether the result can be used; `null` without an answer.
    pub verdict: Option<Verdict>,
    /// What puts it in doubt, the gravest first.
    pub verdict_reasons: Vec<VerdictReason>,
    /// The answers of all methods, the best first.
    pub results: Vec<Estimate>,
    /// The methods without an answer, and why.
    pub not_applicable: Vec<Refusal>,
    /// Errors of sensors and hits, from the best method that estimates them.
    pub details: Option<Details>,
    /// The layout's hash, eight hexadecimal digits.
    pub layout_hash: Option<String>,
    /// Checksum of the calibration; always `null` for a file.
    pub calibration: Option<String>,
    /// Version of the rig's firmware; always `null` for a file.
    pub firmware: Option<String>,
    /// The point that the linear equations are about.
    pub reference_point: &'static str,
    /// The band of the mass lines.
    pub band_hz: Option<[f64; 2]>,
    /// Whether the band was found from the data.
    pub band_automatic: bool,
    /// Always `null`: the file already holds frequency responses.
    pub frf_estimator: Option<String>,
    /// Terms of the mass lines.
    pub terms: &'static str,
    /// The mass lines of every hit.
    pub mass_lines: Vec<MassLine>,
    /// What was understood of the file.
    pub frequency_responses: FrequencyResponsesRead,
    /// Notes on the way from the file to the answer.
    pub notes: Vec<String>,
    /// Findings about the test.
    pub diagnostics: Vec<Finding>,
    /// The search for a single mistake, where one was done.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub single_faults: Option<SingleFaults>,
    /// The suspension modes.
    pub suspension: Option<Modes>,
    /// What the global fit finds besides the ten properties.
    pub global_fit: Option<GlobalFit>,
    /// How the methods agree.
    pub agreement: Option<Agreement>,
    /// Errors that such a test cannot see.
    pub cannot_see: Vec<Unseen>,
}

/// What was understood of a file with frequency responses.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "frequency_responses_read")]
pub struct FrequencyResponsesRead {
    /// Number of frequency responses in use.
    pub functions: usize,
    /// Their quantities and units.
    pub units: Vec<UnitsRead>,
    /// Number of bins in use.
    pub bins: usize,
    /// The first and the last of them.
    pub range_hz: [f64; 2],
    /// What of the file is not used.
    pub left_out: Vec<String>,
}

/// Quantity and unit of frequency responses.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[schemars(rename = "units_read")]
pub struct UnitsRead {
    /// Number of frequency responses with this unit.
    pub functions: usize,
    /// `accelerance`, `mobility` or `receptance`.
    pub quantity: &'static str,
    /// The unit in the file.
    pub unit: String,
    /// Where the unit was read: labels, dataset 164, or nowhere.
    pub source: &'static str,
}

/// The mass lines of a hit.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "mass_line")]
pub struct MassLine {
    /// The DOF.
    pub dof: String,
    /// Rigid-body accelerance of every channel.
    pub accelerance_m_per_s2_per_n: Vec<f64>,
    /// Its standard deviation.
    pub noise_m_per_s2_per_n: Vec<f64>,
}

/// What the global fit finds besides the ten properties, about the origin of the body frame.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "global_fit")]
pub struct GlobalFit {
    /// Stiffness: N/m, N/rad, N m/m, N m/rad.
    pub stiffness: Vec<[f64; 6]>,
    /// Damping: N s/m and so on, or as stiffness for structural damping.
    pub damping: Option<Vec<[f64; 6]>>,
    /// Number of extra terms of the dynamic stiffness.
    pub extra_terms: usize,
    /// What the tests for the extra terms found: standard normal deviates.
    pub extra_terms_z: Vec<Option<f64>>,
    /// Standard deviation of the noise of a reading, of a complex number.
    pub noise_m_per_s2_per_n: f64,
}

//! A result of a rig, with what the host finds from it.

use schemars::JsonSchema;
use serde::Serialize;

use super::FilePath;
use super::{
    Agreement, CalibrationSigma, Details, Estimate, Finding, FoundBy, GlobalFit, LoggedHit, Modes,
    ModesSoFar, Refusal, SingleFaults, Unseen, VerdictReason,
};
use crate::verdict::Verdict;

/// A result of a rig. What the host has found is marked; it is missing where the layout is not known.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "measurement")]
pub struct Measurement {
    /// Whether the result can be used; `null` without an answer.
    pub verdict: Option<Verdict>,
    /// What puts it in doubt, the gravest first.
    pub verdict_reasons: Vec<VerdictReason>,
    /// The rig's answers, the best first; none in the suspension profile, which a rig does not solve. In `solve`, `simulate`
    /// and `demo` those of `host`, where it has some.
    pub results: Vec<Estimate>,
    /// Number of the result on its rig.
    pub number: u32,
    /// Title of the layout.
    pub title: String,
    /// When the campaign was started, RFC 3339 in UTC; `null` when the rig was not told the time.
    pub measured: Option<String>,
    /// The layout's hash, eight hexadecimal digits.
    pub layout_hash: Option<String>,
    /// Checksum of the calibration, eight hexadecimal digits.
    pub calibration: Option<String>,
    /// What the calibration has contributed to the error budget, as old as it was at the start of the campaign; `null` where
    /// it has contributed nothing.
    pub calibration_sigma: Option<CalibrationSigma>,
    /// Version of the rig's firmware.
    pub firmware: String,
    /// Estimator of the frequency responses.
    pub frf_estimator: &'static str,
    /// Terms of the mass lines.
    pub terms: &'static str,
    /// Whether the bands were found from the data.
    pub band_automatic: bool,
    /// What was measured: `mass-line` or `suspension`.
    pub profile: &'static str,
    /// The mass lines of every DOF; none in the suspension profile.
    pub mass_lines: Vec<MeasuredMassLine>,
    /// Every DOF of the suspension profile.
    pub lines: Vec<MeasuredDof>,
    /// Notes on values that the result lacks.
    pub notes: Vec<String>,
    /// Findings of the rig, and of the host where it says so.
    pub diagnostics: Vec<Marked<Finding>>,
    /// The methods without an answer, and why: by the rig or, in the suspension profile, by the host.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_applicable: Option<Vec<Marked<Refusal>>>,
    /// Errors of sensors and hits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub details: Option<Option<Marked<Details>>>,
    /// The suspension modes, in the suspension profile.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub suspension: Option<Marked<Modes>>,
    /// What the global fit finds besides the ten properties, in the suspension profile.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub global_fit: Option<Marked<GlobalFit>>,
    /// How the methods agree.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub agreement: Option<Option<Marked<Agreement>>>,
    /// The search for a single mistake, where one was done.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub single_faults: Option<Marked<SingleFaults>>,
    /// What the host has found from the same mass lines, or from the lines of the suspension profile, in double precision.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub host: Option<HostFindings>,
    /// Errors that such a test cannot see.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cannot_see: Option<Vec<Unseen>>,
    /// The archive that was written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub archive: Option<FilePath>,
    /// How precise the answer was after each DOF of the campaign.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub after_each_dof: Option<Vec<Precision>>,
    /// Which modes had shown after each DOF of the campaign, in the suspension profile.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub modes_after_each_dof: Option<Vec<ModesSoFar>>,
    /// Every hit that was graded while the command followed the campaign, with `measure --output`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hit_log: Option<Vec<LoggedHit>>,
}

/// Something, and who has found it where that is not the rig alone.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "marked_{T}")]
pub struct Marked<T> {
    /// What it is.
    #[serde(flatten)]
    pub what: T,
    /// Who has found it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub found_by: Option<FoundBy>,
}

impl<T> Marked<T> {
    /// Something that this one has found.
    pub fn by(found_by: FoundBy, what: T) -> Self {
        Self { what, found_by: Some(found_by) }
    }

    /// Something that the rig has stored.
    pub fn stored(what: T) -> Self {
        Self { what, found_by: None }
    }
}

/// The mass lines of a DOF of a rig.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "measured_mass_line")]
pub struct MeasuredMassLine {
    /// The DOF.
    pub dof: String,
    /// Number of hits.
    pub hits: u8,
    /// Their band.
    pub band_hz: [f32; 2],
    /// Rigid-body accelerance of every response.
    pub accelerance_m_per_s2_per_n: [f32; 9],
    /// Its standard deviation.
    pub noise_m_per_s2_per_n: [f32; 9],
    /// Mean coherence of every response; `null` for a single hit, whose coherence is one by definition.
    pub coherence: Option<[f32; 9]>,
}

/// A DOF that a rig has measured in the suspension profile, whose lines are stored with the result.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "measured_dof")]
pub struct MeasuredDof {
    /// The DOF.
    pub dof: String,
    /// Number of hits.
    pub hits: u16,
    /// The band of the suspension modes.
    pub band_hz: [f32; 2],
    /// Mean coherence of every response; `null` for a single hit, whose coherence is one by definition.
    pub coherence: Option<[f32; 9]>,
}

/// What the host finds from what a rig has measured.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "host_findings")]
pub struct HostFindings {
    /// The answers of all methods, the best first.
    pub results: Vec<Estimate>,
    /// The methods without an answer, and why.
    pub not_applicable: Vec<Refusal>,
    /// Errors of sensors and hits.
    pub details: Option<Details>,
    /// How the methods agree.
    pub agreement: Option<Agreement>,
    /// The search for a single mistake, where one was done.
    pub single_faults: Option<SingleFaults>,
    /// Findings about the test.
    pub diagnostics: Vec<Finding>,
}

/// How precise the answer is after some DOFs of a campaign. `mass` and `inertia` are relative to the mass and to m L².
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "precision")]
pub struct Precision {
    /// DOFs that are measured.
    pub dofs_measured: usize,
    /// DOFs of the layout.
    pub dofs: usize,
    /// Largest half widths of the 95 % intervals; `null` before the ten properties are determined.
    pub half_widths95: Option<HalfWidths>,
    /// Whether the data contradict the error budget.
    pub contradicts_budget: Option<bool>,
    /// The worst property.
    pub worst: Option<WorstProperty>,
    /// The further hit that helps most.
    pub further_hit: Option<FurtherHit>,
    /// Whether the target of the layout is reached.
    pub target_reached: bool,
}

/// Half widths of 95 % intervals.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "half_widths")]
pub struct HalfWidths {
    /// Of the mass, relative to it.
    pub mass: f64,
    /// The largest of the centre of mass.
    pub center_m: f64,
    /// The largest of the inertia tensor, relative to m L².
    pub inertia: f64,
}

/// The worst property.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "worst_property")]
pub struct WorstProperty {
    /// Its name.
    pub property: &'static str,
    /// Half width of its 95 % interval, in its SI unit.
    pub half_width95: f64,
    /// The same over the target; `null` without a target.
    pub over_target: Option<f64>,
}

/// A further hit.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "further_hit")]
pub struct FurtherHit {
    /// The DOF.
    pub dof: String,
    /// Half width of the worst property's 95 % interval after it, in its SI unit.
    pub half_width95: f64,
}

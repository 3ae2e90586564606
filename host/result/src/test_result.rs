//! The result of a test.

use massline_shared::identify::Method;
use massline_shared::layout::{FrfEstimator, TestProfile};
use massline_shared::mass_line::Terms;
use serde::{Deserialize, Serialize};

use crate::agreement::Agreement;
use crate::calibration_sigma::CalibrationSigma;
use crate::details::Details;
use crate::error_source::ErrorSource;
use crate::estimate::Estimate;
use crate::fault::{ScoreTest, SingleFaults};
use crate::file_path::FilePath;
use crate::finding::{Finding, Refusal, UnseenError, VerdictReason};
use crate::frequency_responses::FrequencyResponsesRead;
use crate::hit_log::LoggedHit;
use crate::json::{Json, JsonError};
use crate::measured::{GlobalFit, MassLine, MeasuredDof};
use crate::modes::{Modes, ModesSoFar};
use crate::named::NamedValue;
use crate::precision::Precision;
use crate::properties::Properties;
use crate::verdict::Verdict;

/// The version of the JSON documents. It is incremented whenever a key is renamed or removed or changes its meaning,
/// but not when a key is added.
pub const SCHEMA_VERSION: u32 = 1;

/// The result of a test, from a rig or from a file with frequency responses.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TestResult {
    /// Whether the answer can be used; `null` without an answer.
    pub verdict: Option<Verdict>,
    /// What puts the answer in doubt, the gravest first.
    #[serde(default)]
    pub verdict_reasons: Vec<VerdictReason>,
    /// Who has solved the test: the rig only where this program does not know the layout.
    #[serde(default)]
    pub solved_by: SolvedBy,
    /// The answers of all methods, the best first.
    pub results: Vec<Estimate>,
    /// The methods without an answer, and why.
    #[serde(default)]
    pub not_applicable: Vec<Refusal>,
    /// How the methods agree.
    pub agreement: Option<Agreement>,
    /// The rig's own answer beside this one; `null` where either has none by a method of the other.
    pub rig: Option<RigAnswer>,
    /// Findings about the test.
    #[serde(default)]
    pub diagnostics: Vec<Finding>,
    /// What the uncertainty of the answer comes from, as shares of the variances that any method must have; none where
    /// that is not known.
    #[serde(default)]
    pub error_sources: Vec<ErrorSource>,
    /// The search for a single mistake, where one was done.
    pub single_faults: Option<SingleFaults>,
    /// The small faults that the answer was tested for, where it was.
    #[serde(default)]
    pub score_tests: Vec<ScoreTest>,
    /// Errors of sensors and hits, from the best method that estimates them.
    pub details: Option<Details>,
    /// The suspension modes.
    pub suspension: Option<Modes>,
    /// What the global fit finds besides the ten properties.
    pub global_fit: Option<GlobalFit>,
    /// Errors that such a test cannot see.
    #[serde(default)]
    pub cannot_see: Vec<UnseenError>,
    /// Notes on the way from the data to the answer.
    #[serde(default)]
    pub notes: Vec<String>,

    /// Title of the layout; may be empty.
    #[serde(default)]
    pub title: String,
    /// When the campaign was started, RFC 3339 in UTC; `null` where that is not known.
    pub measured: Option<String>,
    /// Number of the result on its rig; `null` for a file.
    pub number: Option<u32>,
    /// Version of the rig's firmware; `null` for a file.
    pub firmware: Option<String>,
    /// The layout's hash, eight hexadecimal digits.
    pub layout_hash: Option<String>,
    /// Checksum of the calibration, eight hexadecimal digits.
    pub calibration: Option<String>,
    /// What the calibration has contributed to the error budget, as old as it was at the start of the campaign; `null`
    /// where it has contributed nothing.
    pub calibration_sigma: Option<CalibrationSigma>,
    /// What was measured; `null` for a file, which may hold both.
    pub profile: Option<NamedValue<TestProfile>>,
    /// Estimator of the frequency responses; `null` for a file, which holds them.
    pub frf_estimator: Option<NamedValue<FrfEstimator>>,
    /// What was understood of a file with frequency responses.
    pub frequency_responses: Option<FrequencyResponsesRead>,
    /// Terms of the mass lines.
    pub terms: Option<NamedValue<Terms>>,
    /// The band of the mass lines, where all DOFs share one.
    pub band_hz: Option<[f64; 2]>,
    /// Whether the bands were found from the data.
    #[serde(default)]
    pub band_automatic: bool,
    /// The point that the linear equations are about, in a file's solution.
    pub reference_point: Option<String>,
    /// The mass lines of every DOF.
    #[serde(default)]
    pub mass_lines: Vec<MassLine>,
    /// The DOFs whose frequency responses about the suspension modes a rig has stored.
    #[serde(default)]
    pub lines: Vec<MeasuredDof>,

    /// Seed of the bench, for a simulated object.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// The true properties of a simulated object: m, c_x, c_y, c_z, J_xx, J_yy, J_zz, J_xy, J_xz, J_yz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub truth: Option<[f64; 10]>,
    /// What the ten properties should be, as far as the layout states it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<Properties<Option<f64>>>,
    /// Root mean square distance of the sensors from their centroid, L.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub characteristic_length_m: Option<f64>,
    /// The archive that was written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub archive: Option<FilePath>,
    /// How precise the answer was after each DOF of the campaign.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub after_each_dof: Vec<Precision>,
    /// Which modes had shown after each DOF of the campaign, in the suspension profile.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub modes_after_each_dof: Vec<ModesSoFar>,
    /// Every hit that was graded while the command followed the campaign, with `measure --output`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub hit_log: Vec<LoggedHit>,
}

/// Who has solved a test.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum SolvedBy {
    /// This program, in double precision.
    #[default]
    Host,
    /// The rig, in single precision.
    Rig,
}

/// The rig's own answer beside that of the program by the same method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RigAnswer {
    /// The method.
    pub method: NamedValue<Method>,
    /// The property in which they differ most.
    pub property: String,
    /// The rig's value minus the program's, in the SI unit of the property.
    pub difference: f64,
    /// The same in standard deviations of the program's answer; `null` where these are not known.
    pub difference_sigma: Option<f64>,
    /// The same in % of the scale, m, L, or m L²; `null` where L is not known.
    pub difference_percent_of_scale: Option<f64>,
    /// Whether nobody could tell the answers apart. They differ where the program has solved with a corrected layout.
    pub agrees: bool,
}

impl TestResult {
    /// The answer, which the verdict is about; `None` without one.
    pub fn answer(&self) -> Option<&Estimate> {
        self.results.first()
    }

    /// What the ten properties should be, as far as it is known: those of a simulated object, or the layout's
    /// reference.
    pub fn expected(&self) -> [Option<f64>; 10] {
        let of_layout = self.reference.map_or([None; 10], |reference| reference.in_order());
        self.truth.map_or(of_layout, |truth| truth.map(Some))
    }

    /// The answer of a method.
    pub fn answer_by(&self, method: Method) -> Option<&Estimate> {
        self.results.iter().find(|estimate| estimate.method == method)
    }

    /// Whether the result is the same after it was written and read: every number in it is one.
    pub fn reads_back(&self) -> bool {
        let text = serde_json::to_vec(self).ok();
        let again = text.and_then(|text| Json::parse(&text).ok()?.read::<Self>().ok());
        again.is_some_and(|again| again == *self)
    }

    /// The result at a key of a document; `None` where there is none. What holds results reads them by this function,
    /// so that the type is compiled once.
    ///
    /// # Errors
    /// The first key or value that does not belong there.
    pub fn read_key(document: &Json, key: &str) -> Result<Option<Self>, JsonError> {
        document.read_key(key)
    }

    /// Every finding about the test and its answer, each once.
    pub fn findings(&self) -> Vec<&Finding> {
        let mut findings: Vec<&Finding> = Vec::new();
        let of_answer = self.answer().into_iter().flat_map(|answer| &answer.diagnostics);
        for finding in self.diagnostics.iter().chain(of_answer) {
            if !findings.contains(&finding) {
                findings.push(finding);
            }
        }
        findings
    }

    /// The DOFs that are in the answers, with mass lines or with lines about the suspension modes.
    pub fn measured_dofs(&self) -> Vec<MeasuredDof> {
        let of_mass_lines = self.mass_lines.iter().map(MassLine::measured);
        of_mass_lines.chain(self.lines.iter().cloned()).collect()
    }
}

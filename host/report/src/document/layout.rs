//! Layouts: as resolved, as judged before a measurement, as suggested.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

use massline_result::{ErrorSource, FilePath, Finding, Mode, Properties, Refusal};
use massline_shared::layout::TestValue;

/// A layout with resolved positions and directions in the body frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ShownLayout {
    /// Title of the layout.
    pub title: String,
    /// The layout's hash, eight hexadecimal digits; `null` where it is too large for a rig.
    pub layout_hash: Option<String>,
    /// Gravity in the body frame, where it is given.
    pub gravity_m_per_s2: Option<[f64; 3]>,
    /// Root mean square distance of the sensors from their centroid.
    pub characteristic_length_m: f64,
    /// The sensors.
    pub sensors: Vec<ShownSensor>,
    /// The hits.
    pub hits: Vec<ShownHit>,
    /// The settings of the test by key of the layout file.
    pub test: BTreeMap<String, SettingValue>,
    /// The standard deviations of the error budget by key of the layout file. Sensors and hits that state their own
    /// differ.
    pub uncertainty: BTreeMap<String, f64>,
    /// What becomes of a hit with a fault, by the code of the fault: `keep`, `warn` or `reject`.
    pub policy: BTreeMap<String, String>,
}

/// A sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ShownSensor {
    /// Its node.
    pub node: u16,
    /// Its position.
    pub position_m: [f64; 3],
    /// Its axes x, y and z, unit vectors.
    pub axes: [[f64; 3]; 3],
    /// Whether it senses gravity.
    pub senses_gravity: bool,
}

/// A hit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ShownHit {
    /// Its DOF.
    pub dof: String,
    /// Its position.
    pub position_m: [f64; 3],
    /// Its direction, a unit vector.
    pub direction: [f64; 3],
}

/// What a key of the settings of a test says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum SettingValue {
    /// A whole number.
    Count(u8),
    /// A number; the key has its unit.
    Number(f64),
    /// The ends of a range.
    Range([f64; 2]),
    /// A word; `auto` for a band that is found from the data.
    Word(String),
}

impl From<TestValue> for SettingValue {
    fn from(value: TestValue) -> Self {
        match value {
            TestValue::Count(count) => Self::Count(count),
            TestValue::Number(number) => Self::Number(number),
            TestValue::Range(ends) => Self::Range(ends),
            TestValue::Word(word) => Self::Word(word.to_owned()),
        }
    }
}

/// How accurate a layout will be, and what limits it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LayoutCheck {
    /// The prediction.
    #[serde(flatten)]
    pub judged: JudgedLayout,
    /// What each error source contributes; empty without a prediction.
    pub error_sources: Vec<ErrorSource>,
    /// What a sensor or hit more or less would change; `null` without a prediction.
    pub advice: Option<Advice>,
}

/// Better sensors and hits among the nodes of a layout.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LayoutSuggestion {
    /// The prediction for the suggested layout.
    #[serde(flatten)]
    pub judged: JudgedLayout,
    /// How many there were to choose from.
    pub candidates: CandidateCounts,
    /// The prediction for the layout as the file has it.
    pub before: Prediction,
    /// Seed of the random starts.
    pub seed: u64,
    /// Number of random starts.
    pub starts: u32,
    /// The file that was written.
    pub written: Option<FilePath>,
}

/// Numbers of candidates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CandidateCounts {
    /// Nodes that can carry a sensor.
    pub sensors: usize,
    /// DOFs that can be hit.
    pub hits: usize,
}

/// A layout and what is predicted for it before any measurement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct JudgedLayout {
    /// The predicted uncertainty.
    #[serde(flatten)]
    pub prediction: Prediction,
    /// Whether the layout determines all ten properties.
    pub identifiable: bool,
    /// Rank of the equations of mass lines: ten when the ten properties are determined; `null` in the suspension
    /// profile.
    pub rank: Option<usize>,
    /// Their condition in balanced variables; `null` when it is infinite, and in the suspension profile.
    pub condition: Option<f64>,
    /// The methods of the test's profile.
    pub methods: Vec<JudgedMethod>,
    /// Standard deviation of the noise of one accelerance of one hit.
    pub noise_m_per_s2_per_n: f64,
    /// The same, relative to 1/mass.
    pub noise: f64,
    /// Root mean square distance of the sensors from their centroid, L.
    pub characteristic_length_m: f64,
    /// What percentages are of: m, L, L, L and m L².
    pub scale: Properties<f64>,
    /// In the suspension profile, what each method would answer to a simulated test.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub forecast: Option<Forecast>,
    /// The body of the prediction.
    pub body: AssumedBody,
    /// Nodes of the sensors.
    pub sensors: Vec<u16>,
    /// DOFs of the hits.
    pub hits: Vec<String>,
    /// Accepted hits at each DOF.
    pub hits_per_dof: u8,
    /// The layout's hash, eight hexadecimal digits; `null` where it is too large for a rig.
    pub layout_hash: Option<String>,
    /// Stable names of the findings.
    pub codes: Vec<String>,
    /// Findings about the layout.
    pub diagnostics: Vec<Finding>,
    /// Notes on the file.
    pub notes: Vec<String>,
}

/// A predicted uncertainty; all are `null` where the layout does not determine the ten properties.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Prediction {
    /// Standard deviations of the ten properties.
    pub sigma: Properties<Option<f64>>,
    /// The same in % of the scale.
    pub percent_of_scale: Properties<Option<f64>>,
    /// Their root mean square.
    pub total_percent_of_scale: Option<f64>,
}

/// What each method would answer to a test of the suspension profile that is computed by formula, with noise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Forecast {
    /// The methods with an answer, best first.
    pub answers: Vec<ForecastAnswer>,
    /// The methods without one.
    pub not_applicable: Vec<Refusal>,
    /// All methods together; all are `null` where they are not combined.
    pub combined: Prediction,
    /// The modes of the object, and how much of each a hit shows.
    pub modes: Vec<Mode>,
}

/// How uncertain the answer of a method would be.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ForecastAnswer {
    /// Its name.
    pub method: String,
    /// The uncertainty.
    #[serde(flatten)]
    pub prediction: Prediction,
}

/// Whether a method can work.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct JudgedMethod {
    /// Its name.
    pub method: String,
    /// Whether it can.
    pub applicable: bool,
    /// Stable names of what prevents it.
    pub blocked_by: Vec<String>,
}

/// The body of a prediction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct AssumedBody {
    /// Whose properties these are, in words.
    pub source: String,
    /// Mass, centre of mass and inertia about it: m, c_x, c_y, c_z, J_xx, J_yy, J_zz, J_xy, J_xz, J_yz.
    pub properties: [f64; 10],
}

/// What a sensor or hit more or less would change.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Advice {
    /// The further hit that helps most.
    pub further_hit: Option<HitTotal>,
    /// The further sensor that helps most.
    pub further_sensor: Option<SensorTotal>,
    /// The layout without each hit.
    pub without_hits: Vec<HitTotal>,
    /// The layout without each sensor.
    pub without_sensors: Vec<SensorTotal>,
}

/// A layout with one hit more or less.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct HitTotal {
    /// DOF of the hit.
    pub dof: String,
    /// The total uncertainty then; `null` where the ten properties are not determined.
    pub total_percent_of_scale: Option<f64>,
}

/// A layout with one sensor more or less.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SensorTotal {
    /// Node of the sensor.
    pub node: u16,
    /// The total uncertainty then; `null` where the ten properties are not determined.
    pub total_percent_of_scale: Option<f64>,
}

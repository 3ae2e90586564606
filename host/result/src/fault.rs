//! Single mistakes that explain the data.

use serde::{Deserialize, Serialize};

use crate::estimate::Estimate;
use crate::finding_code::FindingCode;
use crate::properties::Spread;

/// The search for a single mistake that explains the data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SingleFaults {
    /// What came of it.
    pub outcome: FaultOutcome,
    /// χ² of the layout as it is.
    pub chi_squared: Option<f64>,
    /// Its degrees of freedom.
    pub degrees_of_freedom: Option<u16>,
    /// Number of mistakes that were tried.
    pub tested: usize,
    /// The mistakes that explain the data, the best first.
    pub suspects: Vec<Suspect>,
    /// The next best.
    pub runner_up: Option<Suspect>,
    /// For `larger_errors`: the errors over those stated.
    pub errors_over_stated: Option<ErrorsOverStated>,
    /// Mistakes that were not tried, because hits and sensors do not determine the ten properties with them.
    pub not_tried: Vec<Fault>,
    /// Mistakes that the data would not show.
    pub not_visible: Option<Vec<Fault>>,
}

/// What came of the search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum FaultOutcome {
    /// The data do not contradict the layout.
    NothingSuspicious,
    /// A mistake explains the data.
    Suspected,
    /// No mistake explains the data, errors larger than stated do.
    LargerErrors,
    /// Neither explains the data.
    Unexplained,
}

/// Errors that explain the data over those that are stated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ErrorsOverStated {
    /// Of the positions of the hits.
    pub hit_position: f64,
    /// Of the directions of the hits.
    pub hit_direction: f64,
    /// Of what stays the same over the test: sensors and marks.
    pub constant: f64,
}

/// A mistake. Sensors and hits are counted from 1, as in the layout's messages.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Fault {
    /// Its kind.
    pub code: FindingCode,
    /// The mistake in words.
    pub message: String,
    /// The sensor, where it is about one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor: Option<usize>,
    /// The sensors, where it is about two.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensors: Option<[usize; 2]>,
    /// The hit, where it is about one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hit: Option<usize>,
    /// The node that was hit instead, or whose coordinate is wrong.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub node: Option<u16>,
    /// The nodes, where it is about two.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nodes: Option<[u16; 2]>,
    /// The axis of the sensor, or the coordinate of the node.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axis: Option<char>,
}

impl Fault {
    /// A mistake of this kind, without words, about nothing in particular.
    pub fn of(code: impl Into<FindingCode>) -> Self {
        Self {
            code: code.into(),
            message: String::new(),
            sensor: None,
            sensors: None,
            hit: None,
            node: None,
            nodes: None,
            axis: None,
        }
    }
}

/// A small fault that the data were tested for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ScoreTest {
    /// The fault; its words state a size where the data show it.
    #[serde(flatten)]
    pub fault: Fault,
    /// The unit of its size.
    pub unit: FaultUnit,
    /// What the data say of its size; of a turn or a lean the angle, without a sign.
    pub size: Spread<f64>,
    /// Size of a fault of one standard deviation, in the direction that changes the answer most: so large it is unseen
    /// as a rule, and at three times that it begins to show.
    pub sigma: f64,
    /// Largest change of a property by such a fault, in standard deviations of the answer.
    pub shift_sigma: f64,
    /// The standard normal deviate that is exceeded as rarely as the data show the fault.
    pub significance: f64,
    /// The significance beyond which the fault is shown.
    pub limit: f64,
    /// Whether the data show it.
    pub shown: bool,
}

/// The unit of a fault's size.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum FaultUnit {
    /// m.
    #[serde(rename = "m")]
    Meters,
    /// rad.
    #[serde(rename = "rad")]
    Radians,
    /// kg.
    #[serde(rename = "kg")]
    Kilograms,
    /// Of the gain.
    #[serde(rename = "relative")]
    Relative,
}

/// A mistake that explains the data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Suspect {
    /// The mistake.
    #[serde(flatten)]
    pub fault: Fault,
    /// χ² with it.
    pub chi_squared: f64,
    /// Its degrees of freedom.
    pub degrees_of_freedom: u16,
    /// For a gain: the readings over their true values.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gain: Option<Spread<f64>>,
    /// For a coordinate: the true minus the written value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub displacement_m: Option<Spread<f64>>,
    /// For a hit beside its node: the true minus the nominal point, body frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub displacements_m: Option<[Spread<f64>; 3]>,
    /// What the size smells of: a unit, a converter, a reversed sign.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub meaning: Option<String>,
    /// The ten properties as they would be without the mistake; never the answer of the test.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub corrected: Option<Estimate>,
}

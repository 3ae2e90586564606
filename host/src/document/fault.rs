//! Single mistakes that explain the data.

use schemars::JsonSchema;
use serde::Serialize;

use super::Spread;

/// The search for a single mistake that explains the data.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "single_faults")]
pub struct SingleFaults {
    /// `nothing_suspicious`, `suspected` or `unexplained`.
    pub verdict: &'static str,
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
    /// Mistakes that the data would not show.
    pub not_visible: Option<Vec<Fault>>,
}

/// A mistake. Sensors and hits are counted from 1, as in the layout's messages.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "fault")]
pub struct Fault {
    /// Stable name of the kind.
    pub code: &'static str,
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
    /// The node that was hit instead.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub node: Option<u16>,
}

/// A mistake that explains the data.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "suspect")]
pub struct Suspect {
    /// The mistake.
    #[serde(flatten)]
    pub fault: Fault,
    /// χ² with it.
    pub chi_squared: f64,
    /// The scale of all readings, where that is the mistake.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<Spread<f64>>,
}

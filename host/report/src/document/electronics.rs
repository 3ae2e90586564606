//! What calibrations show of multiplexer and converter.

use serde::{Deserialize, Serialize};

/// What a block test shows of multiplexer and converter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Electronics {
    /// What a sensor axis keeps of the hammer before it; `null` where the hits do not show it.
    pub memory: Option<Memory>,
    /// Differences between pushes from the two sides of each direction.
    pub asymmetry: Vec<Asymmetry>,
}

/// The share of a channel's voltage that the channel converted after it keeps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Memory {
    /// Name of the channel that keeps it.
    pub channel: String,
    /// Name of the channel before it.
    pub before: String,
    /// The share.
    pub share: f64,
    /// Its standard deviation.
    pub sigma: f64,
    /// Whether it is significant and large enough to move an answer.
    pub large: bool,
}

/// The difference between responses to pushes from the two sides of a direction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Asymmetry {
    /// The direction, a unit vector in the frame of the block.
    pub direction: [f64; 3],
    /// Response to pushes along it over that to pushes against it, minus one.
    pub difference: f64,
    /// Its standard deviation.
    pub sigma: f64,
    /// Whether it is significant and large enough to matter.
    pub large: bool,
}

//! The nuisance parameters of a fit, and the influence of sensors and hits.

use serde::{Deserialize, Serialize};

use crate::properties::Spread;

/// Errors of sensors and hits as the fit has found them, and how much each of them matters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Details {
    /// Relative error of the hammer's gain.
    pub hammer_gain: Spread<f64>,
    /// The sensors.
    pub sensors: Vec<SensorDetails>,
    /// The hits.
    pub hits: Vec<HitDetails>,
    /// What the answer would be without a sensor or hit.
    pub influence: Vec<Influence>,
    /// What the data have taught about the error budget, where they have.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error_budget: Option<ErrorBudget>,
}

/// Errors of a sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SensorDetails {
    /// Its node.
    pub node: u16,
    /// Relative errors of its sensitivities, row by row.
    pub sensitivity: [[Spread<f64>; 3]; 3],
    /// Its rotation about its axes.
    pub rotation_rad: [Spread<f64>; 3],
    /// Its displacement.
    pub position_m: [Spread<f64>; 3],
    /// Root mean square of its errors, in the standard deviations of the budget; `null` where the budget has none.
    pub pull: Option<f64>,
}

/// Errors of a hit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct HitDetails {
    /// Its DOF.
    pub dof: String,
    /// Its displacement.
    pub position_m: [Spread<f64>; 3],
    /// Its rotation.
    pub direction_rad: [Spread<f64>; 3],
    /// Root mean square of its errors, in the standard deviations of the budget; `null` where the budget has none.
    pub pull: Option<f64>,
    /// What the answer leaves of its responses, over their noise.
    pub normalized_residual: Option<f64>,
}

/// What the answer would be without a sensor or a hit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Influence {
    /// DOF of the hit, where it is a hit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hit: Option<String>,
    /// Node of the sensor, where it is a sensor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor: Option<u16>,
    /// Changes of the ten properties, in their standard deviations; `null` for one that is known exactly.
    pub shift_sigma: [Option<f64>; 10],
    /// Largest of the standard deviations without it, over those with it.
    pub sigma_ratio_without: Option<f64>,
    /// Its share of χ².
    pub chi_squared: f64,
    /// Its share of the degrees of freedom.
    pub equations: u16,
}

impl Influence {
    /// The property that moves most, by its place among the ten, and by how many standard deviations.
    pub fn largest_shift(&self) -> (usize, f64) {
        let shifts = self.shift_sigma.iter().map(|shift| shift.map_or(0.0, f64::abs)).enumerate();
        shifts.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default()
    }
}

/// What a learned error budget was learned from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum LearnedFrom {
    /// The scatter of the hits from repeat hits, all that stays the same during a test from the residuals.
    #[default]
    RepeatHits,
    /// Three factors from the residuals: `constant_scale` is of the sensors, the others are of the marks as well.
    Residuals,
}

impl LearnedFrom {
    /// What `constant_scale` is of, in words.
    pub fn constant(self) -> &'static str {
        match self {
            Self::RepeatHits => "systematic errors",
            Self::Residuals => "errors of the sensors",
        }
    }
}

/// The error budget as stated and as learned.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ErrorBudget {
    /// What it was learned from.
    pub learned_from: LearnedFrom,
    /// Scatter of the position of a hit.
    pub hit_position_m: BudgetTerm,
    /// Scatter of the direction of a hit.
    pub hit_direction_rad: BudgetTerm,
    /// Factor of all that stays the same during a test.
    pub constant_scale: BudgetTerm,
}

/// A standard deviation, or a factor of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BudgetTerm {
    /// As the layout states it.
    pub stated: f64,
    /// As the data have it.
    pub learned: f64,
}

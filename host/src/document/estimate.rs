//! One estimate of the ten properties.

use schemars::JsonSchema;
use serde::Serialize;

use super::{Finding, LearnedFrom, Properties, Spread};

/// The answer of a method: the ten properties in the body frame.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "estimate")]
pub struct Estimate {
    /// Name of the method.
    pub method: &'static str,
    /// The mass.
    pub mass_kg: Spread<f64>,
    /// The centre of mass.
    pub center_of_mass_m: Spread<[f64; 3]>,
    /// The inertia tensor about the centre of mass, row by row; products have the sign of the tensor's elements.
    pub inertia_kg_m2: Spread<[[f64; 3]; 3]>,
    /// The ends of the 95 % interval of each property.
    pub interval95: Option<Properties<[f64; 2]>>,
    /// Covariance of the ten properties, in the order mass, cx, cy, cz, Jxx, Jyy, Jzz, Jxy, Jxz, Jyz.
    pub covariance: Option<[[f64; 10]; 10]>,
    /// Principal moments of inertia, ascending.
    pub principal_moments_kg_m2: PrincipalMoments,
    /// The principal axes as columns, row by row.
    pub principal_axes: Option<[[f64; 3]; 3]>,
    /// Whether a body can have these properties.
    pub physically_consistent: bool,
    /// Condition of the balanced equations.
    pub condition: f64,
    /// What the answer leaves of the data, against their uncertainty.
    pub chi_squared: Option<ChiSquared>,
    /// What the data have taught about the error budget.
    pub learned_budget: Option<LearnedBudget>,
    /// Findings about this answer.
    pub diagnostics: Vec<Finding>,
}

/// Principal moments of inertia.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "principal_moments")]
pub struct PrincipalMoments {
    /// The values.
    pub value: Option<[f64; 3]>,
    /// Their standard deviations.
    pub sigma: Option<[f64; 3]>,
}

/// χ².
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "chi_squared")]
pub struct ChiSquared {
    /// The value.
    pub value: f64,
    /// Its degrees of freedom.
    pub degrees_of_freedom: u16,
    /// The value over the degrees of freedom.
    pub reduced: f64,
}

/// The learned error budget: factors of the stated standard deviations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "learned_budget")]
pub struct LearnedBudget {
    /// What it was learned from.
    pub learned_from: LearnedFrom,
    /// Of the position of a hit.
    pub hit_position_scale: f64,
    /// Of the direction of a hit.
    pub hit_direction_scale: f64,
    /// Of all that stays the same during a test.
    pub constant_scale: f64,
    /// Degrees of freedom of the scatter of the hits.
    pub scatter_degrees_of_freedom: u16,
    /// Standard deviation of the logarithm of `constant_scale`.
    pub constant_log_sigma: f64,
    /// Factors by which the intervals of the ten properties are wider, because the scales are uncertain.
    pub interval_widening: [f64; 10],
}

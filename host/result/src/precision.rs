//! How precise the answer is while a campaign goes on.

use serde::{Deserialize, Serialize};

/// How precise the answer is after some DOFs of a campaign. `mass` and `inertia` are relative to the mass and to m L².
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct HalfWidths {
    /// Of the mass, relative to it.
    pub mass: f64,
    /// The largest of the centre of mass.
    pub center_m: f64,
    /// The largest of the inertia tensor, relative to m L².
    pub inertia: f64,
}

/// The worst property.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct WorstProperty {
    /// Its name.
    pub property: String,
    /// Half width of its 95 % interval, in its SI unit.
    pub half_width95: f64,
    /// The same over the target; `null` without a target.
    pub over_target: Option<f64>,
}

/// A further hit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FurtherHit {
    /// The DOF.
    pub dof: String,
    /// Half width of the worst property's 95 % interval after it, in its SI unit.
    pub half_width95: f64,
}

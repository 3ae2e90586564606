//! How the methods agree.

use schemars::JsonSchema;
use serde::Serialize;

use super::Properties;

/// What all methods say together on the same data.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "agreement")]
pub struct Agreement {
    /// `agree`; `some_off` where the others agree without a few methods; `differ`; `null` where that cannot be said.
    pub outcome: Option<&'static str>,
    /// Stable name of what puts all of them in doubt.
    pub doubt: Option<&'static str>,
    /// The methods that are off.
    pub off: Vec<&'static str>,
    /// All of this as a sentence.
    pub verdict: String,
    /// The methods and their standard deviations from the changes that all of them share.
    pub methods: Vec<OfMethod>,
    /// The combined answer.
    pub combined: Option<Combined>,
    /// For every two methods the property in which they differ most.
    pub pairs: Vec<Pair>,
}

/// A method.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "of_method")]
pub struct OfMethod {
    /// Its name.
    pub method: &'static str,
    /// Standard deviations of its answer.
    pub sigma: Option<Properties<f64>>,
}

/// The combined answer, by generalised least squares.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "combined")]
pub struct Combined {
    /// The ten properties.
    pub value: Properties<f64>,
    /// Their standard deviations.
    pub sigma: Properties<f64>,
    /// Half the widths of their 95 % intervals.
    pub half_width95: Properties<f64>,
    /// Standard deviations between the methods that these contain.
    pub between_methods: Properties<f64>,
}

/// Two methods and the property in which they differ most.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "pair")]
pub struct Pair {
    /// The methods.
    pub methods: [Option<&'static str>; 2],
    /// The property.
    pub property: &'static str,
    /// The difference, in its SI unit.
    pub difference: f64,
    /// Standard deviation of the difference.
    pub sigma: f64,
    /// Whether noise alone would hardly make it.
    pub significant: bool,
}

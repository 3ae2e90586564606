//! The values of a layout file as they are written, with their JSON schemas.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;

use super::exact::array;

/// Local x and y axes.
pub(super) type RawAxes = [[f64; 3]; 2];

/// `band_hz`.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(untagged, expecting = "expected [lowest, highest] in Hz, or \"auto\"")]
pub(super) enum RawBand {
    /// The band is determined from the data.
    Named(RawBandName),
    /// Lower and upper end, Hz.
    Ends(#[serde(deserialize_with = "array")] [f64; 2]),
}

/// A band that is not a pair of numbers.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawBandName {
    /// The band is determined from the data.
    Auto,
}

/// A mass in kg, with or without its standard deviation.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a mass in kg, or { value = 0.004, sigma = 0.0002 }")]
#[schemars(rename = "mass")]
pub(super) enum RawMass {
    Number(#[schemars(range(min = 0))] f64),
    Known(RawKnown),
}

/// A value and its standard deviation.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(
    deny_unknown_fields,
    expecting = "a value with its standard deviation, such as { value = 1.23, sigma = 0.001 }"
)]
#[schemars(rename = "known")]
pub(super) struct RawKnown {
    /// The value, in the unit of the key.
    pub(super) value: f64,
    /// One standard deviation, in the same unit.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub(super) sigma: f64,
}

impl JsonSchema for RawBand {
    fn schema_name() -> Cow<'static, str> {
        "band".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "Lower and upper end in Hz, or \"auto\": from the data.",
            "oneOf": [
                {
                    "type": "array",
                    "items": { "type": "number", "exclusiveMinimum": 0 },
                    "minItems": 2,
                    "maxItems": 2,
                },
                { "const": "auto" },
            ],
        })
    }
}

/// The schema of a node number.
pub(super) enum NodeNumber {}

impl JsonSchema for NodeNumber {
    fn schema_name() -> Cow<'static, str> {
        "node_number".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "Number of a node.",
            "type": "integer",
            "minimum": 1,
            "maximum": u16::MAX,
        })
    }
}

/// The schema of a DOF.
pub(super) enum DofText {}

impl JsonSchema for DofText {
    fn schema_name() -> Cow<'static, str> {
        "dof".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "Node, colon, sign and axis: 1:+Y is a force on the body along local +y of node 1.",
            "type": "string",
            "pattern": r"^\s*[0-9]+:[+-][XYZxyz]\s*$",
        })
    }
}

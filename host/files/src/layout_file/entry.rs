//! The entries of `sensors` and `hits`, in their short forms and as tables.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, Visitor};

use super::budget::{HitKeys, SensorKeys};
use super::keyed::KeyedTable;
use super::values::{DofText, NodeNumber, RawAxes, RawMass};

/// An entry of `sensors`: a node number or a table.
#[derive(Debug)]
pub(super) struct RawSensor(pub(super) RawSensorTable);

/// A triaxial accelerometer.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table such as { node = 1 }")]
#[schemars(rename = "sensor_table")]
pub(super) struct RawSensorTable {
    /// The node where it sits.
    #[schemars(with = "NodeNumber")]
    pub(super) node: i64,
    /// The sensor's own x and y axes, unit vectors of the body frame; z = x × y. Default: the axes of its
    /// node.
    #[schemars(with = "RawAxes")]
    #[serde(default)]
    pub(super) axes: Option<RawAxes>,
    /// False for a sensor that does not sense gravity, such as a laser or a camera.
    #[serde(default)]
    #[schemars(with = "bool", extend("default" = true))]
    pub(super) senses_gravity: Option<bool>,
    /// Name of its calibration in the calibration file.
    #[serde(default)]
    #[schemars(with = "String")]
    pub(super) calibration: Option<String>,
    /// Mass that the sensor adds to the object and that is subtracted from the result, kg. A plain number has
    /// a standard deviation of 5 %.
    #[serde(default)]
    #[schemars(with = "RawMass")]
    pub(super) attached_mass_kg: Option<RawMass>,
    /// Uncertainty of this sensor, which overrides `[uncertainty]`.
    #[serde(default)]
    pub(super) uncertainty: KeyedTable<SensorKeys>,
}

/// An entry of `hits`: a DOF or a table.
#[derive(Debug)]
pub(super) struct RawHit(pub(super) RawHitTable);

/// A DOF that the hammer excites.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table such as { dof = \"1:+Y\" }")]
#[schemars(rename = "hit_table")]
pub(super) struct RawHitTable {
    /// Node, colon, sign and axis.
    #[schemars(with = "DofText")]
    pub(super) dof: String,
    /// Local x and y of this hit, unit vectors of the body frame; z = x × y. Default: the axes of its node.
    #[schemars(with = "RawAxes")]
    #[serde(default)]
    pub(super) axes: Option<RawAxes>,
    /// Uncertainty of this hit, which overrides `[uncertainty]`.
    #[serde(default)]
    pub(super) uncertainty: KeyedTable<HitKeys>,
}

impl<'de> Deserialize<'de> for RawSensor {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Entry;
        impl<'de> Visitor<'de> for Entry {
            type Value = RawSensor;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a node number such as 1, or a table such as { node = 1 }")
            }
            fn visit_i64<E: Error>(self, node: i64) -> Result<RawSensor, E> {
                Ok(RawSensor(RawSensorTable {
                    node,
                    axes: None,
                    senses_gravity: None,
                    calibration: None,
                    attached_mass_kg: None,
                    uncertainty: KeyedTable::default(),
                }))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<RawSensor, A::Error> {
                RawSensorTable::deserialize(MapAccessDeserializer::new(map)).map(RawSensor)
            }
        }
        deserializer.deserialize_any(Entry)
    }
}

impl<'de> Deserialize<'de> for RawHit {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Entry;
        impl<'de> Visitor<'de> for Entry {
            type Value = RawHit;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a DOF such as \"1:+Y\", or a table such as { dof = \"1:+Y\" }")
            }
            fn visit_str<E: Error>(self, dof: &str) -> Result<RawHit, E> {
                Ok(RawHit(RawHitTable {
                    dof: dof.into(),
                    axes: None,
                    uncertainty: KeyedTable::default(),
                }))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<RawHit, A::Error> {
                RawHitTable::deserialize(MapAccessDeserializer::new(map)).map(RawHit)
            }
        }
        deserializer.deserialize_any(Entry)
    }
}

impl JsonSchema for RawSensor {
    fn schema_name() -> Cow<'static, str> {
        "sensor".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "The number of the node where a sensor sits, or a table.",
            "oneOf": [
                generator.subschema_for::<NodeNumber>(),
                generator.subschema_for::<RawSensorTable>(),
            ],
        })
    }
}

impl JsonSchema for RawHit {
    fn schema_name() -> Cow<'static, str> {
        "hit".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A DOF, or a table.",
            "oneOf": [
                generator.subschema_for::<DofText>(),
                generator.subschema_for::<RawHitTable>(),
            ],
        })
    }
}

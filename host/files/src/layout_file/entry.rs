//! The entries of `sensors` and `hits`, in their short forms and as tables.

use std::fmt;

use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, Visitor};

use super::budget::{HitKeys, SensorKeys};
use super::keyed::KeyedTable;
use super::values::{RawAxes, RawMass};

/// An entry of `sensors`: a node number or a table.
#[derive(Debug)]
pub(super) struct RawSensor(pub(super) RawSensorTable);

/// A triaxial accelerometer.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, expecting = "a table such as { node = 1 }")]
pub(super) struct RawSensorTable {
    /// The node where it sits.
    #[cfg_attr(feature = "schema", schemars(with = "super::schema::NodeNumber"))]
    pub(super) node: i64,
    /// The sensor's own x and y axes, unit vectors of the body frame; z = x × y. Default: the axes of its
    /// node.
    #[cfg_attr(feature = "schema", schemars(with = "RawAxes"))]
    #[serde(default)]
    pub(super) axes: Option<RawAxes>,
    /// False for a sensor that does not sense gravity, such as a laser or a camera.
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(with = "bool", extend("default" = true)))]
    pub(super) senses_gravity: Option<bool>,
    /// Name of its calibration in the calibration file.
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(with = "String"))]
    pub(super) calibration: Option<String>,
    /// Mass that the sensor adds to the object and that is subtracted from the result, kg. A plain number has
    /// a standard deviation of 5 %.
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(with = "RawMass"))]
    pub(super) attached_mass_kg: Option<RawMass>,
    /// Uncertainty of this sensor, which overrides `[uncertainty]`.
    #[serde(default)]
    pub(super) uncertainty: KeyedTable<SensorKeys>,
}

/// An entry of `hits`: a DOF or a table.
#[derive(Debug)]
pub(super) struct RawHit(pub(super) RawHitTable);

/// A DOF that the hammer excites.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, expecting = "a table such as { dof = \"1:+Y\" }")]
pub(super) struct RawHitTable {
    /// Node, colon, sign and axis.
    #[cfg_attr(feature = "schema", schemars(with = "super::schema::DofText"))]
    pub(super) dof: String,
    /// Local x and y of this hit, unit vectors of the body frame; z = x × y. Default: the axes of its node.
    #[cfg_attr(feature = "schema", schemars(with = "RawAxes"))]
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

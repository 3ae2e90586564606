//! The layout file as it is written: serde's view, nothing checked beyond types.

use std::fmt;

use massline_shared::layout::FrfEstimator;
use massline_shared::mass_line::Terms;
use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use toml::Spanned;

/// The whole file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawLayout {
    #[serde(default)]
    pub(super) title: Option<Spanned<String>>,
    #[serde(default)]
    pub(super) gravity: Option<Spanned<[f64; 3]>>,
    pub(super) sensors: Option<Vec<Spanned<RawSensor>>>,
    pub(super) hits: Option<Vec<Spanned<RawHit>>>,
    #[serde(default)]
    pub(super) node: Vec<RawNode>,
    #[serde(default)]
    pub(super) test: Option<RawTest>,
    #[serde(default)]
    pub(super) policy: RawPolicy,
    #[serde(default)]
    pub(super) uncertainty: Option<RawUncertainty>,
    #[serde(default)]
    pub(super) prior: Option<RawPrior>,
    #[serde(default)]
    pub(super) attached: Vec<RawAttached>,
    #[serde(default)]
    pub(super) reference: Option<RawReference>,
}

/// Local x and y.
pub(super) type RawAxes = [[f64; 3]; 2];

/// A `[[node]]`.
#[derive(Debug, Deserialize)]
#[serde(
    deny_unknown_fields,
    expecting = "a table [[node]] such as { id = 1, position_m = [0, 0, 0] }"
)]
pub(super) struct RawNode {
    pub(super) id: Spanned<i64>,
    pub(super) position_m: Spanned<[f64; 3]>,
    #[serde(default)]
    pub(super) axes: Option<Spanned<RawAxes>>,
    #[serde(default)]
    pub(super) can_carry_sensor: Option<bool>,
    #[serde(default)]
    pub(super) can_hit: Option<Vec<Spanned<String>>>,
}

/// An entry of `sensors` when it is a table.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table such as { node = 1 }")]
pub(super) struct RawSensorTable {
    pub(super) node: i64,
    #[serde(default)]
    pub(super) axes: Option<RawAxes>,
    #[serde(default)]
    pub(super) senses_gravity: Option<bool>,
    #[serde(default)]
    pub(super) calibration: Option<String>,
    #[serde(default)]
    pub(super) attached_mass_kg: Option<RawMass>,
    #[serde(default)]
    pub(super) uncertainty: Option<RawSensorUncertainty>,
}

/// `uncertainty` of one sensor.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table such as { gain = 0.01 }")]
pub(super) struct RawSensorUncertainty {
    pub(super) sensor_position_m: Option<f64>,
    pub(super) sensor_rotation_rad: Option<f64>,
    pub(super) gain: Option<f64>,
    pub(super) cross_axis: Option<f64>,
}

/// An entry of `hits` when it is a table.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table such as { dof = \"1:+Y\" }")]
pub(super) struct RawHitTable {
    pub(super) dof: String,
    #[serde(default)]
    pub(super) axes: Option<RawAxes>,
    #[serde(default)]
    pub(super) uncertainty: Option<RawHitUncertainty>,
}

/// `uncertainty` of one hit.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table such as { hit_position_m = 0.002 }")]
pub(super) struct RawHitUncertainty {
    pub(super) hit_position_m: Option<f64>,
    pub(super) hit_direction_rad: Option<f64>,
    pub(super) node_position_m: Option<f64>,
    pub(super) node_direction_rad: Option<f64>,
}

/// `band_hz`.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(untagged, expecting = "expected [lowest, highest] in Hz, or \"auto\"")]
pub(super) enum RawBand {
    /// From the data.
    Named(RawBandName),
    /// Lower and upper end, Hz.
    Ends([f64; 2]),
}

/// A band that is no pair of numbers.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawBandName {
    /// From the data.
    Auto,
}

/// `[test]`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [test]")]
pub(super) struct RawTest {
    pub(super) hits_per_dof: Option<Spanned<i64>>,
    pub(super) band_hz: Option<Spanned<RawBand>>,
    pub(super) exponential_decay_per_s: Option<Spanned<f64>>,
    pub(super) force_window_s: Option<Spanned<f64>>,
    pub(super) trigger_n: Option<Spanned<f64>>,
    pub(super) min_peak_force_n: Option<Spanned<f64>>,
    pub(super) frf_estimator: Option<FrfEstimator>,
    pub(super) terms: Option<Terms>,
}

/// `[policy]`: what is done with a hit that has a fault.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [policy]")]
pub(super) struct RawPolicy {
    pub(super) overload: Option<RawVerdict>,
    pub(super) too_weak: Option<RawVerdict>,
    pub(super) too_hard: Option<RawVerdict>,
    pub(super) double_hit: Option<RawVerdict>,
    pub(super) force_spectrum_low: Option<RawVerdict>,
    pub(super) pre_trigger_not_quiet: Option<RawVerdict>,
    pub(super) clipped_record: Option<RawVerdict>,
    pub(super) trigger_too_early: Option<RawVerdict>,
    pub(super) duplicate_hit: Option<RawVerdict>,
    pub(super) hit_inconsistent: Option<RawVerdict>,
    pub(super) motion_not_rigid: Option<RawVerdict>,
}

/// A verdict by its name.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawVerdict {
    Keep,
    Warn,
    Reject,
}

/// `[uncertainty]`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [uncertainty]")]
pub(super) struct RawUncertainty {
    pub(super) hit_position_m: Option<Spanned<f64>>,
    pub(super) hit_direction_rad: Option<Spanned<f64>>,
    pub(super) sensor_position_m: Option<Spanned<f64>>,
    pub(super) sensor_rotation_rad: Option<Spanned<f64>>,
    pub(super) gain: Option<Spanned<f64>>,
    pub(super) cross_axis: Option<Spanned<f64>>,
    pub(super) hammer_gain: Option<Spanned<f64>>,
    pub(super) node_position_m: Option<Spanned<f64>>,
    pub(super) node_direction_rad: Option<Spanned<f64>>,
}

/// `[prior]`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [prior]")]
#[allow(non_snake_case, reason = "the names of the properties")]
pub(super) struct RawPrior {
    pub(super) mass_kg: Option<Spanned<RawKnown>>,
    pub(super) cx_m: Option<Spanned<RawKnown>>,
    pub(super) cy_m: Option<Spanned<RawKnown>>,
    pub(super) cz_m: Option<Spanned<RawKnown>>,
    pub(super) Jxx_kg_m2: Option<Spanned<RawKnown>>,
    pub(super) Jyy_kg_m2: Option<Spanned<RawKnown>>,
    pub(super) Jzz_kg_m2: Option<Spanned<RawKnown>>,
    pub(super) Jxy_kg_m2: Option<Spanned<RawKnown>>,
    pub(super) Jxz_kg_m2: Option<Spanned<RawKnown>>,
    pub(super) Jyz_kg_m2: Option<Spanned<RawKnown>>,
}

/// A mass: a number in kg, or with its standard deviation.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(untagged, expecting = "a mass in kg, or { value = 0.004, sigma = 0.0002 }")]
pub(super) enum RawMass {
    Number(f64),
    Known(RawKnown),
}

/// An `[[attached]]`: a body that hangs on the object but does not belong to it.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [[attached]]")]
pub(super) struct RawAttached {
    pub(super) mass_kg: Spanned<RawKnown>,
    pub(super) center_of_mass_m: Spanned<[f64; 3]>,
    #[serde(default)]
    pub(super) inertia_kg_m2: Option<Spanned<[[f64; 3]; 3]>>,
}

/// A known value and its standard deviation.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(
    deny_unknown_fields,
    expecting = "a value with its standard deviation, such as { value = 1.23, sigma = 0.001 }"
)]
pub(super) struct RawKnown {
    pub(super) value: f64,
    pub(super) sigma: f64,
}

/// `[reference]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [reference]")]
pub(super) struct RawReference {
    pub(super) mass_kg: Option<Spanned<f64>>,
    pub(super) center_of_mass_m: Option<Spanned<[f64; 3]>>,
    pub(super) inertia_kg_m2: Option<Spanned<[[f64; 3]; 3]>>,
}

/// An entry of `sensors`: a node number or a table.
#[derive(Debug)]
pub(super) struct RawSensor(pub(super) RawSensorTable);

/// An entry of `hits`: a DOF or a table.
#[derive(Debug)]
pub(super) struct RawHit(pub(super) RawHitTable);

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
                    uncertainty: None,
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
                Ok(RawHit(RawHitTable { dof: dof.into(), axes: None, uncertainty: None }))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<RawHit, A::Error> {
                RawHitTable::deserialize(MapAccessDeserializer::new(map)).map(RawHit)
            }
        }
        deserializer.deserialize_any(Entry)
    }
}

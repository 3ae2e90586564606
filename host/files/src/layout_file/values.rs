//! The values of a layout file as they are written.

use std::fmt;

use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Unexpected, Visitor};

/// Local x and y axes.
pub(super) type RawAxes = [[f64; 3]; 2];

/// `band_hz`.
#[derive(Clone, Copy, Debug)]
pub(super) enum RawBand {
    /// The band is determined from the data.
    Auto,
    /// Lower and upper end, Hz.
    Ends([f64; 2]),
}

/// A mass in kg, with or without its standard deviation.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(untagged))]
pub(super) enum RawMass {
    Number(#[cfg_attr(feature = "schema", schemars(range(min = 0)))] f64),
    Known(RawKnown),
}

/// A value and its standard deviation.
#[derive(Clone, Copy, Debug, serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(
    deny_unknown_fields,
    expecting = "a value with its standard deviation, such as { value = 1.23, sigma = 0.001 }"
)]
pub(super) struct RawKnown {
    /// The value, in the unit of the key.
    pub(super) value: f64,
    /// One standard deviation, in the same unit.
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub(super) sigma: f64,
}

impl<'de> Deserialize<'de> for RawBand {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Band;
        impl<'de> Visitor<'de> for Band {
            type Value = RawBand;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("[lowest, highest] in Hz, or \"auto\",")
            }
            fn visit_str<E: Error>(self, text: &str) -> Result<RawBand, E> {
                match text {
                    "auto" => Ok(RawBand::Auto),
                    _ => Err(E::invalid_value(Unexpected::Str(text), &self)),
                }
            }
            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<RawBand, A::Error> {
                let ends: Vec<f64> = Deserialize::deserialize(SeqAccessDeserializer::new(list))?;
                let count = ends.len();
                let ends = ends.try_into().map_err(|_| A::Error::invalid_length(count, &self))?;
                Ok(RawBand::Ends(ends))
            }
        }
        deserializer.deserialize_any(Band)
    }
}

impl<'de> Deserialize<'de> for RawMass {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Mass;
        impl<'de> Visitor<'de> for Mass {
            type Value = RawMass;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a mass in kg, such as 0.004 or { value = 0.004, sigma = 0.0002 },")
            }
            fn visit_i64<E: Error>(self, mass: i64) -> Result<RawMass, E> {
                Ok(RawMass::Number(mass as f64))
            }
            fn visit_f64<E: Error>(self, mass: f64) -> Result<RawMass, E> {
                Ok(RawMass::Number(mass))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<RawMass, A::Error> {
                RawKnown::deserialize(MapAccessDeserializer::new(map)).map(RawMass::Known)
            }
        }
        deserializer.deserialize_any(Mass)
    }
}

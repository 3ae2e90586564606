//! Tables whose keys are listed and described outside of this crate: `[uncertainty]`, also that of a sensor or hit, and
//! `[policy]`.

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;
use std::sync::LazyLock;

use massline_shared::layout::{
    HitPolicy, HitTreatment, HitUncertainty, SensorUncertainty, UncertaintyKey, uncertainty_keys,
};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, Visitor};
use serde_json::Map;
use toml::Spanned;

/// Which keys a table has.
pub(super) trait TableKeys {
    /// What a key states.
    type Value;
    /// How the table is written, for errors.
    const WRITTEN: &'static str;
    /// Its name in the schema.
    const NAME: &'static str;
    /// What it is for.
    const MEANING: &'static str;

    /// The names of the keys.
    fn names() -> &'static [&'static str];

    /// Reads the value of a key.
    fn read<'de, A: MapAccess<'de>>(
        name: &'static str,
        map: &mut A,
    ) -> Result<Self::Value, A::Error>;

    /// The schema of a key, with its description: that of a standard deviation, unless a table says otherwise.
    fn schema(name: &str) -> Schema {
        sigma_schema(name)
    }
}

/// What a table states, key by key.
pub(super) struct KeyedTable<K: TableKeys>(Vec<(&'static str, K::Value)>);

impl<K: TableKeys> KeyedTable<K> {
    /// What is stated for a key.
    pub(super) fn get(&self, name: &str) -> Option<&K::Value> {
        self.0.iter().find(|(own, _)| *own == name).map(|(_, value)| value)
    }
}

impl<K: TableKeys> Default for KeyedTable<K> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<K: TableKeys<Value: fmt::Debug>> fmt::Debug for KeyedTable<K> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_map().entries(self.0.iter().map(|(name, value)| (name, value))).finish()
    }
}

impl<'de, K: TableKeys> Deserialize<'de> for KeyedTable<K> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(TableVisitor(PhantomData))
    }
}

struct TableVisitor<K>(PhantomData<K>);

impl<'de, K: TableKeys> Visitor<'de> for TableVisitor<K> {
    type Value = KeyedTable<K>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(K::WRITTEN)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<KeyedTable<K>, A::Error> {
        let mut stated = KeyedTable::default();
        while let Some(name) = map.next_key_seed(KeyName(K::names()))? {
            stated.0.push((name, K::read(name, &mut map)?));
        }
        Ok(stated)
    }
}

/// One of these names; an error about another one has its place.
struct KeyName(&'static [&'static str]);

impl<'de> DeserializeSeed<'de> for KeyName {
    type Value = &'static str;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<&'static str, D::Error> {
        deserializer.deserialize_identifier(self)
    }
}

impl Visitor<'_> for KeyName {
    type Value = &'static str;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a key")
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<&'static str, E> {
        let known = self.0.iter().find(|known| **known == name);
        known.copied().ok_or_else(|| E::unknown_field(name, self.0))
    }
}

impl<K: TableKeys> JsonSchema for KeyedTable<K> {
    fn schema_name() -> Cow<'static, str> {
        K::NAME.into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let property = |name: &&str| ((*name).to_owned(), K::schema(name).to_value());
        let properties: Map<_, _> = K::names().iter().map(property).collect();
        json_schema!({
            "description": K::MEANING,
            "type": "object",
            "properties": properties,
            "additionalProperties": false,
        })
    }
}

/// The key of `[uncertainty]` that is no standard deviation.
const LEARN: &str = "learn";

/// The keys of `[uncertainty]`.
pub(super) struct BudgetKeys;

/// A value of `[uncertainty]`.
#[derive(Debug)]
pub(super) enum BudgetValue {
    /// A standard deviation.
    Sigma(Spanned<f64>),
    /// Whether the data may correct the budget.
    Learn(bool),
}

impl KeyedTable<BudgetKeys> {
    /// The standard deviation that is stated for a key.
    pub(super) fn sigma(&self, name: &str) -> Option<&Spanned<f64>> {
        match self.get(name) {
            Some(BudgetValue::Sigma(sigma)) => Some(sigma),
            Some(BudgetValue::Learn(_)) | None => None,
        }
    }

    /// Whether the data may correct the budget, where it is stated.
    pub(super) fn learn(&self) -> Option<bool> {
        match self.get(LEARN) {
            Some(BudgetValue::Learn(learn)) => Some(*learn),
            Some(BudgetValue::Sigma(_)) | None => None,
        }
    }
}

impl TableKeys for BudgetKeys {
    type Value = BudgetValue;
    const WRITTEN: &'static str = "a table [uncertainty]";
    const NAME: &'static str = "uncertainty";
    const MEANING: &'static str = "The error budget: one standard deviation of each error source. What is not stated is \
                                   the default; `gain`, `cross_axis` and `hammer_gain` then follow the \
                                   calibration, if there is one.";

    fn names() -> &'static [&'static str] {
        static NAMES: LazyLock<Vec<&str>> =
            LazyLock::new(|| uncertainty_keys().map(|key| key.name).chain([LEARN]).collect());
        &NAMES
    }

    fn read<'de, A: MapAccess<'de>>(
        name: &'static str,
        map: &mut A,
    ) -> Result<BudgetValue, A::Error> {
        match name {
            LEARN => map.next_value().map(BudgetValue::Learn),
            _ => map.next_value().map(BudgetValue::Sigma),
        }
    }

    fn schema(name: &str) -> Schema {
        match name {
            LEARN => json_schema!({
                "description": "True when the data may correct the budget; false to use it as stated.",
                "type": "boolean",
                "default": true,
            }),
            _ => sigma_schema(name),
        }
    }
}

/// The keys of the uncertainty of one sensor.
pub(super) struct SensorKeys;

impl TableKeys for SensorKeys {
    type Value = Spanned<f64>;
    const WRITTEN: &'static str = "a table such as { gain = 0.01 }";
    const NAME: &'static str = "sensor_uncertainty";
    const MEANING: &'static str = "Standard deviations of a sensor's errors.";

    fn names() -> &'static [&'static str] {
        static NAMES: LazyLock<Vec<&str>> = LazyLock::new(|| names(SensorUncertainty::<f64>::KEYS));
        &NAMES
    }

    fn read<'de, A: MapAccess<'de>>(
        _: &'static str,
        map: &mut A,
    ) -> Result<Spanned<f64>, A::Error> {
        map.next_value()
    }
}

/// The keys of the uncertainty of one hit.
pub(super) struct HitKeys;

impl TableKeys for HitKeys {
    type Value = Spanned<f64>;
    const WRITTEN: &'static str = "a table such as { hit_position_m = 0.002 }";
    const NAME: &'static str = "hit_uncertainty";
    const MEANING: &'static str = "Standard deviations of a hit's errors.";

    fn names() -> &'static [&'static str] {
        static NAMES: LazyLock<Vec<&str>> = LazyLock::new(|| names(HitUncertainty::<f64>::KEYS));
        &NAMES
    }

    fn read<'de, A: MapAccess<'de>>(
        _: &'static str,
        map: &mut A,
    ) -> Result<Spanned<f64>, A::Error> {
        map.next_value()
    }
}

fn names(keys: &[UncertaintyKey]) -> Vec<&'static str> {
    keys.iter().map(|key| key.name).collect()
}

fn sigma_schema(name: &str) -> Schema {
    let key = uncertainty_keys().find(|key| key.name == name);
    let description = key.map(|key| format!("{}, {}.", key.meaning, key.unit.name()));
    json_schema!({ "description": description, "type": "number", "minimum": 0 })
}

/// The keys of `[policy]`: the faults of a hit.
pub(super) struct PolicyKeys;

impl TableKeys for PolicyKeys {
    type Value = HitTreatment;
    const WRITTEN: &'static str = "a table [policy]";
    const NAME: &'static str = "policy";
    const MEANING: &'static str = "How hits with a fault are treated: keep the hit, keep it with a warning, or reject it \
                                   so that it must be repeated.";

    fn names() -> &'static [&'static str] {
        static NAMES: LazyLock<Vec<&str>> =
            LazyLock::new(|| HitPolicy::CODES.iter().map(|code| code.name()).collect());
        &NAMES
    }

    fn read<'de, A: MapAccess<'de>>(
        _: &'static str,
        map: &mut A,
    ) -> Result<HitTreatment, A::Error> {
        map.next_value_seed(TreatmentName)
    }

    fn schema(name: &str) -> Schema {
        let code = HitPolicy::CODES.into_iter().find(|code| code.name() == name);
        json_schema!({
            "description": code.map(|code| code.meaning()),
            "type": "string",
            "enum": HitTreatment::NAMES,
        })
    }
}

/// Reads a treatment by its name.
struct TreatmentName;

impl<'de> DeserializeSeed<'de> for TreatmentName {
    type Value = HitTreatment;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<HitTreatment, D::Error> {
        deserializer.deserialize_str(self)
    }
}

impl Visitor<'_> for TreatmentName {
    type Value = HitTreatment;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, second, third] = HitTreatment::NAMES;
        write!(f, "\"{first}\", \"{second}\" or \"{third}\"")
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<HitTreatment, E> {
        HitTreatment::from_name(name).ok_or_else(|| E::unknown_variant(name, &HitTreatment::NAMES))
    }
}

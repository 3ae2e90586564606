//! Tables whose keys are listed and described outside of this crate: `[test]`, `[target]`, `[prior]`, `[policy]`, and
//! `[uncertainty]`, also that of a sensor or hit.

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

use massline_shared::diagnosis::{AllowedValues, MAX_HITS_PER_DOF};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, Visitor};
use serde_json::Map;

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

    /// The schema of a key, with its description.
    fn schema(name: &str, generator: &mut SchemaGenerator) -> Schema;
}

/// What a table states, key by key.
pub(super) struct KeyedTable<K: TableKeys>(Vec<(&'static str, K::Value)>);

impl<K: TableKeys> KeyedTable<K> {
    /// What is stated for a key.
    pub(super) fn get(&self, name: &str) -> Option<&K::Value> {
        self.0.iter().find(|(own, _)| *own == name).map(|(_, value)| value)
    }

    /// Takes what is stated for a key out of the table.
    pub(super) fn take(&mut self, name: &str) -> Option<K::Value> {
        let place = self.0.iter().position(|(own, _)| *own == name)?;
        Some(self.0.swap_remove(place).1)
    }

    /// States something for a key that has nothing.
    pub(super) fn insert(&mut self, name: &'static str, value: K::Value) {
        self.0.push((name, value));
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

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let property = |name: &&str| ((*name).to_owned(), K::schema(name, generator).to_value());
        let properties: Map<_, _> = K::names().iter().map(property).collect();
        json_schema!({
            "description": K::MEANING,
            "type": "object",
            "properties": properties,
            "additionalProperties": false,
        })
    }
}

/// `"a", "b" or "c"`.
pub(super) fn alternatives(words: &[&str]) -> String {
    let quoted: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
    quoted
        .split_last()
        .map_or_else(String::new, |(last, others)| format!("{} or {last}", others.join(", ")))
}

/// Reads one of these words.
pub(super) struct OneOf(pub(super) &'static [&'static str]);

impl<'de> DeserializeSeed<'de> for OneOf {
    type Value = &'static str;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<&'static str, D::Error> {
        deserializer.deserialize_str(self)
    }
}

impl Visitor<'_> for OneOf {
    type Value = &'static str;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&alternatives(self.0))
    }

    fn visit_str<E: Error>(self, word: &str) -> Result<&'static str, E> {
        let known = self.0.iter().find(|known| **known == word);
        known.copied().ok_or_else(|| E::unknown_variant(word, self.0))
    }
}

/// The schema of a number.
pub(super) fn number_schema(allowed: AllowedValues) -> Schema {
    match allowed {
        AllowedValues::HitCount => {
            json_schema!({ "type": "integer", "minimum": 1, "maximum": MAX_HITS_PER_DOF })
        }
        AllowedValues::NotNegative => json_schema!({ "type": "number", "minimum": 0 }),
        AllowedValues::Positive => json_schema!({ "type": "number", "exclusiveMinimum": 0 }),
    }
}

/// A meaning as a sentence of its own.
pub(super) fn sentence(meaning: &str) -> String {
    let mut letters = meaning.chars();
    let first = letters.next().map(char::to_uppercase);
    first.into_iter().flatten().chain(letters).chain(['.']).collect()
}

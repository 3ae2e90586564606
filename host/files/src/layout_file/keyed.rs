//! Tables whose keys are listed and described outside of this crate: `[test]`, `[target]`, `[prior]`, `[policy]`, and
//! `[uncertainty]`, also that of a sensor or hit.

use std::fmt;
use std::marker::PhantomData;

use serde::Deserialize;
use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, Visitor};

/// Which keys a table has.
pub(super) trait TableKeys {
    /// What a key states.
    type Value;
    /// How the table is written, for errors.
    const WRITTEN: &'static str;

    /// The names of the keys.
    fn names() -> &'static [&'static str];

    /// Reads the value of a key.
    fn read<'de, A: MapAccess<'de>>(
        name: &'static str,
        map: &mut A,
    ) -> Result<Self::Value, A::Error>;
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

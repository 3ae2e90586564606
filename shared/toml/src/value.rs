//! A value of a TOML text as serde's readers take it.

use std::num::IntErrorKind;
use std::ops::Range;
use std::vec;

use serde::de::value::StringDeserializer;
use serde::de::{
    DeserializeSeed, Deserializer, Error, Expected, IntoDeserializer, MapAccess, SeqAccess,
    Unexpected, Visitor,
};
use serde_spanned::de::{SpannedDeserializer, is_spanned};
use toml::Spanned;
use toml::de::{DeFloat, DeInteger, DeString, DeTable, DeValue};

use super::refusal::{Form, Place, Refusal};

/// A value and where it stands in the text.
pub(super) struct Value<'de> {
    value: DeValue<'de>,
    span: Range<usize>,
    text: &'de str,
}

impl<'de> Value<'de> {
    /// The table of a whole text.
    pub(super) fn of_text(root: Spanned<DeTable<'de>>, text: &'de str) -> Self {
        Self { span: root.span(), value: DeValue::Table(root.into_inner()), text }
    }

    fn of(spanned: Spanned<DeValue<'de>>, text: &'de str) -> Self {
        Self { span: spanned.span(), value: spanned.into_inner(), text }
    }

    /// Where it stands, and how it is written.
    fn place(&self) -> Place {
        let has_braces = |span: &Range<usize>| {
            self.text.get(span.clone()).is_some_and(|written| written.starts_with('{'))
        };
        let form = match &self.value {
            DeValue::Table(_) if !has_braces(&self.span) => Form::Table,
            DeValue::Array(array) => match array.iter().next() {
                Some(first) if first.get_ref().is_table() && !has_braces(&first.span()) => {
                    Form::Tables
                }
                _ => Form::Value,
            },
            _ => Form::Value,
        };
        Place { span: self.span.clone(), form }
    }

    /// A value of another kind than is wanted.
    fn refused(&self, wanted: &dyn Expected) -> Refusal {
        Refusal::invalid_type(Unexpected::Other("value"), wanted).at(&self.place())
    }

    /// Reads a list of this length.
    fn list_of<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Refusal> {
        match &self.value {
            DeValue::Array(array) if array.len() != length => {
                Err(Refusal::length(array.len(), length).at(&self.place()))
            }
            _ => self.deserialize_any(visitor),
        }
    }
}

impl<'de> IntoDeserializer<'de, Refusal> for Value<'de> {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

impl<'de> Deserializer<'de> for Value<'de> {
    type Error = Refusal;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        let (place, text) = (self.place(), self.text);
        let of_kind = match self.value {
            DeValue::Array(array) => visitor.visit_seq(Elements { rest: array.into_iter(), text }),
            DeValue::Table(table) => {
                visitor.visit_map(Entries { rest: table.into_iter(), value: None, text })
            }
            DeValue::String(DeString::Owned(text)) => visitor.visit_string(text),
            DeValue::String(DeString::Borrowed(text)) => visitor.visit_borrowed_str(text),
            DeValue::Boolean(value) => visitor.visit_bool(value),
            DeValue::Integer(number) => {
                integer(&number, &visitor).and_then(|number| visitor.visit_i64(number))
            }
            DeValue::Float(number) => float(&number).and_then(|number| visitor.visit_f64(number)),
            DeValue::Datetime(_) => Err(Refusal::invalid_type(Unexpected::Other("date"), &visitor)),
        };
        of_kind.map_err(|refusal| refusal.at(&place))
    }

    /// A key that is left out is none, and one that is there has a value.
    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        let place = self.place();
        visitor.visit_some(self).map_err(|refusal| refusal.at(&place))
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        let place = self.place();
        visitor.visit_newtype_struct(self).map_err(|refusal| refusal.at(&place))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        if is_spanned(name) {
            let place = self.place();
            return visitor
                .visit_map(SpannedDeserializer::new(self, place.span.clone()))
                .map_err(|refusal| refusal.at(&place));
        }
        match self.value {
            DeValue::Table(_) => self.deserialize_any(visitor),
            _ => Err(self.refused(&visitor)),
        }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        let place = self.place();
        match self.value {
            DeValue::String(name) => {
                let name: StringDeserializer<Refusal> = name.into_owned().into_deserializer();
                visitor.visit_enum(name).map_err(|refusal| refusal.at(&place))
            }
            _ => Err(self.refused(&"a string")),
        }
    }

    fn deserialize_tuple<V: Visitor<'de>>(
        self,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        self.list_of(length, visitor)
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        self.list_of(length, visitor)
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf
        unit unit_struct seq map identifier ignored_any
    }
}

/// The value of a whole number.
fn integer(number: &DeInteger, wanted: &dyn Expected) -> Result<i64, Refusal> {
    i64::from_str_radix(&number.as_str().replace('_', ""), number.radix()).map_err(|error| {
        match error.kind() {
            IntErrorKind::Empty => Refusal::invalid_type(Unexpected::Other("nothing"), wanted),
            _ => Refusal::too_large(),
        }
    })
}

/// The value of any other number.
fn float(number: &DeFloat) -> Result<f64, Refusal> {
    match number.as_str().replace('_', "").parse::<f64>() {
        // Infinity is written as a word; a number as large as that is a mistake.
        Ok(value) if value.is_finite() || number.as_str().ends_with(['f', 'n']) => Ok(value),
        _ => Err(Refusal::too_large()),
    }
}

struct Elements<'de> {
    rest: vec::IntoIter<Spanned<DeValue<'de>>>,
    text: &'de str,
}

impl<'de> SeqAccess<'de> for Elements<'de> {
    type Error = Refusal;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Refusal> {
        let Some(element) = self.rest.next() else { return Ok(None) };
        let value = Value::of(element, self.text);
        // What is wrong with a value may show only after it has been read.
        let place = value.place();
        seed.deserialize(value).map(Some).map_err(|refusal| refusal.at(&place))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.rest.len())
    }
}

struct Entries<'de, I> {
    rest: I,
    /// The key that was read last, and its value.
    value: Option<(String, Value<'de>)>,
    text: &'de str,
}

impl<'de, I> MapAccess<'de> for Entries<'de, I>
where
    I: Iterator<Item = (Spanned<DeString<'de>>, Spanned<DeValue<'de>>)>,
{
    type Error = Refusal;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, Refusal> {
        let Some((key, value)) = self.rest.next() else { return Ok(None) };
        let name = key.get_ref().clone().into_owned();
        self.value = Some((name.clone(), Value::of(value, self.text)));
        let of_key: StringDeserializer<Refusal> = name.clone().into_deserializer();
        seed.deserialize(of_key).map(Some).map_err(|refusal| {
            refusal.at(&Place { span: key.span(), form: Form::Value }).under(&name)
        })
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Refusal> {
        let Some((name, value)) = self.value.take() else {
            return Err(Refusal::custom("a value was asked for without its key"));
        };
        let place = value.place();
        seed.deserialize(value).map_err(|refusal| refusal.at(&place).under(&name))
    }

    fn size_hint(&self) -> Option<usize> {
        self.rest.size_hint().1
    }
}

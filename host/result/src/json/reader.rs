//! A value as serde's types read it.

use serde::de::value::StrDeserializer;
use serde::de::{
    DeserializeSeed, Deserializer, EnumAccess, Error, Expected, IntoDeserializer, MapAccess,
    SeqAccess, VariantAccess, Visitor,
};

use super::Location;
use super::error::ReadFailure;
use super::value::Value;

/// Reads one value.
#[derive(Clone, Copy)]
pub(super) struct Reader<'a> {
    value: &'a Value,
    location: &'a Location<'a>,
}

impl<'a> Reader<'a> {
    pub(super) fn new(value: &'a Value, location: &'a Location<'a>) -> Self {
        Self { value, location }
    }

    /// A value of another kind than is wanted.
    fn refused(&self, wanted: &dyn Expected) -> ReadFailure {
        ReadFailure::invalid_type(self.value.unexpected(), wanted)
    }

    /// The number, if it is one.
    fn read_number(&self, wanted: &dyn Expected) -> Result<f64, ReadFailure> {
        match *self.value {
            Value::Natural(number) => Ok(number as f64),
            Value::Negative(number) => Ok(number as f64),
            Value::Number(number) => Ok(number),
            _ => Err(self.refused(wanted)),
        }
    }

    fn read_whole<'de, V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ReadFailure> {
        match *self.value {
            Value::Natural(number) => visitor.visit_u64(number),
            Value::Negative(number) => visitor.visit_i64(number),
            _ => Err(self.refused(&visitor)),
        }
    }

    fn read_text<'de, V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ReadFailure> {
        match self.value {
            Value::Text(text) => visitor.visit_str(text),
            _ => Err(self.refused(&visitor)),
        }
    }

    fn read_list<'de, V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ReadFailure> {
        let Some(length) = self.value.length() else { return Err(self.refused(&visitor)) };
        let mut elements = Elements { list: self.value, location: self.location, length, next: 0 };
        let read = visitor.visit_seq(&mut elements)?;
        elements.end()?;
        Ok(read)
    }

    fn read_object<'de, V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ReadFailure> {
        match self.value {
            Value::Object(entries) => {
                visitor.visit_map(Entries { rest: entries, value: None, location: self.location })
            }
            _ => Err(self.refused(&visitor)),
        }
    }
}

/// The methods of values that are read alike.
macro_rules! read_as {
    ($($method:ident)* => $read:ident) => {
        $(fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ReadFailure> {
            self.$read(visitor)
        })*
    };
}

impl<'de> Deserializer<'de> for Reader<'_> {
    type Error = ReadFailure;

    read_as! {
        deserialize_i8 deserialize_i16 deserialize_i32 deserialize_i64
        deserialize_u8 deserialize_u16 deserialize_u32 deserialize_u64 => read_whole
    }
    read_as! { deserialize_char deserialize_str deserialize_string deserialize_identifier => read_text }
    read_as! { deserialize_bytes deserialize_byte_buf deserialize_seq => read_list }
    read_as! { deserialize_map => read_object }

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ReadFailure> {
        match self.value {
            Value::Null => visitor.visit_unit(),
            Value::Bool(value) => visitor.visit_bool(*value),
            Value::Natural(number) => visitor.visit_u64(*number),
            Value::Negative(number) => visitor.visit_i64(*number),
            Value::Number(number) => visitor.visit_f64(*number),
            Value::Text(text) => visitor.visit_str(text),
            Value::List(_) | Value::Naturals(_) | Value::Numbers(_) => self.read_list(visitor),
            Value::Object(_) => self.read_object(visitor),
        }
    }

    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ReadFailure> {
        match self.value {
            Value::Bool(value) => visitor.visit_bool(*value),
            _ => Err(self.refused(&visitor)),
        }
    }

    fn deserialize_f32<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ReadFailure> {
        let number = match *self.value {
            Value::Natural(number) => number as f32,
            Value::Negative(number) => number as f32,
            Value::Number(number) => single(number),
            _ => return Err(self.refused(&visitor)),
        };
        if !number.is_finite() {
            return Err(ReadFailure::custom("number out of range"));
        }
        visitor.visit_f32(number)
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ReadFailure> {
        let number = self.read_number(&visitor)?;
        visitor.visit_f64(number)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ReadFailure> {
        match self.value {
            Value::Null => visitor.visit_none(),
            _ => visitor.visit_some(self),
        }
    }

    fn deserialize_unit<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ReadFailure> {
        match self.value {
            Value::Null => visitor.visit_unit(),
            _ => Err(self.refused(&visitor)),
        }
    }

    fn deserialize_unit_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, ReadFailure> {
        self.deserialize_unit(visitor)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, ReadFailure> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_tuple<V: Visitor<'de>>(
        self,
        _: usize,
        visitor: V,
    ) -> Result<V::Value, ReadFailure> {
        self.read_list(visitor)
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: usize,
        visitor: V,
    ) -> Result<V::Value, ReadFailure> {
        self.read_list(visitor)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ReadFailure> {
        self.read_object(visitor)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ReadFailure> {
        let (name, content) = match self.value {
            Value::Text(name) => (name, None),
            Value::Object(entries) => match &**entries {
                [(name, content)] => (name, Some(content)),
                _ => return Err(self.refused(&"an object with one key")),
            },
            _ => return Err(self.refused(&"a name, or an object with one key")),
        };
        visitor.visit_enum(Variant { name, content, location: self.location })
    }

    fn deserialize_ignored_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ReadFailure> {
        visitor.visit_unit()
    }
}

/// The number of single precision that is nearest to the text of this one. Where a number lies in the middle between
/// two, its text tells on which side.
fn single(number: f64) -> f32 {
    const MIDDLE: u64 = 1 << 28;
    let lost = number.to_bits() & (2 * MIDDLE - 1);
    if lost == MIDDLE || number.abs() < f32::MIN_POSITIVE.into() {
        return number.to_string().parse().unwrap_or(number as f32);
    }
    number as f32
}

/// The elements of a list.
struct Elements<'a> {
    list: &'a Value,
    location: &'a Location<'a>,
    length: usize,
    next: usize,
}

impl Elements<'_> {
    /// Refuses elements that nothing has read.
    fn end(&self) -> Result<(), ReadFailure> {
        if self.next < self.length {
            let read = format!("{} elements", self.next);
            return Err(ReadFailure::invalid_length(self.length, &read.as_str()));
        }
        Ok(())
    }
}

impl<'de> SeqAccess<'de> for &mut Elements<'_> {
    type Error = ReadFailure;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, ReadFailure> {
        let index = self.next;
        if index == self.length {
            return Ok(None);
        }
        self.next += 1;
        let number;
        let value = match self.list {
            Value::List(list) => &list[index],
            Value::Naturals(list) => {
                number = Value::Natural(list[index].into());
                &number
            }
            Value::Numbers(list) => {
                number = Value::Number(list[index]);
                &number
            }
            _ => return Ok(None),
        };
        let location = Location::Index(index, self.location);
        seed.deserialize(Reader::new(value, &location))
            .map(Some)
            .map_err(|failure| failure.at(&location))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.length - self.next)
    }
}

/// The keys of an object and their values.
struct Entries<'a> {
    rest: &'a [(Box<str>, Value)],
    value: Option<(&'a str, &'a Value)>,
    location: &'a Location<'a>,
}

impl<'de> MapAccess<'de> for Entries<'_> {
    type Error = ReadFailure;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, ReadFailure> {
        let Some(((key, value), rest)) = self.rest.split_first() else { return Ok(None) };
        self.rest = rest;
        self.value = Some((key, value));
        seed.deserialize(name_reader(key)).map(Some)
    }

    fn next_value_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<T::Value, ReadFailure> {
        let Some((key, value)) = self.value.take() else {
            return Err(ReadFailure::custom("a value is read before its key"));
        };
        let location = Location::Key(key, self.location);
        seed.deserialize(Reader::new(value, &location)).map_err(|failure| failure.at(&location))
    }
}

/// A variant of an enum and what it holds.
struct Variant<'a> {
    name: &'a str,
    content: Option<&'a Value>,
    location: &'a Location<'a>,
}

impl Variant<'_> {
    /// Reads what it holds.
    fn read<T>(
        &self,
        read: impl FnOnce(Reader<'_>) -> Result<T, ReadFailure>,
    ) -> Result<T, ReadFailure> {
        let Some(content) = self.content else {
            return Err(ReadFailure::custom(format_args!("`{}` needs a value", self.name)));
        };
        let location = Location::Key(self.name, self.location);
        read(Reader::new(content, &location)).map_err(|failure| failure.at(&location))
    }
}

impl<'de> EnumAccess<'de> for Variant<'_> {
    type Error = ReadFailure;
    type Variant = Self;

    fn variant_seed<T: DeserializeSeed<'de>>(
        self,
        seed: T,
    ) -> Result<(T::Value, Self), ReadFailure> {
        Ok((seed.deserialize(name_reader(self.name))?, self))
    }
}

impl<'de> VariantAccess<'de> for Variant<'_> {
    type Error = ReadFailure;

    fn unit_variant(self) -> Result<(), ReadFailure> {
        if self.content.is_none() {
            return Ok(());
        }
        self.read(|content| match content.value {
            Value::Null => Ok(()),
            _ => Err(content.refused(&"a name alone")),
        })
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(
        self,
        seed: T,
    ) -> Result<T::Value, ReadFailure> {
        self.read(|content| seed.deserialize(content))
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, ReadFailure> {
        self.read(|content| content.read_list(visitor))
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ReadFailure> {
        self.read(|content| content.read_object(visitor))
    }
}

fn name_reader(name: &str) -> StrDeserializer<'_, ReadFailure> {
    name.into_deserializer()
}

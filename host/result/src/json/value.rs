//! A JSON text as values.

use std::cell::{Cell, RefCell};
use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Unexpected, Visitor};

use super::{JsonError, Location};

/// A value. Lists of numbers of one kind, which a large file mostly is, take as much memory as the numbers.
pub(super) enum Value {
    Null,
    Bool(bool),
    Natural(u64),
    Negative(i64),
    Number(f64),
    Text(Box<str>),
    List(Box<[Value]>),
    Naturals(Box<[u32]>),
    Numbers(Box<[f64]>),
    /// Keys in the order of the text; one that is there twice is there twice.
    Object(Box<[Entry]>),
}

type Entry = (Box<str>, Value);

/// Most memory of the values of a text, bytes: an archive of the largest size holds little but numbers, with at least
/// two characters for the four or eight bytes of each.
const MOST_MEMORY: usize = 192 << 20;
/// What an allocation takes beside its bytes, bytes.
const ALLOCATION: usize = 32;

impl Value {
    /// Parses a whole text.
    ///
    /// # Errors
    /// What is not JSON, or needs too much memory.
    pub(super) fn parse(text: &[u8]) -> Result<Self, JsonError> {
        let state = State { left: Cell::new(MOST_MEMORY), failed_at: RefCell::new(None) };
        let mut parser = serde_json::Deserializer::from_slice(text);
        let value =
            Parser { state: &state, location: &Location::Document }.deserialize(&mut parser);
        value
            .and_then(|value| parser.end().map(|()| value))
            .map_err(|error| JsonError::not_json(&error, state.failed_at.take()))
    }

    /// The number of elements, if it is a list.
    pub(super) fn length(&self) -> Option<usize> {
        match self {
            Self::List(list) => Some(list.len()),
            Self::Naturals(list) => Some(list.len()),
            Self::Numbers(list) => Some(list.len()),
            _ => None,
        }
    }

    /// What it is, for a message.
    pub(super) fn unexpected(&self) -> Unexpected<'_> {
        match self {
            Self::Null => Unexpected::Unit,
            Self::Bool(value) => Unexpected::Bool(*value),
            Self::Natural(number) => Unexpected::Unsigned(*number),
            Self::Negative(number) => Unexpected::Signed(*number),
            Self::Number(number) => Unexpected::Float(*number),
            Self::Text(text) => Unexpected::Str(text),
            Self::List(_) | Self::Naturals(_) | Self::Numbers(_) => Unexpected::Seq,
            Self::Object(_) => Unexpected::Map,
        }
    }
}

/// The state of a text that is parsed.
struct State {
    /// Memory that its values may still take, bytes.
    left: Cell<usize>,
    /// The innermost value that could not be parsed.
    failed_at: RefCell<Option<String>>,
}

/// Parses one value.
#[derive(Clone, Copy)]
struct Parser<'a> {
    state: &'a State,
    location: &'a Location<'a>,
}

impl<'a> Parser<'a> {
    /// The parser of a value within this one.
    fn at(self, location: &'a Location<'a>) -> Self {
        Self { location, ..self }
    }

    /// Takes memory, bytes.
    fn take<E: Error>(self, bytes: usize) -> Result<(), E> {
        let left = self.state.left.get().checked_sub(bytes);
        self.state.left.set(left.ok_or_else(|| {
            E::custom(format_args!("it needs more than {} MiB of memory", MOST_MEMORY >> 20))
        })?);
        Ok(())
    }
}

impl<'de> DeserializeSeed<'de> for Parser<'_> {
    type Value = Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        deserializer.deserialize_any(self).inspect_err(|_| {
            let failed_at = &mut *self.state.failed_at.borrow_mut();
            failed_at.get_or_insert_with(|| self.location.to_string());
        })
    }
}

impl<'de> Visitor<'de> for Parser<'_> {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_unit<E: Error>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<Value, E> {
        Ok(Value::Bool(value))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Value, E> {
        Ok(Value::Natural(value))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Value, E> {
        Ok(Value::Negative(value))
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Value, E> {
        Ok(Value::Number(value))
    }

    fn visit_str<E: Error>(self, value: &str) -> Result<Value, E> {
        self.take(ALLOCATION + value.len())?;
        Ok(Value::Text(value.into()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<Value, A::Error> {
        self.take(ALLOCATION)?;
        let mut list = List::Naturals(Vec::new());
        for index in 0.. {
            let location = Location::Index(index, self.location);
            let Some(element) = elements.next_element_seed(self.at(&location))? else { break };
            let before = list.bytes();
            list = list.with(element);
            self.take(list.bytes() - before)?;
        }
        Ok(list.into_value())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Value, A::Error> {
        self.take(ALLOCATION)?;
        let mut object = Vec::<Entry>::new();
        while let Some(key) = entries.next_key::<Box<str>>()? {
            self.take(size_of::<Entry>() + ALLOCATION + key.len())?;
            let value = entries.next_value_seed(self.at(&Location::Key(&key, self.location)))?;
            object.push((key, value));
        }
        Ok(Value::Object(object.into()))
    }
}

/// A list that is parsed, in the smallest form that its elements have so far.
enum List {
    Naturals(Vec<u32>),
    Numbers(Vec<f64>),
    Values(Vec<Value>),
}

impl List {
    /// The memory of its elements, bytes.
    fn bytes(&self) -> usize {
        match self {
            Self::Naturals(list) => size_of_val(&**list),
            Self::Numbers(list) => size_of_val(&**list),
            Self::Values(list) => size_of_val(&**list),
        }
    }

    /// The list with one more element.
    fn with(mut self, element: Value) -> Self {
        match (&mut self, &element) {
            (Self::Naturals(list), &Value::Natural(number)) if u32::try_from(number).is_ok() => {
                list.push(number as u32);
                return self;
            }
            (Self::Naturals(list), &Value::Number(number)) if list.is_empty() => {
                return Self::Numbers(vec![number]);
            }
            (Self::Numbers(list), &Value::Number(number)) => {
                list.push(number);
                return self;
            }
            _ => {}
        }
        let mut values = self.into_values();
        values.push(element);
        Self::Values(values)
    }

    fn into_values(self) -> Vec<Value> {
        match self {
            Self::Naturals(list) => list.into_iter().map(|n| Value::Natural(n.into())).collect(),
            Self::Numbers(list) => list.into_iter().map(Value::Number).collect(),
            Self::Values(list) => list,
        }
    }

    fn into_value(self) -> Value {
        match self {
            Self::Naturals(list) => Value::Naturals(list.into()),
            Self::Numbers(list) => Value::Numbers(list.into()),
            Self::Values(list) => Value::List(list.into()),
        }
    }
}

//! What is wrong with a JSON text.

use std::fmt;

use serde::de::{Error, Expected, Unexpected};

use super::Location;

/// The place of a document as a whole.
const DOCUMENT: &str = "the document";

/// What is wrong with a JSON text, for people: without the names of types in this program.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {wrong}")]
pub struct JsonError {
    /// The way to the value, or "the document".
    pub place: String,
    /// What is wrong with it.
    pub wrong: String,
}

impl JsonError {
    /// A text that is not JSON, or a value that cannot be kept. The place of a value replaces that in the text.
    pub(super) fn not_json(error: &serde_json::Error, place: Option<String>) -> Self {
        let message = error.to_string();
        match place.filter(|place| !place.is_empty()) {
            Some(place) => {
                let wrong = message.rsplit_once(" at line ").map_or(&*message, |(wrong, _)| wrong);
                Self { place, wrong: wrong.into() }
            }
            None => Self { place: DOCUMENT.into(), wrong: message },
        }
    }
}

/// What is wrong with a value; its place is added by whoever knows it.
#[derive(Debug)]
pub(super) struct ReadFailure {
    message: String,
    place: Option<String>,
}

impl ReadFailure {
    fn new(message: String) -> Self {
        Self { message, place: None }
    }

    /// The same at a place, where it has none yet.
    pub(super) fn at(mut self, location: &Location) -> Self {
        self.place.get_or_insert_with(|| location.to_string());
        self
    }
}

impl From<ReadFailure> for JsonError {
    fn from(ReadFailure { message, place }: ReadFailure) -> Self {
        let place = place.filter(|place| !place.is_empty());
        Self { place: place.unwrap_or_else(|| DOCUMENT.into()), wrong: message }
    }
}

impl fmt::Display for ReadFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for ReadFailure {}

impl Error for ReadFailure {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self::new(message.to_string())
    }

    fn invalid_type(unexpected: Unexpected, expected: &dyn Expected) -> Self {
        let expected = in_words(expected);
        Self::new(match unexpected {
            Unexpected::Unit => format!("invalid type: null, expected {expected}"),
            other => format!("invalid type: {other}, expected {expected}"),
        })
    }

    fn invalid_value(unexpected: Unexpected, expected: &dyn Expected) -> Self {
        Self::new(format!("invalid value: {unexpected}, expected {}", in_words(expected)))
    }
}

/// What serde expects, without the names of types in this program.
fn in_words(expected: &dyn Expected) -> String {
    let expected = expected.to_string();
    match &*expected {
        "f32" | "f64" => "a number".into(),
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number that is not negative".into(),
        "i8" | "i16" | "i32" | "i64" => "a whole number".into(),
        name if name.starts_with("struct ") => "an object".into(),
        _ => expected,
    }
}

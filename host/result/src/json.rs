//! Reads JSON as the types of this program. A text is parsed into values, which keep every key as often as it is there,
//! and a type is read from these: what is wrong has a place, and a type is compiled for this one reader.

use std::fmt;

use serde::Deserialize;
use serde::de::{DeserializeOwned, Error};

mod error;
mod reader;
#[cfg(test)]
mod tests;
mod value;

pub use error::JsonError;
use error::ReadFailure;
use reader::Reader;
use value::Value;

/// A JSON text that was parsed.
pub struct Json(Value);

impl Json {
    /// Parses a whole text.
    ///
    /// # Errors
    /// What is not JSON, or needs more memory than any document of this program.
    pub fn parse(text: &[u8]) -> Result<Self, JsonError> {
        Value::parse(text).map(Self)
    }

    /// The document as a `T`.
    ///
    /// # Errors
    /// The first key or value that does not belong there.
    pub fn read<T: DeserializeOwned>(&self) -> Result<T, JsonError> {
        Ok(T::deserialize(Reader::new(&self.0, &Location::Document))?)
    }

    /// What is at a key of the document; `None` where it is left out or null.
    ///
    /// # Errors
    /// As [`Json::read`], and when the key is there twice.
    pub(crate) fn read_key<T: DeserializeOwned>(&self, key: &str) -> Result<Option<T>, JsonError> {
        let Value::Object(entries) = &self.0 else { return Ok(None) };
        let mut values = entries.iter().filter(|entry| *entry.0 == *key).map(|entry| &entry.1);
        let Some(value) = values.next() else { return Ok(None) };
        let location = Location::Key(key, &Location::Document);
        if values.next().is_some() {
            return Err(ReadFailure::custom("the key is there twice").at(&location).into());
        }
        Ok(Option::deserialize(Reader::new(value, &location))
            .map_err(|failure: ReadFailure| failure.at(&location))?)
    }
}

/// The way to a value: as a text `dofs[0].noise[2]`, and nothing for the whole document.
enum Location<'a> {
    Document,
    Key(&'a str, &'a Location<'a>),
    Index(usize, &'a Location<'a>),
}

impl fmt::Display for Location<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Document => Ok(()),
            Self::Key(key, Self::Document) => f.write_str(key),
            Self::Key(key, above) => write!(f, "{above}.{key}"),
            Self::Index(index, above) => write!(f, "{above}[{index}]"),
        }
    }
}

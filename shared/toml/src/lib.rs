//! Reads TOML texts that people write: a table is a table, a list has its length, and what is wrong is said to the
//! owner of the text.

use std::ops::Range;

use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::DeTable;

mod grammar;
mod refusal;
mod value;

use value::Value;

/// What is wrong with a TOML text, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TomlError {
    /// The bytes of the text that it is about.
    pub span: Range<usize>,
    /// The path of keys to it, with dots; empty when it is not about a value.
    pub key: String,
    /// What is wrong, and what should stand there.
    pub message: String,
}

impl TomlError {
    /// Line of the text, counted from 1.
    pub fn line(&self, text: &str) -> usize {
        line_of(text, self.span.start)
    }
}

/// The line of a byte of a text, counted from 1.
pub fn line_of(text: &str, offset: usize) -> usize {
    text.bytes().take(offset).filter(|&byte| byte == b'\n').count() + 1
}

/// The tables and values of a TOML text.
///
/// # Errors
/// What is not TOML.
pub fn parse(text: &str) -> Result<Spanned<DeTable<'_>>, TomlError> {
    DeTable::parse(text).map_err(|error| grammar::error(text, &error))
}

/// Reads a text as a `T`. Other than with `toml::from_str`, a list is refused where a table belongs, and a list with
/// another length than that of the array that is asked for.
///
/// # Errors
/// What is not TOML, and the first value or key that does not belong there.
///
/// ```
/// #[derive(Debug, serde::Deserialize)]
/// struct Ball {
///     center_m: [f64; 3],
/// }
/// let error = massline_toml::read::<Ball>("\ncenter_m = [0, 1]").unwrap_err();
/// assert_eq!(error.message, "2 values stand where 3 should");
/// assert_eq!(error.key, "center_m");
/// assert_eq!(error.line("\ncenter_m = [0, 1]"), 2);
/// ```
pub fn read<T: DeserializeOwned>(text: &str) -> Result<T, TomlError> {
    T::deserialize(Value::of_text(parse(text)?, text)).map_err(|refusal| refusal.in_text(text))
}

/// Most characters of a value that are shown.
const MOST_SHOWN: usize = 40;

/// A part of a text on one line, shortened.
pub fn shown(part: &str) -> String {
    let line = part.lines().next().unwrap_or_default().trim_end();
    match line.chars().count() > MOST_SHOWN || line.len() < part.trim_end().len() {
        true => line.chars().take(MOST_SHOWN).chain(['…']).collect(),
        false => line.to_owned(),
    }
}

#[cfg(test)]
mod tests;

//! Reads TOML texts that people write: a table is a table, a list has its length, and what is wrong is said to the
//! owner of the text.

use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::DeTable;

mod error;
mod grammar;
mod refusal;
mod value;

pub use error::{TomlError, excerpt, line_of};

use value::Value;

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

#[cfg(test)]
mod tests;

//! Finds the place of a key in a TOML text, so that an error can name file, line and key.

use std::ops::{Range, RangeInclusive};

use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::settings::refusal;
use massline_toml::{TomlError, line_of};

/// What is wrong with a bench file, and where.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}:{line}: {key}{}{message}", if key.is_empty() { "" } else { ": " })]
pub struct BenchFileError {
    /// Name of the file or of the bundled bench.
    pub file: String,
    /// Line, counted from 1.
    pub line: usize,
    /// Dotted path of the key, with `[i]` (from 0) for the entries of arrays where a value is out of range; empty where
    /// the error is not about a key.
    pub key: String,
    /// What is wrong.
    pub message: String,
}

/// A TOML text with the positions of its keys.
pub(super) struct LocatedText<'a> {
    text: &'a str,
    file: &'a str,
    root: Spanned<DeTable<'a>>,
}

impl<'a> LocatedText<'a> {
    /// Reads the text and refuses NaN and infinity.
    pub(super) fn parse(text: &'a str, file: &'a str) -> Result<Self, BenchFileError> {
        let root = massline_toml::parse(text).map_err(|error| in_file(error, text, file))?;
        let located = Self { text, file, root };
        let mut paths = Vec::new();
        walk_table(located.root.get_ref(), "", &mut paths);
        for place in &paths {
            if place.not_finite {
                return Err(located.error(&place.path, "must be a finite number"));
            }
        }
        Ok(located)
    }

    /// Deserialises the text as `T`.
    pub(super) fn deserialize<T: DeserializeOwned>(&self) -> Result<T, BenchFileError> {
        massline_toml::read(self.text).map_err(|error| in_file(error, self.text, self.file))
    }

    /// An error about the key at this path, or about the nearest table above it when the key is absent.
    pub(super) fn error(&self, path: &str, message: impl Into<String>) -> BenchFileError {
        let mut places = Vec::new();
        walk_table(self.root.get_ref(), "", &mut places);
        let nearest = places
            .iter()
            .filter(|p| path.starts_with(&p.path))
            .max_by_key(|p| p.path.len())
            .map_or(0, |p| p.value.start);
        BenchFileError {
            file: self.file.to_string(),
            line: line_of(self.text, nearest),
            key: path.to_string(),
            message: message.into(),
        }
    }

    /// An error about the key at this path unless `holds`.
    pub(super) fn require(
        &self,
        holds: bool,
        path: &str,
        message: impl Into<String>,
    ) -> Result<(), BenchFileError> {
        if holds { Ok(()) } else { Err(self.error(path, message)) }
    }
}

impl LocatedText<'_> {
    /// An error about the key at this path unless its value lies in the range.
    pub(super) fn within(
        &self,
        value: f64,
        range: &RangeInclusive<f64>,
        path: &str,
    ) -> Result<(), BenchFileError> {
        if range.contains(&value) { Ok(()) } else { Err(self.error(path, refusal(value, range))) }
    }
}

/// A value and its path.
struct Place {
    path: String,
    value: Range<usize>,
    not_finite: bool,
}

fn walk_table(table: &DeTable, prefix: &str, places: &mut Vec<Place>) {
    for (key, value) in table {
        let dot = if prefix.is_empty() { "" } else { "." };
        walk_value(value, format!("{prefix}{dot}{}", key.get_ref()), places);
    }
}

fn walk_value(value: &Spanned<DeValue>, path: String, places: &mut Vec<Place>) {
    let not_finite = match value.get_ref() {
        DeValue::Float(f) => !f.as_str().replace('_', "").parse::<f64>().is_ok_and(f64::is_finite),
        _ => false,
    };
    match value.get_ref() {
        DeValue::Table(table) => walk_table(table, &path, places),
        DeValue::Array(entries) => {
            for (i, entry) in entries.iter().enumerate() {
                walk_value(entry, format!("{path}[{i}]"), places);
            }
        }
        _ => {}
    }
    places.push(Place { path, value: value.span(), not_finite });
}

/// The error as one of this file.
fn in_file(error: TomlError, text: &str, file: &str) -> BenchFileError {
    let line = error.line(text);
    BenchFileError { file: file.to_owned(), line, key: error.key, message: error.message }
}

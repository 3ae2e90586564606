//! Finds the place of a key in a TOML text, so that an error can name file, line and key.

use std::ops::RangeInclusive;

use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::settings::refusal;
use crate::toml_message::plain;

/// What is wrong with a bench file, and where.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}:{line}: {key}: {message}")]
pub struct BenchFileError {
    /// Name of the file or of the bundled bench.
    pub file: String,
    /// Line, counted from 1.
    pub line: usize,
    /// Dotted path of the key, with `[i]` (from 0) for the entries of arrays.
    pub key: String,
    /// What is wrong.
    pub message: String,
}

/// A TOML text with the positions of its keys.
pub(super) struct Located<'a> {
    text: &'a str,
    file: &'a str,
    root: Spanned<DeTable<'a>>,
}

impl<'a> Located<'a> {
    /// Reads the text and refuses NaN and infinity.
    pub(super) fn parse(text: &'a str, file: &'a str) -> Result<Self, BenchFileError> {
        let root = DeTable::parse(text).map_err(|e| {
            let offset = e.span().map_or(0, |s| s.start);
            let line = line_text(text, offset);
            BenchFileError {
                file: file.to_string(),
                line: line_number(text, offset),
                key: line.split('=').next().unwrap_or(line).trim().to_string(),
                message: plain(text, &e),
            }
        })?;
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
        toml::from_str(self.text).map_err(|e: toml::de::Error| {
            let offset = e.span().map_or(0, |span| span.start);
            let mut places = Vec::new();
            walk_table(self.root.get_ref(), "", &mut places);
            // The innermost key is the one with the longest path among those that contain the offset.
            let key = places
                .into_iter()
                .filter(|p| p.key.contains(&offset) || p.value.contains(&offset))
                .map(|p| p.path)
                .max_by_key(String::len)
                .unwrap_or_else(|| "file".to_string());
            BenchFileError {
                file: self.file.to_string(),
                line: line_number(self.text, offset),
                key,
                message: plain(self.text, &e),
            }
        })
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
            line: line_number(self.text, nearest),
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

impl Located<'_> {
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

/// A key and its value.
struct Place {
    path: String,
    key: std::ops::Range<usize>,
    value: std::ops::Range<usize>,
    not_finite: bool,
}

fn walk_table(table: &DeTable, prefix: &str, places: &mut Vec<Place>) {
    for (key, value) in table {
        let dot = if prefix.is_empty() { "" } else { "." };
        walk_value(value, format!("{prefix}{dot}{}", key.get_ref()), key.span(), places);
    }
}

fn walk_value(
    value: &Spanned<DeValue>,
    path: String,
    key: std::ops::Range<usize>,
    places: &mut Vec<Place>,
) {
    let not_finite = match value.get_ref() {
        DeValue::Float(f) => !f.as_str().parse::<f64>().is_ok_and(f64::is_finite),
        _ => false,
    };
    match value.get_ref() {
        DeValue::Table(table) => walk_table(table, &path, places),
        DeValue::Array(entries) => {
            for (i, entry) in entries.iter().enumerate() {
                walk_value(entry, format!("{path}[{i}]"), entry.span(), places);
            }
        }
        _ => {}
    }
    places.push(Place { path, key, value: value.span(), not_finite });
}

fn line_number(text: &str, offset: usize) -> usize {
    text.bytes().take(offset).filter(|&b| b == b'\n').count() + 1
}

fn line_text(text: &str, offset: usize) -> &str {
    text.lines().nth(line_number(text, offset) - 1).unwrap_or("")
}

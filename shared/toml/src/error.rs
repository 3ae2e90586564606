//! What is wrong with a text, and what is shown of it.

use std::ops::Range;

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

/// Most characters of a value that are shown.
pub(crate) const MOST_SHOWN: usize = 40;

/// A part of a text on one line, shortened.
pub fn excerpt(part: &str) -> String {
    let line = part.lines().next().unwrap_or_default().trim_end();
    match line.chars().count() > MOST_SHOWN || line.len() < part.trim_end().len() {
        true => line.chars().take(MOST_SHOWN).chain(['…']).collect(),
        false => line.to_owned(),
    }
}

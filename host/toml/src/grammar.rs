//! What is no TOML, in words for the owner of the text.

use toml::de::Error;

use super::{TomlError, is_in_heading, shown};

/// What can stand on a line.
const LINE: &str =
    "a line is `key = value`, or the name of a table in brackets, or a remark that begins with #";
/// What numbers and lists look like.
const NUMBER: &str = "a number has a decimal point and no unit (0.5), a list has brackets and commas ([1, 2, 3]), and a remark \
                      begins with #";
/// What other values look like.
const WORD: &str = "a text stands in straight quotes; true and false are in small letters";
/// How a text in quotes ends.
const TEXT: &str = "a text ends with the quotes that it begins with, and one with a backslash stands in single quotes";

/// What the reader says about lines, not about values.
const OF_LINES: [&str; 10] = [
    "key with no value",
    "invalid unquoted key",
    "unquoted keys cannot be empty",
    "missing assignment",
    "keys cannot be",
    "unclosed table",
    "unclosed array table",
    "invalid key-value pair",
    "missing table open",
    "unexpected content",
];
/// What the reader says about texts in quotes.
const OF_TEXTS: [&str; 6] = [
    "invalid basic string",
    "invalid literal string",
    "invalid multi-line",
    "missing escaped value",
    "too few unicode",
    "invalid escape",
];

/// The error for the owner of the text.
pub(super) fn error(text: &str, error: &Error) -> TomlError {
    let span = error.span().unwrap_or_default();
    let message = said(text, error.message(), span.start.min(text.len()));
    let key = match is_in_heading(text, &span) {
        true => String::new(),
        false => key_before(text, span.start),
    };
    TomlError { span, key, message }
}

fn said(text: &str, of_reader: &str, at: usize) -> String {
    let line = line_at(text, at);
    let begins = |words: &[&str]| words.iter().any(|word| of_reader.starts_with(word));
    if begins(&["duplicate key"]) {
        return match line.trim_start().starts_with('[') {
            true => "this name stands above already; of several tables each is [[name]]".into(),
            false => "this key is in the file twice; delete one".into(),
        };
    }
    if begins(&["missing comma", "unclosed array", "unclosed inline"])
        && !begins(&["unclosed array table"])
    {
        return "a comma or a closing bracket is missing before this".into();
    }
    if line.chars().any(|c| c.is_control() && c != '\t' && c != '\r')
        || begins(&["carriage return"])
    {
        return "a control character stands here; delete it".into();
    }
    if begins(&["recursion limit", "cannot recurse"]) {
        return "too many brackets stand within brackets here".into();
    }
    let (has_key, value) = match line.split_once('=') {
        Some((_, value)) => (true, value.trim()),
        None => (false, line.trim()),
    };
    let is_heading = !has_key && value.starts_with('[') && begins(&["unexpected key or value"]);
    if is_heading || begins(&OF_LINES) {
        return format!("{} cannot be read: {LINE}", shown(line.trim()));
    }
    if begins(&OF_TEXTS) {
        return format!("{} cannot be read: {TEXT}", shown(value));
    }
    if value.is_empty() {
        return "there is no value after the `=`".into();
    }
    let looks_like_number =
        |c: char| c.is_ascii_digit() || matches!(c, '.' | '+' | '-' | '−' | '[' | '(' | '=');
    let advice = if value.starts_with(looks_like_number) { NUMBER } else { WORD };
    format!("{} is no value: {advice}", shown(value))
}

/// The line around a byte.
fn line_at(text: &str, at: usize) -> &str {
    let (before, after) = (text.get(..at).unwrap_or(text), text.get(at..).unwrap_or_default());
    let start = before.rfind('\n').map_or(0, |end| end + 1);
    let end = after.find('\n').map_or(text.len(), |end| at + end);
    text.get(start..end).unwrap_or_default()
}

/// The key of the last line with one up to a byte.
fn key_before(text: &str, at: usize) -> String {
    let end = at
        + text
            .get(at..)
            .and_then(|after| after.find('\n'))
            .unwrap_or(text.len().saturating_sub(at));
    let lines = text.get(..end).unwrap_or_default().lines().rev();
    let keys = lines.filter_map(|line| line.split_once('=')).map(|(key, _)| key.trim());
    let mut keys = keys.filter(|key| !key.starts_with(['#', '[', '{', '"']));
    keys.next().unwrap_or_default().to_owned()
}

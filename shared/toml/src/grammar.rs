//! What is no TOML, in words for the owner of the text.

use toml::de::Error;

use super::error::{TomlError, excerpt};

/// What can stand on a line.
const LINE: &str =
    "a line is `key = value`, or the name of a table in brackets, or a remark that begins with #";
/// What can stand after the `=` of a line, where it looks like a number or a list.
const NUMBER: &str = "one value stands after the `=`: a number has a decimal point and no unit (0.5), a list has \
                      brackets and commas ([1, 2, 3]), and a remark begins with #";
/// What can stand there where it looks like a word.
const WORD: &str =
    "one value stands after the `=`: a text in straight quotes, or true or false in small letters";
/// What can stand there where it begins with a brace.
const BRACES: &str = "in braces stand `key = value` with commas between them";
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
    let at = span.start.min(text.len());
    let is_of_line = line_at(text, at).trim_start().starts_with('[')
        || OF_LINES.iter().any(|words| error.message().starts_with(words));
    let key = if is_of_line { String::new() } else { key_before(text, at) };
    TomlError { message: sentence(text, error.message(), at), span, key }
}

fn sentence(text: &str, of_reader: &str, at: usize) -> String {
    let line = line_at(text, at);
    let begins = |words: &[&str]| words.iter().any(|word| of_reader.starts_with(word));
    if begins(&["duplicate key"]) {
        return match line.trim_start().starts_with('[') {
            true => "this name stands above already: put these keys there, or, where there can be several such tables, \
                     write the name of each in double brackets"
                .into(),
            false => "this key is in the file twice; delete one".into(),
        };
    }
    if begins(&["cannot extend"]) {
        return "the part of this key before its last dot has a value above already".into();
    }
    if begins(&["missing comma", "unclosed array", "unclosed inline"])
        && !begins(&["unclosed array table"])
    {
        return "a comma or a closing bracket is missing before this, or in a line above".into();
    }
    if line.chars().any(is_invisible) || begins(&["carriage return"]) {
        return "an invisible character stands here; delete it".into();
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
        return format!("{} cannot be read: {LINE}", excerpt(line.trim()));
    }
    if begins(&OF_TEXTS) {
        return format!("{} cannot be read: {TEXT}", excerpt(value));
    }
    if value.is_empty() {
        return "there is no value after the `=`".into();
    }
    let looks_like_number =
        |c: char| c.is_ascii_digit() || matches!(c, '.' | '+' | '-' | '−' | '[' | '(' | '=');
    let advice = match value {
        value if value.starts_with('{') => BRACES,
        value if value.starts_with(looks_like_number) => NUMBER,
        _ => WORD,
    };
    format!("{} cannot be read: {advice}", excerpt(value))
}

/// Whether a character has no place outside of quotes and does not show: control characters, spaces of print, marks of
/// order.
fn is_invisible(c: char) -> bool {
    c.is_control() && c != '\t' && c != '\r'
        || matches!(
            c,
            '\u{a0}' | '\u{2000}'..='\u{200f}' | '\u{2028}' | '\u{2029}' | '\u{202f}' | '\u{feff}'
        )
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

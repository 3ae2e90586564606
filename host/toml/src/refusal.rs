//! Why a value or a key of a TOML text is refused, in words for the owner of the text.

use std::fmt::{self, Display};
use std::ops::Range;

use serde::de::{Error, Expected, Unexpected};

use super::{TomlError, is_in_heading, shown};

/// What serde's readers ask for, and its name for the owner of a text.
const TYPES: [(&str, &str); 16] = [
    ("a sequence", "a list in brackets"),
    ("a map", "a table"),
    ("a boolean", "true or false"),
    ("a string", "a text in quotes"),
    ("f64", "a number"),
    ("f32", "a number"),
    ("i64", "a whole number"),
    ("i32", "a whole number"),
    ("i16", "a whole number"),
    ("i8", "a whole number from -128 to 127"),
    ("u64", "a whole number that is not negative"),
    ("u32", "a whole number that is not negative"),
    ("usize", "a whole number that is not negative"),
    ("u16", "a whole number from 0 to 65535"),
    ("u8", "a whole number from 0 to 255"),
    ("struct", "a table"),
];

/// Why a value or a key is refused. The readers know what is wrong, and the values that they read know where.
#[derive(Debug)]
pub(super) struct Refusal {
    reason: Reason,
    span: Option<Range<usize>>,
    /// The keys on the way to it, from the inside.
    keys: Vec<String>,
}

#[derive(Debug)]
enum Reason {
    /// Something else is wanted.
    Wanted(String),
    /// A list has another length.
    Length { found: usize, wanted: usize },
    /// A sentence of its own.
    Said(String),
}

impl Refusal {
    /// A list with another length than the wanted one.
    pub(super) fn length(found: usize, wanted: usize) -> Self {
        Self::of(Reason::Length { found, wanted })
    }

    fn of(reason: Reason) -> Self {
        Self { reason, span: None, keys: Vec::new() }
    }

    /// The same at this place, unless a closer one is known.
    pub(super) fn at(mut self, span: &Range<usize>) -> Self {
        self.span.get_or_insert_with(|| span.clone());
        self
    }

    /// The same below this key.
    pub(super) fn under(mut self, key: &str) -> Self {
        self.keys.push(key.to_owned());
        self
    }

    /// The error for the owner of the text.
    pub(super) fn in_text(mut self, text: &str) -> TomlError {
        self.keys.reverse();
        let key = self.keys.join(".");
        let span = self.span.unwrap_or_default();
        let written = text.get(span.clone()).unwrap_or_default();
        let message = match self.reason {
            Reason::Said(sentence) => sentence,
            Reason::Length { found: 1, wanted } => format!("1 value stands where {wanted} should"),
            Reason::Length { found, wanted } => {
                format!("{found} values stand where {wanted} should")
            }
            Reason::Wanted(wanted) if is_in_heading(text, &span) => {
                let list = wanted == "a sequence" || wanted.contains("[[");
                match list {
                    true => "there can be several such tables: write the name of each in double brackets".into(),
                    false if written.starts_with("[[") => {
                        "there is one such table only: write its name in single brackets".into()
                    }
                    false => format!("a table stands where {} should", named(&wanted)),
                }
            }
            Reason::Wanted(wanted) => {
                format!("{} stands where {} should", shown(written), named(&wanted))
            }
        };
        TomlError { span, key, message }
    }
}

/// What is wanted, in the words of the owner of a text.
fn named(wanted: &str) -> String {
    if let Some(length) = wanted.strip_prefix("an array of length ") {
        return format!("a list of {length} values in brackets");
    }
    let kind = if wanted.starts_with("struct ") { "struct" } else { wanted };
    let known = TYPES.iter().find(|(of_reader, _)| *of_reader == kind);
    known.map_or(wanted, |(_, words)| words).to_owned()
}

/// Names with a comma between them and "or" before the last.
fn either(names: &[&str]) -> String {
    let quoted: Vec<_> = names.iter().map(|name| format!("`{name}`")).collect();
    match quoted.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        _ => quoted.concat(),
    }
}

impl Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.reason {
            Reason::Wanted(wanted) => write!(f, "{wanted} is wanted"),
            Reason::Length { found, wanted } => write!(f, "{found} values instead of {wanted}"),
            Reason::Said(sentence) => f.write_str(sentence),
        }
    }
}

impl std::error::Error for Refusal {}

impl Error for Refusal {
    fn custom<T: Display>(message: T) -> Self {
        Self::of(Reason::Said(message.to_string()))
    }

    fn invalid_type(_: Unexpected<'_>, wanted: &dyn Expected) -> Self {
        Self::of(Reason::Wanted(wanted.to_string()))
    }

    fn invalid_value(found: Unexpected<'_>, wanted: &dyn Expected) -> Self {
        Self::invalid_type(found, wanted)
    }

    fn invalid_length(_: usize, wanted: &dyn Expected) -> Self {
        Self::of(Reason::Wanted(wanted.to_string()))
    }

    fn unknown_variant(name: &str, known: &'static [&'static str]) -> Self {
        Self::custom(format_args!("`{name}` is not known here; write {}", either(known)))
    }

    fn unknown_field(name: &str, known: &'static [&'static str]) -> Self {
        Self::custom(format_args!("there is no key `{name}` here, but {}", either(known)))
    }

    fn missing_field(name: &'static str) -> Self {
        Self::custom(format_args!("the key `{name}` is missing"))
    }
}

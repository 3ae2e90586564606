//! Why a value or a key of a TOML text is refused, in words for the owner of the text.

use std::fmt::{self, Display};
use std::ops::Range;

use serde::de::{Error, Expected, Unexpected};

use super::error::{TomlError, excerpt};

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
    ("u64", "a whole number, zero or more,"),
    ("usize", "a whole number, zero or more,"),
    ("u32", "a whole number from 0 to 4294967295"),
    ("u16", "a whole number from 0 to 65535"),
    ("u8", "a whole number from 0 to 255"),
    ("struct", "a table"),
];

/// Why a value or a key is refused. The readers know what is wrong, and the values that they read know where.
#[derive(Debug)]
pub(super) struct Refusal {
    reason: Reason,
    place: Option<Place>,
    /// The keys on the way to it, from the inside.
    keys: Vec<String>,
}

/// Where a refused value stands, and how it is written.
#[derive(Clone, Debug)]
pub(super) struct Place {
    pub span: Range<usize>,
    pub form: Form,
}

/// How a value is written, as far as advice depends on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    /// After a key.
    Value,
    /// A table with its name in brackets, or from keys with dots.
    Table,
    /// Tables with their name in double brackets.
    Tables,
}

#[derive(Debug)]
enum Reason {
    /// Something else is wanted.
    Wanted(String),
    /// A list has another length.
    Length { count: usize, wanted: usize },
    /// A number that no type has room for.
    TooLarge,
    /// A sentence of its own.
    Said(String),
}

impl Refusal {
    /// A list with another length than the wanted one.
    pub(super) fn length(count: usize, wanted: usize) -> Self {
        Self::of(Reason::Length { count, wanted })
    }

    /// A number that no type has room for.
    pub(super) fn too_large() -> Self {
        Self::of(Reason::TooLarge)
    }

    fn of(reason: Reason) -> Self {
        Self { reason, place: None, keys: Vec::new() }
    }

    /// The same at this place, unless a closer one is known.
    pub(super) fn at(mut self, place: &Place) -> Self {
        self.place.get_or_insert_with(|| place.clone());
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
        let Place { span, form } = self.place.unwrap_or(Place { span: 0..0, form: Form::Value });
        let written = excerpt(text.get(span.clone()).unwrap_or_default());
        let name = self.keys.last().map_or("key", String::as_str);
        let message = match self.reason {
            Reason::Said(sentence) => sentence,
            Reason::TooLarge => format!("{written} is too large"),
            Reason::Length { count: 1, wanted } => format!("1 value stands where {wanted} should"),
            Reason::Length { count, wanted } => {
                format!("{count} values stand where {wanted} should")
            }
            Reason::Wanted(wanted) => instead(&written, form, &wanted, name),
        };
        TomlError { span, key, message }
    }
}

/// What stands in the place of what is wanted, and how that is written.
fn instead(written: &str, form: Form, wanted: &str, name: &str) -> String {
    let is_list = wanted == "a sequence" || wanted.starts_with("a list");
    let is_whole = named(wanted).starts_with("a whole number");
    match form {
        Form::Table if is_list => format!(
            "one table stands where a list should: of several tables the name of each is in double brackets, and other \
             lists are written `{name} = [1, 2]`"
        ),
        Form::Tables if wanted.starts_with("a table") || wanted.starts_with("struct ") => {
            "there is one such table only: write its name in single brackets".into()
        }
        Form::Table | Form::Tables => {
            format!("a table stands where {} should: write `{name} = …`", named(wanted))
        }
        Form::Value if is_whole && written.contains('.') => {
            format!("{written} stands where {} should, without a decimal point", named(wanted))
        }
        Form::Value => format!("{written} stands where {} should", named(wanted)),
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
            Reason::Length { count, wanted } => write!(f, "{count} values instead of {wanted}"),
            Reason::TooLarge => f.write_str("a number is too large"),
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

    fn invalid_value(unexpected: Unexpected<'_>, wanted: &dyn Expected) -> Self {
        Self::invalid_type(unexpected, wanted)
    }

    fn invalid_length(_: usize, wanted: &dyn Expected) -> Self {
        Self::of(Reason::Wanted(wanted.to_string()))
    }

    fn unknown_variant(name: &str, known: &'static [&'static str]) -> Self {
        Self::custom(format_args!("`{}` is not known here; write {}", excerpt(name), either(known)))
    }

    fn unknown_field(name: &str, known: &'static [&'static str]) -> Self {
        Self::custom(format_args!(
            "there is no key `{}` here, but {}",
            excerpt(name),
            either(known)
        ))
    }

    fn missing_field(name: &'static str) -> Self {
        Self::custom(format_args!("the key `{name}` is missing"))
    }
}

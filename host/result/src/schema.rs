//! The JSON schemas of types that have no derived one, and the names of all.

use std::borrow::Cow;
use std::path::PathBuf;

use massline_shared::diagnosis::Code;
use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::{Map, Value};

use crate::file_path::FilePath;
use crate::finding_code::{FindingCode, UNKNOWN_PREFIX};
use crate::named::{HasNames, NamedValue};

impl JsonSchema for FindingCode {
    fn schema_name() -> Cow<'static, str> {
        "FindingCode".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let names = Code::ALL.iter().map(|code| code.name());
        let names: Vec<&str> =
            names.chain(Self::OF_PROGRAM.iter().map(|(_, name)| *name)).collect();
        json_schema!({ "anyOf": [
            { "type": "string", "enum": names },
            {
                "type": "string",
                "pattern": format!("^{UNKNOWN_PREFIX}[0-9]+$"),
                "examples": [Code::Unknown(999).to_string()],
            },
        ] })
    }
}

impl JsonSchema for FilePath {
    fn schema_name() -> Cow<'static, str> {
        PathBuf::schema_name()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        PathBuf::json_schema(generator)
    }

    fn inline_schema() -> bool {
        PathBuf::inline_schema()
    }
}

impl<T: HasNames> JsonSchema for NamedValue<T> {
    fn schema_name() -> Cow<'static, str> {
        T::WHAT.into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let names: Vec<&str> = T::ALL.iter().map(|value| value.name_of()).collect();
        json_schema!({ "type": "string", "enum": names })
    }
}

/// The schema of a type with these settings, its parts by the names of their types in snake case.
#[must_use]
pub fn schema_of<T: JsonSchema>(settings: SchemaSettings) -> Value {
    let mut schema = settings.into_generator().into_root_schema_for::<T>().to_value();
    rename(&mut schema);
    schema
}

/// Renames the parts of a schema, and what refers to them.
fn rename(schema: &mut Value) {
    const PARTS: &str = "#/$defs/";
    match schema {
        Value::Object(members) => {
            if let Some(Value::Object(parts)) = members.get_mut("$defs") {
                let named = std::mem::take(parts).into_iter();
                *parts = named.map(|(name, part)| (snake_case(&name), part)).collect::<Map<_, _>>();
            }
            if let Some(Value::String(reference)) = members.get_mut("$ref")
                && let Some(name) = reference.strip_prefix(PARTS)
            {
                *reference = PARTS.to_owned() + &snake_case(name);
            }
            members.values_mut().for_each(rename);
        }
        Value::Array(items) => items.iter_mut().for_each(rename),
        _ => {}
    }
}

/// The name of a type in snake case, without the `Raw` of what a file says before it is checked.
fn snake_case(name: &str) -> String {
    let mut words = String::new();
    for letter in name.strip_prefix("Raw").unwrap_or(name).chars() {
        if letter.is_uppercase() && words.ends_with(char::is_alphanumeric) {
            words.push('_');
        }
        words.extend(letter.to_lowercase());
    }
    words
}

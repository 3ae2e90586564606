//! JSON schemas: those of types that cannot derive one, and what the schemas of all documents have in common.

use std::borrow::Cow;
use std::path::PathBuf;

use massline_shared::diagnosis::Code;
use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::Value;

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

/// Generates the schema of a type with these settings. Its definitions have the names of their types in snake case, and
/// the lines of a description, which end where those of the source do, are joined.
///
/// # Panics
/// When two types have the same name.
#[must_use]
pub fn generate_schema<T: JsonSchema>(settings: SchemaSettings) -> Value {
    let mut schema = settings.into_generator().into_root_schema_for::<T>().to_value();
    finish(&mut schema);
    schema
}

/// Renames definitions and what refers to them, and joins lines.
fn finish(schema: &mut Value) {
    const DEFINITIONS: &str = "#/$defs/";
    match schema {
        Value::Object(members) => {
            if let Some(Value::Object(definitions)) = members.get_mut("$defs") {
                for (name, definition) in std::mem::take(definitions) {
                    let before = definitions.insert(snake_case(&name), definition);
                    assert!(before.is_none(), "two types are called {name}");
                }
            }
            if let Some(Value::String(reference)) = members.get_mut("$ref")
                && let Some(name) = reference.strip_prefix(DEFINITIONS)
            {
                *reference = DEFINITIONS.to_owned() + &snake_case(name);
            }
            if let Some(Value::String(description)) = members.get_mut("description") {
                let paragraphs = description.split("\n\n");
                let joined: Vec<_> = paragraphs.map(|lines| lines.replace('\n', " ")).collect();
                *description = joined.join("\n\n");
            }
            members.values_mut().for_each(finish);
        }
        Value::Array(items) => items.iter_mut().for_each(finish),
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

//! What every test gets with `--json` is held against its schema.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use jsonschema::Validator;
use massline_report::document::DocumentKind;
use serde_json::Value;

/// Strict validators by the name of the document: no key may be missing in a schema, though readers have to admit new
/// ones.
static VALIDATORS: LazyLock<BTreeMap<&str, Validator>> = LazyLock::new(|| {
    let validator = |kind: &DocumentKind| {
        let mut schema = serde_json::from_str(kind.schema).unwrap();
        // A command may add keys to its error.
        if kind.name != "error" {
            close(&mut schema);
        }
        (kind.name, jsonschema::validator_for(&schema).unwrap())
    };
    DocumentKind::ALL.iter().map(validator).collect()
});

/// Admits no keys but those of the schema.
fn close(schema: &mut Value) {
    match schema {
        Value::Object(members) => {
            members.values_mut().for_each(close);
            if members.contains_key("properties") && members.contains_key("type") {
                members.insert("unevaluatedProperties".into(), false.into());
            }
        }
        Value::Array(items) => items.iter_mut().for_each(close),
        _ => {}
    }
}

/// Holds a document that a command has printed against its schema, where it has one.
#[track_caller]
pub fn check(arguments: &[&str], document: &Value) {
    let words: Vec<&str> =
        arguments.iter().copied().filter(|word| !word.starts_with('-')).collect();
    let printed_by = |command: &&str| words.join(" ").starts_with(*command);
    let may_be = |kind: &&DocumentKind| match document.get("error") {
        Some(_) => kind.name == "error",
        None => kind.commands.iter().any(printed_by),
    };
    let candidates: Vec<&DocumentKind> = DocumentKind::ALL.iter().filter(may_be).collect();
    let wrong = |kind: &&DocumentKind| {
        let errors = VALIDATORS[kind.name].iter_errors(document);
        let errors = errors.map(|error| format!("{}: {error:.300}", error.instance_path()));
        (kind.name, errors.collect::<Vec<_>>())
    };
    let mismatches: Vec<_> = candidates.iter().map(wrong).collect();
    let fits = mismatches.is_empty() || mismatches.iter().any(|(_, wrong)| wrong.is_empty());
    assert!(fits, "{arguments:?}: {mismatches:#?}");
}

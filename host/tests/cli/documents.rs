//! What every test gets with `--json` is held against its schema.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use jsonschema::Validator;
use massline_report::document::Described;
use serde_json::Value;

/// Strict validators by the name of the document: no key may be missing in a schema, though readers have to admit new ones.
static VALIDATORS: LazyLock<BTreeMap<&str, Validator>> = LazyLock::new(|| {
    let of = |described: &Described| {
        let mut schema = described.schema().to_value();
        // A command may add keys to its error.
        if described.name != "error" {
            close(&mut schema);
        }
        (described.name, jsonschema::validator_for(&schema).unwrap())
    };
    Described::ALL.iter().map(of).collect()
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
    let may_be = |of: &&Described| match document.get("error") {
        Some(_) => of.name == "error",
        None => of.commands.iter().any(printed_by),
    };
    let candidates: Vec<&Described> = Described::ALL.iter().filter(may_be).collect();
    let wrong = |of: &&Described| {
        let errors = VALIDATORS[of.name].iter_errors(document);
        let errors = errors.map(|error| format!("{}: {error:.300}", error.instance_path()));
        (of.name, errors.collect::<Vec<_>>())
    };
    let found: Vec<_> = candidates.iter().map(wrong).collect();
    let fits = found.is_empty() || found.iter().any(|(_, wrong)| wrong.is_empty());
    assert!(fits, "{arguments:?}: {found:#?}");
}

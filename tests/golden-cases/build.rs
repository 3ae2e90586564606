//! Turns the JSON of `tests/golden` into Rust constants (`cases.rs` in the output folder).
//!
//! Every array of numbers becomes one flat slice, stored with its shape under a dotted path. A list of
//! objects becomes one array per key: `inputs.sensors` of three `{p, R}` gives `inputs.sensors.p` (3 × 3)
//! and `inputs.sensors.R` (3 × 3 × 3). Arrays of whole numbers below 65536 are stored as `u16`, so that
//! the ADC counts fit into a microcontroller's flash.

use std::fmt::Write as _;
use std::path::Path;
use std::{env, fs};

use serde_json::{Map, Value};

fn main() {
    let folder = Path::new(&env::var("CARGO_MANIFEST_DIR").unwrap()).join("../golden");
    println!("cargo::rerun-if-changed={}", folder.display());
    let mut files: Vec<_> = fs::read_dir(&folder)
        .unwrap_or_else(|e| panic!("{}: {e}", folder.display()))
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "json"))
        .collect();
    files.sort();
    let mut code =
        String::from("/// Every golden case, by name.\npub static CASES: &[Case] = &[\n");
    for file in files {
        println!("cargo::rerun-if-changed={}", file.display());
        let text = fs::read_to_string(&file).unwrap();
        let case: Value =
            serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        write_case(&mut code, &case);
    }
    code.push_str("];\n");
    fs::write(Path::new(&env::var("OUT_DIR").unwrap()).join("cases.rs"), code).unwrap();
}

fn write_case(code: &mut String, case: &Value) {
    assert_eq!(case["schema"], "rbp-golden/1");
    writeln!(
        code,
        "Case {{ id: {:?}, method: {:?}, arrays: &[",
        case["id"].as_str().unwrap(),
        case["method"].as_str().unwrap()
    )
    .unwrap();
    for part in ["inputs", "expected"] {
        flatten(code, part, &case[part]);
    }
    code.push_str("], rules: &[\n");
    for (path, rule) in case["tolerance"].as_object().unwrap() {
        write_rule(code, path, rule.as_object().unwrap(), &case["expected"]["sd_stated"]);
    }
    code.push_str("] },\n");
}

/// `sd` is the unit of the tolerances `abs_sd`, number by number.
fn write_rule(code: &mut String, path: &str, rule: &Map<String, Value>, sd: &Value) {
    for key in rule.keys() {
        let known = ["abs", "rel", "abs_f32", "rel_f32", "abs_sd", "abs_sd_f32", "min", "note"]
            .contains(&key.as_str());
        assert!(known, "the rule of {path} has an unknown {key}");
    }
    let list = |key: &str, in_sd: &str| {
        let mut numbers = Vec::new();
        match (rule.get(key), rule.get(in_sd)) {
            (None, None) => return "None".to_string(),
            (Some(value), _) => collect(value, &mut numbers),
            (None, Some(factor)) => {
                collect(sd, &mut numbers);
                numbers.iter_mut().for_each(|sd| *sd *= factor.as_f64().unwrap());
            }
        }
        format!("Some(&{numbers:?})")
    };
    let number = |key: &str| match rule.get(key) {
        None => "None".to_string(),
        Some(value) => format!("Some({:?})", value.as_f64().unwrap()),
    };
    let note = rule.get("note").and_then(Value::as_str).unwrap_or("");
    writeln!(
        code,
        "Rule {{ path: {path:?}, abs: {}, rel: {}, abs_f32: {}, rel_f32: {}, min: {}, \
         columns_up_to_sign: {}, set: {} }},",
        list("abs", "abs_sd"),
        number("rel"),
        list("abs_f32", "abs_sd_f32"),
        number("rel_f32"),
        number("min"),
        note.contains("columns up to sign"),
        note.contains("set equality"),
    )
    .unwrap();
}

fn flatten(code: &mut String, path: &str, value: &Value) {
    match value {
        Value::Object(members) => {
            for (key, member) in members {
                flatten(code, &format!("{path}.{key}"), member);
            }
        }
        Value::Array(_) if holds_objects(value) => {
            for key in first_object(value).keys() {
                flatten(code, &format!("{path}.{key}"), &pick(value, key));
            }
        }
        Value::Array(items) if items.iter().all(Value::is_string) => {
            writeln!(
                code,
                "Array {{ path: {path:?}, shape: &[{}], values: Values::Text(&{items:?}) }},",
                items.len(),
                items = items.iter().map(|i| i.as_str().unwrap()).collect::<Vec<_>>(),
            )
            .unwrap();
        }
        Value::Array(_) | Value::Number(_) | Value::Bool(_) => {
            let mut shape = Vec::new();
            measure(value, &mut shape);
            let mut numbers = Vec::new();
            collect(value, &mut numbers);
            assert_eq!(numbers.len(), shape.iter().product::<usize>(), "{path} is ragged");
            let whole = |v: &f64| *v >= 0.0 && *v < 65536.0 && v.fract() == 0.0;
            let values = if !shape.is_empty() && numbers.iter().all(whole) {
                let counts: Vec<u16> = numbers.iter().map(|&v| v as u16).collect();
                format!("Values::Whole(&{counts:?})")
            } else {
                format!("Values::Real(&{numbers:?})")
            };
            writeln!(code, "Array {{ path: {path:?}, shape: &{shape:?}, values: {values} }},")
                .unwrap();
        }
        Value::String(_) | Value::Null => {}
    }
}

fn holds_objects(value: &Value) -> bool {
    match value {
        Value::Array(items) => items.first().is_some_and(holds_objects),
        other => other.is_object(),
    }
}

fn first_object(value: &Value) -> &Map<String, Value> {
    match value {
        Value::Array(items) => first_object(&items[0]),
        other => other.as_object().unwrap(),
    }
}

/// The same nested lists with every object replaced by one of its members.
fn pick(value: &Value, key: &str) -> Value {
    match value {
        Value::Array(items) => Value::Array(items.iter().map(|item| pick(item, key)).collect()),
        other => other[key].clone(),
    }
}

fn measure(value: &Value, shape: &mut Vec<usize>) {
    if let Value::Array(items) = value {
        shape.push(items.len());
        if let Some(first) = items.first() {
            measure(first, shape);
        }
    }
}

fn collect(value: &Value, numbers: &mut Vec<f64>) {
    match value {
        Value::Array(items) => items.iter().for_each(|item| collect(item, numbers)),
        Value::Bool(flag) => numbers.push(f64::from(u8::from(*flag))),
        // `null` stands for "not finite / not available".
        Value::Null => numbers.push(f64::NAN),
        other => numbers.push(other.as_f64().unwrap()),
    }
}

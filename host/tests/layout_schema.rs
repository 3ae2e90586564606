//! The JSON schema of layout files accepts and refuses the same files as the reader.

use jsonschema::Validator;
use massline_files::layout_file::{LayoutFile, SCHEMA, template};
use massline_shared::layout::{
    HitPolicy, HitUncertainty, SensorUncertainty, TestProfile, uncertainty_keys,
};
use serde_json::Value;

/// A layout with every table and every form of an entry.
const FULL: &str = r#"
title = "everything"
gravity = [0.0, 0.0, -9.80665]
sensors = [
    1,
    { node = 2, axes = [[0, 1, 0], [-1, 0, 0]], senses_gravity = false, calibration = "A17", attached_mass_kg = 0.002 },
    { node = 3, attached_mass_kg = { value = 0.004, sigma = 0.0002 }, uncertainty = { gain = 0.01 } },
]
hits = ["1:+Y", " 2:-z ", { dof = "3:+X", axes = [[1, 0, 0], [0, 1, 0]], uncertainty = { node_position_m = 0 } }]
node = [
    { id = 1, position_m = [0, 0, 0], can_carry_sensor = false, can_hit = ["+X", "-z"] },
    { id = 2, position_m = [0.2, -0.2, 0], axes = [[1, 0, 0], [0, 1, 0]] },
    { id = 3, position_m = [0.2, 0, 0.1] },
]
attached = [{ mass_kg = { value = 0.05, sigma = 0.001 }, center_of_mass_m = [0.1, 0, 0] }]
[test]
hits_per_dof = 5
band_hz = "auto"
exponential_decay_per_s = 0
min_peak_force_n = 8
impulse_ns = [0.8, 1.3]
frf_estimator = "hv"
[policy]
too_hard = "keep"
[uncertainty]
hammer_gain = 0.0
[target]
mass = 0.01
center_m = 0.001
inertia = 0.02

[prior]
mass_kg = { value = 1.23, sigma = 0.001 }
[reference]
mass_kg = 1.23
inertia_kg_m2 = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
"#;

fn schema() -> Value {
    serde_json::from_str(SCHEMA).unwrap()
}

fn validator() -> Validator {
    jsonschema::validator_for(&schema()).unwrap()
}

/// A layout parsed as an editor does.
fn document(text: &str) -> Value {
    toml::from_str(text).unwrap()
}

#[test]
fn good_layouts_fit_the_schema() {
    let validator = validator();
    let examples =
        ["block", "three-bar-test-1", "three-bar-test-2", "three-bar-test-3", "three-bar-test-4"]
            .map(|name| std::fs::read_to_string(format!("examples/{name}.toml")).unwrap());
    let commented = template(TestProfile::MassLine);
    for text in examples.iter().map(String::as_str).chain([&*commented, FULL]) {
        let errors: Vec<_> =
            validator.iter_errors(&document(text)).map(|e| e.to_string()).collect();
        assert!(errors.is_empty(), "{errors:?}\n{text}");
        LayoutFile::parse(text, "l.toml").unwrap();
    }
}

#[test]
fn what_the_reader_refuses_the_schema_refuses() {
    let validator = validator();
    for (from, to) in [
        ("title =", "name ="),
        ("\"everything\"", r#""a title with a\u001b[2J terminal's commands""#),
        ("gravity = [0.0, 0.0, -9.80665]", "gravity = [0.0, -9.80665]"),
        ("    1,\n", "    0,\n"),
        ("    1,\n", "    \"1\",\n"),
        ("node = 2,", "node = 65536,"),
        ("attached_mass_kg = 0.002", "attached_mass_kg = -0.002"),
        ("gain = 0.01", "gain = -0.01"),
        ("gain = 0.01", "hammer_gain = 0.01"),
        ("\"1:+Y\"", "\"1:Y\""),
        ("dof = \"3:+X\", ", ""),
        ("id = 1,", "id = -1,"),
        ("id = 2, position_m", "id = 2, position"),
        ("can_hit = [\"+X\"", "can_hit = [\"X\""),
        ("axes = [[1, 0, 0], [0, 1, 0]] }", "axes = [[1, 0, 0]] }"),
        ("hits_per_dof = 5", "hits_per_dof = 0"),
        ("hits_per_dof = 5", "hits_per_dof = 256"),
        ("band_hz = \"auto\"", "band_hz = \"wide\""),
        ("band_hz = \"auto\"", "band_hz = [0, 100]"),
        ("band_hz = \"auto\"", "band_hz = [100]"),
        ("exponential_decay_per_s = 0", "exponential_decay_per_s = -1"),
        ("min_peak_force_n = 8", "min_peak_force_n = -1"),
        ("impulse_ns = [0.8, 1.3]", "impulse_ns = [0.8]"),
        ("frf_estimator = \"hv\"", "profile = \"modal\""),
        ("frf_estimator = \"hv\"", "frf_estimator = \"h3\""),
        ("too_hard = \"keep\"", "too_hard = \"ignore\""),
        ("sigma = 0.0002", "sigma = -0.0002"),
        ("sigma = 0.001 }\n[reference]", "sigma = 0 }\n[reference]"),
        ("center_of_mass_m = [0.1, 0, 0]", "center_of_mass = [0.1, 0, 0]"),
        ("mass_kg = 1.23", "mass_kg = 0"),
        ("[0, 1, 0], [0, 0, 1]]\n", "[0, 1, 0]]\n"),
        ("[0, 1, 0], [0, 0, 1]]\n", "[0, 1, 0], [0, 0, 1], [0, 0, 1]]\n"),
        ("position_m = [0.2, 0, 0.1]", "position_m = [0.2, 0, 0.1, 0]"),
        ("gravity = [0.0, 0.0, -9.80665]", "gravity = [0.0, 0.0, -9.80665, 0.0]"),
        ("axes = [[1, 0, 0], [0, 1, 0]] }", "axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]] }"),
        ("band_hz = \"auto\"", "band_hz = [10, 100, 120]"),
        ("center_m = 0.001", "center_m = 0"),
    ] {
        assert!(FULL.contains(from), "{from}");
        let text = FULL.replacen(from, to, 1);
        assert!(!validator.is_valid(&document(&text)), "the schema takes {to}");
        assert!(LayoutFile::parse(&text, "l.toml").is_err(), "the reader takes {to}");
    }
}

#[test]
fn the_reader_takes_every_word_that_the_schema_offers() {
    let schema = schema();
    let tests = &schema["properties"]["test"]["properties"];
    let offered = |key: &str| tests[key]["enum"].as_array().unwrap().clone();
    for (key, count) in [("frf_estimator", 3), ("terms", 3)] {
        let words = offered(key);
        assert_eq!(words.len(), count);
        for word in words {
            let text = FULL.replacen("frf_estimator = \"hv\"", &format!("{key} = {word}"), 1);
            LayoutFile::parse(&text, "l.toml").unwrap();
        }
    }
}

/// The number of keys of all tables in a schema, each of which has a description of its own.
fn described_keys(schema: &Value) -> usize {
    let Some(members) = schema.as_object() else { return 0 };
    let properties = members.get("properties").and_then(Value::as_object).into_iter().flatten();
    let own = properties.map(|(key, property)| {
        assert!(property["description"].as_str().is_some_and(|text| text.len() > 5), "{key}");
        1
    });
    own.sum::<usize>() + members.values().map(described_keys).sum::<usize>()
}

#[test]
fn every_key_is_described_and_none_is_null() {
    let schema = schema();
    assert!(!schema.to_string().contains("null"), "TOML has no null");
    let keys = described_keys(&schema);
    // All keys of the tables: file 13, node 5, sensor 6, hit 3, test 10, target 3, prior 10, attached 3, known value 2,
    // reference 3, report 7; the budget with `learn`, and what of it a sensor or a hit may state; the policy.
    let (policy, budget) = (HitPolicy::CODES.len(), uncertainty_keys().count() + 1);
    let own = SensorUncertainty::<f64>::KEYS.len() + HitUncertainty::<f64>::KEYS.len();
    assert_eq!(keys, 65 + policy + budget + own);
}

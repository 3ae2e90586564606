use serde::{Deserialize, Serialize};
use serde_json::json;

use super::*;

#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Sample {
    title: String,
    mass_kg: f64,
    noise: Vec<f32>,
    axes: [[f64; 2]; 2],
    codes: Vec<u16>,
    offset: Option<i8>,
    kind: Kind,
    names: Vec<Kind>,
    #[serde(flatten)]
    beside: Beside,
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Beside {
    is_good: bool,
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Kind {
    Plain,
    Value(f64),
    Pair(u8, u8),
    Named { hits: u32 },
}

fn sample() -> Sample {
    Sample {
        title: "a \"bar\" of 3 µm".into(),
        mass_kg: 0.1 + 0.2,
        // The third lies so near to the middle of two that its text in double precision rounds to the other one.
        noise: vec![0.1, -0.0, 7.038531e-26, 1e-45, f32::MIN_POSITIVE, f32::MAX],
        axes: [[1.0, 0.0], [0.0, 1.0]],
        codes: vec![0, 4095, u16::MAX],
        offset: Some(-3),
        kind: Kind::Named { hits: u32::MAX },
        names: vec![Kind::Plain, Kind::Value(2.0), Kind::Pair(1, 2)],
        beside: Beside { is_good: true },
    }
}

fn wrong(key: &str, value: serde_json::Value) -> String {
    let mut document = serde_json::to_value(sample()).unwrap();
    document[key] = value;
    let text = Json::parse(document.to_string().as_bytes()).unwrap();
    text.read::<Sample>().unwrap_err().to_string()
}

#[test]
fn what_serde_json_writes_is_read() {
    let text = serde_json::to_vec(&sample()).unwrap();
    assert_eq!(Json::parse(&text).unwrap().read::<Sample>().unwrap(), sample());
}

/// Whole numbers where any number may stand, as other programs write them, and numbers of both kinds in one list.
#[test]
fn a_number_may_be_written_without_a_point() {
    let mut document = serde_json::to_value(sample()).unwrap();
    document["mass_kg"] = json!(3);
    document["axes"] = json!([[1, -2], [0.5, 18_446_744_073_709_551_615_u64]]);
    let text = Json::parse(document.to_string().as_bytes()).unwrap();
    let read: Sample = text.read().unwrap();
    assert_eq!((read.mass_kg, read.axes), (3.0, [[1.0, -2.0], [0.5, 2_f64.powi(64)]]));
}

#[test]
fn what_is_wrong_has_a_place() {
    let number = wrong("mass_kg", json!(null));
    assert_eq!(number, "mass_kg: invalid type: null, expected a number");
    assert_eq!(
        wrong("mass_kg", json!("1")),
        "mass_kg: invalid type: string \"1\", expected a number"
    );
    assert_eq!(
        wrong("codes", json!([1, 2, -3])),
        "codes[2]: invalid value: integer `-3`, expected a whole number that is not negative"
    );
    assert_eq!(
        wrong("codes", json!([1.5])),
        "codes[0]: invalid type: floating point `1.5`, expected a whole number that is not negative"
    );
    assert_eq!(wrong("noise", json!([1.0, 1e39])), "noise[1]: number out of range");
    assert_eq!(
        wrong("axes", json!([[1.0, 0.0], [1.0]])),
        "axes[1]: invalid length 1, expected an array of length 2"
    );
    assert_eq!(
        wrong("axes", json!([[1.0, 0.0], [1.0, 2.0, 3.0]])),
        "axes[1]: invalid length 3, expected 2 elements"
    );
    assert_eq!(
        wrong("names", json!([{ "value": "x" }])),
        "names[0].value: invalid type: string \"x\", expected a number"
    );
    assert_eq!(wrong("kind", json!({ "named": {} })), "kind.named: missing field `hits`");
    assert_eq!(
        wrong("kind", json!("round")),
        "kind: unknown variant `round`, expected one of `plain`, `value`, `pair`, `named`"
    );
    assert_eq!(
        wrong("kind", json!({})),
        "kind: invalid type: map, expected an object with one key"
    );
    assert_eq!(wrong("kind", json!("named")), "kind: `named` needs a value");
    assert_eq!(
        wrong("mass_kg", json!("1, expected u8")),
        "mass_kg: invalid type: string \"1, expected u8\", expected a number"
    );
}

/// A table given as a list of its values has lost its keys.
#[test]
fn a_list_is_no_object() {
    let text = Json::parse(br#"[true]"#).unwrap();
    let error = text.read::<Beside>().unwrap_err().to_string();
    assert_eq!(error, "the document: invalid type: sequence, expected an object");
}

#[test]
fn a_key_that_is_there_twice_is_refused() {
    let text = Json::parse(br#"{"is_good":true,"is_good":false}"#).unwrap();
    let error = text.read::<Beside>().unwrap_err().to_string();
    assert_eq!(error, "the document: duplicate field `is_good`");
    assert_eq!(
        text.read_key::<bool>("is_good").unwrap_err().to_string(),
        "is_good: the key is there twice"
    );
}

#[test]
fn one_key_is_read_alone() {
    let text = Json::parse(br#"{"a":{"is_good":true},"b":null,"c":{"is_good":[]}}"#).unwrap();
    assert_eq!(text.read_key("a").unwrap(), Some(Beside { is_good: true }));
    assert_eq!(text.read_key::<Beside>("b").unwrap(), None);
    assert_eq!(text.read_key::<Beside>("d").unwrap(), None);
    assert_eq!(
        text.read_key::<Beside>("c").unwrap_err().to_string(),
        "c.is_good: invalid type: sequence, expected a boolean"
    );
}

#[test]
fn what_is_not_json_is_refused() {
    for text in ["", "{", "[1,]", "{} {}", "\"\\ud800\""] {
        assert!(Json::parse(text.as_bytes()).is_err(), "{text}");
    }
    let deep = "[".repeat(1000) + &"]".repeat(1000);
    assert!(Json::parse(deep.as_bytes()).is_err());
}

#[test]
fn what_cannot_be_parsed_has_a_place() {
    let error = |text: &str| Json::parse(text.as_bytes()).err().unwrap().to_string();
    assert_eq!(error("{\"a\":[1,{\"b\":1e999}]}"), "a[1].b: number out of range");
    assert!(error("{\"a\":[\"\\ud800\"]}").starts_with("a[0]: "));
}

/// Two or three characters for each value, which takes ten times that in memory.
#[test]
fn a_text_that_needs_too_much_memory_is_refused() {
    for part in ["[],", "\"\",", "null,", "{},", "[0],"] {
        let text = format!("{{\"a\":[{}0]}}", part.repeat(1 << 23));
        let error = Json::parse(text.as_bytes()).err().unwrap().to_string();
        assert!(error.starts_with("a") && error.contains("more than 192 MiB"), "{part}: {error}");
    }
    // A list of numbers takes their memory only.
    let text = format!("[{}1]", "1,".repeat(1 << 24));
    assert!(Json::parse(text.as_bytes()).is_ok());
}

//! Every document but the receipts is read back as it was written, whatever it holds: values are made from the schema.

use massline_result::{Modes, TestResult};
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};

use super::{
    BlockCalibration, Calibration, CalibrationCheck, CalibrationDemo, Demo, DemoWheel, DeviceAbort,
    DeviceBrownOut, DeviceCheck, DeviceErase, DeviceIdentity, DeviceList, DeviceStats, Doctor,
    Failure, LayoutCheck, LayoutSuggestion, ShownLayout, SimulatedRuns, Simulation,
    TumbleCalibration,
};

/// Documents of each kind that are made.
const CASES: u64 = 200;

/// Values that fit a schema.
struct Maker<'s> {
    definitions: &'s Map<String, Value>,
    /// State of the generator SplitMix64 (Steele, Lea and Flood, 2014).
    state: u64,
}

impl Maker<'_> {
    fn next(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, count: u64) -> u64 {
        self.next() % count.max(1)
    }

    fn one_of<'v>(&mut self, values: &'v [Value]) -> &'v Value {
        &values[self.below(values.len() as u64) as usize]
    }

    fn value(&mut self, schema: &Value) -> Value {
        if let Some(name) = schema["$ref"].as_str() {
            let name = name.rsplit('/').next().unwrap();
            return self.value(&self.definitions[name]);
        }
        if let Some(constant) = schema.get("const") {
            return constant.clone();
        }
        for key in ["enum", "anyOf", "oneOf"] {
            if let Some(values) = schema[key].as_array() {
                let one = self.one_of(values).clone();
                return if key == "enum" { one } else { self.value(&one) };
            }
        }
        if let Some(examples) = schema["examples"].as_array() {
            return self.one_of(examples).clone();
        }
        let kind = match &schema["type"] {
            Value::Array(kinds) => self.one_of(kinds).clone(),
            kind => kind.clone(),
        };
        match kind.as_str() {
            Some("null") => Value::Null,
            Some("boolean") => json!(self.below(2) == 0),
            Some("string") => json!(self.text(schema["maxLength"].as_u64())),
            Some("integer") => self.integer(schema["format"].as_str()),
            Some("number") => self.number(schema["format"].as_str()),
            Some("array") => self.list(schema),
            Some("object") => self.object(schema),
            other => panic!("no value is made for {other:?}: {schema}"),
        }
    }

    fn text(&mut self, most: Option<u64>) -> String {
        const LETTERS: [char; 8] = ['a', 'Z', '0', ' ', '"', '\\', 'µ', '−'];
        let length = most.unwrap_or_else(|| self.below(6));
        (0..length).map(|_| LETTERS[self.below(8) as usize]).collect()
    }

    fn integer(&mut self, format: Option<&str>) -> Value {
        let bits = format
            .and_then(|format| format.trim_start_matches(|c: char| c.is_alphabetic()).parse().ok());
        // Of a size that every program reads.
        json!(self.next() >> (64 - bits.unwrap_or(32_u32).min(53)))
    }

    fn number(&mut self, format: Option<&str>) -> Value {
        let mantissa = (self.next() >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
        let number = mantissa * 10_f64.powi(self.below(24) as i32 - 12);
        match format {
            // With the digits of single precision.
            Some("float") => json!(f64::from(number as f32)),
            _ => json!(number),
        }
    }

    fn list(&mut self, schema: &Value) -> Value {
        let least = schema["minItems"].as_u64().unwrap_or(0);
        let length = schema["maxItems"].as_u64().unwrap_or_else(|| least + self.below(3));
        (0..length)
            .map(|k| match schema["prefixItems"].get(k as usize) {
                Some(item) => self.value(item),
                None => self.value(&schema["items"]),
            })
            .collect()
    }

    fn object(&mut self, schema: &Value) -> Value {
        let mut object = Map::new();
        let required = schema["required"].as_array().cloned().unwrap_or_default();
        for (key, property) in schema["properties"].as_object().into_iter().flatten() {
            if required.contains(&json!(key)) || self.below(2) == 0 {
                object.insert(key.clone(), self.value(property));
            }
        }
        if schema["additionalProperties"].is_object() {
            object.insert(self.text(None), self.value(&schema["additionalProperties"]));
        }
        Value::Object(object)
    }
}

/// Checks that everything in `part` stands in `whole` as well.
#[track_caller]
fn holds(whole: &Value, part: &Value, place: &str) {
    match (whole, part) {
        (Value::Object(whole), Value::Object(part)) => {
            for (key, part_value) in part {
                // An empty list or nothing may be left out.
                let is_nothing =
                    part_value.is_null() || part_value.as_array().is_some_and(Vec::is_empty);
                match whole.get(key) {
                    Some(whole_value) => holds(whole_value, part_value, &format!("{place}.{key}")),
                    None => assert!(is_nothing, "{place}.{key} is lost"),
                }
            }
        }
        (Value::Array(whole), Value::Array(part)) => {
            assert_eq!(whole.len(), part.len(), "{place}");
            for (k, (whole_value, part_value)) in whole.iter().zip(part).enumerate() {
                holds(whole_value, part_value, &format!("{place}[{k}]"));
            }
        }
        (Value::Number(whole), Value::Number(part)) => {
            assert_eq!(whole.as_f64(), part.as_f64(), "{place}");
        }
        _ => assert_eq!(whole, part, "{place}"),
    }
}

#[track_caller]
fn round_trips<T: Serialize + DeserializeOwned + JsonSchema + PartialEq + std::fmt::Debug>() {
    let generator = SchemaSettings::draft2020_12().for_serialize().into_generator();
    let schema = generator.into_root_schema_for::<T>().to_value();
    let none = Map::new();
    let definitions = schema["$defs"].as_object().unwrap_or(&none);
    for seed in 0..CASES {
        let document = Maker { definitions, state: seed }.value(&schema);
        let read: T = serde_json::from_value(document.clone())
            .unwrap_or_else(|e| panic!("seed {seed}: {e}: {document}"));
        let written = serde_json::to_value(&read).unwrap();
        holds(&written, &document, "");
        let again: T = serde_json::from_str(&written.to_string()).unwrap();
        assert_eq!(again, read, "seed {seed}");
    }
}

#[test]
fn whatever_a_document_holds_it_reads_back_as_it_was_written() {
    round_trips::<TestResult>();
    round_trips::<Modes>();
    round_trips::<Demo>();
    round_trips::<DemoWheel>();
    round_trips::<Simulation>();
    round_trips::<SimulatedRuns>();
    round_trips::<ShownLayout>();
    round_trips::<LayoutCheck>();
    round_trips::<LayoutSuggestion>();
    round_trips::<DeviceList>();
    round_trips::<DeviceIdentity>();
    round_trips::<DeviceStats>();
    round_trips::<DeviceAbort>();
    round_trips::<DeviceErase>();
    round_trips::<DeviceBrownOut>();
    round_trips::<DeviceCheck>();
    round_trips::<Doctor>();
    round_trips::<Calibration>();
    round_trips::<TumbleCalibration>();
    round_trips::<BlockCalibration>();
    round_trips::<CalibrationCheck>();
    round_trips::<CalibrationDemo>();
    round_trips::<Failure>();
}

//! The JSON schema of the layout file.

use std::borrow::Cow;

use massline_shared::diagnosis::{AllowedValues, MAX_HITS_PER_DOF, Setting};
use massline_shared::layout::{
    AUTOMATIC, HitPolicy, HitTreatment, TARGET_KEYS, TEST_KEYS, TestForm, TestKey, uncertainty_keys,
};
use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::{Map, Value};

use super::budget::{BudgetKeys, HitKeys, LEARN, SensorKeys};
use super::entry::{RawHit, RawHitTable, RawSensor, RawSensorTable};
use super::keyed::{KeyedTable, TableKeys};
use super::known::{PRIOR_KEYS, PriorKeys};
use super::policy::PolicyKeys;
use super::raw::RawLayout;
use super::test_settings::{TargetKeys, TestKeys};
use super::values::RawKnown;

/// Generates the JSON schema (draft 2020-12) of the layout file; the program prints [`SCHEMA`](super::SCHEMA).
#[must_use]
pub fn schema() -> Value {
    let settings = SchemaSettings::draft2020_12().with_transform(RecursiveTransform(adapt_to_toml));
    massline_result::generate_schema::<RawLayout>(settings)
}

/// Removes what does not apply to TOML: the formats of Rust's numbers, and null as the default of an optional
/// key.
fn adapt_to_toml(schema: &mut Schema) {
    schema.remove("format");
    if schema.get("default").is_some_and(Value::is_null) {
        schema.remove("default");
    }
}

/// Keys with a schema.
trait DescribedKeys: TableKeys {
    /// The schema of a key, with its description.
    fn schema(name: &str, generator: &mut SchemaGenerator) -> Schema;
}

impl<K: DescribedKeys> JsonSchema for KeyedTable<K> {
    fn schema_name() -> Cow<'static, str> {
        std::any::type_name::<K>().into()
    }

    /// Each table is used once, and is described there.
    fn inline_schema() -> bool {
        true
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let property = |name: &&str| ((*name).to_owned(), K::schema(name, generator).to_value());
        let properties: Map<_, _> = K::names().iter().map(property).collect();
        json_schema!({ "type": "object", "properties": properties, "additionalProperties": false })
    }
}

impl DescribedKeys for TestKeys {
    fn schema(name: &str, _: &mut SchemaGenerator) -> Schema {
        let Some(key) = TEST_KEYS.iter().find(|key| key.name == name) else {
            return Schema::default();
        };
        let mut schema = match key.form {
            TestForm::Word(choice) => json_schema!({ "type": "string", "enum": choice.words() }),
            TestForm::Number(setting) => number_schema(setting.allowed()),
            TestForm::Range([lower, _]) => {
                let range = json_schema!({
                    "type": "array",
                    "items": number_schema(lower.allowed()),
                    "minItems": 2,
                    "maxItems": 2,
                });
                match lower {
                    Setting::BandLower => {
                        json_schema!({ "oneOf": [range, { "const": AUTOMATIC }] })
                    }
                    _ => range,
                }
            }
        };
        schema.insert("description".into(), describe(key).into());
        schema
    }
}

/// What a key says, with its unit.
fn describe(key: &TestKey) -> String {
    let unit = match key.form {
        TestForm::Number(setting) | TestForm::Range([setting, _]) => setting.unit(),
        TestForm::Word(_) => "",
    };
    let text = sentence(key.meaning);
    if unit.is_empty() { text } else { format!("{text} Unit: {unit}.") }
}

impl DescribedKeys for TargetKeys {
    fn schema(name: &str, _: &mut SchemaGenerator) -> Schema {
        let key = TARGET_KEYS.iter().find(|key| key.name == name);
        let mut schema = number_schema(AllowedValues::Positive);
        schema.insert("description".into(), key.map(|key| sentence(key.meaning)).into());
        schema
    }
}

impl DescribedKeys for PriorKeys {
    fn schema(name: &str, generator: &mut SchemaGenerator) -> Schema {
        let key = PRIOR_KEYS.iter().find(|key| key.name == name);
        let mut schema = generator.subschema_for::<RawKnown>();
        schema.insert("description".into(), key.map(|key| key.meaning).into());
        schema
    }
}

impl DescribedKeys for PolicyKeys {
    fn schema(name: &str, _: &mut SchemaGenerator) -> Schema {
        let code = HitPolicy::CODES.into_iter().find(|code| code.name() == name);
        json_schema!({
            "description": code.map(|code| code.meaning()),
            "type": "string",
            "enum": HitTreatment::NAMES,
        })
    }
}

impl DescribedKeys for BudgetKeys {
    fn schema(name: &str, _: &mut SchemaGenerator) -> Schema {
        match name {
            LEARN => json_schema!({
                "description": "True when the data may correct the budget; false to use it as stated.",
                "type": "boolean",
                "default": true,
            }),
            _ => sigma_schema(name),
        }
    }
}

impl DescribedKeys for SensorKeys {
    fn schema(name: &str, _: &mut SchemaGenerator) -> Schema {
        sigma_schema(name)
    }
}

impl DescribedKeys for HitKeys {
    fn schema(name: &str, _: &mut SchemaGenerator) -> Schema {
        sigma_schema(name)
    }
}

fn sigma_schema(name: &str) -> Schema {
    let key = uncertainty_keys().find(|key| key.name == name);
    let mut schema = number_schema(AllowedValues::NotNegative);
    let meaning = key.map(|key| format!("{}, {}.", key.meaning, key.unit.name()));
    schema.insert("description".into(), meaning.into());
    schema
}

fn number_schema(allowed: AllowedValues) -> Schema {
    match allowed {
        AllowedValues::HitCount => {
            json_schema!({ "type": "integer", "minimum": 1, "maximum": MAX_HITS_PER_DOF })
        }
        AllowedValues::NotNegative => json_schema!({ "type": "number", "minimum": 0 }),
        AllowedValues::Positive => json_schema!({ "type": "number", "exclusiveMinimum": 0 }),
    }
}

/// A meaning as a sentence of its own.
fn sentence(meaning: &str) -> String {
    let mut letters = meaning.chars();
    let first = letters.next().map(char::to_uppercase);
    first.into_iter().flatten().chain(letters).chain(['.']).collect()
}

impl JsonSchema for RawSensor {
    fn schema_name() -> Cow<'static, str> {
        "sensor".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "The number of the node where a sensor sits, or a table.",
            "oneOf": [
                generator.subschema_for::<NodeNumber>(),
                generator.subschema_for::<RawSensorTable>(),
            ],
        })
    }
}

impl JsonSchema for RawHit {
    fn schema_name() -> Cow<'static, str> {
        "hit".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A DOF, or a table.",
            "oneOf": [
                generator.subschema_for::<DofText>(),
                generator.subschema_for::<RawHitTable>(),
            ],
        })
    }
}

/// A node number.
pub(super) enum NodeNumber {}

impl JsonSchema for NodeNumber {
    fn schema_name() -> Cow<'static, str> {
        "node_number".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "Number of a node.",
            "type": "integer",
            "minimum": 1,
            "maximum": u16::MAX,
        })
    }
}

/// A DOF.
pub(super) enum DofText {}

impl JsonSchema for DofText {
    fn schema_name() -> Cow<'static, str> {
        "dof".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "Node, colon, sign and axis: 1:+Y is a force on the body along local +y of node 1.",
            "type": "string",
            "pattern": r"^\s*[0-9]+:[+-][XYZxyz]\s*$",
        })
    }
}

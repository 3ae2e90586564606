//! The schemas of the documents, made from their types: those in `host/schemas/` are what the program prints.

use massline_result::TestResult;
use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;
use schemars::{JsonSchema, Schema};
use serde::Serialize;
use serde_json::Value;

use super::{
    Calibration, DeviceIdentity, Failure, LayoutCheck, ShownLayout, SimulatedRuns, Simulation,
};

/// A document with the version of its schema, as it is printed.
#[derive(Serialize, JsonSchema)]
struct Versioned<T> {
    /// It is incremented whenever a key is renamed or removed or changes its meaning, but not when a key is added.
    schema_version: u32,
    #[serde(flatten)]
    document: T,
}

/// The schema of each document that has one, draft 2020-12, by its name.
#[must_use]
pub fn schemas() -> [(&'static str, Value); 8] {
    [
        ("result", schema_of::<TestResult>()),
        ("simulation", schema_of::<Simulation>()),
        ("simulated-runs", schema_of::<SimulatedRuns>()),
        ("layout", schema_of::<ShownLayout>()),
        ("layout-check", schema_of::<LayoutCheck>()),
        ("device", schema_of::<DeviceIdentity>()),
        ("calibration", schema_of::<Calibration>()),
        ("error", schema_of::<Failure>()),
    ]
}

fn schema_of<T: JsonSchema>() -> Value {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    massline_result::schema_of::<Versioned<T>>(
        settings.with_transform(RecursiveTransform(join_lines)),
    )
}

/// Joins the lines of a description, which end where those of the source do.
fn join_lines(schema: &mut Schema) {
    if let Some(Value::String(description)) = schema.get_mut("description") {
        let paragraphs = description.split("\n\n").map(|paragraph| paragraph.replace('\n', " "));
        *description = paragraphs.collect::<Vec<_>>().join("\n\n");
    }
}

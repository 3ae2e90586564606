//! Generates the schemas of the documents; the program prints the copies in `host/schemas/`.

use massline_result::{TestResult, generate_schema};
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
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
    generate_schema::<Versioned<T>>(SchemaSettings::draft2020_12().for_serialize())
}

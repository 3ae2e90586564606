//! The documents that have a schema: what other programs read.

use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Serialize;
use serde_json::Value;

use massline_result::TestResult;

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

/// A document that has a schema.
pub struct DocumentKind {
    /// Its name.
    pub name: &'static str,
    /// What it is.
    pub summary: &'static str,
    /// The commands that print it.
    pub commands: &'static [&'static str],
    schema: fn(&mut SchemaGenerator) -> Schema,
}

impl DocumentKind {
    /// Every document that has a schema.
    pub const ALL: [Self; 8] = [
        Self {
            name: "result",
            summary: "the result of a test",
            commands: &["measure", "solve", "results get", "replay"],
            schema: schema_of::<TestResult>,
        },
        Self {
            name: "simulation",
            summary: "a simulated test beside the truth",
            commands: &["simulate"],
            schema: schema_of::<Simulation>,
        },
        Self {
            name: "simulated-runs",
            summary: "many simulated tests of a layout, from --runs",
            commands: &["simulate"],
            schema: schema_of::<SimulatedRuns>,
        },
        Self {
            name: "layout",
            summary: "a layout with resolved positions and directions",
            commands: &["layout show"],
            schema: schema_of::<ShownLayout>,
        },
        Self {
            name: "layout-check",
            summary: "how accurate a layout will be, and what limits it",
            commands: &["layout check"],
            schema: schema_of::<LayoutCheck>,
        },
        Self {
            name: "device",
            summary: "who a rig is and what it is doing",
            commands: &["device identify"],
            schema: schema_of::<DeviceIdentity>,
        },
        Self {
            name: "calibration",
            summary: "the calibration of a rig",
            commands: &["calibrate show", "calibrate push"],
            schema: schema_of::<Calibration>,
        },
        Self {
            name: "error",
            summary: "why a command has failed",
            commands: &[],
            schema: schema_of::<Failure>,
        },
    ];

    /// The schema, draft 2020-12.
    pub fn schema(&self) -> Schema {
        let settings = SchemaSettings::draft2020_12().for_serialize();
        let settings = settings.with_transform(RecursiveTransform(join_lines));
        (self.schema)(&mut settings.into_generator())
    }
}

fn schema_of<T: JsonSchema>(generator: &mut SchemaGenerator) -> Schema {
    std::mem::take(generator).into_root_schema_for::<Versioned<T>>()
}

/// Joins the lines of a description, which end where those of the source do.
fn join_lines(schema: &mut Schema) {
    if let Some(Value::String(description)) = schema.get_mut("description") {
        let paragraphs = description.split("\n\n").map(|paragraph| paragraph.replace('\n', " "));
        *description = paragraphs.collect::<Vec<_>>().join("\n\n");
    }
}

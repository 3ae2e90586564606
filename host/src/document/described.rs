//! The documents that have a schema.

use schemars::{JsonSchema, Schema, SchemaGenerator, generate::SchemaSettings};
use serde::Serialize;

use super::{
    BlockCalibration, Calibration, CalibrationCheck, CalibrationDemo, Completions, DeletedResults,
    Demo, DemoWheel, DemoWheelFiles, DeviceAbort, DeviceBrownOut, DeviceCheck, DeviceErase,
    DeviceIdentity, DeviceList, DeviceStats, Doctor, DrawnPictures, ExportedFile, Failure,
    Flashing, History, Hits, LayoutCheck, LayoutSuggestion, LayoutTemplate, ManualPage,
    Measurement, Modes, RecordedTape, ResultsList, SchemaList, ShownLayout, SimulatedRuns,
    Simulation, Solution, TumbleCalibration, VirtualPort, WrittenFile, WrittenPages,
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
pub struct Described {
    /// Its name.
    pub name: &'static str,
    /// What it is.
    pub summary: &'static str,
    /// The commands that print it.
    pub commands: &'static [&'static str],
    schema: fn(&mut SchemaGenerator) -> Schema,
}

impl Described {
    /// Every document that has a schema.
    pub const ALL: [Self; 40] = [
        Self {
            name: "measurement",
            summary: "a result of a rig, and what the host finds from it",
            commands: &["measure", "results get", "replay", "solve"],
            schema: of::<Measurement>,
        },
        Self {
            name: "solution",
            summary: "the solution of frequency responses",
            commands: &["solve"],
            schema: of::<Solution>,
        },
        Self {
            name: "modes",
            summary: "the suspension modes",
            commands: &["modes"],
            schema: of::<Modes>,
        },
        Self {
            name: "results-list",
            summary: "the results that a rig keeps",
            commands: &["results list"],
            schema: of::<ResultsList>,
        },
        Self {
            name: "results-delete",
            summary: "the results that were deleted on a rig",
            commands: &["results delete"],
            schema: of::<DeletedResults>,
        },
        Self {
            name: "history",
            summary: "the archives in a folder",
            commands: &["history"],
            schema: of::<History>,
        },
        Self {
            name: "hits",
            summary: "the graded hits of a recording",
            commands: &["hits"],
            schema: of::<Hits>,
        },
        Self {
            name: "layout-check",
            summary: "how accurate a layout will be, and what limits it",
            commands: &["layout check"],
            schema: of::<LayoutCheck>,
        },
        Self {
            name: "layout-suggest",
            summary: "better sensors and hits among the nodes of a layout",
            commands: &["layout suggest"],
            schema: of::<LayoutSuggestion>,
        },
        Self {
            name: "layout-show",
            summary: "a layout with resolved positions and directions",
            commands: &["layout show"],
            schema: of::<ShownLayout>,
        },
        Self {
            name: "device-list",
            summary: "the USB serial ports of this computer",
            commands: &["device list"],
            schema: of::<DeviceList>,
        },
        Self {
            name: "device-identify",
            summary: "who a rig is and what it is doing",
            commands: &["device identify"],
            schema: of::<DeviceIdentity>,
        },
        Self {
            name: "device-stats",
            summary: "what a rig has counted since power-on",
            commands: &["device stats"],
            schema: of::<DeviceStats>,
        },
        Self {
            name: "device-abort",
            summary: "the end of a campaign on a rig",
            commands: &["device abort"],
            schema: of::<DeviceAbort>,
        },
        Self {
            name: "device-check",
            summary: "what a rig reads at rest, and faults of wiring and parts",
            commands: &["device check"],
            schema: of::<DeviceCheck>,
        },
        Self {
            name: "device-brown-out",
            summary: "the level at which a rig's chip resets itself",
            commands: &["device brown-out"],
            schema: of::<DeviceBrownOut>,
        },
        Self {
            name: "device-erase",
            summary: "what a rig in safe mode has erased",
            commands: &["device erase"],
            schema: of::<DeviceErase>,
        },
        Self {
            name: "doctor",
            summary: "what is plugged in, and what is missing on this computer",
            commands: &["doctor"],
            schema: of::<Doctor>,
        },
        Self {
            name: "simulation",
            summary: "a simulated test beside the truth",
            commands: &["simulate", "demo wheel"],
            schema: of::<Simulation>,
        },
        Self {
            name: "simulated-runs",
            summary: "many simulated tests of a layout, from --runs",
            commands: &["simulate"],
            schema: of::<SimulatedRuns>,
        },
        Self {
            name: "demo",
            summary: "the tests of the demonstration beside the truth",
            commands: &["demo"],
            schema: of::<Demo>,
        },
        Self {
            name: "demo-wheel",
            summary: "the methods of suspension modes against the truth",
            commands: &["demo wheel"],
            schema: of::<DemoWheel>,
        },
        Self {
            name: "demo-wheel-files",
            summary: "the files of the demonstration's wheel, from --write",
            commands: &["demo wheel"],
            schema: of::<DemoWheelFiles>,
        },
        Self {
            name: "record",
            summary: "a tape of a rig's scans",
            commands: &["record"],
            schema: of::<RecordedTape>,
        },
        Self {
            name: "flash",
            summary: "firmware, and the part of a board's flash that it takes",
            commands: &["flash"],
            schema: of::<Flashing>,
        },
        Self {
            name: "calibration",
            summary: "the calibration of a rig",
            commands: &["calibrate show", "calibrate push"],
            schema: of::<Calibration>,
        },
        Self {
            name: "calibrate-tumble",
            summary: "a calibration after a tumble test",
            commands: &["calibrate tumble"],
            schema: of::<TumbleCalibration>,
        },
        Self {
            name: "calibrate-block",
            summary: "a calibration after a block test",
            commands: &["calibrate block"],
            schema: of::<BlockCalibration>,
        },
        Self {
            name: "calibrate-verify",
            summary: "a check of a calibration by a block test",
            commands: &["calibrate verify"],
            schema: of::<CalibrationCheck>,
        },
        Self {
            name: "calibrate-demo",
            summary: "a calibration on the simulated bench, and what it improves",
            commands: &["calibrate demo"],
            schema: of::<CalibrationDemo>,
        },
        Self {
            name: "layout-new",
            summary: "a layout to start from",
            commands: &["layout new"],
            schema: of::<LayoutTemplate>,
        },
        Self {
            name: "written",
            summary: "a file that was written",
            commands: &["layout new", "calibrate pull", "report"],
            schema: of::<WrittenFile>,
        },
        Self {
            name: "export",
            summary: "a file for another program",
            commands: &["export"],
            schema: of::<ExportedFile>,
        },
        Self {
            name: "virtual",
            summary: "the port of a virtual rig",
            commands: &["virtual"],
            schema: of::<VirtualPort>,
        },
        Self {
            name: "completions",
            summary: "what a shell knows about the program",
            commands: &["completions"],
            schema: of::<Completions>,
        },
        Self {
            name: "plot",
            summary: "pictures that were written",
            commands: &["plot"],
            schema: of::<DrawnPictures>,
        },
        Self {
            name: "man",
            summary: "the manual page of the program",
            commands: &["man"],
            schema: of::<ManualPage>,
        },
        Self {
            name: "man-pages",
            summary: "the manual pages of all commands, from --output",
            commands: &["man"],
            schema: of::<WrittenPages>,
        },
        Self {
            name: "schema",
            summary: "the documents that have a schema",
            commands: &["schema"],
            schema: of::<SchemaList>,
        },
        Self {
            name: "error",
            summary: "why a command has failed",
            commands: &[],
            schema: of::<Failure>,
        },
    ];

    /// The schema, draft 2020-12.
    pub fn schema(&self) -> Schema {
        let mut generator = SchemaSettings::draft2020_12().for_serialize().into_generator();
        (self.schema)(&mut generator)
    }
}

fn of<T: JsonSchema>(generator: &mut SchemaGenerator) -> Schema {
    std::mem::take(generator).into_root_schema_for::<Versioned<T>>()
}

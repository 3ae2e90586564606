//! The JSON documents that commands print with `--json`, as types, from which their schemas are generated.
//!
//! [`report`](crate::report) fills them. A key whose value is not known is `null`; numbers are in SI units, which their
//! keys state.

mod agreement;
mod calibration;
mod details;
mod device;
mod electronics;
mod estimate;
mod fault;
mod finding;
mod hits;
mod layout;
mod list;
mod measurement;
mod modes;
mod rig_files;
mod simulation;
mod solution;
mod written;

use massline_shared::Estimated;
use schemars::{JsonSchema, Schema, SchemaGenerator, generate::SchemaSettings};
use serde::Serialize;

pub use agreement::{Agreement, Combined, OfMethod, Pair};
pub use calibration::{
    AxisDrift, BeforeAndAfter, Block, BlockCalibration, CalibratedTest, Calibration,
    CalibrationCheck, CalibrationDemo, CalibrationErrors, CalibrationSigma, HammerCalibration,
    HammerRatio, Hum, RcCutoff, SensorCalibration, SensorCheck, SensorRatio, Tumble,
    TumbleCalibration, TumbledSensor,
};
pub use details::{Details, ErrorBudget, HitDetails, Influence, SensorDetails, StatedAndLearned};
pub use device::{
    CounterFinding, DeviceAbort, DeviceIdentity, DeviceList, DeviceStats, Doctor, Looked, Port,
};
pub use electronics::{Asymmetry, Electronics, Memory};
pub use estimate::{ChiSquared, Estimate, LearnedBudget, PrincipalMoments};
pub use fault::{Fault, SingleFaults, Suspect};
pub use finding::{Cause, Failure, Finding, FoundBy, Refusal, Unseen};
pub use hits::{Decided, GradedHit, HitFinding, Hits};
pub use layout::{
    Advice, AssumedBody, Band, CandidateCounts, ErrorSource, HitTotal, JudgedLayout, JudgedMethod,
    LayoutCheck, LayoutSuggestion, Prediction, SensorTotal, ShownHit, ShownLayout, ShownSensor,
    ShownSettings,
};
pub use list::{
    DeletedResults, History, KeptResult, ListedArchive, ResultsList, Summary, Unreadable,
};
pub use measurement::{
    FurtherHit, HalfWidths, HostFindings, Marked, MeasuredMassLine, Measurement, Precision,
    WorstProperty,
};
pub use modes::{BetterHit, Indicator, Mode, Modes, Order, Pole};
pub use rig_files::{AddressRange, Flashing, RecordedTape};
pub use simulation::{
    ComparedMethod, ComparedTest, Demo, DemoWheel, DemoWheelFiles, ForceSet, MethodOverRuns,
    PropertyOverRuns, RunsToTarget, SimulatedRuns, Simulation,
};
pub use solution::{GlobalFit, MassLine, Solution};
pub use written::{
    Completions, DescribedDocument, ExportedAnswer, ExportedFile, LayoutTemplate, ManualPage,
    SchemaList, VirtualPort, WrittenFile, WrittenPages,
};

/// A number, or several, with the standard deviation; `null` where that is not known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "spread_of_{T}")]
pub struct Spread<T> {
    /// The value.
    pub value: T,
    /// Its standard deviation, in the same unit.
    pub sigma: Option<T>,
}

impl From<Estimated<f64>> for Spread<f64> {
    fn from(Estimated { value, sigma }: Estimated<f64>) -> Self {
        Self { value, sigma: Some(sigma) }
    }
}

/// The same thing for each of the ten properties. Masses are in kg, distances in m, moments and products of inertia in kg m²;
/// `Jxy` is the element of the tensor, `−∫ x y dm`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "properties_of_{T}")]
pub struct Properties<T> {
    /// The mass.
    pub mass: T,
    /// Coordinate x of the centre of mass.
    pub cx: T,
    /// Coordinate y of the centre of mass.
    pub cy: T,
    /// Coordinate z of the centre of mass.
    pub cz: T,
    /// Moment of inertia about x.
    #[serde(rename = "Jxx")]
    pub jxx: T,
    /// Moment of inertia about y.
    #[serde(rename = "Jyy")]
    pub jyy: T,
    /// Moment of inertia about z.
    #[serde(rename = "Jzz")]
    pub jzz: T,
    /// Product of inertia.
    #[serde(rename = "Jxy")]
    pub jxy: T,
    /// Product of inertia.
    #[serde(rename = "Jxz")]
    pub jxz: T,
    /// Product of inertia.
    #[serde(rename = "Jyz")]
    pub jyz: T,
}

impl<T: Copy> Properties<T> {
    /// Ten things in the order of `theta`.
    pub fn of(all: [T; 10]) -> Self {
        let [mass, cx, cy, cz, jxx, jyy, jzz, jxy, jxz, jyz] = all;
        Self { mass, cx, cy, cz, jxx, jyy, jzz, jxy, jxz, jyz }
    }
}

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
    pub const ALL: [Self; 36] = [
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
            name: "doctor",
            summary: "what is plugged in, and what is missing on this computer",
            commands: &["doctor"],
            schema: of::<Doctor>,
        },
        Self {
            name: "simulation",
            summary: "a simulated test beside the truth",
            commands: &["simulate"],
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
            commands: &["layout new", "calibrate pull"],
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

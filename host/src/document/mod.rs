//! The JSON documents that commands print with `--json`, as types, from which their schemas are generated.
//!
//! [`report`](crate::report) fills them. A key whose value is not known is `null`; numbers are in SI units, which their
//! keys state.

mod agreement;
mod calibration;
mod described;
mod details;
mod device;
mod electronics;
mod estimate;
mod fault;
mod file_path;
mod finding;
mod hit_log;
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
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use agreement::{Agreement, Combined, OfMethod, Pair};
pub use calibration::{
    AxisDrift, BeforeAndAfter, Block, BlockCalibration, CalibratedTest, Calibration,
    CalibrationCheck, CalibrationDemo, CalibrationErrors, CalibrationSigma, HammerCalibration,
    HammerRatio, Hum, RcCutoff, SensorCalibration, SensorCheck, SensorRatio, Tumble,
    TumbleCalibration, TumbledSensor,
};
pub use described::Described;
pub use details::{
    Details, ErrorBudget, HitDetails, Influence, LearnedFrom, SensorDetails, StatedAndLearned,
};
pub use device::{
    BatteryCharge, ChannelCheck, CounterFinding, DeviceAbort, DeviceBrownOut, DeviceCheck,
    DeviceErase, DeviceIdentity, DeviceList, DeviceStats, Doctor, Looked, Port,
};
pub use electronics::{Asymmetry, Electronics, Memory};
pub use estimate::{ChiSquared, Estimate, LearnedBudget, PrincipalMoments};
pub use fault::{ErrorsOverStated, Fault, SingleFaults, Suspect};
pub use file_path::FilePath;
pub use finding::{Cause, Failure, Finding, FoundBy, Refusal, Unseen, VerdictReason};
pub use hit_log::{HitRemark, HitVerdict, LoggedHit};
pub use hits::{
    ColumnLeftOut, Decided, GradedHit, HitFinding, Hits, RecordedChannel, RecordingSummary,
};
pub use layout::{
    Advice, AssumedBody, Band, CandidateCounts, ErrorSource, Forecast, ForecastAnswer, HitTotal,
    JudgedLayout, JudgedMethod, LayoutCheck, LayoutSuggestion, Prediction, SensorTotal, ShownHit,
    ShownLayout, ShownSensor, ShownSettings,
};
pub use list::{
    DeletedResults, History, KeptResult, ListedArchive, ResultsList, Summary, Unreadable,
};
pub use measurement::{
    FurtherHit, HalfWidths, HostFindings, Marked, MeasuredDof, MeasuredMassLine, Measurement,
    Precision, WorstProperty,
};
pub use modes::{BetterHit, Indicator, Mode, Modes, ModesSoFar, NextPoint, Order, Pole, SeenMode};
pub use rig_files::{AddressRange, Flashing, RecordedTape};
pub use simulation::{
    ComparedMethod, ComparedTest, Demo, DemoWheel, DemoWheelFiles, ForceSet, MethodOverRuns,
    PropertyOverRuns, RunsToTarget, SimulatedRuns, Simulation,
};
pub use solution::{FrequencyResponsesRead, GlobalFit, MassLine, Solution, UnitsRead};
pub use written::{
    Completions, DescribedDocument, DrawnPictures, ExportedAnswer, ExportedFile, LayoutTemplate,
    ManualPage, SchemaList, VirtualPort, WrittenFile, WrittenPages,
};

/// A number, or several, with the standard deviation; `null` where that is not known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
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

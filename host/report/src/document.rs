//! The JSON documents that commands print with `--json`, as types. Those that other programs read have a schema
//! ([`DocumentKind`]), which a test generates.
//!
//! [`words`](crate::words) and the commands fill them. A key whose value is not known is `null`; numbers are in SI
//! units, which their keys state.
//!
//! Most of them are read as well as written, which a test does with each. Receipts (`hits`, `list`, `rig_files`,
//! `written`) are only written: they say what a command did, and nothing here reads them again.

use massline_result::{Error, Result, SCHEMA_VERSION};
use serde::Serialize;

mod calibration;
mod described;
mod device;
mod electronics;
mod failure;
mod hits;
mod layout;
mod list;
mod rig_files;
#[cfg(feature = "schema")]
mod schema;
mod simulation;
#[cfg(test)]
mod tests;
mod written;

pub use calibration::{
    AxisDrift, BeforeAndAfter, Block, BlockCalibration, CalibratedTest, Calibration,
    CalibrationCheck, CalibrationDemo, CalibrationErrors, HammerCalibration, HammerRatio, Hum,
    RcCutoff, SensorCalibration, SensorCheck, SensorRatio, Tumble, TumbleCalibration,
    TumbledSensor,
};
pub use described::DocumentKind;
pub use device::{
    BatteryCharge, ChannelCheck, CounterFinding, DeviceAbort, DeviceBrownOut, DeviceCheck,
    DeviceErase, DeviceIdentity, DeviceList, DeviceStats, Doctor, DoctorFinding, Port,
};
pub use electronics::{Asymmetry, Electronics, Memory};
pub use failure::{Cause, Failure};
pub use hits::{
    ColumnLeftOut, DecidingNumber, GradedHit, HitFinding, Hits, RecordedChannel, RecordingSummary,
};
pub use layout::{
    Advice, AssumedBody, CandidateCounts, Forecast, ForecastAnswer, HitTotal, JudgedLayout,
    JudgedMethod, LayoutCheck, LayoutSuggestion, Prediction, SensorTotal, SettingValue, ShownHit,
    ShownLayout, ShownSensor,
};
pub use list::{
    DeletedResults, History, KeptResult, ListedArchive, ResultsList, Summary, UnreadableFile,
};
pub use rig_files::{AddressRange, Flashing, RecordedTape};
#[cfg(feature = "schema")]
pub use schema::schemas;
pub use simulation::{
    ComparedMethod, ComparedTest, Demo, DemoWheel, DemoWheelFiles, ForceSet, MethodOverRuns,
    PropertyOverRuns, RunsToTarget, SimulatedRuns, Simulation,
};
pub use written::{
    Completions, DescribedDocument, DrawnPictures, ExportedAnswer, ExportedFile, LayoutTemplate,
    SchemaList, VirtualPort, WrittenFile,
};

/// A JSON answer with the version of its schema.
#[derive(Serialize)]
struct Document<'a, T> {
    schema_version: u32,
    #[serde(flatten)]
    answer: &'a T,
}

/// A JSON answer with the version of its schema, as text.
///
/// # Errors
/// When it cannot be written as JSON.
pub fn versioned(answer: &impl Serialize) -> Result<String> {
    let document = Document { schema_version: SCHEMA_VERSION, answer };
    serde_json::to_string(&document)
        .map_err(|e| Error::internal("document_not_written", format!("{e}; report this")))
}

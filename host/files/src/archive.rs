//! An archive: everything that one test has measured, in one file from which it can be solved again.
//!
//! The file is a JSON object in one line, by convention with the extension `.massline`. All quantities are in SI units,
//! positions and directions in the body frame.
//!
//! | key | what it holds |
//! | --- | --- |
//! | `format`, `schema_version` | `"massline-archive"`, and the version of this table |
//! | `measured` | when the campaign was started, RFC 3339; null when the rig was not told the time |
//! | `written`, `program` | when this file was written, and the version of the program that wrote it |
//! | `rig` | board of the rig, version and commit of its firmware, and its `sampler`: the converter and the scans before the trigger, without which the codes of `hit_records` have no unit |
//! | `layout` | `title`; `nodes` with positions and axes; `resolved`: sensors, hits and settings as the solvers take them; `toml`: the layout file as it was written, null when the rig supplied the layout |
//! | `calibration` | the calibration in force, with the keys of a calibration file; null when the rig has another one by now |
//! | `result` | the result as the rig has stored it: for each DOF its mass lines, their noise, and number and scatter of its hits; the answers of all methods |
//! | `spectra` | for each DOF whose spectra were read: G_FF, G_XF and G_XX of all responses, each hit divided by the root of its force's energy in the band; H1 = G_XF / G_FF |
//! | `lines` | for each DOF in the suspension profile, its frequency responses as the rig has stored them; missing in the mass-line profile |
//! | `hit_records` | codes of all channels for each accepted hit, when they were kept |
//! | `hit_log` | every hit that was graded while the program followed the campaign: its DOF, number, peaks and time, what became of it and why; missing when nobody has followed |
//! | `answers` | the result that `measure` or `results get` printed with `--json`; null when the test was not solved |
//! | `checksum` | CRC-32 of the file without white space between values and without this key, which is the last; whoever edits the file on purpose deletes it |
//!
//! `layout.resolved` and `result` have the field names of `massline_shared::layout::Layout` and
//! `massline_protocol::object::MeasurementResult`. Numbers are written with as many digits as they need to be read back
//! without a change, so the same mass lines give the same answers. A key may be added without a new version; a program
//! refuses files of a version that it does not know.
//!
//! `format` and `schema_version` come first in a file that this program has written; a reader finds them at any place.

mod check;
mod checksum;
mod lines;
mod records;
mod sources;
mod spectra;

use std::path::Path;

use massline_protocol::calibration_checksum;
use massline_protocol::message::Identity;
use massline_protocol::object::MeasurementResult;
use massline_shared::calibration::CalibrationRecord;
use massline_shared::layout::{HOST_HITS, HostLayout, TestProfile};
use massline_shared::signal::{AdcProperties, resolution};
use serde::{Deserialize, Serialize};

use crate::calibration_file::CalibrationTable;
use crate::file::{self, ExistingFile};
use crate::layout_file::{LayoutFile, nodes_of};
use crate::limited::at_most;
use crate::uff::Frf;
use crate::{clock, embedded};
use massline_result::{Error, Json, JsonError, LoggedHit, Result, TestResult};

pub use lines::ArchivedLines;
pub use records::HitRecord;
pub use spectra::ArchivedSpectra;

/// Name of the format.
pub const FORMAT: &str = "massline-archive";
/// Version of the format: incremented when a key is renamed or removed or changes its meaning.
pub const SCHEMA_VERSION: u32 = 1;
/// Largest archive that is read, bytes: 600 hits with their records.
pub const MAX_BYTES: u64 = 96 << 20;
/// Largest number of records of hits.
pub const MOST_RECORDS: usize = 4096;
/// Largest number of hits in a log.
pub const MOST_LOGGED_HITS: usize = 8192;
/// Largest number of nodes of a layout.
const MOST_NODES: usize = u16::MAX as usize;
/// Extension by which a file is taken for an archive.
pub const EXTENSION: &str = "massline";

/// Everything that one test has measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Archive {
    format: String,
    schema_version: u32,
    /// When the campaign was started, RFC 3339 in UTC; `None` when the rig was not told the time.
    pub measured: Option<String>,
    /// When the file was written, RFC 3339 in UTC.
    pub written: String,
    /// Version of the program that wrote it.
    pub program: String,
    /// The rig.
    pub rig: ArchivedRig,
    /// The layout.
    pub layout: ArchivedLayout,
    calibration: Option<CalibrationTable>,
    /// The result as the rig has stored it.
    pub result: MeasurementResult,
    /// Spectra of the DOFs.
    #[serde(deserialize_with = "at_most::<HOST_HITS, _, _>")]
    pub spectra: Vec<ArchivedSpectra>,
    /// Lines of the DOFs, in the suspension profile.
    #[serde(
        default,
        skip_serializing_if = "Vec::is_empty",
        deserialize_with = "at_most::<HOST_HITS, _, _>"
    )]
    pub lines: Vec<ArchivedLines>,
    /// Records of the accepted hits.
    #[serde(deserialize_with = "at_most::<MOST_RECORDS, _, _>")]
    pub hit_records: Vec<HitRecord>,
    /// Every hit that was graded, and what became of it.
    #[serde(
        default,
        skip_serializing_if = "Vec::is_empty",
        deserialize_with = "at_most::<MOST_LOGGED_HITS, _, _>"
    )]
    pub hit_log: Vec<LoggedHit>,
    /// [`Archive::parse`] reads it by [`TestResult::read_key`].
    #[serde(skip_deserializing)]
    answers: Option<TestResult>,
}

/// Where a result comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArchivedRig {
    /// Name of the board.
    pub board: String,
    /// Version of the firmware.
    pub firmware: String,
    /// Commit that the firmware was built from.
    pub git_hash: String,
    /// Whether its sources had changes beside that commit.
    pub git_dirty: bool,
    /// How it samples.
    pub sampler: ArchivedSampler,
}

/// What gives the codes of a record their units and their times.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArchivedSampler {
    /// The converter.
    pub adc: AdcProperties,
    /// Scans of a record before the trigger.
    pub pre_trigger_scans: u16,
}

/// The layout of a test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArchivedLayout {
    /// The whole title.
    pub title: String,
    /// Every point that could have been hit.
    #[serde(deserialize_with = "at_most::<MOST_NODES, _, _>")]
    pub nodes: Vec<ArchivedNode>,
    /// Sensors, hits and settings, positions and directions in the body frame.
    pub resolved: HostLayout,
    /// The layout file; `None` when the layout comes from the rig.
    pub toml: Option<String>,
}

/// A numbered point of the object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArchivedNode {
    /// Its number.
    pub id: u16,
    /// Position in the body frame, m.
    pub position_m: [f64; 3],
    /// Local x, y and z axis, unit vectors of the body frame; `None` when they are not known.
    pub axes: Option<[[f64; 3]; 3]>,
}

impl ArchivedLayout {
    /// The layout of a file.
    pub fn of_file(file: &LayoutFile) -> Self {
        let node = |node: &crate::layout_file::Node| ArchivedNode {
            id: node.id,
            position_m: node.position,
            axes: Some(node.axes),
        };
        Self {
            title: file.title.clone(),
            nodes: file.nodes.iter().map(node).collect(),
            resolved: file.layout.clone(),
            toml: Some(file.text.clone()),
        }
    }

    /// The layout that a rig has stored: its nodes are those of sensors and hits.
    pub fn of_rig(layout: HostLayout) -> Self {
        let node = |(id, position_m)| ArchivedNode { id, position_m, axes: None };
        Self {
            title: layout.title.as_str().to_owned(),
            nodes: nodes_of(&layout).into_iter().map(node).collect(),
            resolved: layout,
            toml: None,
        }
    }
}

impl Archive {
    /// The result when the archive was written; `None` where the test was not solved then.
    pub fn answers(&self) -> Option<&TestResult> {
        self.answers.as_ref()
    }

    /// The archive of a result, written now; without spectra and records of hits. `calibration` is left out unless it
    /// is the one that the result was measured with.
    pub fn new(
        identity: &Identity,
        layout: ArchivedLayout,
        calibration: &CalibrationRecord,
        result: MeasurementResult,
        answers: Option<TestResult>,
    ) -> Self {
        let is_that = calibration_checksum(&calibration.calibration) == result.head.calibration;
        Self {
            format: FORMAT.into(),
            schema_version: SCHEMA_VERSION,
            measured: clock::moment(result.head.started_unix_s),
            written: clock::now(),
            program: env!("CARGO_PKG_VERSION").into(),
            rig: ArchivedRig {
                board: identity.board.as_str().into(),
                firmware: identity.firmware.as_str().into(),
                git_hash: identity.git_hash.as_str().into(),
                git_dirty: identity.git_dirty,
                sampler: ArchivedSampler {
                    adc: identity.adc,
                    pre_trigger_scans: identity.pre_trigger_scans,
                },
            },
            layout,
            calibration: is_that.then(|| CalibrationTable::of_record(calibration)),
            result,
            spectra: Vec::new(),
            lines: Vec::new(),
            hit_records: Vec::new(),
            hit_log: Vec::new(),
            // An answer that would not read back as it is must not cost what was measured: it can be solved again.
            answers: answers.filter(TestResult::reads_back),
        }
    }

    /// Reads an archive, or the one in a report.
    ///
    /// # Errors
    /// Exit 2 when the file cannot be read, is not an archive, is cut short, has a version that this program does not
    /// know, holds what no test gives or what contradicts itself, or was edited.
    pub fn read(path: &Path) -> Result<Self> {
        let name = path.display();
        let bytes = embedded::read(path, MAX_BYTES)
            .map_err(|e| Error::input("archive_not_readable", file::unreadable(path, &e)))?;
        Self::parse(&bytes, &name.to_string())
    }

    /// Reads the bytes of an archive; `file` is its name in errors.
    ///
    /// # Errors
    /// As [`Archive::read`].
    pub fn parse(bytes: &[u8], file: &str) -> Result<Self> {
        let stated = check::head(bytes, file)?;
        let malformed = |error: JsonError| check::malformed(file, error.to_string());
        let document = Json::parse(bytes).map_err(malformed)?;
        let mut archive: Self = document.read().map_err(malformed)?;
        archive.answers = TestResult::read_key(&document, "answers").map_err(malformed)?;
        check::contents(&archive).map_err(|reason| check::malformed(file, reason))?;
        if !checksum::is_intact(bytes, stated) {
            return Err(check::edited(file));
        }
        Ok(archive)
    }

    /// The bytes of the archive, which read back as they are; `file` is its name in errors.
    ///
    /// # Errors
    /// Exit 1 when the archive holds what it cannot, such as a number that is NaN.
    pub fn to_bytes(&self, file: &str) -> Result<Vec<u8>> {
        let bytes = serde_json::to_vec(self).map_err(|e| unfaithful(file, &e.to_string()))?;
        let mut bytes = checksum::sealed(bytes);
        bytes.push(b'\n');
        let again = Self::parse(&bytes, file).map_err(|e| unfaithful(file, &e.to_string()))?;
        if again != *self {
            return Err(unfaithful(file, "it does not read back as it was"));
        }
        Ok(bytes)
    }

    /// Writes the archive.
    ///
    /// # Errors
    /// Exit 2 when the file exists and is kept, or cannot be written.
    pub fn write(&self, path: &Path, existing: ExistingFile) -> Result<()> {
        file::write(path, &self.to_bytes(&path.display().to_string())?, existing)
    }

    /// The calibration in force during the test; `None` when it is not known.
    pub fn calibration(&self) -> Option<CalibrationRecord> {
        self.calibration.as_ref().map(CalibrationTable::record)
    }

    /// The frequency responses of all DOFs with lines, or else H1 of those with spectra, at every sensor, corrected for
    /// cross-axis sensitivities. They are those at `s = σ + iω`, with σ of [`Self::decay_per_s`]. From spectra, empty
    /// when the calibration is not known.
    pub fn frfs(&self) -> Vec<Frf> {
        let sensors = &self.layout.resolved.sensors;
        let nodes: Vec<u16> = sensors.iter().map(|sensor| sensor.node).collect();
        if !self.lines.is_empty() {
            let spacing = resolution::<f64>(&self.rig.sampler.adc, TestProfile::Suspension);
            return self.lines.iter().flat_map(|lines| lines.frfs(&nodes, spacing)).collect();
        }
        let Some(calibration) = self.calibration() else { return Vec::new() };
        let frfs = |spectra: &ArchivedSpectra| spectra.frfs(&nodes, &calibration.calibration);
        self.spectra.iter().flat_map(frfs).collect()
    }

    /// Decay rate σ of the exponential window of the frequency responses, 1/s; `None` without them.
    pub fn decay_per_s(&self) -> Option<f64> {
        if !self.lines.is_empty() {
            return Some(self.layout.resolved.test.exponential_decay);
        }
        self.spectra.first().map(|spectra| spectra.decay_per_s)
    }
}

/// True for a file that is an archive by its extension or by its first bytes.
pub fn is_archive(path: &Path) -> bool {
    is_named(path) || check::begins_as_archive(path)
}

/// True for a path whose extension is that of archives.
pub fn is_named(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(EXTENSION))
}

fn unfaithful(file: &str, why: &str) -> Error {
    Error::internal("archive_not_faithful", format!("{file}: not written: {why}; report this"))
}

#[cfg(test)]
mod tests;

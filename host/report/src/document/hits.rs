//! The graded hits of a recording.

use serde::Serialize;

/// The graded hits of a recording.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Hits {
    /// What was understood of the recording.
    pub recording: RecordingSummary,
    /// The hits, in the order of the file.
    pub hits: Vec<GradedHit>,
    /// Warnings about the recording.
    pub notes: Vec<String>,
}

/// What was understood of a recording before its hits were graded.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RecordingSummary {
    /// The format of the file.
    pub format: &'static str,
    /// The encoding of its text; `null` for a file that is no text.
    pub encoding: Option<&'static str>,
    /// What separates its columns; `null` where the format fixes it.
    pub separator: Option<&'static str>,
    /// The decimal sign, `point` or `comma`; `null` where the format fixes it.
    pub decimal: Option<&'static str>,
    /// The channels in use, the force first.
    pub channels: Vec<RecordedChannel>,
    /// The sampling rate in use.
    pub rate_hz: f64,
    /// Where the rate comes from: `time_column`, `header` or `option`.
    pub rate_source: &'static str,
    /// Name of the time column that gives the rate, empty for one without a name; `null` for another source.
    pub time_column: Option<String>,
    /// The unit in which the time column is read; `null` for another source.
    pub time_unit: Option<String>,
    /// Whether that unit is assumed because the file states none.
    pub time_unit_assumed: bool,
    /// Number of segments.
    pub segments: usize,
    /// Samples of a channel in all segments together.
    pub samples: usize,
    /// Their duration.
    pub duration_s: f64,
    /// Columns that are not used.
    pub left_out: Vec<ColumnLeftOut>,
}

/// A channel of a recording, with its unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RecordedChannel {
    /// Its name, or its number where it has none.
    pub name: String,
    /// `force` or `response`.
    pub role: &'static str,
    /// The unit of its samples, or with a sensitivity the unit of the sensor.
    pub unit: String,
    /// Where the unit was read: `file`, `unit_system`, `option` or `sensitivity`.
    pub unit_source: &'static str,
    /// Factor from its samples to N or m/s².
    pub factor_to_si: f64,
    /// Whether its sign is reversed.
    pub reversed: bool,
}

/// A column of a recording that is not used.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ColumnLeftOut {
    /// Its name, or its number where it has none.
    pub name: String,
    /// Why it is not used.
    pub reason: String,
}

/// A graded hit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GradedHit {
    /// Segment of the file, or number of the hit in a continuous recording, from 0.
    pub segment: usize,
    /// `accepted`, `warning` or `rejected`.
    pub verdict: &'static str,
    /// Stable names of the findings.
    pub codes: Vec<String>,
    /// The findings.
    pub findings: Vec<HitFinding>,
    /// Time of first contact, after the beginning of the segment or the recording.
    pub start_s: f64,
    /// Largest force.
    pub peak_force_n: f64,
    /// Largest magnitude of any response.
    pub peak_response_m_per_s2: f64,
    /// Distance of the responses per force from the mean of the other consistent hits, relative to it; `null` for a hit
    /// that is not compared.
    pub distance_relative: Option<f64>,
    /// Whether the hit belongs to the best consistent set.
    pub kept: bool,
}

/// A finding about a hit, with the number that decided under a key that names its unit.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct HitFinding {
    /// Stable name of what was found.
    pub code: String,
    /// `note`, `warning` or `error`.
    pub severity: &'static str,
    /// The channel, 0 for the force; missing in a finding about all of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub channel: Option<u8>,
    /// The number that decided.
    #[serde(flatten)]
    pub decided: DecidingNumber,
}

/// The number that decided; one of these keys.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct DecidingNumber {
    /// The extreme of an overloaded force.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extreme_n: Option<f64>,
    /// The extreme of an overloaded response.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extreme_m_per_s2: Option<f64>,
    /// The peak of a weak force.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_force_n: Option<f64>,
    /// Level of the force at the top of the band, against 0 Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level_db: Option<f64>,
    /// Scans before the trigger.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pre_trigger_scans: Option<f64>,
    /// Distance from the other hits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_relative: Option<f64>,
    /// The second peak of the force over the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub second_peak_relative: Option<f64>,
    /// A share, from 0 to 1; what of depends on the code.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share_relative: Option<f64>,
}

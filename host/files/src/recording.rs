//! Hammer data recorded by other systems: force and responses over time.
//!
//! | format | recognised by | reader |
//! | --- | --- | --- |
//! | LabVIEW measurement | `LabVIEW Measurement` in the first line | `lvm` |
//! | universal file, dataset 58, function type 1 | a line `    -1` at the beginning | `uff` |
//! | NumPy array (segments,) samples, channels | `\x93NUMPY` | `npy` |
//! | text with a column for each channel | anything else that is text | `csv` |
//!
//! Every reader returns a [`Recording`]. The readers accept any bytes: they never panic, and never allocate
//! more than a small multiple of the input's length.
//!
//! A reader says what the file states and no more. What the user states is added later: the rate in `rate`, the units
//! and sensitivities in `scale`. A unit is read or asked for, never assumed.

mod beginnings;
mod clock;
mod csv;
mod date;
mod declared;
mod dialect;
mod error;
mod factors;
mod header;
mod line;
mod losses;
mod lvm;
mod npy;
mod number;
mod rate;
mod scale;
mod sensitivity;
mod stamp;
mod steps;
mod time;
mod uff;
mod uneven;

use std::path::Path;

pub use error::RecordingError;
pub use number::Decimal;
pub use number::six_digits;
pub use rate::{DeclaredRate, Rate, RateSource};
use scale::called;
pub use scale::column;
pub use scale::{EVERY_RESPONSE, Scale, StatedSensitivity, StatedUnit, Statements, UnitSource};
pub use sensitivity::Sensitivity;
pub use steps::Steps;
pub use time::{Places, TimeColumn, TimeUnit};
pub use uneven::Unevenness;

use crate::encoding::Text;
use steps::Times;

/// Largest file that is read, bytes.
pub const MAX_BYTES: u64 = 1 << 27;

/// Most channels, and most segments: more than any recording of hits has.
const MOST_CHANNELS: usize = 1000;
const MOST_SEGMENTS: usize = 10_000;

/// Most lines of text before the numbers.
const MOST_HEADER_LINES: usize = 1000;

/// Longest line of a text, bytes.
const MOST_LINE_BYTES: usize = 1 << 20;

/// Most values of all channels and segments together, which fit into the memory of small computers: five minutes of
/// ten channels at 5 kHz.
const MOST_VALUES: usize = 1 << 24;

/// Channels over time, in one segment or in several.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    /// How the file is written.
    pub source: Source,
    /// The sampling rate that a header states.
    pub declared: Option<DeclaredRate>,
    /// The column that has the time.
    pub time: Option<TimeColumn>,
    /// The channels.
    pub channels: Vec<Channel>,
    /// The segments of the file; one when the recording is continuous.
    pub segments: Vec<Segment>,
    /// What the file has beside these channels.
    pub left_out: Vec<LeftOutColumn>,
    /// What a person should know about the file.
    pub notes: Vec<String>,
}

/// How a file is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Source {
    /// The format, as a person knows it.
    pub format: &'static str,
    /// The encoding of its text.
    pub encoding: Option<&'static str>,
    /// What separates its columns.
    pub separator: Option<&'static str>,
    /// The decimal sign.
    pub decimal: Option<Decimal>,
}

/// A column that is not used, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOutColumn {
    /// Its name.
    pub name: String,
    /// Why.
    pub reason: String,
}

/// Name and unit of a channel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Channel {
    /// Its name in the file; an unnamed channel has an empty name.
    pub name: String,
    /// Its unit in the file.
    pub unit: String,
    /// The factor to N or m/s² for a channel without a unit of its own, where the file states its units for all
    /// channels together.
    pub factor: Option<f64>,
    /// A factor that the file states for its numbers beside their unit, as part of a sentence.
    pub multiplier: Option<String>,
    /// Why its samples cannot be used.
    pub fault: Option<RecordingError>,
}

/// A segment of a recording: the samples of every channel, equally many for all.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Segment(pub Vec<Vec<f64>>);

impl From<RecordingError> for massline_result::Error {
    fn from(error: RecordingError) -> Self {
        Self::input(error.code(), error.to_string())
    }
}

impl Recording {
    /// Reads a file of any of the formats; `decimal` is the decimal sign of a text with columns, where it is stated.
    ///
    /// # Errors
    /// When the file cannot be read, has an unknown format, is truncated or malformed; the message names the
    /// file and the place.
    pub fn read(path: &Path, decimal: Option<Decimal>) -> massline_result::Result<Self> {
        let file = path.display();
        let bytes = crate::file::read(path, MAX_BYTES).map_err(|error| {
            let message = crate::file::unreadable(path, &error);
            massline_result::Error::input("recording_not_readable", message)
        })?;
        Self::parse_with(&bytes, decimal)
            .map_err(|error| massline_result::Error::from(error).within(file))
    }

    /// Reads the bytes of a file of any of the formats.
    ///
    /// # Errors
    /// As [`Recording::read`].
    pub fn parse(bytes: &[u8]) -> Result<Self, RecordingError> {
        Self::parse_with(bytes, None)
    }

    fn parse_with(bytes: &[u8], decimal: Option<Decimal>) -> Result<Self, RecordingError> {
        if bytes.starts_with(crate::npy::MAGIC) {
            return npy::read(bytes)?.checked();
        }
        if bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).starts_with(b"    -1") {
            return uff::read(bytes)?.checked();
        }
        let text = Text::decode(bytes)?;
        if text.text.trim().is_empty() {
            return Err(RecordingError::Empty);
        }
        let recording = if text.text.trim_start().starts_with("LabVIEW Measurement") {
            lvm::read(&text)
        } else {
            csv::read(&text, decimal)
        };
        recording?.checked()
    }

    /// Refuses more channels or segments than a recording has.
    fn plausible(segments: u64, channels: u64) -> Result<(), RecordingError> {
        if channels > MOST_CHANNELS as u64 {
            Err(RecordingError::TooManyChannels { channels })
        } else if segments > MOST_SEGMENTS as u64 {
            Err(RecordingError::TooManySegments { segments })
        } else {
            Ok(())
        }
    }

    /// Refuses more values than are held in memory.
    fn within_memory(before: usize, segment: &Segment) -> Result<(), RecordingError> {
        if before + segment.values() > MOST_VALUES { Err(RecordingError::TooLong) } else { Ok(()) }
    }

    /// Refuses a recording without samples, and marks channels with values that are no readings.
    fn checked(mut self) -> Result<Self, RecordingError> {
        if self.channels.is_empty() && self.time.is_some() {
            return Err(RecordingError::NoReadings);
        }
        if self.segments.iter().all(|segment| segment.samples() == 0) || self.channels.is_empty() {
            return Err(RecordingError::Empty);
        }
        for (k, segment) in self.segments.iter().enumerate() {
            for (n, (channel, samples)) in self.channels.iter_mut().zip(&segment.0).enumerate() {
                if let Some(at) = samples.iter().position(|value| !is_reading(*value)) {
                    let value = samples.get(at).copied().unwrap_or(f64::NAN);
                    let place = format!("segment {k}, sample {at}");
                    let fault = RecordingError::NotFinite { place, channel: n + 1, value };
                    channel.fault.get_or_insert(fault);
                }
            }
        }
        Ok(self)
    }

    /// Takes the time out of the columns: `columns` are the times of those that may be one, `line` gives the line of a
    /// row. The rows of a single segment are cut where the time begins again.
    fn take_time(
        &mut self,
        columns: Vec<(usize, Times)>,
        line: impl Fn(usize) -> usize,
    ) -> Result<(), RecordingError> {
        let time::TimeColumns { time, others } = time::find(&self.channels, &columns);
        let column_at = |place: usize| {
            let (_, times) = columns.iter().find(|(other, _)| *other == place)?;
            Some((self.channels.get(place)?, times))
        };
        let time_column = time.and_then(column_at);
        // The columns that are no channels, each but the time with the reason.
        let mut taken: Vec<(usize, Option<&str>)> =
            time.iter().map(|&place| (place, None)).collect();
        for place in others {
            if let Some(other) = column_at(place) {
                taken.push((place, Some(time::beside_the_time(time_column, other, &line)?)));
            }
        }
        if let Some((channel, times)) = time_column {
            let (column, runs) = time::time_column(channel, times, &line)?;
            self.time = Some(column);
            if let ([whole], [_, _, ..]) = (self.segments.as_slice(), runs.as_slice()) {
                Self::plausible(runs.len() as u64, 1)?;
                let part = |rows: &std::ops::Range<usize>| {
                    whole
                        .0
                        .iter()
                        .map(|samples| samples.get(rows.clone()).unwrap_or_default().to_vec())
                        .collect()
                };
                self.notes
                    .push(format!("the time begins again or pauses: {} segments", runs.len()));
                self.segments = runs.iter().map(|rows| Segment(part(rows))).collect();
            }
        }
        taken.sort_unstable();
        for (place, reason) in taken.into_iter().rev() {
            let channel = self.remove(place);
            if let Some(reason) = reason {
                let (name, reason) = (column(place, &channel), reason.to_owned());
                self.left_out.push(LeftOutColumn { name, reason });
            }
        }
        Ok(())
    }

    /// Removes a channel from all segments.
    fn remove(&mut self, place: usize) -> Channel {
        for segment in self.segments.iter_mut().filter(|segment| place < segment.0.len()) {
            segment.0.remove(place);
        }
        if place < self.channels.len() { self.channels.remove(place) } else { Channel::default() }
    }
}

/// True for the name of a force.
pub fn is_named_force(name: &str) -> bool {
    let name = name.to_lowercase();
    ["force", "hammer", "kraft"].iter().any(|word| name.contains(word))
}

/// True for a value that a converter could produce in any unit. The squares of larger values overflow.
fn is_reading(value: f64) -> bool {
    value.abs() < 1e15
}

impl Segment {
    /// Number of samples of each channel.
    pub fn samples(&self) -> usize {
        self.0.iter().map(Vec::len).min().unwrap_or(0)
    }

    /// A segment of this many channels without samples.
    fn of_channels(channels: usize) -> Self {
        Self(vec![Vec::new(); channels])
    }

    /// Number of values of all channels.
    fn values(&self) -> usize {
        self.0.iter().map(Vec::len).sum()
    }
}

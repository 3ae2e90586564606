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

mod csv;
mod lvm;
mod npy;
mod number;
mod si;
mod uff;

use std::borrow::Cow;
use std::path::Path;

use thiserror::Error;

pub use si::StatedUnit;

/// Largest file that is read, bytes.
pub const MAX_BYTES: u64 = 1 << 27;

/// Most channels, and most segments: more than any recording of hits has.
const MOST_CHANNELS: usize = 1000;
const MOST_SEGMENTS: usize = 10_000;

/// Longest line of a text, bytes.
const MOST_LINE_BYTES: usize = 1 << 20;

/// Most values of all channels and segments together, which fit into the memory of small computers: five minutes of
/// ten channels at 5 kHz.
const MOST_VALUES: usize = 1 << 24;

/// Channels over time, in one segment or in several.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Sampling rate, Hz, when the file states it.
    pub rate_hz: Option<f64>,
    /// Name and unit of each channel; an unnamed channel has an empty name.
    pub channels: Vec<Channel>,
    /// The segments of the file; one when the recording is continuous.
    pub segments: Vec<Segment>,
}

/// Name and unit of a channel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Channel {
    /// Its name in the file.
    pub name: String,
    /// Its unit in the file.
    pub unit: String,
    /// The factor to N or m/s² for a channel without a unit of its own, where the file states its units for all
    /// channels together.
    pub factor: Option<f64>,
}

/// A segment of a recording: the samples of every channel, equally many for all.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Segment(pub Vec<Vec<f64>>);

/// Why a file is not accepted as a recording.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RecordingError {
    /// The file is empty.
    #[error("the file is empty; export the measurement again")]
    Empty,
    /// The format is not one of those that are known.
    #[error(
        "the format is not known; LabVIEW measurement (.lvm), CSV, universal files with dataset 58 \
         and NumPy arrays (.npy) are read"
    )]
    UnknownFormat,
    /// A line with a different number of columns than the lines before.
    #[error(
        "line {line}: {found} columns where {wanted} are expected; every line needs one value for \
         each channel"
    )]
    Ragged {
        /// The line, from 1.
        line: usize,
        /// Its columns.
        found: usize,
        /// The number of columns of the lines before.
        wanted: usize,
    },
    /// Text where a number should be.
    #[error(
        "line {line}, column {column}: \"{text}\" is not a number with decimal {decimal}; check the \
         decimal sign and the columns of the export"
    )]
    NotANumber {
        /// The line, from 1.
        line: usize,
        /// The column, from 1.
        column: usize,
        /// The text of the field.
        text: String,
        /// The decimal sign that is expected.
        decimal: &'static str,
    },
    /// Commas as decimal sign and as separator.
    #[error(
        "line {line}, column {column}: \"{text}\" looks like the decimals of a number: the comma cannot both \
         separate columns and be the decimal sign; export with semicolons, tabs or decimal points"
    )]
    CommaTwice {
        /// The line, from 1.
        line: usize,
        /// The column, from 1.
        column: usize,
        /// The text of the field.
        text: String,
    },
    /// NaN, infinity, or a value that no measurement can have.
    #[error(
        "{place}, channel {channel}: the value is {value:e}; cut the recording where the signal is \
         lost"
    )]
    NotFinite {
        /// The place in the file, as text for people.
        place: String,
        /// The channel, from 1.
        channel: usize,
        /// The value.
        value: f64,
    },
    /// More values than are held in memory.
    #[error(
        "the recording has more than {MOST_VALUES} values; export fewer channels, a lower rate or a shorter time"
    )]
    TooLong,
    /// More channels than a recording of hits has.
    #[error(
        "{channels} channels; at most {MOST_CHANNELS} are read: check the separator of columns, or export fewer"
    )]
    TooManyChannels {
        /// Their number.
        channels: u64,
    },
    /// More segments than a recording of hits has.
    #[error(
        "{segments} segments; at most {MOST_SEGMENTS} are read: check the order of the dimensions, or export fewer"
    )]
    TooManySegments {
        /// Their number.
        segments: u64,
    },
    /// A line that is longer than any line of numbers.
    #[error(
        "line {line}: it is longer than {MOST_LINE_BYTES} bytes; check the line ends and quotes of the export"
    )]
    LongLine {
        /// The line, from 1.
        line: usize,
    },
    /// The file is truncated.
    #[error("the file is truncated: {wanted} should come; copy or export it again")]
    Truncated {
        /// What is missing.
        wanted: String,
    },
    /// An invalid header.
    #[error("line {line}: {fault}")]
    Header {
        /// The line, from 1.
        line: usize,
        /// What is wrong and what to do.
        fault: String,
    },
    /// A NumPy array that cannot be read as a recording.
    #[error("{0}")]
    Array(String),
    /// A universal file that cannot be read.
    #[error(transparent)]
    Uff(#[from] crate::uff::UffError),
}

impl RecordingError {
    /// The stable identifier of this error in JSON.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Empty => "recording_empty",
            Self::UnknownFormat => "recording_unknown_format",
            Self::Truncated { .. } => "recording_truncated",
            Self::TooLong | Self::TooManyChannels { .. } | Self::TooManySegments { .. } => {
                "recording_too_long"
            }
            Self::NotFinite { .. } => "data_not_finite",
            Self::Uff(error) => error.fault.code(),
            _ => "recording_malformed",
        }
    }
}

impl From<RecordingError> for crate::Error {
    fn from(error: RecordingError) -> Self {
        Self::input(error.code(), error.to_string())
    }
}

impl Recording {
    /// Reads a file of any of the formats.
    ///
    /// # Errors
    /// When the file cannot be read, has an unknown format, is truncated or malformed; the message names the
    /// file and the place.
    pub fn read(path: &Path) -> crate::Result<Self> {
        let file = path.display();
        let bytes = crate::file::read(path, MAX_BYTES).map_err(|error| {
            let message = crate::file::unreadable(path, &error);
            crate::Error::input("recording_not_readable", message)
        })?;
        Self::parse(&bytes).map_err(|error| crate::Error::from(error).within(file))
    }

    /// Reads the bytes of a file of any of the formats.
    ///
    /// # Errors
    /// As [`Recording::read`].
    pub fn parse(bytes: &[u8]) -> Result<Self, RecordingError> {
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let recording = if text.trim_ascii().is_empty() {
            Err(RecordingError::Empty)
        } else if bytes.starts_with(crate::npy::MAGIC) {
            npy::read(bytes)
        } else if text.trim_ascii_start().starts_with(b"LabVIEW Measurement") {
            lvm::read(&decoded(text))
        } else if text.starts_with(b"    -1") {
            uff::read(bytes)
        } else {
            match std::str::from_utf8(text) {
                Ok(text) if !text.contains('\0') => csv::read(text),
                _ => Err(RecordingError::UnknownFormat),
            }
        }?;
        recording.checked()
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

    /// Rejects channels of different lengths and values that are not plausible readings.
    fn checked(self) -> Result<Self, RecordingError> {
        let count = self.channels.len();
        if self.segments.iter().all(|segment| segment.samples() == 0) || count == 0 {
            return Err(RecordingError::Empty);
        }
        for (k, segment) in self.segments.iter().enumerate() {
            for (channel, samples) in segment.0.iter().enumerate() {
                if let Some(at) = samples.iter().position(|value| !is_reading(*value)) {
                    let value = samples.get(at).copied().unwrap_or(f64::NAN);
                    let place = format!("segment {k}, sample {at}");
                    return Err(RecordingError::NotFinite { place, channel: channel + 1, value });
                }
            }
        }
        Ok(self)
    }
}

/// The text of bytes that are UTF-8 or else, as LabVIEW on Windows writes them, Latin-1.
fn decoded(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.into(),
        Err(_) => bytes.iter().copied().map(char::from).collect::<String>().into(),
    }
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

//! Why a file is not accepted as a recording.

use thiserror::Error;

use super::{MOST_CHANNELS, MOST_HEADER_LINES, MOST_LINE_BYTES, MOST_SEGMENTS, MOST_VALUES};
use crate::encoding::NotText;
use crate::uff::UffError;

/// Why a file is not accepted as a recording.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RecordingError {
    /// The file is empty.
    #[error("the file is empty; export the measurement again")]
    Empty,
    /// Nothing but a time.
    #[error(
        "the file has a time column and no column of readings, which are plain numbers; export force and responses \
         with it"
    )]
    NoReadings,
    /// The format is not one of those that are known.
    #[error(
        "the format is not known; LabVIEW measurement (.lvm), text with columns (CSV) whose numbers begin within \
         {MOST_HEADER_LINES} lines, universal files with dataset 58 and NumPy arrays (.npy) are read"
    )]
    UnknownFormat,
    /// Bytes that are no text.
    #[error(
        "{0}; LabVIEW measurement (.lvm), text with columns (CSV), universal files and NumPy arrays (.npy) are read"
    )]
    NotText(#[from] NotText),
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
         decimal sign and the columns of the export, and that no text stands beside a number"
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
    /// A time of day that is not understood.
    #[error(
        "line {line}, column {column}: \"{text}\" is not a time that is read; export times such as 12:00:01.25, with a \
         date such as 2026-01-02 before them and a zone such as Z or +01:00 behind them"
    )]
    NotATime {
        /// The line, from 1.
        line: usize,
        /// The column, from 1.
        column: usize,
        /// The text of the field.
        text: String,
    },
    /// A sign that may be a decimal sign or separate thousands.
    #[error(
        "line {line}, column {column}: the sign in \"{text}\" may be the decimal sign or separate thousands; state the \
         decimal sign with --decimal, or export without separators of thousands"
    )]
    Thousands {
        /// The line, from 1.
        line: usize,
        /// The column, from 1.
        column: usize,
        /// The text of the field.
        text: String,
    },
    /// A row without a value in a column.
    #[error(
        "line {line}: column {column} has no value here, and values in other rows; export evenly sampled channels"
    )]
    Hole {
        /// The line, from 1.
        line: usize,
        /// The column, from 1.
        column: usize,
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
    Uff(#[from] UffError),
}

impl RecordingError {
    /// The stable identifier of this error in JSON.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Empty => "recording_empty",
            Self::UnknownFormat | Self::NotText(NotText::Binary { .. } | NotText::Utf32) => {
                "recording_unknown_format"
            }
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

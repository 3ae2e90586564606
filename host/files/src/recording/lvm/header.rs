//! The headers of a LabVIEW measurement file: that of the file, and those of its segments.

use super::super::clock::DAY;
use super::super::date::Date;
use super::super::number::{Decimal, last_digit};
use super::super::stamp::Stamp;
use super::super::{DeclaredRate, RecordingError, six_digits};
use super::{EQUAL_RATES, LinesOf};

const END_OF_HEADER: &str = "***End_of_Header***";
const DELTA: &str = "Delta_X";
/// Other entries of a segment's header.
const ENTRIES: [&str; 8] =
    ["Channels", "Samples", "Date", "Time", "X_Dimension", "X0", "Y_Unit_Label", "Y_Dimension"];
/// How far the beginnings of two channels may be apart, in steps, where they were sampled together.
const TOGETHER: f64 = 0.1;
/// Relative difference of two equal numbers that were written alike.
const ROUNDED: f64 = 1e-9;

/// Position of the X values in the file.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum XColumns {
    /// No X values; the first column is empty.
    No,
    /// X values in the first column.
    One,
    /// An X column before each channel.
    Multi,
}

/// The contents of the file header.
pub(super) struct Format {
    pub separator: char,
    pub decimal: Decimal,
    pub x_columns: XColumns,
}

impl Format {
    /// Index of the column with the X values of a channel, from 0.
    pub fn x_column(&self, channel: usize) -> Option<usize> {
        match self.x_columns {
            XColumns::No => None,
            XColumns::One => Some(0),
            XColumns::Multi => Some(2 * channel),
        }
    }
}

/// A time step and the unit of its last digit.
#[derive(Clone, Copy)]
struct Delta {
    step: f64,
    digit: f64,
}

/// The contents of a segment header.
#[derive(Default)]
pub(super) struct SegmentHeader {
    pub line: usize,
    pub channels: usize,
    pub units: Vec<String>,
    samples: Vec<Option<usize>>,
    deltas: Vec<Option<Delta>>,
    dates: Vec<Option<Date>>,
    /// The time of day at which each channel began, s, and its first X value.
    clocks: Vec<Option<f64>>,
    firsts: Vec<Option<f64>>,
    /// The lines of the time steps and of these beginnings.
    delta_line: usize,
    clock_line: usize,
    first_line: usize,
}

impl SegmentHeader {
    /// True for a channel with samples.
    pub fn is_filled(&self, channel: usize) -> bool {
        self.samples.get(channel).copied().flatten() != Some(0)
    }

    /// The first channel with samples, which the others are compared with.
    pub fn reference(&self) -> usize {
        (0..self.channels).find(|&k| self.is_filled(k)).unwrap_or(0)
    }

    /// Samples of a block.
    pub fn block(&self) -> Option<usize> {
        self.samples.get(self.reference()).copied().flatten()
    }

    /// The sampling rate.
    pub fn rate(&self) -> Option<DeclaredRate> {
        let Delta { step, digit } = self.deltas.get(self.reference()).copied().flatten()?;
        let uncertainty = 0.5 * digit / step;
        (step > 0.0).then_some(DeclaredRate {
            hz: step.recip(),
            uncertainty,
            entry: DELTA.to_owned(),
            states_unit: true,
        })
    }

    /// Counts the times of day from the first date.
    fn add_days(&mut self) {
        let first = self.dates.first().copied().flatten();
        for (clock, date) in self.clocks.iter_mut().zip(&self.dates) {
            let days = date.zip(first).and_then(|(date, first)| date.days_after(first));
            *clock = clock.map(|seconds| seconds + DAY * days.unwrap_or_default() as f64);
        }
    }

    /// Why a channel cannot be used beside the others: it has another rate, begins at another time or has another
    /// number of samples.
    pub fn fault(&self, channel: usize) -> Option<RecordingError> {
        let reference = self.reference();
        let (this, that) = (channel + 1, reference + 1);
        let pair = |list: &[Option<f64>]| {
            Some((list.get(reference).copied()??, list.get(channel).copied()??))
        };
        let steps: Vec<Option<f64>> =
            self.deltas.iter().map(|delta| delta.map(|delta| delta.step)).collect();
        if let Some((first, step)) = pair(&steps)
            && (step - first).abs() > EQUAL_RATES * first.abs()
        {
            let fault = format!(
                "Delta_X: channel {this} has a step of {step} s and channel {that} one of {first} s; export channels \
                 of one rate"
            );
            return Some(RecordingError::Header { line: self.delta_line, fault });
        }
        let step = steps.get(reference).copied().flatten().unwrap_or_default();
        for (entry, beginnings, line) in
            [("X0", &self.firsts, self.first_line), ("Time", &self.clocks, self.clock_line)]
        {
            if let Some((first, begins)) = pair(beginnings)
                && (begins - first).abs() > TOGETHER * step.abs() + ROUNDED * first.abs()
            {
                let fault = format!(
                    "{entry}: channel {this} begins {} s {} channel {that}; export channels that were sampled together",
                    six_digits((begins - first).abs()),
                    if begins > first { "after" } else { "before" }
                );
                return Some(RecordingError::Header { line, fault });
            }
        }
        let samples = |k: usize| self.samples.get(k).copied().flatten();
        let (first, count) = (samples(reference)?, samples(channel)?);
        (count != first).then(|| {
            let fault = format!(
                "Samples: channel {this} has {count} and channel {that} has {first}; export channels of one rate"
            );
            RecordingError::Header { line: self.line, fault }
        })
    }
}

/// True for a line that is an entry of a header, by its first field.
pub(super) fn is_entry(first: &str) -> bool {
    ENTRIES.contains(&first) || first == DELTA || first.starts_with("***")
}

/// Reads up to the first end-of-header line.
pub(super) fn file_header(lines: &mut LinesOf<'_>) -> Result<Format, RecordingError> {
    let mut format = Format { separator: '\t', decimal: Decimal::Point, x_columns: XColumns::One };
    for (line, text) in lines {
        let (key, value) = entry(text);
        let unknown = |known: &str| {
            let fault = format!("{key} is \"{value}\"; {known} are read");
            Err(RecordingError::Header { line, fault })
        };
        match key {
            END_OF_HEADER => return Ok(format),
            "Separator" => match value {
                "Tab" => format.separator = '\t',
                "Comma" => format.separator = ',',
                "Semicolon" => format.separator = ';',
                _ => return unknown("Tab, Comma and Semicolon"),
            },
            "Decimal_Separator" => match value {
                "." => format.decimal = Decimal::Point,
                "," | "" => format.decimal = Decimal::Comma,
                _ => return unknown("point and comma"),
            },
            "X_Columns" => match value {
                "No" => format.x_columns = XColumns::No,
                "One" => format.x_columns = XColumns::One,
                "Multi" => format.x_columns = XColumns::Multi,
                _ => return unknown("No, One and Multi"),
            },
            _ => {}
        }
    }
    Err(RecordingError::Truncated { wanted: format!("the line {END_OF_HEADER}") })
}

/// Key and value of a header line, whatever the separator.
fn entry(line: &str) -> (&str, &str) {
    let line = line.trim();
    let at = line.find(['\t', ';', ',']).unwrap_or(line.len());
    let (key, rest) = line.split_at_checked(at).unwrap_or((line, ""));
    let mut rest = rest.chars();
    rest.next();
    (key, rest.as_str().trim_end_matches(['\t', ';']).trim())
}

pub(super) fn segment_header(
    lines: &mut LinesOf<'_>,
    format: &Format,
) -> Result<SegmentHeader, RecordingError> {
    let line = lines.peek().map_or(0, |(line, _)| *line);
    let mut header = SegmentHeader { line, ..SegmentHeader::default() };
    for (line, text) in lines {
        let mut fields = text.split(format.separator).map(str::trim);
        let key = fields.next().unwrap_or_default();
        let mut first = || fields.next().unwrap_or_default();
        let count = |text: &str| {
            text.parse::<usize>().map_err(|_| RecordingError::Header {
                line,
                fault: format!("{key} is \"{text}\"; it should be a whole number"),
            })
        };
        match key {
            END_OF_HEADER => {
                if header.channels == 0 {
                    let fault =
                        "the segment's header has no Channels entry; export it again".into();
                    return Err(RecordingError::Header { line, fault });
                }
                header.add_days();
                return Ok(header);
            }
            "Channels" => header.channels = count(first())?,
            "Samples" => {
                let samples = fields
                    .map(|field| if field.is_empty() { Ok(None) } else { count(field).map(Some) });
                header.samples = samples.collect::<Result<_, _>>()?;
            }
            "X_Dimension" => {
                let dimension = first();
                if !(dimension.is_empty() || dimension.eq_ignore_ascii_case("time")) {
                    let fault =
                        format!("X_Dimension is \"{dimension}\"; a recording over time is needed");
                    return Err(RecordingError::Header { line, fault });
                }
            }
            DELTA => {
                header.deltas = deltas(fields, format, line)?;
                header.delta_line = line;
            }
            "X0" => {
                header.firsts = numbers(fields, format, line)?;
                header.first_line = line;
            }
            "Date" => header.dates = fields.map(Date::parse).collect(),
            "Time" => {
                let seconds = |field| Stamp::parse(field).map(|stamp| stamp.seconds);
                header.clocks = fields.map(seconds).collect();
                header.clock_line = line;
            }
            "Y_Unit_Label" => header.units = fields.map(str::to_owned).collect(),
            _ => {}
        }
    }
    Err(RecordingError::Truncated { wanted: format!("the line {END_OF_HEADER} of a segment") })
}

/// The number of each channel; none where the entry is empty.
fn numbers<'t>(
    fields: impl Iterator<Item = &'t str>,
    format: &Format,
    line: usize,
) -> Result<Vec<Option<f64>>, RecordingError> {
    let number = |(column, field): (usize, &str)| match field {
        "" => Ok(None),
        field => format.decimal.value(field, line, column).map(Some),
    };
    (1..).zip(fields).map(number).collect()
}

/// The time step of each channel; none where the entry is empty.
fn deltas<'t>(
    fields: impl Iterator<Item = &'t str>,
    format: &Format,
    line: usize,
) -> Result<Vec<Option<Delta>>, RecordingError> {
    let delta = |(column, field): (usize, &str)| {
        if field.is_empty() {
            return Ok(None);
        }
        let step = format.decimal.value(field, line, column)?;
        Ok(Some(Delta { step, digit: last_digit(field) }))
    };
    (1..).zip(fields).map(delta).collect()
}

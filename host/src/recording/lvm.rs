//! LabVIEW measurement files (.lvm): text with a header for the file and one for each segment or for all segments.

use super::dialect::Lines;
use super::header::{channel, decided};
use super::number::{Decimal, last_digit};
use super::steps::{Steps, Times};
use super::time::{TimeColumn, time_column};
use super::{
    Channel, DeclaredRate, LeftOut, MOST_LINE_BYTES, Recording, RecordingError, Segment, Source,
};
use crate::encoding::Text;

/// Relative difference up to which two rates are the same, written with different digits.
pub(super) const EQUAL_RATES: f64 = 1e-6;

/// The fewest samples of a block under one header for several.
const SHORTEST_BLOCK: usize = 32;

const END_OF_HEADER: &str = "***End_of_Header***";
const DELTA: &str = "Delta_X";

/// Position of the X values in the file.
#[derive(Clone, Copy, PartialEq, Eq)]
enum XColumns {
    /// No X values; the first column is empty.
    No,
    /// X values in the first column.
    One,
    /// An X column before each channel.
    Multi,
}

/// The contents of the file header.
struct Format {
    separator: char,
    decimal: Decimal,
    x_columns: XColumns,
}

/// A time step and the unit of its last digit.
#[derive(Clone, Copy)]
struct Delta {
    step: f64,
    digit: f64,
}

/// The contents of a segment header.
#[derive(Default)]
struct SegmentHeader {
    line: usize,
    channels: usize,
    samples: Vec<Option<usize>>,
    units: Vec<String>,
    deltas: Vec<Option<Delta>>,
    /// The line of the time steps.
    delta_line: usize,
}

impl SegmentHeader {
    /// True for a channel with samples.
    fn is_filled(&self, channel: usize) -> bool {
        self.samples.get(channel).copied().flatten() != Some(0)
    }

    /// The first channel with samples, which the others are compared with.
    fn reference(&self) -> usize {
        (0..self.channels).find(|&k| self.is_filled(k)).unwrap_or(0)
    }

    /// Samples of a block.
    fn block(&self) -> Option<usize> {
        self.samples.get(self.reference()).copied().flatten()
    }

    /// The sampling rate.
    fn rate(&self) -> Option<DeclaredRate> {
        let Delta { step, digit } = self.deltas.get(self.reference()).copied().flatten()?;
        let uncertainty = 0.5 * digit / step;
        (step > 0.0).then_some(DeclaredRate { hz: step.recip(), uncertainty, entry: DELTA })
    }

    /// Why a channel cannot be used beside the others: it has another rate or another number of samples.
    fn fault(&self, channel: usize) -> Option<RecordingError> {
        let reference = self.reference();
        let delta = |k: usize| self.deltas.get(k).copied().flatten().map(|delta| delta.step);
        let samples = |k: usize| self.samples.get(k).copied().flatten();
        let fault = match (delta(reference), delta(channel)) {
            (Some(first), Some(step)) if (step - first).abs() > EQUAL_RATES * first.abs() => {
                format!(
                    "Delta_X: channel {} has a step of {step} s and channel {} one of {first} s; export channels of \
                 one rate",
                    channel + 1,
                    reference + 1
                )
            }
            _ => match (samples(reference), samples(channel)) {
                (Some(first), Some(count)) if count != first => format!(
                    "Samples: channel {} has {count} and channel {} has {first}; export channels of one rate",
                    channel + 1,
                    reference + 1
                ),
                _ => return None,
            },
        };
        Some(RecordingError::Header { line: self.delta_line.max(self.line), fault })
    }
}

/// Lines with their numbers, from 1.
type LinesOf<'t> =
    std::iter::Peekable<std::iter::Zip<std::ops::RangeFrom<usize>, std::str::Lines<'t>>>;

/// The rows under one header.
#[derive(Default)]
struct Rows {
    samples: Segment,
    x: Times,
    lines: Lines,
    count: usize,
}

/// Reads the text of a file.
pub(super) fn read(text: &Text<'_>) -> Result<Recording, RecordingError> {
    let content: &str = &text.text;
    if let Some(at) = content.lines().position(|line| line.len() > MOST_LINE_BYTES) {
        return Err(RecordingError::LongLine { line: at + 1 });
    }
    let mut lines: LinesOf<'_> = (1..).zip(content.lines()).peekable();
    let format = file_header(&mut lines)?;
    let mut recording = Recording {
        source: Source {
            format: "LabVIEW measurement",
            encoding: Some(text.encoding()),
            separator: None,
            decimal: Some(format.decimal),
        },
        ..Recording::default()
    };
    let mut values = 0;
    let mut empty = Vec::new();
    loop {
        while lines.peek().is_some_and(|(_, line)| line.trim().is_empty()) {
            lines.next();
        }
        let Some(&(line, _)) = lines.peek() else { break };
        let header = SegmentHeader { line, ..segment_header(&mut lines, &format)? };
        let names = names(&mut lines, &format, &header, text)?;
        if recording.segments.is_empty() {
            Recording::plausible(1, header.channels as u64)?;
            empty = (0..header.channels).map(|k| !header.is_filled(k)).collect();
            recording.channels = names;
            recording.declared = header.rate();
        } else {
            same_channels(&recording, &header)?;
        }
        let rows = rows(&mut lines, &format, &header, values)?;
        values += rows.samples.values();
        for segment in segments(&mut recording, &header, rows)? {
            Recording::plausible(recording.segments.len() as u64 + 1, 1)?;
            recording.segments.push(segment);
        }
    }
    if recording.segments.is_empty() {
        let wanted = "the first segment".to_owned();
        return Err(RecordingError::Truncated { wanted });
    }
    for (place, _) in empty.iter().enumerate().rev().filter(|(_, is_empty)| **is_empty) {
        let channel = recording.remove(place);
        let name = super::column(place, &channel);
        recording.left_out.push(LeftOut { name, reason: "it has no samples".into() });
    }
    Ok(recording)
}

/// Refuses a segment of other channels or of another rate than those before.
fn same_channels(recording: &Recording, header: &SegmentHeader) -> Result<(), RecordingError> {
    let expected = recording.channels.len();
    let line = header.line;
    if header.channels != expected {
        let fault = format!(
            "a segment of {} channels after one of {expected}; export segments of the same channels",
            header.channels
        );
        return Err(RecordingError::Header { line, fault });
    }
    if let (Some(first), Some(rate)) = (recording.declared, header.rate())
        && (rate.hz / first.hz - 1.0).abs() > EQUAL_RATES
    {
        let fault = format!(
            "Delta_X: this segment was sampled at {} Hz and the first one at {} Hz; export segments of one rate",
            rate.hz, first.hz
        );
        return Err(RecordingError::Header { line, fault });
    }
    Ok(())
}

/// The segments of the rows under one header: cut where the X values begin again, or without X values into blocks of as
/// many samples as the header states.
fn segments(
    recording: &mut Recording,
    header: &SegmentHeader,
    rows: Rows,
) -> Result<Vec<Segment>, RecordingError> {
    let Rows { samples, x, lines, count } = rows;
    let part = |range: std::ops::Range<usize>| {
        Segment(
            samples
                .0
                .iter()
                .map(|all| all.get(range.clone()).unwrap_or_default().to_vec())
                .collect(),
        )
    };
    let block = header.block().unwrap_or(count);
    if count < block {
        let wanted = format!("{block} samples of a segment ({count} are there)");
        return Err(RecordingError::Truncated { wanted });
    }
    if x.values.len() == count && x.rise() {
        let x_channel = Channel { name: "X_Value".into(), unit: "s".into(), ..Channel::default() };
        let (column, runs) = time_column(&x_channel, &x, |row| lines.of(row))?;
        same_step(recording, column, header.line)?;
        if runs.len() > 1 {
            recording.notes.push(format!(
                "the X values begin again: {} segments under one header",
                runs.len()
            ));
        }
        return Ok(runs.into_iter().map(part).collect());
    }
    if count == block {
        return Ok(vec![samples]);
    }
    if block < SHORTEST_BLOCK {
        recording
            .notes
            .push(format!("the header states {block} samples, and {count} are there: one segment"));
        return Ok(vec![samples]);
    }
    if count % block != 0 {
        let wanted = format!("{block} samples of the last segment ({} are there)", count % block);
        return Err(RecordingError::Truncated { wanted });
    }
    recording.notes.push(format!("one header for {} segments of {block} samples", count / block));
    Ok((0..count / block).map(|k| part(k * block..(k + 1) * block)).collect())
}

/// Keeps the X column of the first segment, or the first one whose steps are not even; refuses another step.
fn same_step(
    recording: &mut Recording,
    column: TimeColumn,
    line: usize,
) -> Result<(), RecordingError> {
    match (recording.time.as_ref().map(|time| time.steps), column.steps) {
        (
            Some(Steps::Even { step: first, uncertainty: a, .. }),
            Steps::Even { step, uncertainty: b, .. },
        ) if (step / first - 1.0).abs() > 1e-3 + a + b => {
            let fault = format!(
                "the X values of this segment have a step of {step} s and those before {first} s; export segments of \
                 one rate"
            );
            return Err(RecordingError::Header { line, fault });
        }
        (None, _) | (Some(Steps::Even { .. }), Steps::Lost { .. } | Steps::Uneven { .. }) => {
            recording.time = Some(column)
        }
        _ => {}
    }
    Ok(())
}

/// Reads up to the first end-of-header line.
fn file_header(lines: &mut LinesOf<'_>) -> Result<Format, RecordingError> {
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

fn segment_header(
    lines: &mut LinesOf<'_>,
    format: &Format,
) -> Result<SegmentHeader, RecordingError> {
    let mut header = SegmentHeader::default();
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
            "Y_Unit_Label" => header.units = fields.map(str::to_owned).collect(),
            _ => {}
        }
    }
    Err(RecordingError::Truncated { wanted: format!("the line {END_OF_HEADER} of a segment") })
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

/// Index of the value column of channel `k`, from 0.
fn column_of(k: usize, x_columns: XColumns) -> usize {
    match x_columns {
        XColumns::No | XColumns::One => 1 + k,
        XColumns::Multi => 2 * k + 1,
    }
}

fn names(
    lines: &mut LinesOf<'_>,
    format: &Format,
    header: &SegmentHeader,
    text: &Text<'_>,
) -> Result<Vec<Channel>, RecordingError> {
    let Some((at, names)) = lines.next() else {
        return Err(RecordingError::Truncated { wanted: "the names of the channels".into() });
    };
    let fields: Vec<&str> = names.split(format.separator).map(str::trim).collect();
    if header.channels > fields.len() {
        let fault = format!(
            "the header in line {} states {} channels, {} columns have names",
            header.line,
            header.channels,
            fields.len().saturating_sub(1)
        );
        return Err(RecordingError::Header { line: at, fault });
    }
    let named = |k: usize| {
        let name = fields.get(column_of(k, format.x_columns)).copied().unwrap_or_default();
        let fault = if header.is_filled(k) { header.fault(k) } else { None };
        match header.units.get(k).filter(|unit| !unit.is_empty()) {
            Some(unit) => Channel {
                name: name.to_owned(),
                unit: decided(unit, text),
                fault,
                ..Channel::default()
            },
            None => Channel { fault, ..channel(name, text) },
        }
    };
    Ok((0..header.channels).map(named).collect())
}

/// The rows under a header, up to the next header or the end of the file; `before` is the number of values in the
/// segments before.
fn rows(
    lines: &mut LinesOf<'_>,
    format: &Format,
    header: &SegmentHeader,
    before: usize,
) -> Result<Rows, RecordingError> {
    let mut rows = Rows { samples: Segment::of_channels(header.channels), ..Rows::default() };
    let is_used: Vec<bool> =
        (0..header.channels).map(|k| header.is_filled(k) && header.fault(k).is_none()).collect();
    let x_column = match format.x_columns {
        XColumns::No => None,
        XColumns::One => Some(0),
        XColumns::Multi => Some(2 * header.reference()),
    };
    while let Some(&(line, text)) = lines.peek() {
        let is_blank = text.trim().is_empty();
        if !is_blank && !is_row(text, format) {
            break;
        }
        lines.next();
        if is_blank {
            continue;
        }
        // Some versions of LabVIEW omit the empty first column; such lines have only the values.
        let fields: Vec<&str> = text.split(format.separator).collect();
        let bare = format.x_columns == XColumns::No && fields.len() == header.channels;
        for (k, (to, is_used)) in rows.samples.0.iter_mut().zip(&is_used).enumerate() {
            if !header.is_filled(k) {
                continue;
            }
            let column = if bare { k } else { column_of(k, format.x_columns) };
            let Some(field) = fields.get(column) else {
                let wanted = column_of(header.channels - 1, format.x_columns) + 1;
                return Err(RecordingError::Ragged { line, found: fields.len(), wanted });
            };
            to.push(match is_used {
                true => format.decimal.value(field, line, column)?,
                // A slower channel has empty fields.
                false => format.decimal.number(field).unwrap_or_default(),
            });
        }
        if let Some(field) = x_column.and_then(|column| fields.get(column))
            && let Some(x) = format.decimal.number(field)
        {
            rows.x.push(x, last_digit(field));
        }
        rows.lines.add(rows.count, line);
        rows.count += 1;
        Recording::within_memory(before, &rows.samples)?;
    }
    Ok(rows)
}

/// True for a line that is no entry of a header: its first field is empty or begins like a number.
fn is_row(text: &str, format: &Format) -> bool {
    let first = text.split(format.separator).next().unwrap_or_default().trim();
    first.is_empty() || !first.starts_with(|c: char| c.is_alphabetic() || c == '*')
}

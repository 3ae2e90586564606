//! LabVIEW measurement files (.lvm): text with a header for the file and one for each segment or for all segments.

mod header;

use super::dialect::Lines;
use super::header::{channel, decided, with_unit};
use super::number::last_digit;
use super::steps::{Steps, Times};
use super::time::{TimeColumn, time_column};
use super::{
    Channel, LeftOutColumn, MOST_LINE_BYTES, Recording, RecordingError, Segment, Source, called,
};
use crate::encoding::Text;
use crate::units::is_unstated;
use header::{Format, SegmentHeader, XColumns, file_header, is_entry, segment_header};

/// Relative difference up to which two rates are the same, written with different digits.
pub(super) const EQUAL_RATES: f64 = 1e-6;

/// The fewest samples of a block under one header for several.
const SHORTEST_BLOCK: usize = 32;

/// Lines with their numbers, from 1.
type LinesOf<'t> =
    std::iter::Peekable<std::iter::Zip<std::ops::RangeFrom<usize>, std::str::Lines<'t>>>;

/// The rows under one header.
#[derive(Default)]
struct Rows {
    samples: Segment,
    /// The X values: of all channels, or of each where each has its own.
    x: Vec<Times>,
    /// The first row without an X value.
    without_x: Option<usize>,
    lines: Lines,
    count: usize,
}

impl Rows {
    /// The X values of a channel, where each row has one.
    fn x_of(&self, channel: usize) -> Option<&Times> {
        let x = if self.x.len() == 1 { self.x.first() } else { self.x.get(channel) }?;
        (x.values.len() == self.count).then_some(x)
    }

    /// The row from which on the X values of a channel are more than half a step from those of another one.
    fn parts_from(&self, channel: usize, other: usize) -> Option<usize> {
        let (x, other) = (self.x_of(channel)?, self.x_of(other)?);
        let range = other.values.last()? - other.values.first()?;
        let most = 0.5 * (range / self.count.max(2) as f64).abs();
        let digits = x.digits.iter().zip(&other.digits).map(|(a, b)| a + b);
        let mut pairs = x.values.iter().zip(&other.values).zip(digits);
        pairs.position(|((a, b), digits)| (a - b).abs() > most + digits)
    }
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
        if lines.peek().is_none() {
            break;
        }
        let header = segment_header(&mut lines, &format)?;
        let mut names = names(&mut lines, &format, &header, text)?;
        let x_unit = row_of_units(&mut lines, &format, &header, text, &mut names);
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
        mark_other_times(&mut recording.channels, &header, &rows);
        let x_unit = x_unit.as_deref().unwrap_or("s");
        for segment in segments(&mut recording, &header, rows, x_unit)? {
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
        recording.left_out.push(LeftOutColumn { name, reason: "it has no samples".into() });
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
    if let (Some(first), Some(rate)) = (&recording.declared, header.rate())
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
    x_unit: &str,
) -> Result<Vec<Segment>, RecordingError> {
    let x = rows.x_of(header.reference()).filter(|x| x.change()).cloned();
    let has_x = rows.x.iter().any(|x| !x.values.is_empty());
    let Rows { samples, lines, count, without_x, .. } = rows;
    if let Some(row) = without_x.filter(|_| has_x) {
        let fault =
            "this row has no X value, and others have; export them with or without X values".into();
        return Err(RecordingError::Header { line: lines.of(row), fault });
    }
    let part = |range: std::ops::Range<usize>| {
        Segment(
            samples
                .0
                .iter()
                .map(|values| values.get(range.clone()).unwrap_or_default().to_vec())
                .collect(),
        )
    };
    let block = header.block().unwrap_or(count);
    if count < block {
        let wanted = format!("{block} samples of a segment ({count} are there)");
        return Err(RecordingError::Truncated { wanted });
    }
    if let Some(x) = x {
        let x_channel =
            Channel { name: "X_Value".into(), unit: x_unit.into(), ..Channel::default() };
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

/// Marks the channels whose own X values are not those of the first channel: they were not sampled with it.
fn mark_other_times(channels: &mut [Channel], header: &SegmentHeader, rows: &Rows) {
    let reference = header.reference();
    let first =
        channels.get(reference).map_or_else(String::new, |channel| called(reference, channel));
    for (k, channel) in channels.iter_mut().enumerate() {
        let Some(row) = rows.parts_from(k, reference).filter(|_| header.is_filled(k)) else {
            continue;
        };
        let x =
            |k: usize| rows.x_of(k).and_then(|x| x.values.get(row).copied()).unwrap_or_default();
        let fault = format!(
            "the X value of {} is {} here and that of {first} {}; export channels that were sampled together, without \
             gaps",
            called(k, channel),
            x(k),
            x(reference)
        );
        let fault = RecordingError::Header { line: rows.lines.of(row), fault };
        channel.fault.get_or_insert(fault);
    }
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
        (None, _) | (Some(Steps::Even { .. }), Steps::Lost { .. } | Steps::Uneven(_)) => {
            recording.time = Some(column)
        }
        _ => {}
    }
    Ok(())
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

/// Reads a row of units beneath the names, where there is one: whatever stands there in place of numbers. The unit of
/// the X values, where it is stated.
fn row_of_units(
    lines: &mut LinesOf<'_>,
    format: &Format,
    header: &SegmentHeader,
    text: &Text<'_>,
    channels: &mut [Channel],
) -> Option<String> {
    let (_, row) = lines.peek()?;
    let fields: Vec<&str> = row.split(format.separator).map(str::trim).collect();
    let field = |column: usize| fields.get(column).copied().unwrap_or_default();
    let labels: Vec<&str> =
        (0..header.channels).map(|k| field(column_of(k, format.x_columns))).collect();
    let is_number = |label: &&str| format.decimal.number(label).is_some();
    let is_of_units = labels.iter().any(|label| !label.is_empty())
        && !labels.iter().any(is_number)
        && !is_entry(field(0));
    if !is_of_units {
        return None;
    }
    lines.next();
    for (channel, label) in channels.iter_mut().zip(labels) {
        *channel = with_unit(std::mem::take(channel), label, text);
    }
    let x_unit = format.x_column(header.reference()).map(field)?;
    (!is_unstated(x_unit)).then(|| decided(x_unit.trim_matches(['[', ']', '(', ')']), text))
}

/// The rows under a header, up to the next header or the end of the file; `before` is the number of values in the
/// segments before.
fn rows(
    lines: &mut LinesOf<'_>,
    format: &Format,
    header: &SegmentHeader,
    before: usize,
) -> Result<Rows, RecordingError> {
    let x_columns: Vec<usize> = match format.x_columns {
        XColumns::Multi => (0..header.channels).filter_map(|k| format.x_column(k)).collect(),
        _ => format.x_column(header.reference()).into_iter().collect(),
    };
    let mut rows = Rows {
        samples: Segment::of_channels(header.channels),
        x: vec![Times::default(); x_columns.len()],
        ..Rows::default()
    };
    let is_used: Vec<bool> =
        (0..header.channels).map(|k| header.is_filled(k) && header.fault(k).is_none()).collect();
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
        for (x, column) in rows.x.iter_mut().zip(&x_columns) {
            if let Some(field) = fields.get(*column)
                && let Some(value) = format.decimal.number(field)
            {
                x.push(value, last_digit(field));
            } else if Some(*column) == format.x_column(header.reference()) {
                rows.without_x.get_or_insert(rows.count);
            }
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

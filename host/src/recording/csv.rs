//! Text with a column for each channel: separated by semicolon, tab or comma, with or without a line
//! of names.

use std::cell::Cell;
use std::io::{self, Read};
use std::rc::Rc;

use super::number::Decimal;
use super::{Channel, MOST_LINE_BYTES, Recording, RecordingError, Segment};
use crate::units::{Quantity, force_unit, motion_unit};

/// Largest relative deviation of a time step from the mean step at which the time column counts as even.
const EVEN: f64 = 1e-2;

/// Most lines of text before the data.
const MOST_HEADER_LINES: usize = 1000;

/// A line of fields, with its number, from 1.
struct Row {
    line: usize,
    fields: Vec<String>,
}

/// Reads the text of a file.
pub(super) fn read(text: &str) -> Result<Recording, RecordingError> {
    let sample = text.lines().filter(|line| !is_comment(line)).take(8).last().unwrap_or_default();
    // The last of the first eight lines is numeric if any of them is.
    let (separator, decimal) = dialect(sample).ok_or(RecordingError::UnknownFormat)?;
    let (mut header, mut data) = (Vec::new(), Segment::default());
    for row in rows_of(text, separator) {
        let Row { line, fields } = row?;
        let before = data.samples() == 0;
        if before && fields.iter().any(|f| is_text(f)) {
            if header.len() == MOST_HEADER_LINES {
                return Err(RecordingError::UnknownFormat);
            }
            header.push(Row { line, fields });
            continue;
        }
        if fields.first().is_some_and(|first| first.starts_with('#')) {
            continue;
        }
        if before {
            Recording::plausible(1, fields.len() as u64)?;
            data = Segment::of_channels(fields.len());
        }
        let wanted = data.0.len();
        if fields.len() != wanted {
            return Err(RecordingError::Ragged { line, found: fields.len(), wanted });
        }
        refuse_decimals(&fields, separator, &header, line)?;
        for (column, (to, field)) in data.0.iter_mut().zip(&fields).enumerate() {
            to.push(decimal.value(field, line, column)?);
        }
        Recording::within_memory(0, &data)?;
    }
    if data.samples() == 0 {
        return Err(RecordingError::UnknownFormat);
    }
    let channels = channels(header, data.0.len())?;
    Ok(recording(channels, data))
}

/// The rows of the text, with quotes taken off; blank lines are left out.
fn rows_of(text: &str, separator: char) -> impl Iterator<Item = Result<Row, RecordingError>> {
    let left = Rc::new(Cell::new(0));
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(u8::try_from(separator).unwrap_or(b','))
        .has_headers(false)
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(Limited { bytes: text.as_bytes(), left: left.clone() });
    let mut record = csv::StringRecord::new();
    std::iter::from_fn(move || {
        loop {
            left.set(MOST_LINE_BYTES);
            let line = reader.position().line() as usize;
            match reader.read_record(&mut record) {
                Ok(false) => return None,
                Ok(true) => {}
                // That the text is UTF-8 has been checked.
                Err(_) => return Some(Err(RecordingError::LongLine { line })),
            }
            let line = record.position().map_or(1, |at| at.line()) as usize;
            let mut fields: Vec<String> = record.iter().map(str::to_owned).collect();
            if fields.len() > 1 && fields.last().is_some_and(String::is_empty) {
                fields.pop();
            }
            if fields.iter().any(|field| !field.is_empty()) {
                return Some(Ok(Row { line, fields }));
            }
        }
    })
}

/// Bytes of which a part is read at a time: a line that does not end, or a quote, would fill the memory.
struct Limited<'t> {
    bytes: &'t [u8],
    left: Rc<Cell<usize>>,
}

impl Read for Limited<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.left.get() == 0 && !self.bytes.is_empty() {
            return Err(io::ErrorKind::FileTooLarge.into());
        }
        let most = buffer.len().min(self.left.get().max(1));
        let read = self.bytes.read(&mut buffer[..most])?;
        self.left.set(self.left.get().saturating_sub(read));
        Ok(read)
    }
}

/// The channels from the lines of text before the data: names, then perhaps units; other lines are comments.
fn channels(header: Vec<Row>, columns: usize) -> Result<Vec<Channel>, RecordingError> {
    let mut whole: Vec<Vec<String>> = Vec::new();
    let mut last = None;
    for Row { line, mut fields } in header {
        if let Some(first) = fields.first_mut() {
            *first = first.trim_start_matches(['#', '%']).trim().to_owned();
        }
        if fields.len() == columns {
            whole.push(fields);
        } else {
            last = Some((line, fields));
        }
    }
    let units = whole.pop_if(|fields| fields.iter().all(|f| f.is_empty() || is_unit(f)));
    let names = match (whole.pop(), last) {
        (Some(names), _) => names,
        // The header may omit names, but must not have more names than there are columns.
        (None, Some((line, fields))) if fields.len() > columns && columns > 1 => {
            return Err(RecordingError::Ragged { line, found: fields.len(), wanted: columns });
        }
        (None, Some((_, fields))) => fields,
        (None, None) => Vec::new(),
    };
    let unit = |k: usize| units.as_ref().and_then(|units| units.get(k)).filter(|u| !u.is_empty());
    let named = |k: usize| channel(names.get(k).map_or("", String::as_str));
    Ok((0..columns)
        .map(|k| match unit(k) {
            Some(unit) => Channel { unit: unwrapped(unit), ..named(k) },
            None => named(k),
        })
        .collect())
}

/// A unit without its brackets.
fn unwrapped(unit: &str) -> String {
    unit.trim_matches(['[', ']', '(', ')']).trim().to_owned()
}

fn is_unit(text: &str) -> bool {
    let unit = unwrapped(text);
    let known = ["s", "ms", "us", "µs", "V", "mV", "-", "1", "°C", "degC"];
    known.contains(&unit.as_str())
        || force_unit(&unit).is_some()
        || Quantity::ALL.into_iter().any(|quantity| motion_unit(&unit, quantity).is_some())
}

/// A comment, or nothing.
fn is_comment(line: &str) -> bool {
    line.trim().is_empty() || line.trim_start().starts_with('#')
}

/// Refuses a row in which commas are decimal signs and separators.
fn refuse_decimals(
    fields: &[String],
    separator: char,
    header: &[Row],
    line: usize,
) -> Result<(), RecordingError> {
    if separator != ',' {
        return Ok(());
    }
    let names = header.last().map_or(0, |names| names.fields.len());
    let halved = names * 2 == fields.len() && !fields.iter().any(|field| field.contains('.'));
    let decimals = |(k, field): (usize, &String)| is_decimals(field) || (halved && k % 2 == 1);
    match fields.iter().enumerate().position(decimals) {
        None => Ok(()),
        Some(column) => {
            let text =
                fields.get(column).map_or_else(String::new, |f| f.chars().take(40).collect());
            Err(RecordingError::CommaTwice { line, column: column + 1, text })
        }
    }
}

/// True for a field that is a name rather than a malformed number: it begins with a letter; NaN and infinity
/// count as numbers.
fn is_text(field: &str) -> bool {
    let begins = field
        .chars()
        .next()
        .is_some_and(|c| c.is_alphabetic() || matches!(c, '#' | '[' | '(' | '%'));
    begins && field.parse::<f64>().is_err()
}

/// True for digits that no whole number begins with: a zero and another digit.
fn is_decimals(field: &str) -> bool {
    let mut characters = field.chars();
    characters.next() == Some('0')
        && characters.next().is_some_and(|c| c.is_ascii_digit())
        && characters.all(|c| c.is_ascii_digit())
}

/// Separator and decimal sign of a line of numbers.
fn dialect(line: &str) -> Option<(char, Decimal)> {
    let separator = [';', '\t'].into_iter().find(|&c| line.contains(c));
    let of = |fields: &str| match fields.contains(',') && !fields.contains('.') {
        true => Decimal::Comma,
        false => Decimal::Point,
    };
    match separator {
        Some(separator) => Some((separator, of(line))),
        None if line.contains(',') => Some((',', Decimal::Point)),
        // A single column.
        None => line.trim().parse::<f64>().ok().map(|_| (',', Decimal::Point)),
    }
}

/// Removes a time column.
fn recording(mut channels: Vec<Channel>, mut segment: Segment) -> Recording {
    let named = channels.first().is_some_and(|c| is_time(&c.name));
    let step = segment.0.first().and_then(|first| even_step(first));
    let unnamed = channels.first().is_some_and(|c| c.name.is_empty());
    let mut rate_hz = None;
    if named || (unnamed && step.is_some()) {
        let unit = match channels.first().map(|c| c.unit.as_str()) {
            Some("ms") => 1e3,
            Some("us" | "µs") => 1e6,
            _ => 1.0,
        };
        rate_hz = step.map(|step| unit / step);
        channels.remove(0);
        segment.0.remove(0);
    }
    Recording { rate_hz, channels, segments: vec![segment] }
}

/// Splits `Force [N]` or `Force (N)` into a name and a unit.
fn channel(text: &str) -> Channel {
    let open = text.rfind(['[', '(']);
    let parts = open.and_then(|at| text.split_at_checked(at));
    match parts {
        Some((name, unit)) if unit.ends_with([']', ')']) => {
            Channel { name: name.trim().to_owned(), unit: unwrapped(unit), factor: None }
        }
        _ => Channel { name: text.to_owned(), ..Channel::default() },
    }
}

fn is_time(name: &str) -> bool {
    let name = name.to_lowercase();
    ["t", "x_value", "zeit"].contains(&name.as_str()) || name.starts_with("time")
}

/// The step of a column whose values rise evenly.
fn even_step(column: &[f64]) -> Option<f64> {
    let (first, last) = (column.first()?, column.last()?);
    let steps = column.len().checked_sub(1).filter(|&steps| steps >= 2)?;
    let mean = (last - first) / steps as f64;
    let even = column.windows(2).all(|pair| match pair {
        [a, b] => (b - a - mean).abs() <= EVEN * mean,
        _ => false,
    });
    (even && mean > 0.0).then_some(mean)
}

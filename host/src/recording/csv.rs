//! Text with a column for each channel: separated by semicolon, tab or comma, with or without a line
//! of names.

use super::number::Decimal;
use super::{Channel, Recording, RecordingError, Segment};

/// Largest relative deviation of a time step from the mean step at which the time column counts as even.
const EVEN: f64 = 1e-2;

/// Reads the text of a file.
pub(super) fn read(text: &str) -> Result<Recording, RecordingError> {
    let lines = || (1..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty());
    // The last of the first eight lines is numeric if any of them is.
    let sample = lines().take(8).last().map_or("", |(_, line)| line);
    let (separator, decimal) = dialect(sample).ok_or(RecordingError::UnknownFormat)?;
    let fields = |line: &'_ str| -> Vec<String> {
        let line = line.trim_end_matches(separator).trim_end_matches('\r');
        line.split(separator).map(|field| field.trim().trim_matches('"').to_owned()).collect()
    };
    let (mut names, mut rows, mut columns) = (Vec::new(), Vec::new(), 0);
    for (line, text) in lines() {
        let fields = fields(text);
        let is_names = rows.is_empty() && fields.iter().any(|f| is_text(f));
        if is_names {
            names = fields;
            continue;
        }
        if rows.is_empty() {
            columns = fields.len();
        }
        if fields.len() != columns {
            return Err(RecordingError::Ragged { line, found: fields.len(), wanted: columns });
        }
        let halved = names.len() * 2 == columns && !text.contains('.');
        let decimals = |(k, field): (usize, &String)| is_decimals(field) || (halved && k % 2 == 1);
        if separator == ','
            && let Some(column) = fields.iter().enumerate().position(decimals)
        {
            let text =
                fields.get(column).map_or_else(String::new, |f| f.chars().take(40).collect());
            return Err(RecordingError::CommaTwice { line, column: column + 1, text });
        }
        for (column, field) in fields.iter().enumerate() {
            rows.push(decimal.value(field, line, column)?);
        }
    }
    if rows.is_empty() {
        return Err(RecordingError::UnknownFormat);
    }
    // The header may omit names, but must not have more names than there are columns.
    if names.len() > columns {
        return Err(RecordingError::Ragged { line: 1, found: names.len(), wanted: columns });
    }
    Ok(recording(names, Segment::of_rows(&rows, columns)))
}

/// True for a field that is a name rather than a malformed number: it begins with a letter; NaN and infinity
/// count as numbers.
fn is_text(field: &str) -> bool {
    let begins = field.chars().next().is_some_and(|c| c.is_alphabetic() || c == '#' || c == '[');
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

/// Removes a time column, and splits units in brackets off the names.
fn recording(names: Vec<String>, mut segment: Segment) -> Recording {
    let mut channels: Vec<Channel> =
        (0..segment.0.len()).map(|k| channel(names.get(k).map_or("", String::as_str))).collect();
    let named = channels.first().is_some_and(|c| is_time(&c.name));
    let step = segment.0.first().and_then(|first| even_step(first));
    let unnamed = channels.first().is_some_and(|c| c.name.is_empty());
    let mut rate_hz = None;
    if named || (unnamed && step.is_some()) {
        let unit = if channels.first().is_some_and(|c| c.unit == "ms") { 1e3 } else { 1.0 };
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
        Some((name, unit)) if unit.ends_with([']', ')']) => Channel {
            name: name.trim().to_owned(),
            unit: unit.trim_matches(['[', ']', '(', ')']).trim().to_owned(),
            factor: None,
        },
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

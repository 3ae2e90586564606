//! LabVIEW measurement files (.lvm): text with a header for the file and one for each segment.

use super::number::Decimal;
use super::{Channel, MOST_LINE_BYTES, Recording, RecordingError, Segment};

/// Relative difference up to which two rates are the same, written with different digits.
pub(super) const EQUAL_RATES: f64 = 1e-6;

const END_OF_HEADER: &str = "***End_of_Header***";

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

/// The contents of a segment header.
#[derive(Default)]
struct SegmentHeader {
    channels: usize,
    samples: Option<usize>,
    units: Vec<String>,
    delta: Option<f64>,
}

impl SegmentHeader {
    /// The sampling rate, Hz.
    fn rate(&self) -> Option<f64> {
        self.delta.filter(|step| *step > 0.0).map(f64::recip)
    }
}

/// Lines with their numbers, from 1.
type Lines<'t> =
    std::iter::Peekable<std::iter::Zip<std::ops::RangeFrom<usize>, std::str::Lines<'t>>>;

/// Reads the text of a file.
pub(super) fn read(text: &str) -> Result<Recording, RecordingError> {
    if let Some(at) = text.lines().position(|line| line.len() > MOST_LINE_BYTES) {
        return Err(RecordingError::LongLine { line: at + 1 });
    }
    let mut lines: Lines<'_> = (1..).zip(text.lines()).peekable();
    let format = file_header(&mut lines)?;
    let mut recording = Recording { rate_hz: None, channels: Vec::new(), segments: Vec::new() };
    let mut values = 0;
    loop {
        while lines.peek().is_some_and(|(_, line)| line.trim().is_empty()) {
            lines.next();
        }
        let Some(&(line, _)) = lines.peek() else { break };
        let header = segment_header(&mut lines, &format)?;
        let names = names(&mut lines, &format, &header, line)?;
        let expected =
            if recording.segments.is_empty() { header.channels } else { recording.channels.len() };
        if header.channels != expected {
            let fault = format!(
                "a segment of {} channels after one of {expected}; export segments of the same \
                 channels",
                header.channels
            );
            return Err(RecordingError::Header { line, fault });
        }
        Recording::plausible(recording.segments.len() as u64 + 1, header.channels as u64)?;
        if recording.segments.is_empty() {
            recording.channels = names;
            recording.rate_hz = header.rate();
        } else if let (Some(first), Some(rate)) = (recording.rate_hz, header.rate())
            && (rate / first - 1.0).abs() > EQUAL_RATES
        {
            let fault = format!(
                "this segment was sampled at {rate} Hz and the first one at {first} Hz; export segments of one rate"
            );
            return Err(RecordingError::Header { line, fault });
        }
        let segment = data(&mut lines, &format, &header, values)?;
        values += segment.values();
        recording.segments.push(segment);
    }
    if recording.segments.is_empty() {
        let wanted = "the first segment".to_owned();
        return Err(RecordingError::Truncated { wanted });
    }
    Ok(recording)
}

/// Reads up to the first end-of-header line.
fn file_header(lines: &mut Lines<'_>) -> Result<Format, RecordingError> {
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

fn segment_header(lines: &mut Lines<'_>, format: &Format) -> Result<SegmentHeader, RecordingError> {
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
            "Samples" => header.samples = Some(count(first())?),
            "Delta_X" => header.delta = delta(fields, format, line)?,
            "Y_Unit_Label" => header.units = fields.map(str::to_owned).collect(),
            _ => {}
        }
    }
    Err(RecordingError::Truncated { wanted: format!("the line {END_OF_HEADER} of a segment") })
}

/// The time step of all channels; none when the entry is empty.
fn delta<'t>(
    fields: impl Iterator<Item = &'t str>,
    format: &Format,
    line: usize,
) -> Result<Option<f64>, RecordingError> {
    let mut first = None;
    for (column, field) in (1..).zip(fields).filter(|(_, field)| !field.is_empty()) {
        let step = format.decimal.value(field, line, column)?;
        let same = |first: f64| (step - first).abs() <= EQUAL_RATES * first.abs();
        if !same(*first.get_or_insert(step)) {
            let fault = format!(
                "Delta_X: channel {column} has a step of {step} s and channel 1 one of {} s; export channels of \
                 one rate",
                first.unwrap_or(step)
            );
            return Err(RecordingError::Header { line, fault });
        }
    }
    Ok(first)
}

/// Index of the value column of channel `k`, from 0.
fn column_of(k: usize, x_columns: XColumns) -> usize {
    match x_columns {
        XColumns::No | XColumns::One => 1 + k,
        XColumns::Multi => 2 * k + 1,
    }
}

fn names(
    lines: &mut Lines<'_>,
    format: &Format,
    header: &SegmentHeader,
    line: usize,
) -> Result<Vec<Channel>, RecordingError> {
    let Some((at, text)) = lines.next() else {
        return Err(RecordingError::Truncated { wanted: "the names of the channels".into() });
    };
    let fields: Vec<&str> = text.split(format.separator).map(str::trim).collect();
    if header.channels > fields.len() {
        let fault = format!(
            "the header in line {line} states {} channels, {} columns have names",
            header.channels,
            fields.len().saturating_sub(1)
        );
        return Err(RecordingError::Header { line: at, fault });
    }
    let text = |from: Option<&&str>| from.map_or_else(String::new, |text| (*text).to_owned());
    Ok((0..header.channels)
        .map(|k| Channel {
            name: text(fields.get(column_of(k, format.x_columns))),
            unit: header.units.get(k).cloned().unwrap_or_default(),
            factor: None,
        })
        .collect())
}

/// The rows of a segment, up to an empty line or the end of the file; `before` is the number of values in segments before.
fn data(
    lines: &mut Lines<'_>,
    format: &Format,
    header: &SegmentHeader,
    before: usize,
) -> Result<Segment, RecordingError> {
    let mut data = Segment::of_channels(header.channels);
    let mut samples = 0_usize;
    while header.samples.is_none_or(|all| samples < all) {
        let Some(&(line, text)) = lines.peek() else { break };
        if text.trim().is_empty() || text.starts_with("Channels") {
            break;
        }
        lines.next();
        // Some versions of LabVIEW omit the empty first column; such lines have only the values.
        let fields: Vec<&str> = text.split(format.separator).collect();
        let bare = format.x_columns == XColumns::No && fields.len() == header.channels;
        for (k, to) in data.0.iter_mut().enumerate() {
            let column = if bare { k } else { column_of(k, format.x_columns) };
            let Some(field) = fields.get(column) else {
                let wanted = column_of(header.channels - 1, format.x_columns) + 1;
                return Err(RecordingError::Ragged { line, found: fields.len(), wanted });
            };
            to.push(format.decimal.value(field, line, column)?);
        }
        samples += 1;
        Recording::within_memory(before, &data)?;
    }
    match header.samples {
        Some(wanted) if wanted > samples => {
            let wanted = format!("{wanted} samples of a segment ({samples} are there)");
            Err(RecordingError::Truncated { wanted })
        }
        _ => Ok(data),
    }
}

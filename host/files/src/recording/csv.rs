//! Text with a column for each channel, separated by semicolons, tabs, commas or blanks.

mod column;

use super::clock::{refuse_set_clock, with_fractions};
use super::date::Date;
use super::dialect::{Dialect, Kind, Lines, Row, Separator, rows_of};
use super::header;
use super::number::Decimal;
use super::steps::Times;
use super::time::{TimeUnit, may_be_time};
use super::{Channel, LeftOutColumn, Recording, RecordingError, Segment, Source, declared, losses};
use crate::encoding::Text;
use crate::units::is_unstated;
use column::Column;

/// Reads the text of a file; `stated` is its decimal sign, where the user states it.
pub(super) fn read(text: &Text<'_>, stated: Option<Decimal>) -> Result<Recording, RecordingError> {
    let content: &str = &text.text;
    let dialect = Dialect::of(content)?;
    let separator = dialect.separator;
    let decimal = match stated {
        Some(decimal) => decimal,
        None => dialect.decimal(content)?,
    };
    Recording::plausible(1, dialect.kinds.len() as u64)?;
    let mut rows = rows_of(content, separator);
    let header = rows.by_ref().take(dialect.start).collect::<Result<Vec<_>, _>>()?;
    let names = header.last().map_or(0, |names| names.fields.len());
    header.iter().try_for_each(losses::refuse)?;
    let declared = declared::rate(&header);
    let channels = header::channels(header, dialect.kinds.len(), separator, text)?;
    let mut table = Table::new(&channels, &dialect.kinds, decimal);
    for row in rows {
        let row = row?;
        if row.fields.first().is_some_and(|first| first.starts_with('#')) {
            table.add_comment(&row)?;
            continue;
        }
        if separator == Separator::Comma {
            refuse_decimals(&row, names)?;
        }
        table.add(row)?;
    }
    let mut recording = table.recording(channels)?;
    recording.declared = declared;
    recording.source = Source {
        format: "text with columns",
        encoding: Some(text.encoding()),
        separator: Some(separator.name()),
        decimal: Some(decimal),
    };
    Ok(recording)
}

/// The columns of numbers while they are read.
struct Table {
    decimal: Decimal,
    columns: Vec<Column>,
    lines: Lines,
    rows: usize,
    /// Rows with text behind the numbers.
    comments: usize,
    /// The first line of text among the numbers.
    remark: Option<String>,
}

impl Table {
    fn new(channels: &[Channel], kinds: &[Kind], decimal: Decimal) -> Self {
        let column = |(place, kind): (usize, &Kind)| {
            let is_candidate =
                channels.get(place).is_some_and(|channel| may_be_time(place, channel));
            Column::new(*kind, is_candidate || *kind == Kind::Stamp)
        };
        let columns = kinds.iter().enumerate().map(column).collect();
        Self { decimal, columns, lines: Lines::default(), rows: 0, comments: 0, remark: None }
    }

    /// Notes a line of text among the numbers.
    ///
    /// # Errors
    /// When it says that samples were lost.
    fn add_comment(&mut self, row: &Row) -> Result<(), RecordingError> {
        losses::refuse(row)?;
        let text: String = row.fields.join(" ").chars().take(60).collect();
        let remark = || {
            format!("a line of text among the numbers is not used: \"{text}\" (line {})", row.line)
        };
        self.remark.get_or_insert_with(remark);
        Ok(())
    }

    fn add(&mut self, Row { line, mut fields }: Row) -> Result<(), RecordingError> {
        let wanted = self.columns.len();
        let may_be_empty =
            self.columns.last().is_some_and(|column| column.numbers == 0 && column.stamps == 0);
        if fields.len() + 1 == wanted && wanted > 1 && may_be_empty {
            fields.push(String::new());
        }
        // A remark behind the numbers.
        if fields.len() == wanted + 1
            && fields.last().is_some_and(|last| Kind::of(last) == Kind::Text)
        {
            fields.pop();
            self.comments += 1;
        }
        if fields.len() != wanted {
            return Err(RecordingError::Ragged { line, found: fields.len(), wanted });
        }
        let is_date = |column: &Column| column.kind == Some(Kind::Date);
        let date = self.columns.iter().position(is_date).and_then(|place| fields.get(place));
        let date = date.and_then(|field| Date::parse(field));
        for (place, (column, field)) in self.columns.iter_mut().zip(&fields).enumerate() {
            column.add(field, self.decimal, date, [line, place]);
        }
        self.lines.add(self.rows, line);
        self.rows += 1;
        if self.rows.saturating_mul(wanted) > super::MOST_VALUES {
            return Err(RecordingError::TooLong);
        }
        Ok(())
    }

    /// The recording of these columns.
    fn recording(self, mut channels: Vec<Channel>) -> Result<Recording, RecordingError> {
        if self.rows == 0 {
            return Err(RecordingError::UnknownFormat);
        }
        let Self { mut columns, lines, rows, comments, remark, .. } = self;
        let rising = |column: &Column| {
            let times = Times::exact(column.values.clone());
            times.count() || times.rise()
        };
        name_rows(&mut channels, columns.first().is_some_and(rising));
        let mut recording =
            Recording { segments: vec![Segment::default()], ..Recording::default() };
        recording.notes.extend(remark);
        take_columns_of_units(&columns, &mut channels);
        recording.left_out.extend(join_fractions(&mut columns, &mut channels, rows));
        let mut times = Vec::new();
        let mut clocks = Vec::new();
        let mut broken_time = None;
        for (place, (column, mut channel)) in columns.into_iter().zip(channels).enumerate() {
            let is_whole = column.numbers + column.stamps == rows;
            let is_clock = matches!(column.text, Some(RecordingError::NotATime { .. }));
            if !is_whole && (column.digits.is_some() || is_clock) && !channel.name.is_empty() {
                // A time with holes or text is none, and no reading of a sensor either.
                let fault = column.text.clone().or_else(|| column.empty.clone());
                if (super::time::is_time(&channel) || is_clock)
                    && (column.numbers + column.stamps > 0 || column.begins_with_digit())
                {
                    broken_time = broken_time.or(fault);
                }
                let name = super::column(place, &channel);
                recording.left_out.push(LeftOutColumn { name, reason: column.not_whole() });
                continue;
            }
            if let Some(reason) = column.no_channel(rows) {
                if !channel.name.is_empty() || column.text.is_some() {
                    recording
                        .left_out
                        .push(LeftOutColumn { name: super::column(place, &channel), reason });
                }
                continue;
            }
            let is_read = column.numbers > 0 || column.kind == Some(Kind::Number);
            let of_text = column.text.clone().filter(|_| is_read);
            channel.fault = of_text.or_else(|| column.empty.clone()).or(channel.fault);
            let here = recording.channels.len();
            if column.stamps > 0 {
                clocks.push(here);
            }
            let rising = column.rising(&channel).filter(|_| is_whole);
            if let Some(of_column) = column.times().filter(|_| is_whole) {
                if column.stamps > 0 {
                    refuse_set_clock(&channel.name, &of_column, |row| lines.of(row))?;
                }
                times.push((here, of_column));
            } else if let Some(of_column) = rising {
                times.push((here, of_column));
            }
            recording.channels.push(channel);
            recording.segments.iter_mut().for_each(|segment| segment.0.push(column.values.clone()));
        }
        if comments > 0 {
            recording
                .notes
                .push(format!("{comments} rows have text behind the numbers, which is not used"));
        }
        // A clock is a time, whatever its name.
        for &place in &clocks {
            if let Some(channel) = recording.channels.get_mut(place) {
                channel.unit = "s".into();
            }
        }
        let first_clock = clocks.first().copied();
        recording.take_time(times, |row| lines.of(row))?;
        if let (None, Some(fault)) = (&recording.time, broken_time) {
            return Err(fault);
        }
        if let (Some(time), true) = (&mut recording.time, first_clock.is_some())
            && matches!(&time.unit, TimeUnit::Known { label, .. } if label == "s")
        {
            time.unit = TimeUnit::Clock;
        }
        Ok(recording)
    }
}

/// Gives each channel the unit that stands in every row of the column of units after it.
fn take_columns_of_units(columns: &[Column], channels: &mut [Channel]) {
    let units = columns.iter().skip(1).map(|column| column.same.as_ref());
    let names: Vec<bool> =
        channels.iter().skip(1).map(|channel| header::is_unit_word(&channel.name)).collect();
    for ((channel, unit), is_of_units) in channels.iter_mut().zip(units).zip(names) {
        if let Some(unit) = unit.filter(|_| is_of_units && is_unstated(&channel.unit)) {
            channel.unit.clone_from(unit);
        }
    }
}

/// Adds the fractions of seconds that stand in a column of their own to the clock beside them; the column that is left
/// out then.
fn join_fractions(
    columns: &mut Vec<Column>,
    channels: &mut Vec<Channel>,
    rows: usize,
) -> Option<LeftOutColumn> {
    let unit = |place: usize| match TimeUnit::of(channels.get(place)?) {
        TimeUnit::Known { seconds, .. } => Some(seconds),
        _ => None,
    };
    // A clock, or a count of seconds.
    let is_clock = |place: &usize| {
        let column = columns.get(*place);
        column.is_some_and(|column| column.stamps == rows || column.numbers == rows)
            && (column.is_some_and(|column| column.stamps > 0) || unit(*place) == Some(1.0))
    };
    let clock = (0..columns.len()).find(is_clock)?;
    let seconds = columns.get(clock)?.times()?;
    let (place, joined) = (0..columns.len()).find_map(|place| {
        let unit = unit(place)?;
        let column = columns.get(place).filter(|column| column.numbers == rows)?;
        Some((place, with_fractions(&seconds, &column.times()?, unit)?))
    })?;
    let of_clock = columns.get_mut(clock)?;
    (of_clock.values, of_clock.digits) = (joined.values, Some(joined.digits));
    let name_of_clock = super::column(clock, channels.get(clock)?);
    columns.remove(place);
    let name = super::column(place, &channels.remove(place));
    Some(LeftOutColumn {
        name,
        reason: format!("it has the fractions of the seconds of {name_of_clock}"),
    })
}

/// A header with one name less than there are columns, where the first column counts the rows: the names belong to the
/// other columns.
fn name_rows(channels: &mut [Channel], first_rises: bool) {
    let [first, .., last] = channels else { return };
    let is_shifted = last.name.is_empty()
        && last.unit.is_empty()
        && !first.name.is_empty()
        && !super::time::is_time(first);
    if is_shifted && first_rises {
        channels.rotate_right(1);
    }
}

/// Refuses a row in which commas are decimal signs and separators. `names` is the number of names in the header.
fn refuse_decimals(row: &Row, names: usize) -> Result<(), RecordingError> {
    let Row { line, fields } = row;
    let halved = names * 2 == fields.len() && !fields.iter().any(|field| field.contains('.'));
    let decimals = |(k, field): (usize, &String)| is_decimals(field) || (halved && k % 2 == 1);
    match fields.iter().enumerate().position(decimals) {
        None => Ok(()),
        Some(column) => {
            let text = fields
                .get(column)
                .map_or_else(String::new, |field| field.chars().take(40).collect());
            Err(RecordingError::CommaTwice { line: *line, column: column + 1, text })
        }
    }
}

/// True for digits that no whole number begins with: a zero and another digit.
fn is_decimals(field: &str) -> bool {
    let mut characters = field.chars();
    characters.next() == Some('0')
        && characters.next().is_some_and(|c| c.is_ascii_digit())
        && characters.all(|c| c.is_ascii_digit())
}

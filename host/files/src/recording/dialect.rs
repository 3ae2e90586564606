//! How a text with columns is written: its separator, its decimal sign, and where its numbers begin.

use std::cell::Cell;
use std::io::{self, Read};
use std::rc::Rc;

use super::number::{Decimal, looks_numeric};
use super::stamp::{Stamp, is_date};
use super::{MOST_HEADER_LINES, MOST_LINE_BYTES, RecordingError};

/// Rows that must look alike where the numbers begin.
const ALIKE: usize = 3;

/// What separates columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Separator {
    Semicolon,
    Tab,
    Comma,
    Blanks,
}

impl Separator {
    /// Every separator, the most certain one first.
    pub const ALL: [Self; 4] = [Self::Semicolon, Self::Tab, Self::Comma, Self::Blanks];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Semicolon => "semicolons",
            Self::Tab => "tabs",
            Self::Comma => "commas",
            Self::Blanks => "blanks",
        }
    }

    fn byte(self) -> Option<u8> {
        match self {
            Self::Semicolon => Some(b';'),
            Self::Tab => Some(b'\t'),
            Self::Comma => Some(b','),
            Self::Blanks => None,
        }
    }

    /// The fields of one line of a header.
    pub fn fields(self, line: &str) -> Vec<String> {
        let Some(byte) = self.byte() else { return joined_brackets(line) };
        line.split(char::from(byte))
            .map(|field| field.trim().trim_matches('"').trim().to_owned())
            .collect()
    }

    /// The line of these fields.
    pub fn line(self, fields: &[String]) -> String {
        fields.join(self.byte().map_or(" ", |byte| match byte {
            b';' => ";",
            b'\t' => "\t",
            _ => ",",
        }))
    }
}

/// The words of a line, where a unit in brackets belongs to the word before it.
fn joined_brackets(line: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    for word in line.split_whitespace() {
        match words.last_mut().filter(|_| word.starts_with(['[', '('])) {
            Some(last) => *last += &format!(" {word}"),
            None => words.push(word.to_owned()),
        }
    }
    words
}

/// A line of fields, with its number, from 1.
#[derive(Debug)]
pub(super) struct Row {
    pub line: usize,
    pub fields: Vec<String>,
}

/// The lines of rows: that of the first, and of each that does not follow the one before.
#[derive(Default)]
pub(super) struct Lines {
    jumps: Vec<(usize, usize)>,
}

impl Lines {
    pub fn add(&mut self, row: usize, line: usize) {
        if self.of(row) != line {
            self.jumps.push((row, line));
        }
    }

    pub fn of(&self, row: usize) -> usize {
        let at = self.jumps.partition_point(|(first, _)| *first <= row);
        let jump = at.checked_sub(1).and_then(|at| self.jumps.get(at));
        jump.map_or(row + 1, |(first, line)| line + (row - first))
    }
}

/// What a field is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Number,
    Stamp,
    Date,
    Empty,
    Text,
}

impl Kind {
    pub fn of(field: &str) -> Self {
        if field.is_empty() {
            Self::Empty
        } else if is_date(field) {
            Self::Date
        } else if looks_numeric(field) {
            Self::Number
        } else if Stamp::parse(field).is_some() {
            Self::Stamp
        } else {
            Self::Text
        }
    }
}

/// Where the numbers of a text are.
#[derive(Debug, PartialEq)]
pub(super) struct Dialect {
    pub separator: Separator,
    /// The row in which the numbers begin, from 0.
    pub start: usize,
    /// What the fields of that row are.
    pub kinds: Vec<Kind>,
}

impl Dialect {
    /// The dialect of a text: the numbers begin where [`ALIKE`] rows have numbers in equally many columns. If there are
    /// no such rows, columns of text may stand beside the numbers.
    ///
    /// # Errors
    /// When no such rows follow within the header that is allowed.
    pub fn of(text: &str) -> Result<Self, RecordingError> {
        for fewest in [2, 1] {
            for may_have_text in [false, true] {
                for separator in Separator::ALL {
                    let dialect = Self::with(text, separator, may_have_text);
                    if let Some(dialect) = dialect.filter(|dialect| dialect.kinds.len() >= fewest) {
                        return Ok(dialect);
                    }
                }
            }
        }
        let mut rows = rows_of(text, Separator::Comma).take(MOST_HEADER_LINES);
        Err(rows.find_map(Result::err).unwrap_or(RecordingError::UnknownFormat))
    }

    fn with(text: &str, separator: Separator, may_have_text: bool) -> Option<Self> {
        let last = text.trim_end().rsplit(['\n', '\r']).next().unwrap_or_default();
        let last = kinds(&rows_of(last, separator).next()?.ok()?);
        let rows = rows_of(text, separator).take(MOST_HEADER_LINES + ALIKE).map_while(Result::ok);
        let rows: Vec<Vec<Kind>> = rows.map(|row| kinds(&row)).collect();
        let begins = |start: usize| {
            let window = rows.get(start..(start + ALIKE).min(rows.len())).unwrap_or_default();
            let first = window.first().map_or(&[][..], Vec::as_slice);
            let has_number = first.contains(&Kind::Number);
            let alike = |row: &[Kind]| {
                row.len() == first.len()
                    && std::iter::zip(row, first)
                        .all(|(a, b)| (*a == Kind::Text) == (*b == Kind::Text))
            };
            let has_text = first.contains(&Kind::Text);
            let certain = !has_text
                || may_have_text && window.len() == ALIKE && alike(&last) && first.len() > 1;
            has_number && certain && window.iter().all(|row| alike(row))
        };
        let start = (0..rows.len().min(MOST_HEADER_LINES + 1)).find(|&start| begins(start))?;
        Some(Self { separator, start, kinds: rows.into_iter().nth(start)? })
    }

    /// The decimal sign of the numbers: that of most fields that have one.
    ///
    /// # Errors
    /// When the signs may as well separate thousands.
    pub fn decimal(&self, text: &str) -> Result<Decimal, RecordingError> {
        let mut signs = Signs::default();
        for row in rows_of(text, self.separator).skip(self.start) {
            let Row { line, fields } = row?;
            for (column, field) in fields.iter().enumerate() {
                signs.add(line, column, field);
            }
        }
        if let Some((line, column, text)) = signs.thousands() {
            return Err(RecordingError::Thousands { line, column: column + 1, text });
        }
        Ok(if signs.commas > signs.points { Decimal::Comma } else { Decimal::Point })
    }
}

/// The signs in the numbers of a file.
#[derive(Default)]
struct Signs {
    commas: usize,
    points: usize,
    /// Whether a sign was seen that cannot separate thousands.
    decimal: bool,
    /// The first field with a sign that may separate thousands.
    first: Option<(usize, usize, String)>,
    /// For each column, whether it has numbers without and with a sign.
    columns: Vec<[bool; 2]>,
}

impl Signs {
    fn add(&mut self, line: usize, column: usize, field: &str) {
        let sign = match [field.contains(','), field.contains('.')] {
            [true, true] => return,
            [true, false] => Some(','),
            [false, true] => Some('.'),
            [false, false] => None,
        };
        if Kind::of(field) != Kind::Number {
            return;
        }
        if self.columns.len() <= column {
            self.columns.resize(column + 1, [false; 2]);
        }
        if let Some(seen) = self.columns.get_mut(column) {
            seen[usize::from(sign.is_some())] = true;
        }
        let Some(sign) = sign else { return };
        match sign {
            ',' => self.commas += 1,
            _ => self.points += 1,
        }
        let groups = field.trim_start_matches(['+', '-']).split_once(sign);
        let is_group = |(front, rest): (&str, &str)| {
            let digits = |text: &str| text.chars().all(|c| c.is_ascii_digit());
            digits(front)
                && digits(rest)
                && (1..=3).contains(&front.len())
                && rest.len() == 3
                && !front.starts_with('0')
        };
        if groups.is_some_and(is_group) {
            self.first.get_or_insert_with(|| (line, column, field.chars().take(40).collect()));
        } else {
            self.decimal = true;
        }
    }

    /// A field whose sign may separate thousands: all of them have three digits behind it, and in the same column there
    /// are numbers without.
    fn thousands(&self) -> Option<(usize, usize, String)> {
        let mixed = self.columns.contains(&[true, true]);
        self.first.clone().filter(|_| mixed && !self.decimal)
    }
}

fn kinds(row: &Row) -> Vec<Kind> {
    row.fields.iter().map(|field| Kind::of(field)).collect()
}

/// The rows of the text, with quotes taken off; blank lines are left out.
pub(super) fn rows_of<'t>(
    text: &'t str,
    separator: Separator,
) -> Box<dyn Iterator<Item = Result<Row, RecordingError>> + 't> {
    match separator.byte() {
        Some(byte) => Box::new(separated(text, byte)),
        None => Box::new(words(text)),
    }
}

/// The rows of columns that are separated by blanks.
fn words(text: &str) -> impl Iterator<Item = Result<Row, RecordingError>> + '_ {
    let lines = (1..).zip(text.lines()).filter(|(_, text)| !text.trim().is_empty());
    lines.map(|(line, text)| {
        if text.len() > MOST_LINE_BYTES {
            return Err(RecordingError::LongLine { line });
        }
        Ok(Row { line, fields: text.split_whitespace().map(str::to_owned).collect() })
    })
}

fn separated(text: &str, delimiter: u8) -> impl Iterator<Item = Result<Row, RecordingError>> + '_ {
    let left = Rc::new(Cell::new(0));
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(delimiter)
        .has_headers(false)
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(LimitedReader { bytes: text.as_bytes(), left: left.clone() });
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
            if fields.iter().any(|field| !field.is_empty()) {
                if fields.len() > 1 && fields.last().is_some_and(String::is_empty) {
                    fields.pop();
                }
                return Some(Ok(Row { line, fields }));
            }
        }
    })
}

/// Bytes of which a part is read at a time: a line that does not end, or a quote, would fill the memory.
struct LimitedReader<'t> {
    bytes: &'t [u8],
    left: Rc<Cell<usize>>,
}

impl Read for LimitedReader<'_> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(text: &str, separator: Separator, start: usize, columns: usize, decimal: Decimal) {
        let dialect = Dialect::of(text).unwrap();
        assert_eq!(
            (dialect.separator, dialect.start, dialect.kinds.len()),
            (separator, start, columns),
            "{text}"
        );
        assert_eq!(dialect.decimal(text), Ok(decimal), "{text}");
    }

    #[test]
    fn separator_and_decimal_sign_are_those_of_the_whole_file() {
        use Separator::{Blanks, Comma, Semicolon, Tab};
        let many = |row: &str| row.repeat(20);
        check(&format!("a;b\n{}0,5;1\n", many("0;0\n")), Semicolon, 1, 2, Decimal::Comma);
        check(&format!("{}0.5;1\n", many("0;0\n")), Semicolon, 0, 2, Decimal::Point);
        check(&many("1.5 2.5\n"), Blanks, 0, 2, Decimal::Point);
        check(&many("  1,5   2,5\n"), Blanks, 0, 2, Decimal::Comma);
        check(&many("1,5\t2,5\n"), Tab, 0, 2, Decimal::Comma);
        check(&many("1.5,2.5\n"), Comma, 0, 2, Decimal::Point);
        check(&many("1.5, 2.5\n"), Comma, 0, 2, Decimal::Point);
        check(&many("12:00:01.25 1.5\n"), Blanks, 0, 2, Decimal::Point);
        check(&many("2026-01-02 12:00:01.25,1.5\n"), Comma, 0, 2, Decimal::Point);
        check(&many("1.5;OK\n"), Semicolon, 0, 2, Decimal::Point);
        check(&many("1.5\n"), Semicolon, 0, 1, Decimal::Point);
        // Lines of a header in another dialect.
        check(&format!("Rate;5120\nRange;100\n{}", many("1,5\t2,5\n")), Tab, 2, 2, Decimal::Comma);
        check(
            &format!("{}{}", "line of text\n".repeat(900), many("1.5;2.5\n")),
            Semicolon,
            900,
            2,
            Decimal::Point,
        );
        check(
            &format!("date;12.03.2026\nat;12:00:00\n{}", many("1.5;2.5\n")),
            Semicolon,
            2,
            2,
            Decimal::Point,
        );
        for text in ["", "Dear Sir or Madam", "a;b\nc;d\n"] {
            assert_eq!(Dialect::of(text), Err(RecordingError::UnknownFormat), "{text}");
        }
        let long = format!("{}{}", "line of text\n".repeat(1001), many("1.5;2.5\n"));
        assert_eq!(Dialect::of(&long), Err(RecordingError::UnknownFormat));
    }

    #[test]
    fn a_comma_that_may_separate_thousands_is_asked_for() {
        let text = "F;a\n1,234;5\n567;6\n2,345;7\n";
        let error = Dialect::of(text).unwrap().decimal(text).unwrap_err();
        assert!(
            matches!(&error, RecordingError::Thousands { line: 2, column: 1, .. }),
            "{error:?}"
        );
        // Three decimals in every row, or a number that begins with zero.
        for text in ["F;a\n1,234;5\n2,567;6\n", "F;a\n1,234;5\n567;6\n0,345;7\n"] {
            assert_eq!(Dialect::of(text).unwrap().decimal(text), Ok(Decimal::Comma), "{text}");
        }
    }

    #[test]
    fn the_line_of_a_row_is_known_after_comments_and_blank_lines() {
        let mut lines = Lines::default();
        for (row, line) in [3, 4, 5, 8, 9, 12].into_iter().enumerate() {
            lines.add(row, line);
        }
        assert_eq!((0..6).map(|row| lines.of(row)).collect::<Vec<_>>(), [3, 4, 5, 8, 9, 12]);
        assert_eq!(lines.jumps.len(), 3);
    }
}

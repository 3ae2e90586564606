//! One column of a text: its numbers, times or texts, and what it is.

use super::super::clock::Clock;
use super::super::date::Date;
use super::super::dialect::Kind;
use super::super::number::{Decimal, last_digit};
use super::super::stamp::Stamp;
use super::super::steps::Times;
use super::super::{Channel, RecordingError, is_named_force};
use crate::units::is_unstated;

/// The fewest rows of which each is above the one before by more than chance.
const FEWEST_RISING: usize = 32;

/// One column.
#[derive(Default)]
pub(super) struct Column {
    pub kind: Option<Kind>,
    pub values: Vec<f64>,
    /// The time of the stamps before.
    clock: Clock,
    /// The unit of the last digit of each value, for a column that may be a time.
    pub digits: Option<Vec<f64>>,
    pub numbers: usize,
    pub stamps: usize,
    /// The first field that is no number, and the first that is empty.
    pub text: Option<RecordingError>,
    /// The text that all rows have.
    pub same: Option<String>,
    pub empty: Option<RecordingError>,
}

impl Column {
    /// A column of fields of this kind, whose digits are kept where it may be a time.
    pub fn new(kind: Kind, may_be_time: bool) -> Self {
        Self { kind: Some(kind), digits: may_be_time.then(Vec::new), ..Self::default() }
    }

    /// Adds a field; `date` is the date in another column of the row.
    pub fn add(
        &mut self,
        field: &str,
        decimal: Decimal,
        date: Option<Date>,
        [line, place]: [usize; 2],
    ) {
        let value = match self.kind {
            Some(Kind::Stamp) => Stamp::parse(field).map(|stamp| {
                self.stamps += 1;
                let stamp = Stamp { date: stamp.date.or(date), ..stamp };
                (self.clock.seconds(stamp), stamp.digit)
            }),
            _ => decimal.number(field).map(|value| {
                self.numbers += 1;
                (value, if self.digits.is_some() { last_digit(field) } else { 0.0 })
            }),
        };
        if value.is_none() && field.is_empty() {
            self.empty.get_or_insert(RecordingError::Hole { line, column: place + 1 });
        } else if value.is_none() {
            if self.values.is_empty() {
                self.same = Some(field.to_owned());
            }
            let fault =
                || match field.contains(':') && field.starts_with(|c: char| c.is_ascii_digit()) {
                    true => {
                        let text = field.chars().take(40).collect();
                        RecordingError::NotATime { line, column: place + 1, text }
                    }
                    false => decimal.fault(field, line, place),
                };
            self.text.get_or_insert_with(fault);
        }
        if self.same.as_deref().is_some_and(|same| same != field) {
            self.same = None;
        }
        let (value, digit) = value.unwrap_or_default();
        self.values.push(value);
        if let Some(digits) = &mut self.digits {
            digits.push(digit);
        }
    }

    /// Its values as times, for a column that may be a time.
    pub fn times(&self) -> Option<Times> {
        Some(Times { values: self.values.clone(), digits: self.digits.clone()? }.unwrapped())
    }

    /// The values of a column without a unit as times, if each is above the one before: no reading of a sensor does
    /// that.
    pub fn rising(&self, channel: &Channel) -> Option<Times> {
        let rises = self.values.len() >= FEWEST_RISING
            && self.values.windows(2).all(|pair| pair[0] < pair[1]);
        (rises && is_unstated(&channel.unit) && !is_named_force(&channel.name)).then(|| Times {
            values: self.values.clone(),
            digits: self.values.iter().map(|value| last_digit(&value.to_string())).collect(),
        })
    }

    /// Whether its first text begins like a number or a time.
    pub fn begins_with_digit(&self) -> bool {
        match &self.text {
            Some(RecordingError::NotANumber { text, .. }) => {
                text.starts_with(|c: char| c.is_ascii_digit())
            }
            Some(RecordingError::NotATime { .. }) => true,
            _ => false,
        }
    }

    /// Why a column that may be a time is none.
    pub fn not_whole(&self) -> String {
        match &self.text {
            Some(
                RecordingError::NotANumber { text, .. } | RecordingError::NotATime { text, .. },
            ) => {
                format!("it has text, such as \"{text}\"")
            }
            _ => "it has empty cells".into(),
        }
    }

    /// Why this column is no channel: it has no numbers, or mostly text.
    pub fn no_channel(&self, rows: usize) -> Option<String> {
        let read = self.numbers + self.stamps;
        let is_text =
            self.text.is_some() && matches!(self.kind, Some(Kind::Text | Kind::Date | Kind::Empty));
        if is_text && 2 * read < rows.max(1) {
            Some("it has text".into())
        } else if read == 0 && self.text.is_none() {
            Some("it has no values".into())
        } else {
            None
        }
    }
}

//! The sampling rate of a recording, and where it comes from.

use std::ops::RangeInclusive;

use super::Recording;
use super::number::six_digits;
use super::steps::Steps;
use super::time::{TimeColumn, TimeUnit};
use super::uneven::Unevenness;
use crate::units::time_unit;
use massline_result::{Error, Result};

/// Rates of a hammer test, Hz. A time column without a unit is read in seconds only if these give such a rate.
const PLAUSIBLE_HZ: RangeInclusive<f64> = 500.0..=1e6;

/// The years from 2000 to 2100 in seconds since 1970.
const EPOCH_S: RangeInclusive<f64> = 9.4e8..=4.2e9;
/// Units in which programs count the time since 1970.
const EPOCH_UNITS: [(&str, f64); 4] = [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)];

/// Relative difference of two rates beyond what their digits allow.
const EQUAL_RATES: f64 = 1e-4;
/// Relative uncertainty of a rate that is worth a note.
const COARSE: f64 = 1e-3;
/// Relative uncertainty of a rate from which on it is none.
const UNUSABLE: f64 = 1e-2;
/// Relative difference up to which the rate of --rate-hz is that of the file.
const SAME_RATE: f64 = 1e-5;

/// The name by which --unit means a time column that has no name.
const ANY_TIME: &str = "time";

/// A rate that a header states.
#[derive(Clone, Debug, PartialEq)]
pub struct DeclaredRate {
    /// The rate, Hz.
    pub hz: f64,
    /// Its relative uncertainty by the digits of the entry.
    pub uncertainty: f64,
    /// The entry that states it.
    pub entry: String,
    /// Whether it states a unit; else the number is taken for Hz, to compare it.
    pub states_unit: bool,
}

/// Where a rate comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum RateSource {
    /// `--rate-hz`.
    Option,
    /// The time column in this unit.
    Column {
        /// Name of the column.
        name: String,
        /// The unit in use.
        unit: String,
        /// Whether the unit is assumed.
        assumed: bool,
    },
    /// An entry of a header.
    Header(String),
}

/// The sampling rate in use.
#[derive(Clone, Debug, PartialEq)]
pub struct Rate {
    /// The rate, Hz.
    pub hz: f64,
    /// Where it comes from.
    pub source: RateSource,
    /// What a person should know about it.
    pub notes: Vec<String>,
}

impl Rate {
    /// Where it comes from, in words.
    pub fn origin(&self) -> String {
        match &self.source {
            RateSource::Option => "from --rate-hz".into(),
            RateSource::Header(entry) => format!("from {entry}"),
            RateSource::Column { name, unit, assumed } => {
                let name = if name.is_empty() {
                    "the first column".to_owned()
                } else {
                    format!("the time column \"{name}\"")
                };
                let assumed = if *assumed { " (assumed)" } else { "" };
                format!("from {name} in {unit}{assumed}")
            }
        }
    }
}

impl Recording {
    /// The sampling rate: `stated_hz` from --rate-hz, else that of the time column, whose unit `stated_unit` gives
    /// where the file does not, else that of a header.
    ///
    /// # Errors
    /// When samples are missing, or nothing states the rate, or a time column has no unit or no even steps.
    pub fn rate(&self, stated_hz: Option<f64>, stated_unit: Option<&str>) -> Result<Rate> {
        if let Some(fault) = self.time.as_ref().and_then(TimeColumn::fault_whatever_the_rate) {
            return Err(fault);
        }
        let of_column = self.time.as_ref().map(|column| column.rate(stated_unit)).transpose();
        let unclear = self.declared.as_ref().filter(|declared| !declared.states_unit);
        let declared = self.declared.as_ref().map(|declared| {
            let mut notes = Vec::new();
            if declared.uncertainty > COARSE {
                notes.push(format!(
                    "{} has few digits: the rate is known to {:.1} %",
                    declared.entry,
                    100.0 * declared.uncertainty
                ));
            }
            (
                Rate { hz: declared.hz, source: RateSource::Header(declared.entry.clone()), notes },
                declared.uncertainty,
            )
        });
        // A count of the samples states no rate, and leaves it to the header.
        let of_column = match of_column {
            Err(error) if error.code() == "no_rate" && declared.is_some() => Ok(None),
            of_column => of_column,
        };
        let of_file = match (of_column, declared) {
            (Ok(None), Some(_)) if let Some(unclear) = unclear => {
                let message = format!(
                    "{} states a rate without a unit; give it in Hz with --rate-hz",
                    unclear.entry
                );
                Err(Error::input("no_rate", message))
            }
            (Ok(None), None) => Err(Error::input(
                "no_rate",
                "the recording does not state its sampling rate; give it with --rate-hz",
            )),
            (Err(error), _) => Err(error),
            (Ok(None), Some((rate, uncertainty))) if uncertainty > UNUSABLE => {
                let message = format!(
                    "by the digits of {} the rate is known to {:.0} % only; give it with --rate-hz",
                    rate.entry(),
                    100.0 * uncertainty
                );
                Err(Error::input("time_too_coarse", message))
            }
            (Ok(None), Some(declared)) => Ok(declared),
            (Ok(Some(column)), None) => Ok(column),
            (Ok(Some(column)), Some(declared)) => Ok(finer(column, declared, unclear.is_none())),
        };
        let Some(hz) = stated_hz else { return of_file.map(|(rate, _)| rate) };
        let notes = match of_file {
            Ok((rate, uncertainty)) if (rate.hz / hz - 1.0).abs() > SAME_RATE + uncertainty => {
                vec![format!(
                    "the file states {} Hz, using {hz} Hz from --rate-hz",
                    six_digits(rate.hz)
                )]
            }
            Err(error) if error.code() != "no_rate" => {
                vec![format!("using {hz} Hz from --rate-hz: {error}")]
            }
            _ => Vec::new(),
        };
        Ok(Rate { hz, source: RateSource::Option, notes })
    }

    /// Whether a column of the command line means the time.
    pub fn is_time_column(&self, column: &str) -> bool {
        self.time.as_ref().is_some_and(|time| {
            time.name.eq_ignore_ascii_case(column)
                || time.name.is_empty() && column.eq_ignore_ascii_case(ANY_TIME)
        })
    }
}

impl Rate {
    /// The entry of a header that states it.
    fn entry(&self) -> &str {
        match &self.source {
            RateSource::Header(entry) => entry,
            _ => "",
        }
    }
}

/// The rate of a time column, or that of a header where it `may_be_used`, agrees and is known better by far; the
/// column's when they contradict each other.
fn finer(column: (Rate, f64), declared: (Rate, f64), may_be_used: bool) -> (Rate, f64) {
    let (hz, other) = (column.0.hz, declared.0.hz);
    if (hz / other - 1.0).abs() <= EQUAL_RATES + column.1 + declared.1 {
        let is_better = may_be_used && declared.1 < column.1 && column.1 > EQUAL_RATES;
        return if is_better { declared } else { column };
    }
    let RateSource::Header(entry) = &declared.0.source else { return column };
    let (mut rate, uncertainty) = column;
    rate.notes.push(format!(
        "{entry} states {} Hz and the time column {} Hz: the time column is used",
        six_digits(other),
        six_digits(hz)
    ));
    (rate, uncertainty)
}

impl TimeColumn {
    /// Why the rows are not even samples, whatever their rate is.
    fn fault_whatever_the_rate(&self) -> Option<Error> {
        match self.steps {
            Steps::Lost { gaps, samples, row, after } => {
                Some(lost(gaps, samples, &self.places.name(row), after))
            }
            Steps::Uneven(unevenness) if !unevenness.may_be_even => Some(self.uneven(&unevenness)),
            _ => None,
        }
    }

    fn uneven(&self, unevenness: &Unevenness) -> Error {
        let message = unevenness.sentence(&self.called(), |place| self.places.name(place));
        Error::input("time_uneven", message)
    }

    /// The rate by this column and its relative uncertainty.
    fn rate(&self, stated_unit: Option<&str>) -> Result<(Rate, f64)> {
        let name = self.called();
        let (step, uncertainty, rounded_to) = match self.steps {
            Steps::Even { uncertainty, rounded_to: Some(digit), .. } if uncertainty > UNUSABLE => {
                let message = format!(
                    "the times of {name} are rounded to {}, by which the rate is known to {:.0} % only; give it with \
                     --rate-hz, or export more digits",
                    six_digits(digit),
                    100.0 * uncertainty
                );
                return Err(Error::input("time_too_coarse", message));
            }
            Steps::Even { step, uncertainty, rounded_to } => (step, uncertainty, rounded_to),
            Steps::Uneven(unevenness) => return Err(self.uneven(&unevenness)),
            Steps::Lost { gaps, samples, row, after } => {
                return Err(lost(gaps, samples, &self.places.name(row), after));
            }
        };
        let (label, seconds, assumed) = self.unit(step, stated_unit)?;
        let hz = (step * seconds).recip();
        let mut notes = Vec::new();
        if let Some(digit) = rounded_to {
            notes.push(format!(
                "the times of {name} are rounded to {} {label}; the rate of {} Hz is that of the whole length",
                six_digits(digit),
                six_digits(hz)
            ));
        }
        if uncertainty > COARSE {
            notes.push(format!("by its digits the rate is known to {:.1} %", 100.0 * uncertainty));
        }
        if assumed {
            let since =
                if label == "s" && !EPOCH_S.contains(&self.first) { "" } else { " since 1970" };
            notes.push(format!(
                "{name} states no unit and is read in {label}{since}; state another with --unit \"{}=ms\"",
                self.column()
            ));
        }
        let source = RateSource::Column { name: self.name.clone(), unit: label, assumed };
        Ok((Rate { hz, source, notes }, uncertainty))
    }

    /// The unit of this column: label, size in seconds, and whether it is assumed.
    fn unit(&self, step: f64, stated: Option<&str>) -> Result<(String, f64, bool)> {
        let column = self.column();
        if let Some(stated) = stated {
            let seconds = time_unit(stated).ok_or_else(|| {
                let message = format!(
                    "--unit \"{column}={stated}\": {stated} is no unit of time; s, ms, us, ns, min and h are"
                );
                Error::input("time_unit_unknown", message)
            })?;
            return Ok((stated.to_owned(), seconds, false));
        }
        let refused = |fault: String| {
            let advice = format!(
                "state its unit with --unit \"{column}=UNIT\" (s, ms, us, ns, …), or the rate with --rate-hz"
            );
            Err(Error::input("time_unit_unknown", format!("{fault}; {advice}")))
        };
        match &self.unit {
            TimeUnit::Known { label, seconds } => Ok((label.clone(), *seconds, false)),
            TimeUnit::Clock => Ok(("s".to_owned(), 1.0, false)),
            TimeUnit::Unknown(label) => {
                refused(format!("\"{label}\", the unit of {}, is no unit of time", self.called()))
            }
            TimeUnit::Contradictory(a, b) => {
                refused(format!("the name of {} says {a} and its unit says {b}", self.called()))
            }
            TimeUnit::Unstated if self.is_index => {
                let message = format!(
                    "{} counts the samples and states no time; give the sampling rate with --rate-hz",
                    self.called()
                );
                Err(Error::input("no_rate", message))
            }
            TimeUnit::Unstated => match self.assumed(step) {
                Some((label, seconds)) => Ok((label.to_owned(), seconds, true)),
                None => refused(format!(
                    "{} states no unit, and its steps of {} are no seconds of a hammer test",
                    self.called(),
                    six_digits(step)
                )),
            },
        }
    }

    /// The unit that times without a unit have: that of the time since 1970 which they are, or seconds.
    fn assumed(&self, step: f64) -> Option<(&'static str, f64)> {
        let is_plausible = |seconds: f64| PLAUSIBLE_HZ.contains(&(step * seconds).recip());
        let epoch =
            EPOCH_UNITS.into_iter().find(|(_, seconds)| EPOCH_S.contains(&(self.first * seconds)));
        epoch.or(Some(("s", 1.0))).filter(|&(_, seconds)| is_plausible(seconds))
    }

    /// The column as it is named in messages.
    fn called(&self) -> String {
        match self.name.as_str() {
            "" => "the first column, which rises like a time,".into(),
            name => format!("the time column \"{name}\""),
        }
    }

    /// The column as it is named on the command line.
    fn column(&self) -> &str {
        if self.name.is_empty() { ANY_TIME } else { &self.name }
    }
}

fn lost(gaps: usize, samples: f64, place: &str, after: f64) -> Error {
    let are_missing = if samples == 1.0 {
        "1 sample is missing".into()
    } else {
        format!("{samples} samples are missing")
    };
    let more = match gaps - 1 {
        0 => String::new(),
        1 => ", and there is one more gap".into(),
        more => format!(", and there are {more} more gaps"),
    };
    let message = format!(
        "{are_missing} after the time {} ({place}){more}; record again without losses, or cut the file there",
        six_digits(after)
    );
    Error::input("samples_lost", message)
}

#[cfg(test)]
mod tests {
    use super::super::time::Places;
    use super::*;

    fn column(name: &str, unit: TimeUnit, step: f64, first: f64) -> Recording {
        let steps = Steps::Even { step, uncertainty: 1e-7, rounded_to: None };
        let time = TimeColumn {
            name: name.into(),
            unit,
            steps,
            first,
            places: Places::Lines,
            is_index: step == 1.0 && first == 0.0,
        };
        Recording { time: Some(time), ..Recording::default() }
    }

    fn known(label: &str) -> TimeUnit {
        TimeUnit::Known { label: label.into(), seconds: time_unit(label).unwrap() }
    }

    fn hz(recording: &Recording) -> f64 {
        recording.rate(None, None).unwrap().hz
    }

    #[track_caller]
    fn refused(recording: &Recording, code: &str, words: &str) {
        let error = recording.rate(None, None).unwrap_err();
        assert!(error.code() == code && error.to_string().contains(words), "{error}");
        let rate = recording.rate(Some(5000.0), None).unwrap();
        assert_eq!((rate.hz, rate.source), (5000.0, RateSource::Option));
    }

    #[test]
    fn a_rate_is_read_in_the_unit_of_its_column_or_refused() {
        for (unit, step) in [("s", 2e-4), ("ms", 0.2), ("us", 200.0), ("ns", 2e5)] {
            assert!((hz(&column("Time", known(unit), step, 0.0)) - 5000.0).abs() < 1e-6, "{unit}");
        }
        refused(
            &column("Time", TimeUnit::Unknown("ticks".into()), 0.2, 0.0),
            "time_unit_unknown",
            "\"ticks\"",
        );
        let both = TimeUnit::Contradictory("ms".into(), "s".into());
        refused(&column("time_ms", both, 0.2, 0.0), "time_unit_unknown", "says ms");
        refused(&column("Time", TimeUnit::Unstated, 0.2, 0.0), "time_unit_unknown", "steps of 0.2");
        refused(&column("", TimeUnit::Unstated, 1.0, 0.0), "no_rate", "counts the samples");
        let milliseconds =
            column("Time", TimeUnit::Unstated, 0.2, 0.0).rate(None, Some("ms")).unwrap();
        assert!((milliseconds.hz - 5000.0).abs() < 1e-6);
        assert!(column("Time", TimeUnit::Unstated, 0.2, 0.0).rate(None, Some("N")).is_err());
    }

    #[test]
    fn an_assumed_unit_is_stated() {
        for (step, first, unit) in [
            (2e-4, 0.0, "s"),
            (2e-4, 1.7e9, "s since 1970"),
            (0.2, 1.7e12, "ms since 1970"),
            (200.0, 1.7e15, "us since 1970"),
            (2e5, 1.7e18, "ns since 1970"),
        ] {
            let rate = column("t", TimeUnit::Unstated, step, first).rate(None, None).unwrap();
            assert!((rate.hz - 5000.0).abs() < 1e-6, "{}", rate.hz);
            assert!(rate.notes[0].contains(&format!("is read in {unit};")), "{:?}", rate.notes);
        }
    }

    #[test]
    fn lost_samples_are_refused_also_with_a_rate() {
        let mut recording = column("Time", known("s"), 2e-4, 0.0);
        if let Some(time) = &mut recording.time {
            time.steps = Steps::Lost { gaps: 2, samples: 40.0, row: 1026, after: 0.2 };
        }
        for stated in [None, Some(5000.0)] {
            let error = recording.rate(stated, None).unwrap_err().to_string();
            assert!(
                error.contains("40 samples are missing after the time 0.2 (line 1026)"),
                "{error}"
            );
            assert!(error.contains("and there is one more gap"), "{error}");
        }
    }

    #[test]
    fn a_header_that_contradicts_its_time_column_is_named() {
        let mut recording = column("X_Value", known("s"), 1.0 / 5120.0, 0.0);
        let declare = |hz, uncertainty| {
            Some(DeclaredRate { hz, uncertainty, entry: "Delta_X".to_owned(), states_unit: true })
        };
        recording.declared = declare(1.0, 1e-6);
        let rate = recording.rate(None, None).unwrap();
        assert!((rate.hz - 5120.0).abs() < 1e-6);
        assert_eq!(
            rate.notes,
            ["Delta_X states 1 Hz and the time column 5120 Hz: the time column is used"]
        );
        // Few digits are no contradiction.
        recording.declared = declare(5128.2, 2.6e-3);
        let rate = recording.rate(None, None).unwrap();
        assert!((rate.hz - 5120.0).abs() < 1e-6 && rate.notes.is_empty());
        recording.time = None;
        let rate = recording.rate(None, None).unwrap();
        assert_eq!((rate.hz, rate.notes.len()), (5128.2, 1));
    }
}

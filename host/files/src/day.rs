//! Calendar dates.

use std::fmt;
use std::str::FromStr;

use jiff::Timestamp;
use jiff::civil::Date;
use jiff::tz::TimeZone;
use massline_shared::calibration::CalibrationRecord;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A date of the Gregorian calendar, written `yyyy-mm-dd`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Day(Date);

/// Why a text is not a date.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("\"{0}\" is not a date; give a day as yyyy-mm-dd")]
pub struct InvalidDate(String);

impl Day {
    /// Today's date by the clock of this computer, in UTC.
    pub fn today() -> Self {
        Self(Timestamp::now().to_zoned(TimeZone::UTC).date())
    }

    /// Days from this date until today; zero for one in the future.
    pub fn age_in_days(self) -> u16 {
        let days = self.days_until(Self::today());
        u16::try_from(days.max(0)).unwrap_or(u16::MAX)
    }

    /// Days from this date until another; negative for an earlier one.
    pub fn days_until(self, other: Self) -> i32 {
        (other.0 - self.0).get_days()
    }

    /// The text as a calibration stores it; empty for a year with more than four digits.
    pub fn text(self) -> heapless::String<10> {
        self.to_string().as_str().try_into().unwrap_or_default()
    }
}

/// Age of a calibration by the clock of this computer, days; zero when it has no date or one in the future.
pub fn age_in_days(record: &CalibrationRecord) -> u16 {
    record.date.parse().map_or(0, |day: Day| day.age_in_days())
}

impl fmt::Display for Day {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl FromStr for Day {
    type Err = InvalidDate;

    /// Only this one of the many notations of ISO 8601 is accepted, so that equal dates are equal texts.
    fn from_str(text: &str) -> Result<Self, InvalidDate> {
        let day = text.parse().ok().map(Self).filter(|day| day.text() == text);
        day.ok_or_else(|| InvalidDate(text.to_owned()))
    }
}

impl Serialize for Day {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Day {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_day_that_the_calendar_does_not_have_is_refused() {
        for text in ["2026-02-29", "2026-02-31", "2026-04-31", "2100-02-29", "2026-13-01"] {
            let error = text.parse::<Day>().unwrap_err().to_string();
            assert!(error.contains(text) && error.contains("yyyy-mm-dd"), "{error}");
        }
        for text in ["2024-02-29", "2000-02-29", "0001-01-01", "9999-12-31"] {
            assert_eq!(text.parse::<Day>().unwrap().text(), text);
        }
    }

    #[test]
    fn other_notations_of_a_day_are_refused() {
        for text in ["20260314", "2026-03-14T00:00", "-002026-03-14", "2026-3-14", "2026-03-14 "] {
            assert_eq!(text.parse::<Day>(), Err(InvalidDate(text.into())));
        }
    }
}

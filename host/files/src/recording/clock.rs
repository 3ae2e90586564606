//! Times of a clock, row by row: over midnight, by their dates and zones, with the fractions of their seconds in a
//! column beside them; and whether the clock was set meanwhile.

use super::stamp::Stamp;
use super::steps::Times;
use super::{RecordingError, six_digits};

/// Half a day and a day, s.
const HALF_A_DAY: f64 = 43_200.0;
pub(super) const DAY: f64 = 86_400.0;
/// By how much a clock is set for summer time, s.
const SUMMER_TIME: f64 = 3600.0;

/// Counts the seconds of stamps that follow each other, from the midnight before the first of them.
#[derive(Default)]
pub(super) struct Clock {
    days: i64,
    last: Option<Stamp>,
}

impl Clock {
    /// The seconds of the next stamp. Without dates, a step back of more than half a day is midnight.
    pub fn seconds(&mut self, stamp: Stamp) -> f64 {
        if let Some(last) = self.last {
            let is_midnight = last.seconds - stamp.seconds > HALF_A_DAY;
            let days = stamp.date.zip(last.date).and_then(|(date, last)| date.days_after(last));
            self.days += days.unwrap_or(i64::from(is_midnight));
        }
        self.last = Some(stamp);
        self.days as f64 * DAY + stamp.seconds - stamp.zone
    }
}

/// Refuses a clock that goes back, but for a stopwatch that begins again, or that goes forward by an hour; `line` gives
/// the line of a row.
pub(super) fn refuse_set_clock(
    name: &str,
    times: &Times,
    line: impl Fn(usize) -> usize,
) -> Result<(), RecordingError> {
    let rows = times.values.len();
    let [Some(&first), Some(&last)] = [times.values.first(), times.values.last()] else {
        return Ok(());
    };
    let mut start = first;
    for (row, pair) in times.values.windows(2).enumerate() {
        let &[before, after] = pair else { continue };
        let step = after - before;
        let begins_again = (after - start).abs() <= 0.01 * (before - start);
        let usual = ((last - first - SUMMER_TIME) / rows as f64).abs();
        let digit = times.digits.get(row).copied().unwrap_or_default();
        let is_hour = (step - SUMMER_TIME).abs() <= 2.0 * (usual + digit);
        let fault = if step < 0.0 && !begins_again {
            format!("goes back by {} s", six_digits(-step))
        } else if is_hour && usual < 1.0 {
            "goes forward by an hour".to_owned()
        } else {
            if step < 0.0 {
                start = after;
            }
            continue;
        };
        let fault = format!(
            "the clock \"{name}\" {fault} after this row; if it was set, as for summer time, export times in UTC or \
             with their zones, else export the samples in the order of their time"
        );
        return Err(RecordingError::Header { line: line(row), fault });
    }
    Ok(())
}

/// The times of a clock that states whole seconds with those of a column beside it, in units of `unit` seconds, which
/// has their fractions: it begins again wherever the clock goes on.
pub(super) fn with_fractions(clock: &Times, fractions: &Times, unit: f64) -> Option<Times> {
    let is_fraction = |value: &f64| (0.0..1.0).contains(&(value * unit));
    let is_whole = clock.digits.iter().all(|digit| *digit == 1.0);
    let goes_on = |pair: &[f64]| pair[1] > pair[0];
    let begins_again = |pair: &[f64]| pair[1] < pair[0];
    let mut pairs = clock.values.windows(2).zip(fractions.values.windows(2));
    let alike = pairs.all(|(clock, other)| goes_on(clock) == begins_again(other));
    let is_moving = clock.values.windows(2).any(goes_on);
    if !(is_whole && alike && is_moving && fractions.values.iter().all(is_fraction)) {
        return None;
    }
    let seconds = clock.values.iter().zip(&fractions.values);
    Some(Times {
        values: seconds.map(|(second, fraction)| second + fraction * unit).collect(),
        digits: fractions.digits.iter().map(|digit| digit * unit).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn seconds(stamps: &[&str]) -> Vec<f64> {
        let mut clock = Clock::default();
        stamps.iter().map(|text| clock.seconds(Stamp::parse(text).unwrap())).collect()
    }

    /// The seconds from the first to the last of these stamps.
    #[track_caller]
    fn passed(stamps: &[&str]) -> f64 {
        let seconds = seconds(stamps);
        ((seconds[seconds.len() - 1] - seconds[0]) * 1e6).round() / 1e6
    }

    #[test]
    fn a_clock_goes_on_over_midnight_days_and_zones() {
        assert_eq!(passed(&["23:59:59.9", "00:00:00.1"]), 0.2);
        assert_eq!(passed(&["23:59:59.9", "00:00:00.1", "23:59:59", "00:00:01"]), DAY + 1.1);
        // Dates count: a night is not two.
        assert_eq!(passed(&["2026-10-25 23:59:59.9", "2026-10-26 00:00:00.1"]), 0.2);
        assert_eq!(passed(&["2026-10-25T23:59:59.9", "2026-10-27T00:00:00.1"]), DAY + 0.2);
        assert_eq!(passed(&["25.10.2026 12:00:00", "27.10.2026 12:00:00"]), 2.0 * DAY);
        assert_eq!(passed(&["10/11/2026 12:00:00", "11/11/2026 12:00:00"]), DAY);
        assert_eq!(passed(&["10/31/2026 12:00:00", "11/1/2026 12:00:00"]), DAY);
        assert_eq!(passed(&["31-Dec-2026 12:00:00", "1-Jan-2027 12:00:00"]), DAY);
        // The end of summer time, with zones.
        assert_eq!(passed(&["2026-10-25T02:59:59.9+02:00", "2026-10-25T02:00:00.1+01:00"]), 0.2);
        assert_eq!(passed(&["2026-03-29T01:59:59.9+01:00", "2026-03-29T03:00:00.1+02:00"]), 0.2);
        assert_eq!(passed(&["2026-10-25T23:59:59.9-0500", "2026-10-26T04:59:59.9Z"]), 0.0);
        // A clock that is set back by an hour.
        assert_eq!(passed(&["11:00:00", "10:00:00"]), -3600.0);
    }

    #[test]
    fn a_clock_that_was_set_is_named_and_a_stopwatch_begins_again() {
        let check = |at: &dyn Fn(f64) -> f64| {
            let times = Times::exact((0..4000).map(|k| at(f64::from(k) * 1e-3)).collect());
            refuse_set_clock("Time", &times, |row| row + 2).map_err(|error| error.to_string())
        };
        let back = check(&|t| if t < 2.0 { 10_000.0 + t } else { 6400.0 + t }).unwrap_err();
        assert!(back.contains("line 2001") && back.contains("goes back by 3600 s"), "{back}");
        let forward = check(&|t| if t < 2.0 { t } else { 3600.0 + t }).unwrap_err();
        assert!(forward.contains("goes forward by an hour"), "{forward}");
        assert_eq!(check(&|t| t % 1.0), Ok(()));
        assert_eq!(check(&|t| if t < 2.0 { t } else { 60.0 + t }), Ok(()));
    }

    #[test]
    fn whole_seconds_and_milliseconds_are_one_time() {
        let written =
            |digit: f64, values: Vec<f64>| Times { digits: vec![digit; values.len()], values };
        let clock = written(1.0, vec![5.0, 5.0, 6.0, 6.0]);
        let fractions = written(1.0, vec![250.0, 750.0, 250.0, 750.0]);
        let both = with_fractions(&clock, &fractions, 1e-3).unwrap();
        assert_eq!(both.values, [5.25, 5.75, 6.25, 6.75]);
        assert_eq!(both.digits, [1e-3; 4]);
        for other in [[250.0, 750.0, 1250.0, 1750.0], [250.0, 750.0, 800.0, 100.0]] {
            assert!(with_fractions(&clock, &written(1.0, other.to_vec()), 1e-3).is_none());
        }
    }
}

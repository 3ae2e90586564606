//! Times of day in a column of text: `12:00:01.250`, `2026-01-02T12:00:00.000195Z`, `20260102T120000.25Z`,
//! `05.01.2026 10:00:00,5`.

use super::date::Date;

/// Half a day, s.
const HALF_A_DAY: f64 = 43_200.0;

/// By how many hours the clocks of these zones are ahead of UTC. Only how a zone changes from row to row counts, so it
/// does not matter that some of the names are those of several zones.
const ZONES: [(&str, f64); 20] = [
    ("wet", 0.0),
    ("west", 1.0),
    ("bst", 1.0),
    ("cet", 1.0),
    ("mez", 1.0),
    ("cest", 2.0),
    ("mesz", 2.0),
    ("eet", 2.0),
    ("eest", 3.0),
    ("jst", 9.0),
    ("kst", 9.0),
    ("ast", -4.0),
    ("edt", -4.0),
    ("est", -5.0),
    ("cdt", -5.0),
    ("cst", -6.0),
    ("mdt", -6.0),
    ("mst", -7.0),
    ("pdt", -7.0),
    ("pst", -8.0),
];

/// A time of day.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stamp {
    /// The date before it.
    pub date: Option<Date>,
    /// Seconds since midnight where the clock is.
    pub seconds: f64,
    /// By how much this clock is ahead of UTC, s; 0 where no zone is stated.
    pub zone: f64,
    /// The unit of its last digit, s.
    pub digit: f64,
}

impl Stamp {
    /// Reads a time of day with or without a date before it and a zone behind it.
    pub fn parse(field: &str) -> Option<Self> {
        let field = field.trim().trim_matches('"').trim();
        let with_colons = basic(field);
        let field = with_colons.as_deref().unwrap_or(field);
        let colon = field.find(':')?;
        let (before, _) = field.split_at_checked(colon)?;
        let hour = before.trim_end_matches(|c: char| c.is_ascii_digit());
        let (date, clock) = field.split_at_checked(hour.len())?;
        let is_of_date = |c: char| c.is_alphanumeric() || "-./, _".contains(c);
        if !date.chars().all(is_of_date) || (!date.is_empty() && !has_digit(date)) {
            return None;
        }
        let end = clock.find(|c: char| !(c.is_ascii_digit() || ":.,".contains(c)));
        let (clock, rest) = clock.split_at_checked(end.unwrap_or(clock.len()))?;
        let (afternoon, zone) = half_and_zone(rest)?;
        let (seconds, digit) = since_midnight(clock)?;
        let seconds = match afternoon {
            // 12 AM is midnight, 12 PM noon.
            Some(is_afternoon) => {
                seconds % HALF_A_DAY + if is_afternoon { HALF_A_DAY } else { 0.0 }
            }
            None => seconds,
        };
        Some(Self { date: Date::parse(date), seconds, zone, digit })
    }
}

/// A basic stamp of ISO 8601, `20260102T120000.25Z`, with colons in its time.
fn basic(field: &str) -> Option<String> {
    let is_number = |text: &str| text.bytes().all(|b| b.is_ascii_digit());
    let (date, clock) = field.split_once(['T', 't'])?;
    let (hours, minutes) = (clock.get(..2)?, clock.get(2..4)?);
    let (seconds, rest) = (clock.get(4..6)?, clock.get(6..)?);
    let is_basic = date.len() == 8 && [date, hours, minutes, seconds].into_iter().all(is_number);
    is_basic.then(|| format!("{date} {hours}:{minutes}:{seconds}{rest}"))
}

/// True for a date alone, such as 2026-01-02 or 05.01.2026.
pub(super) fn is_date(field: &str) -> bool {
    ['-', '.', '/'].into_iter().any(|sign| {
        let groups: Vec<&str> = field.split(sign).collect();
        let digits = |group: &&str| group.chars().all(|c| c.is_ascii_digit());
        let lengths: Vec<usize> = groups.iter().map(|group| group.len()).collect();
        groups.iter().all(digits)
            && matches!(lengths[..], [4, 1..=2, 1..=2] | [1..=2, 1..=2, 2 | 4])
    })
}

fn has_digit(text: &str) -> bool {
    text.chars().any(|c| c.is_ascii_digit())
}

/// Whether what follows a time says morning or afternoon, and by how much its zone is ahead of UTC, s; none when it is
/// neither.
fn half_and_zone(rest: &str) -> Option<(Option<bool>, f64)> {
    let rest: String = rest.chars().filter(|c| !c.is_whitespace() && *c != '.').collect();
    match rest.to_ascii_lowercase().as_str() {
        "" | "z" | "utc" | "gmt" => Some((None, 0.0)),
        "am" => Some((Some(false), 0.0)),
        "pm" => Some((Some(true), 0.0)),
        zone => {
            let named = ZONES.iter().find(|(name, _)| *name == zone);
            let ahead = named.map(|(_, hours)| 3600.0 * hours);
            let stated = || offset(zone.trim_start_matches("utc").trim_start_matches("gmt"));
            Some((None, ahead.or_else(stated)?))
        }
    }
}

/// The seconds of `+01:00`, `-0530` or `+2`.
fn offset(zone: &str) -> Option<f64> {
    let sign = if zone.starts_with('+') { 1.0 } else { -1.0 };
    let digits = zone.strip_prefix(['+', '-', '−'])?;
    let (hours, minutes) = match digits.split_once(':') {
        Some(parts) => parts,
        None if digits.len() > 2 => digits.split_at_checked(digits.len() - 2)?,
        None => (digits, "0"),
    };
    let (hours, minutes) = (group(hours)?, group(minutes)?);
    (hours <= 14.0 && minutes < 60.0).then_some(sign * (3600.0 * hours + 60.0 * minutes))
}

/// The seconds of hours, minutes and seconds, and the unit of the last digit. A time of two groups with decimals has no
/// hours; a fourth group has the decimals of the seconds.
fn since_midnight(clock: &str) -> Option<(f64, f64)> {
    let (whole, decimals) = clock.split_once(['.', ',']).unwrap_or((clock, ""));
    let groups: Vec<&str> = whole.split(':').collect();
    let has_decimals = clock.contains(['.', ',']);
    let (hours, minutes, seconds, decimals) = match groups[..] {
        [minutes, seconds] if has_decimals => ("0", minutes, seconds, decimals),
        [hours, minutes] => return Some((3600.0 * group(hours)? + 60.0 * group(minutes)?, 60.0)),
        [hours, minutes, seconds] => (hours, minutes, seconds, decimals),
        [hours, minutes, seconds, decimals] if !has_decimals => (hours, minutes, seconds, decimals),
        _ => return None,
    };
    let (minutes, seconds) = (group(minutes)?, group(seconds)?);
    if minutes >= 60.0 && hours != "0" || seconds > 60.0 {
        return None;
    }
    let places = i32::try_from(decimals.len()).ok().filter(|&places| places <= 12)?;
    let fraction = if decimals.is_empty() { 0.0 } else { format!("0.{decimals}").parse().ok()? };
    Some((3600.0 * group(hours)? + 60.0 * minutes + seconds + fraction, 10_f64.powi(-places)))
}

fn group(digits: &str) -> Option<f64> {
    let is_number = (1..=4).contains(&digits.len()) && digits.chars().all(|c| c.is_ascii_digit());
    if is_number { digits.parse().ok() } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_of_day_are_read_as_programs_write_them() {
        for (text, seconds, digit) in [
            ("12:00:01.250", 43_201.25, 1e-3),
            ("2026-01-02T12:00:00.000195Z", 43_200.000_195, 1e-6),
            ("2026-01-02 00:00:01.5", 1.5, 0.1),
            ("2026-01-02T01:00:00.25+01:00", 0.25, 0.01),
            ("01:00:00.25-0530", 23_400.25, 0.01),
            ("01:00:00.25 UTC+2", -3599.75, 0.01),
            ("20260102T120000.25Z", 43_200.25, 0.01),
            ("20260102T010000+0100", 0.0, 1.0),
            ("25.10.2026 02:00:00.5 CEST", 0.5, 0.1),
            ("2026-01-02 01:00:00.5 CET", 0.5, 0.1),
            ("05.01.2026 10:00:00,500", 36_000.5, 1e-3),
            ("1/2/2026 1:00:01.5 PM", 46_801.5, 0.1),
            ("12:30:00 AM", 1800.0, 1.0),
            ("01:30:00 p.\u{a0}m.", 48_600.0, 1.0),
            ("12:00:01:250", 43_201.25, 1e-3),
            ("00:01.25", 1.25, 0.01),
            ("10:15", 36_900.0, 60.0),
            ("\"7:08:09\"", 25_689.0, 1.0),
            ("2-Jan-2026 10:00:00.1", 36_000.1, 0.1),
        ] {
            let stamp = Stamp::parse(text).unwrap_or_else(|| panic!("{text}"));
            assert!(
                (stamp.seconds - stamp.zone - seconds).abs() < 1e-9
                    && (stamp.digit / digit - 1.0).abs() < 1e-9,
                "{text}"
            );
        }
        for text in [
            "",
            ":",
            "12",
            "a:b",
            "12:",
            "12:61:00",
            "12:00:61",
            "Rate: 5120",
            "20260102T1200",
            "2026T120000",
            "12:00:00 XYZ",
            "12:00:01.25 m/s",
            "1:2:3:4:5",
        ] {
            assert_eq!(Stamp::parse(text), None, "{text}");
        }
        let dates = ["2026-01-02", "05.01.2026", "1/2/26"];
        assert!(dates.iter().all(|text| is_date(text) && Stamp::parse(text).is_none()));
        assert!(
            ["1.5", "2026", "1.234.567", "1-2", "", "..", "-5"].iter().all(|text| !is_date(text))
        );
    }
}

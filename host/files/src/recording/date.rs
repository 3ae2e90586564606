//! Dates before the times of day in a column of text: `2026-01-02`, `05.01.2026`, `1/2/2026`, `2-Jan-2026`.

use jiff::civil;

/// The first letters of the months, in English, German, French and Spanish where they differ.
const MONTHS: [&[&str]; 12] = [
    &["jan", "ene"],
    &["feb", "fev", "fév"],
    &["mar", "mär", "mrz"],
    &["apr", "avr", "abr"],
    &["may", "mai"],
    &["jun", "juin"],
    &["jul", "juil"],
    &["aug", "aoû", "ago"],
    &["sep"],
    &["oct", "okt"],
    &["nov"],
    &["dec", "dez", "déc", "dic"],
];

/// A date: its day since 1970 with the day before the month and with the month before the day, as far as it is one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Date([Option<i64>; 2]);

impl Date {
    /// Reads a date.
    pub fn parse(text: &str) -> Option<Self> {
        let groups: Vec<&str> = text
            .split(|c: char| !c.is_alphanumeric())
            .map(|group| match group.strip_suffix(['T', 't']) {
                Some(digits) if is_number(digits) => digits,
                _ => group,
            })
            .filter(|group| is_number(group) || month(group).is_some())
            .collect();
        let number = |group: &str| group.parse::<i64>().ok();
        let both = |day: Option<i64>| Self([day; 2]);
        let date = match groups[..] {
            [compact] if compact.len() == 8 => {
                let part = |from: usize, to: usize| number(compact.get(from..to)?);
                both(day_of(part(0, 4)?, part(4, 6)?, part(6, 8)?))
            }
            [year, of_year, day] if year.len() == 4 && is_number(year) => {
                let of_year = month(of_year).or_else(|| number(of_year))?;
                both(day_of(number(year)?, of_year, number(day)?))
            }
            [first, second, year] => {
                let year = number(year).map(|year| if year < 100 { 2000 + year } else { year })?;
                match (month(first), month(second)) {
                    (Some(of_year), _) => both(day_of(year, of_year, number(second)?)),
                    (_, Some(of_year)) => both(day_of(year, of_year, number(first)?)),
                    _ => {
                        let (first, second) = (number(first)?, number(second)?);
                        Self([day_of(year, second, first), day_of(year, first, second)])
                    }
                }
            }
            _ => return None,
        };
        date.0.iter().any(Option::is_some).then_some(date)
    }

    /// The days from an earlier date to this one: the fewest of the two orders of day and month.
    pub fn days_after(self, earlier: Self) -> Option<i64> {
        let days = self.0.into_iter().zip(earlier.0).filter_map(|(a, b)| Some(a? - b?));
        days.min_by_key(|days| (*days < 0, days.abs()))
    }
}

fn is_number(group: &str) -> bool {
    !group.is_empty() && group.len() <= 8 && group.bytes().all(|b| b.is_ascii_digit())
}

fn month(group: &str) -> Option<i64> {
    let group = group.to_lowercase();
    let place = MONTHS.iter().position(|names| names.iter().any(|name| group.starts_with(name)))?;
    i64::try_from(place + 1).ok()
}

/// The day since 1970.
fn day_of(year: i64, month: i64, day: i64) -> Option<i64> {
    let date =
        civil::Date::new(year.try_into().ok()?, month.try_into().ok()?, day.try_into().ok()?);
    let since = date.ok()?.since(civil::Date::constant(1970, 1, 1)).ok()?;
    Some(since.get_days().into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_read_as_programs_write_them() {
        // 2026-01-02 is 20455 days after 1970-01-01: 56 years, 14 of them leap years, and a day.
        for text in
            ["2026-01-02", "20260102", "2026/1/2", "02.01.2026", "2-Jan-2026", "Jan 2, 2026"]
        {
            let Date(days) = Date::parse(text).unwrap_or_else(|| panic!("{text}"));
            assert!(days.contains(&Some(56 * 365 + 14 + 1)), "{text}: {days:?}");
        }
        for text in ["", "T", "2026", "13:00", "1.5", "2026-13-40", "a-b-c"] {
            assert_eq!(Date::parse(text), None, "{text}");
        }
        let days = |a: &str, b: &str| Date::parse(b).unwrap().days_after(Date::parse(a).unwrap());
        assert_eq!(days("2024-02-28", "2024-03-01"), Some(2));
        assert_eq!(days("2025-02-28", "2025-03-01"), Some(1));
        assert_eq!(days("31/12/2026", "01/01/2027"), Some(1));
        assert_eq!(days("2026-01-02", "2026-01-01"), Some(-1));
    }
}

//! Numbers of text files, with a decimal point or comma.

use super::RecordingError;

/// The decimal sign of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decimal {
    /// A decimal point.
    Point,
    /// A decimal comma.
    Comma,
}

impl Decimal {
    /// The name of the decimal sign.
    pub fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Comma => "comma",
        }
    }

    /// The decimal sign of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::Point, Self::Comma].into_iter().find(|decimal| decimal.name() == name)
    }

    /// Parses a field; `None` when it is not a number.
    pub(super) fn number(self, field: &str) -> Option<f64> {
        let field = field.trim().trim_matches('"').trim();
        match self {
            Self::Point => field.parse().ok().or_else(|| unusual(field)),
            Self::Comma if field.contains('.') => no_number(field),
            Self::Comma => {
                let pointed = field.replace(',', ".");
                pointed.parse().ok().or_else(|| unusual(&pointed))
            }
        }
    }

    /// Parses a field; the error names the line and the column.
    pub(super) fn value(
        self,
        field: &str,
        line: usize,
        column: usize,
    ) -> Result<f64, RecordingError> {
        self.number(field).ok_or_else(|| self.fault(field, line, column))
    }

    /// The error of a field that is no number; the column is from 0.
    pub(super) fn fault(self, field: &str, line: usize, column: usize) -> RecordingError {
        RecordingError::NotANumber {
            line,
            column: column + 1,
            text: field.trim().chars().take(40).collect(),
            decimal: self.name(),
        }
    }
}

/// The unit of the last digit of a number, whatever its decimal sign: 0.01 for `1.25`, 1e-6 for `1.95E-04`.
pub(super) fn last_digit(field: &str) -> f64 {
    let field = field.trim().trim_matches('"');
    let (mantissa, exponent) = field.split_once(['e', 'E', 'd', 'D']).unwrap_or((field, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let places = mantissa.split_once(['.', ',']).map_or(0, |(_, decimals)| decimals.len());
    10_f64.powi(exponent.saturating_sub(i32::try_from(places).unwrap_or(i32::MAX)))
}

/// True for the characters of a number, of any decimal sign.
pub(super) fn looks_numeric(field: &str) -> bool {
    let field = field.trim_matches('"');
    let begins = field
        .trim_start_matches(['+', '-', '−', '.', ','])
        .starts_with(|c: char| c.is_ascii_digit());
    let only = |c: char| c.is_ascii_digit() || "+-−.,eEdD".contains(c);
    begins && field.chars().all(only)
        || Decimal::Point.number(field).is_some()
        || no_number(field).is_some()
}

/// A number with the exponent of Fortran, or with the minus sign of a typesetter.
fn unusual(field: &str) -> Option<f64> {
    let text = field.replace('−', "-").replace(['d', 'D'], "e");
    let begins = text.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    if begins { text.parse().ok().or_else(|| no_number(field)) } else { no_number(field) }
}

/// What Windows programs write for a value that is no number, such as `-1.#IND`.
fn no_number(field: &str) -> Option<f64> {
    let text = field.trim_start_matches(['+', '-']).to_ascii_lowercase();
    (text.starts_with("1.#") || text.starts_with("nan(")).then_some(f64::NAN)
}

/// A number with six significant digits.
pub fn six_digits(value: f64) -> String {
    format!("{value:.5e}")
        .parse::<f64>()
        .map_or_else(|_| value.to_string(), |rounded| rounded.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_as_programs_write_them() {
        for (text, expected) in [
            ("1.5", 1.5),
            ("-1e-3", -1e-3),
            ("+2", 2.0),
            (".5", 0.5),
            ("5.", 5.0),
            ("1.0D-03", 1e-3),
            ("−3", -3.0),
            ("\"1.5\"", 1.5),
            (" 7 ", 7.0),
        ] {
            assert_eq!(Decimal::Point.number(text), Some(expected), "{text}");
        }
        assert_eq!(Decimal::Comma.number("1,5"), Some(1.5));
        assert_eq!(Decimal::Comma.number("1,0E-03"), Some(1e-3));
        assert!(
            ["-1.#IND", "1.#QNAN0", "-nan(ind)", "NaN"]
                .iter()
                .all(|text| Decimal::Point.number(text).unwrap().is_nan())
        );
        for text in ["", "two", "1.5.5", "d", "e5", "1,5", "0x10", "-"] {
            assert_eq!(Decimal::Point.number(text), None, "{text}");
        }
        assert_eq!(Decimal::Comma.number("1.5"), None);
    }

    #[test]
    fn the_last_digit_says_how_finely_a_number_was_written() {
        for (text, expected) in [
            ("1.25", 1e-2),
            ("0,0002", 1e-4),
            ("1.95E-04", 1e-6),
            ("7", 1.0),
            ("1e3", 1e3),
            ("1.5e+2", 10.0),
        ] {
            assert!((last_digit(text) / expected - 1.0).abs() < 1e-12, "{text}");
        }
        assert!(
            looks_numeric("1.234,5")
                && looks_numeric("-0,5")
                && looks_numeric("NaN")
                && looks_numeric("1.#INF")
        );
        assert!(
            !looks_numeric("N")
                && !looks_numeric("")
                && !looks_numeric("5 V")
                && !looks_numeric("-")
        );
    }
}

//! The data of dataset 58: record 12, as text or binary.

use super::error::{UffError, UffFault};
use super::lines::{Lines, is_delimiter};
use crate::encoding::label;

/// The format of the data: record 7.
pub(super) struct Shape {
    pub(super) complex: bool,
    pub(super) double: bool,
    pub(super) points: usize,
    /// Minimum and increment of an even abscissa; `None` when each point has its own abscissa.
    pub(super) even: Option<[f64; 2]>,
}

impl Shape {
    /// Number of values per point.
    pub(super) fn per_point(&self) -> usize {
        1 + usize::from(self.complex) + usize::from(self.even.is_none())
    }

    /// Number of values in the dataset.
    fn values(&self) -> usize {
        self.points.saturating_mul(self.per_point())
    }
}

/// How binary data are stored.
#[derive(Clone, Copy)]
pub(super) struct Binary {
    pub(super) big_endian: bool,
}

impl Binary {
    /// The byte order and the number by which a header states it.
    fn name(self) -> &'static str {
        if self.big_endian { "big-endian (2)" } else { "little-endian (1)" }
    }
}

/// Parses a number in Fortran notation, or one of the words that programs write for no number.
pub(super) fn real(text: &str) -> Option<f64> {
    let text = text.trim();
    let exponent = || text.replace(['D', 'd'], "E").parse().ok();
    text.parse().ok().or_else(exponent).or_else(|| without_letter(text)).or_else(|| no_number(text))
}

/// What is not finite, or did not fit its columns: `-1.#IND`, `1.#QNAN000`, `1.#INF`, `-nan(ind)`, `NaNQ`, `*****`.
fn no_number(text: &str) -> Option<f64> {
    let text = text.to_ascii_lowercase();
    if !text.is_empty() && text.bytes().all(|b| b == b'*') {
        return Some(f64::NAN);
    }
    let (sign, word) = match text.strip_prefix('-') {
        Some(word) => (-1.0, word),
        None => (1.0, text.strip_prefix('+').unwrap_or(&text)),
    };
    let word = word.strip_prefix("1.#").unwrap_or(word);
    let ends = |rest: &str| {
        let digits = rest.trim_start_matches(|c: char| c.is_ascii_digit());
        let exponent = digits.strip_prefix('e').unwrap_or(digits).trim_start_matches(['+', '-']);
        exponent.bytes().all(|b| b.is_ascii_digit())
    };
    let not_numbers = ["nan(ind)", "nan(snan)", "nan", "nanq", "nans", "ind", "qnan", "snan"];
    let is_one_of = |words: &[&str]| words.iter().any(|w| word.strip_prefix(w).is_some_and(ends));
    match () {
        () if is_one_of(&not_numbers) => Some(f64::NAN),
        () if is_one_of(&["inf", "infinity"]) => Some(sign * f64::INFINITY),
        () => None,
    }
}

/// Parses a number whose exponent has three digits, for which Fortran leaves the letter out: `1.0-101`.
fn without_letter(text: &str) -> Option<f64> {
    let at = text.rfind(['+', '-']).filter(|&at| at > 0)?;
    let (digits, exponent) = text.split_at_checked(at)?;
    let plain = |c: char| c.is_ascii_digit() || matches!(c, '.' | '+' | '-');
    let good = exponent.len() == 4 && digits.ends_with(|c: char| c.is_ascii_digit() || c == '.');
    (good && text.chars().all(plain)).then(|| format!("{digits}E{exponent}").parse().ok()).flatten()
}

/// Reads the values of an ASCII dataset up to the delimiter.
pub(super) fn read_ascii(lines: &mut Lines<'_>, shape: &Shape) -> Result<Vec<f64>, UffError> {
    let wanted = shape.values();
    // A value takes at least two bytes, so a false header cannot make this allocate too much.
    let possible = lines.rest().len() / 2;
    if wanted > possible {
        return Err(lines.error(UffFault::TooFewValues { wanted, found: possible }));
    }
    let mut values = Vec::with_capacity(wanted);
    while values.len() < wanted {
        let line = match lines.peek() {
            Some(line) if !is_delimiter(line) => label(line),
            _ => {
                let count = values.len();
                return Err(lines.error(UffFault::TooFewValues { wanted, found: count }));
            }
        };
        lines.next();
        if !push_words(&line, &mut values) && !push_columns(&line, shape, &mut values) {
            let text = line.chars().take(80).collect();
            return Err(lines.error(UffFault::NotANumber { field: "data values", text }));
        }
    }
    let more = lines.peek().is_some_and(|l| !is_delimiter(l) && !l.trim_ascii().is_empty());
    if values.len() > wanted || more {
        return Err(lines.error(UffFault::TooManyValues { wanted }));
    }
    Ok(values)
}

/// Parses the blank-separated numbers of a line; false when one is malformed.
fn push_words(line: &str, values: &mut Vec<f64>) -> bool {
    let before = values.len();
    for word in line.split_ascii_whitespace() {
        match real(word) {
            Some(value) => values.push(value),
            None => {
                values.truncate(before);
                return false;
            }
        }
    }
    true
}

/// Parses the numbers of a line by the columns of the format, where they may touch.
fn push_columns(line: &str, shape: &Shape, values: &mut Vec<f64>) -> bool {
    const ABSCISSA: usize = 13;
    let ordinate = if shape.double { 20 } else { 13 };
    let mut rest = line.trim_end();
    let mut k = 0;
    while !rest.is_empty() {
        let is_abscissa = shape.even.is_none() && k % shape.per_point() == 0;
        let width = if is_abscissa { ABSCISSA } else { ordinate };
        let Some((number, after)) = rest.split_at_checked(width.min(rest.len())) else {
            return false;
        };
        let Some(value) = real(number) else { return false };
        values.push(value);
        rest = after;
        k += 1;
    }
    true
}

/// Reads the values of a binary dataset up to the delimiter.
///
/// The byte count of the header is not used, because common writers state half of it. The length is computed
/// from record 7, and the delimiter after the data confirms it.
pub(super) fn read_binary(
    lines: &mut Lines<'_>,
    shape: &Shape,
    binary: Binary,
) -> Result<Vec<f64>, UffError> {
    let ordinates = shape.per_point() - usize::from(shape.even.is_none());
    let point = |abscissa: usize, ordinate: usize| {
        let abscissa = if shape.even.is_none() { abscissa } else { 0 };
        (abscissa, ordinate, shape.points.saturating_mul(abscissa + ordinate * ordinates))
    };
    // The layout of the format; the layout with the abscissa in the format's single precision; the layout of
    // writers that store doubles whatever record 7 states.
    let stated = if shape.double { 8 } else { 4 };
    let candidates = [point(stated, stated), point(4, stated), point(8, 8)];
    let Some(&(abscissa, ordinate, length)) =
        candidates.iter().find(|(_, _, length)| lines.ends_after(*length))
    else {
        let bytes = candidates[0].2;
        let available = lines.rest().len();
        let fault = if available < bytes {
            UffFault::TooFewValues { wanted: shape.values(), found: available / stated }
        } else {
            UffFault::BinaryLength { bytes }
        };
        return Err(lines.error(fault));
    };
    let data = lines.take(length).unwrap_or_default();
    // A line end may follow the data.
    if lines.peek().is_some_and(<[u8]>::is_empty) {
        lines.next();
    }
    let decode = |binary: Binary| {
        let mut values = Vec::with_capacity(shape.values());
        for point in data.chunks_exact((abscissa + ordinate * ordinates).max(1)) {
            let (first, rest) = point.split_at_checked(abscissa).unwrap_or((point, &[]));
            if abscissa > 0 {
                values.push(number(first, binary));
            }
            values.extend(rest.chunks_exact(ordinate).map(|bytes| number(bytes, binary)));
        }
        values
    };
    let values = decode(binary);
    let absurd = absurd(&values);
    let swapped = Binary { big_endian: !binary.big_endian };
    if 4 * absurd > values.len() && 50 * self::absurd(&decode(swapped)) <= values.len() {
        let (stated, other) = (binary.name(), swapped.name());
        let values = values.len();
        return Err(lines.error(UffFault::ByteOrder { stated, other, absurd, values }));
    }
    Ok(values)
}

/// How many of these values no measurement has.
fn absurd(values: &[f64]) -> usize {
    let is_plausible = |value: &&f64| **value == 0.0 || (1e-20..1e20).contains(&value.abs());
    values.len() - values.iter().filter(is_plausible).count()
}

/// A single or double from 4 or 8 bytes.
fn number(bytes: &[u8], binary: Binary) -> f64 {
    if let Ok(bytes) = <[u8; 8]>::try_from(bytes) {
        return if binary.big_endian {
            f64::from_be_bytes(bytes)
        } else {
            f64::from_le_bytes(bytes)
        };
    }
    match <[u8; 4]>::try_from(bytes) {
        Ok(bytes) if binary.big_endian => f64::from(f32::from_be_bytes(bytes)),
        Ok(bytes) => f64::from(f32::from_le_bytes(bytes)),
        // Not reached: all slices have 4 or 8 bytes.
        Err(_) => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_words_of_other_programs_for_no_number_are_read() {
        for text in [
            "-1.#IND000000",
            "1.#QNAN",
            "1.#QNAN00E+00",
            "-1.#IND",
            "1.#SNAN0",
            "nan(ind)",
            "-nan(ind)",
            "NaN",
            "-nan",
            "NaNQ",
            "nans",
            "*************",
            " 1.#IND ",
        ] {
            assert!(real(text).is_some_and(f64::is_nan), "{text}");
        }
        for (text, sign) in [
            ("1.#INF", 1.0),
            ("-1.#INF000", -1.0),
            ("inf", 1.0),
            ("-Infinity", -1.0),
            ("+Inf", 1.0),
        ] {
            assert_eq!(real(text), Some(sign * f64::INFINITY), "{text}");
        }
        for text in [
            "",
            "*1",
            "1.#",
            "#IND",
            "ind.",
            "1.#IND0000001.0E+00",
            "nano",
            "none",
            "information",
            "2.#IND",
        ] {
            assert!(real(text).is_none(), "{text}");
        }
        let mut values = Vec::new();
        let shape = Shape { complex: true, double: true, points: 1, even: Some([0.0, 1.0]) };
        let touching = "     -1.#IND00000000-1.234567890123E+001";
        assert!(!push_words(touching, &mut values) && push_columns(touching, &shape, &mut values));
        assert!(values[0].is_nan() && values[1] == -12.345_678_901_23, "{values:?}");
    }

    #[test]
    fn an_exponent_of_three_digits_needs_no_letter_and_a_range_is_no_number() {
        for (text, value) in [
            ("1.0-101", 1e-101),
            ("-2.5+101", -2.5e101),
            ("1.-101", 1e-101),
            ("1.0D-05", 1e-5),
            (" 1.0E+02 ", 100.0),
        ] {
            assert_eq!(real(text), Some(value), "{text}");
        }
        for text in ["1.0-10", "1-2", "10-1000", "1.0--101", "-101", "1.0-101-101", "a-101", ""] {
            assert!(real(text).is_none_or(|value| value == -101.0), "{text}");
        }
    }
}

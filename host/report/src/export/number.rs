//! Numbers as text.

/// The shortest text that reads back as the same number, with a point and a signed exponent: readers of YAML 1.1 take
/// `1e-5` for a string, and `1.0e-5` for a number.
pub(super) fn shortest(value: f64) -> String {
    let text = format!("{value:?}");
    let Some((mantissa, exponent)) = text.split_once('e') else { return text };
    let point = if mantissa.contains('.') { "" } else { ".0" };
    let sign = if exponent.starts_with('-') { "" } else { "+" };
    format!("{mantissa}{point}e{sign}{exponent}")
}

/// The text of at most `width` columns that is closest to a number; `None` when there is none.
pub(super) fn closest(value: f64, width: usize) -> Option<String> {
    let mut best: Option<(f64, String)> = None;
    for candidate in [decimal(value, width), exponential(value, width)].into_iter().flatten() {
        let error = (candidate.parse::<f64>().ok()? - value).abs();
        if best.as_ref().is_none_or(|(least, _)| error < *least) {
            best = Some((error, candidate));
        }
    }
    best.map(|(_, text)| text)
}

/// Most digits that are tried: a double has 17.
const DIGITS: usize = 18;

fn decimal(value: f64, width: usize) -> Option<String> {
    let digits = (1..=DIGITS).rev();
    let text = digits.map(|digits| format!("{value:.digits$}")).find(|text| text.len() <= width)?;
    let short = text.trim_end_matches('0');
    Some(if short.ends_with('.') { format!("{short}0") } else { short.into() })
}

fn exponential(value: f64, width: usize) -> Option<String> {
    let digits = (1..=DIGITS).rev();
    let text = |digits| with_fortran_exponent(&format!("{value:.digits$E}"));
    digits.map(text).find(|text| text.len() <= width)
}

/// The same number with the sign and at least two digits of the exponent, as Fortran writes them.
pub(super) fn with_fortran_exponent(text: &str) -> String {
    let Some((mantissa, exponent)) = text.split_once('E') else { return text.into() };
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let sign = if exponent < 0 { '-' } else { '+' };
    format!("{mantissa}E{sign}{:02}", exponent.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_has_a_point_and_a_signed_exponent() {
        let texts = [1.0, -0.25, 1e-5, 2.5e-7, 1e16, 1.5e300].map(shortest);
        assert_eq!(texts, ["1.0", "-0.25", "1.0e-5", "2.5e-7", "1.0e+16", "1.5e+300"]);
    }

    #[test]
    fn a_narrow_column_keeps_as_many_digits_as_fit() {
        // Sixteen columns leave ten digits or more, with or without an exponent of two digits.
        for (value, text) in [
            (0.0, "0.0"),
            (1.23, "1.23"),
            (-9.557249267687536e-4, "-0.0009557249268"),
            (0.0042529759241209525, "0.00425297592412"),
            (-0.25, "-0.25"),
            (-1.234567890123456e-120, "-1.23456789E-120"),
        ] {
            let number = closest(value, 16).unwrap();
            assert!(number.len() <= 16, "{number}");
            assert_eq!(number, text);
        }
        assert_eq!(closest(1e200, 6), None);
    }
}

//! Numbers with as many digits as their uncertainty allows.

use massline_shared::identify::HALF_WIDTH_95;

/// Most decimals that are printed.
const MOST_DECIMALS: i32 = 12;
/// Significant digits of a value whose uncertainty is not known.
const WITHOUT_SIGMA: i32 = 4;

/// A number, unless it stands for what is not known.
pub fn known(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// Decimals with which a number has this many significant digits.
fn decimals(number: f64, digits: i32) -> usize {
    let first = number.abs().log10().floor() as i32;
    // 0.0996 is 0.10 with two digits.
    let last = 10f64.powi(first + 1) - 0.5 * 10f64.powi(first + 1 - digits);
    let rounds_up = number.abs() >= last;
    (digits - 1 - first - i32::from(rounds_up)).clamp(0, MOST_DECIMALS) as usize
}

/// The standard deviation, if it says how many digits a value deserves.
fn telling(sigma: Option<f64>) -> Option<f64> {
    sigma.filter(|sigma| sigma.is_finite() && *sigma > 0.0)
}

/// A number with the decimals of a standard deviation that has two significant digits; without one, or with one of
/// zero, four significant digits.
pub fn as_exact_as(value: f64, sigma: Option<f64>) -> String {
    let decimals = match telling(sigma) {
        Some(sigma) => decimals(sigma, 2),
        None if value == 0.0 => 0,
        None => decimals(value, WITHOUT_SIGMA),
    };
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(zero) if zero.chars().all(|c| matches!(c, '0' | '.')) => zero.to_owned(),
        _ => text,
    }
}

/// A standard deviation or another small positive number with two significant digits; a dash where none is known.
pub fn two_digits(value: f64) -> String {
    // With the most decimals it would be zero.
    let tiny = value > 0.0 && value < 0.5 * 10f64.powi(1 - MOST_DECIMALS);
    match value {
        _ if !value.is_finite() => "-".to_owned(),
        _ if tiny => format!("{value:.1e}"),
        _ => as_exact_as(value, Some(value)),
    }
}

/// `1.220 ± 0.027`: a value and its standard deviation, which has two significant digits. Only the value where none is
/// known.
pub fn with_sigma(value: f64, sigma: f64) -> String {
    let number = as_exact_as(value, Some(sigma));
    if sigma.is_finite() { format!("{number} ± {}", two_digits(sigma)) } else { number }
}

/// A number with the decimals of a value whose 95 % interval has this half width, as [`as_exact_as`]: those of a
/// standard deviation of half / 1.96. The interval of a learned budget is wider than 1.96 standard deviations.
pub fn in_interval(value: f64, half: Option<f64>) -> String {
    as_exact_as(value, half.map(|half| half / HALF_WIDTH_95))
}

/// A value with half the width of its 95 % interval, both as [`in_interval`]. Only the value where that is not known.
pub fn with_half_width(value: f64, half: f64) -> String {
    let number = in_interval(value, Some(half));
    match half {
        _ if !half.is_finite() => number,
        _ if half < 10f64.powi(-MOST_DECIMALS) => format!("{number} ± {}", two_digits(half)),
        _ => format!("{number} ± {}", in_interval(half, Some(half))),
    }
}

/// The same of a standard deviation.
pub fn with_interval(value: f64, sigma: f64) -> String {
    with_half_width(value, HALF_WIDTH_95 * sigma)
}

/// As [`with_sigma`] for a deviation, whose sign is always written: `+0.31 ± 0.12`.
pub fn deviation(value: f64, sigma: f64) -> String {
    signed(with_sigma(value, sigma))
}

/// A number as [`as_exact_as`], whose sign is always written.
pub fn signed_as_exact_as(value: f64, sigma: f64) -> String {
    signed(as_exact_as(value, Some(sigma)))
}

fn signed(number: String) -> String {
    if number.starts_with('-') { number } else { format!("+{number}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_standard_deviation_has_two_significant_digits_and_its_value_the_same_decimals() {
        for (value, sigma, text) in [
            (1.220_04, 0.026_91, "1.220 ± 0.027"),
            (0.001_234_56, 0.000_000_417, "0.00123456 ± 0.00000042"),
            (168.750_5, 0.634_9, "168.75 ± 0.63"),
            (12_345.6, 263.0, "12346 ± 263"),
            (-0.5, 0.099_6, "-0.50 ± 0.10"),
            (5.0, 0.095, "5.000 ± 0.095"),
            (5.0, 1.0, "5.0 ± 1.0"),
            (5.0, 9.96, "5 ± 10"),
            (-0.4, 13.0, "0 ± 13"),
        ] {
            assert_eq!(with_sigma(value, sigma), text);
        }
    }

    /// 1.96 × 0.0060 is 0.0118: with two digits of its own the interval would be narrower or wider by up to 5 %.
    #[test]
    fn an_interval_has_the_decimals_of_its_standard_deviation() {
        for (value, sigma, text) in [
            (1.220_04, 0.026_91, "1.220 ± 0.053"),
            (2.5, 0.006, "2.5000 ± 0.0118"),
            (2.5, 0.0, "2.500 ± 0"),
            (2.5, f64::NAN, "2.500"),
        ] {
            assert_eq!(with_interval(value, sigma), text);
        }
    }

    #[test]
    fn a_value_without_a_standard_deviation_has_four_significant_digits() {
        for none in [None, Some(f64::NAN), Some(f64::INFINITY), Some(0.0)] {
            assert_eq!(as_exact_as(1.0, none), "1.000");
            assert_eq!(as_exact_as(0.001_234_56, none), "0.001235");
            assert_eq!(as_exact_as(99_999.6, none), "100000");
            assert_eq!(as_exact_as(0.0, none), "0");
        }
    }

    /// The numbers must not look like `0.0012 ± 0.0000`, which states a precision that nobody has.
    #[test]
    fn a_standard_deviation_that_is_zero_tiny_or_unknown_is_not_a_row_of_zeros() {
        assert_eq!(with_sigma(0.001_234_56, 0.0), "0.001235 ± 0");
        assert_eq!(with_sigma(0.001_234_56, 4.2e-15), "0.001234560000 ± 4.2e-15");
        assert_eq!(with_sigma(0.001_234_56, f64::NAN), "0.001235");
        assert_eq!(two_digits(f64::NAN), "-");
        assert_eq!(two_digits(4.96e-12), "5.0e-12");
        assert_eq!(two_digits(5.1e-12), "0.000000000005");
    }

    #[test]
    fn a_deviation_has_its_sign() {
        assert_eq!(deviation(0.314, 0.12), "+0.31 ± 0.12");
        assert_eq!(deviation(-0.314, 0.12), "-0.31 ± 0.12");
        assert_eq!(deviation(-0.001, 0.12), "+0.00 ± 0.12");
        assert_eq!(deviation(0.0, 0.0), "+0 ± 0");
    }

    #[test]
    fn numbers_have_two_digits_that_count() {
        let shown = [0.834, 1.25, 12.4, 123.4, 0.0123].map(two_digits);
        assert_eq!(shown, ["0.83", "1.2", "12", "123", "0.012"]);
    }
}

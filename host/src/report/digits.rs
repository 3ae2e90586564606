//! Numbers with as many digits as their uncertainty allows.

/// Most decimals that are printed.
const MOST_DECIMALS: i32 = 12;
/// Decimals of a value whose uncertainty is not known.
const WITHOUT_SIGMA: usize = 4;

/// Decimals with which a standard deviation has two significant digits.
fn decimals(sigma: f64) -> usize {
    if !(sigma.is_finite() && sigma > 0.0) {
        return WITHOUT_SIGMA;
    }
    let first = sigma.log10().floor() as i32;
    // 0.0996 is 0.10 with two digits.
    let rounds_up = sigma / 10f64.powi(first) >= 9.95;
    (1 - first - i32::from(rounds_up)).clamp(0, MOST_DECIMALS) as usize
}

/// A number with the decimals of a standard deviation that has two significant digits.
pub fn as_exact_as(value: f64, sigma: Option<f64>) -> String {
    let text = format!("{value:.*}", sigma.map_or(WITHOUT_SIGMA, decimals));
    match text.strip_prefix('-') {
        Some(zero) if zero.chars().all(|c| matches!(c, '0' | '.')) => zero.to_owned(),
        _ => text,
    }
}

/// A standard deviation or another small positive number with two significant digits.
pub fn two_digits(value: f64) -> String {
    as_exact_as(value, Some(value))
}

/// `1.220 ± 0.027`: a value and its standard deviation, which has two significant digits.
pub fn with_sigma(value: f64, sigma: f64) -> String {
    let of = |number| as_exact_as(number, Some(sigma));
    format!("{} ± {}", of(value), of(sigma))
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

    #[test]
    fn a_value_without_a_standard_deviation_has_four_decimals() {
        assert_eq!(as_exact_as(1.0, None), "1.0000");
        assert_eq!(as_exact_as(1.0, Some(f64::NAN)), "1.0000");
        assert_eq!(as_exact_as(1.0, Some(0.0)), "1.0000");
    }
}

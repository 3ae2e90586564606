//! Numbers as text. The float formatter of `core` takes 20 KB of flash; a screen needs seven digits.

use core::fmt::Write as _;

use heapless::String;

/// A number as text, or a line of the screen.
pub type Text = String<32>;

/// The most decimals that are shown.
const MOST_DECIMALS: u8 = 6;
/// Largest number that is shown, in units of the last decimal: an `f32` holds seven digits.
const LARGEST: f32 = 9_999_999.0;

/// A number with this many decimals, or fewer if it would have more than seven digits. A number that is
/// NaN, infinite or too large is shown as `?` or `>max`.
pub fn fixed(value: f32, decimals: u8) -> Text {
    let mut text = Text::new();
    let mut decimals = decimals.min(MOST_DECIMALS);
    while decimals > 0 && value.abs() * power(decimals) > LARGEST {
        decimals -= 1;
    }
    let scaled = value.abs() * power(decimals) + 0.5;
    if value.is_nan() || scaled > LARGEST + 1.0 {
        // There is room.
        let _ = text.push_str(if value.is_nan() { "?" } else { ">max" });
        return text;
    }
    let digits = scaled as u32;
    let unit = 10_u32.pow(u32::from(decimals));
    let sign = if value < 0.0 && digits > 0 { "-" } else { "" };
    // The text has room for a sign, seven digits, a point and leading zeros.
    let _ = write!(text, "{sign}{}", digits / unit);
    if decimals > 0 {
        let width = usize::from(decimals);
        let _ = write!(text, ".{:0width$}", digits % unit);
    }
    text
}

/// Number of decimals that show `value` with this many significant digits.
pub fn decimals_for(value: f32, significant: u8) -> u8 {
    let mut decimals = 0;
    let mut limit = power(significant.saturating_sub(1));
    // The condition is false for NaN and infinity.
    while decimals < MOST_DECIMALS && value.abs() < limit && value != 0.0 {
        limit /= 10.0;
        decimals += 1;
    }
    decimals
}

/// A number in `width` characters with as many decimals as fit, at most `decimals`.
pub fn fitting(value: f32, decimals: u8, width: usize) -> Text {
    let mut decimals = decimals;
    loop {
        let text = fixed(value, decimals);
        if text.len() <= width || decimals == 0 {
            return text;
        }
        decimals -= 1;
    }
}

/// A share as a percentage with two significant digits.
pub fn percent(share: f32) -> Text {
    let percent = 100.0 * share;
    let mut text = fitting(percent, decimals_for(percent, 2), 5);
    // There is room for five characters and two more.
    let _ = text.push_str(" %");
    text
}

fn power(exponent: u8) -> f32 {
    (0..exponent).fold(1.0, |power, _| power * 10.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_to_their_decimals() {
        for (value, decimals, text) in [
            (1.2294, 4, "1.2294"),
            (-0.9615, 2, "-0.96"),
            (0.996, 2, "1.00"),
            (-0.001, 2, "0.00"),
            (168.0, 0, "168"),
            (0.05, 3, "0.050"),
            (1234567.0, 6, "1234567"),
            (9.99e9, 2, ">max"),
            (f32::NAN, 2, "?"),
            (f32::NEG_INFINITY, 2, ">max"),
        ] {
            assert_eq!(fixed(value, decimals), text, "{value}");
        }
    }

    #[test]
    fn decimals_give_significant_digits() {
        for (value, significant, decimals) in [
            (0.0293, 2, 3),
            (0.91, 2, 2),
            (1.27, 2, 1),
            (31.0, 2, 0),
            (0.0, 2, 0),
            (1e-9, 2, 6),
            (f32::NAN, 2, 0),
        ] {
            assert_eq!(decimals_for(value, significant), decimals, "{value}");
        }
    }

    #[test]
    fn a_number_fits_its_width_by_giving_up_decimals() {
        assert_eq!(fitting(-12345.678, 3, 8), "-12345.7");
        assert_eq!(fitting(-1234567.0, 3, 4), "-1234567");
        assert_eq!(percent(0.0137), "1.4 %");
        assert_eq!(percent(2.5), "250 %");
    }
}

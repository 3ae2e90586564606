//! Signs of print in text that people read, on a page or in a picture. Files for programs keep the signs of ASCII.

/// The text with a minus sign (U+2212) in place of each hyphen that begins a number or an exponent.
///
/// A hyphen after a letter, a digit or another hyphen joins words, dates and options, and stays.
pub fn with_minus_signs(text: &str) -> String {
    let letters: Vec<char> = text.chars().collect();
    let is_sign = |place: usize| {
        let begins = match letters[..place] {
            [.., digit, 'e'] => digit.is_ascii_digit(),
            [.., before] => !before.is_alphanumeric() && before != '-',
            [] => true,
        };
        begins && letters.get(place + 1).is_some_and(char::is_ascii_digit)
    };
    let printed = |(place, letter): (usize, &char)| match letter {
        '-' if is_sign(place) => '−',
        other => *other,
    };
    letters.iter().enumerate().map(printed).collect()
}

#[cfg(test)]
mod tests {
    use super::with_minus_signs;

    #[test]
    fn negative_numbers_and_exponents_have_a_minus_sign_and_words_and_dates_keep_their_hyphens() {
        for (text, printed) in [
            ("-0.50 ± 0.10", "−0.50 ± 0.10"),
            ("1, -2 (-3)", "1, −2 (−3)"),
            ("5.0e-12", "5.0e−12"),
            (
                "2026-11-27, mass-line, hits at 1:-Y, --seed -, H-1",
                "2026-11-27, mass-line, hits at 1:-Y, --seed -, H-1",
            ),
        ] {
            assert_eq!(with_minus_signs(text), printed);
        }
    }
}

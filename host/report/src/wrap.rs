//! Long lines of text broken between words.

use textwrap::{Options, WordSeparator, WordSplitter, WrapAlgorithm};

/// Width of text without a terminal, columns.
pub const WIDTH: usize = 100;

/// Indentation of continuation lines.
const INDENT: &str = "    ";

/// Stands for a space at which a line is not broken, nor a cell of a table.
pub const KEPT: char = '\u{a0}';

/// Units, and what else belongs to the number before it.
const UNITS: [&str; 32] = [
    "%",
    "kg",
    "g",
    "mm",
    "m",
    "µm",
    "N",
    "kN",
    "Hz",
    "kHz",
    "s",
    "ms",
    "V",
    "mV",
    "mrad",
    "rad",
    "sd",
    "dB",
    "m²",
    "m/s²",
    "(m/s²)/N",
    "N/m",
    "°C",
    "kB",
    "MB",
    "bytes",
    "scans",
    "min",
    "°",
    "1/s",
    "kg/m³",
    "UTC",
];

/// The text with every line of more than `width` columns broken at spaces; continuation lines are indented. A number is
/// not parted from its unit. Lines that fit, such as those of tables, stay as they are, and so does a single word that
/// is too long.
pub fn wrapped(text: &str, width: usize) -> String {
    let options = Options::new(width)
        .subsequent_indent(INDENT)
        .break_words(false)
        .word_separator(WordSeparator::AsciiSpace)
        .word_splitter(WordSplitter::NoHyphenation)
        .wrap_algorithm(WrapAlgorithm::FirstFit);
    let broken = |line: &str| match textwrap::core::display_width(line) > width {
        true => textwrap::fill(&kept_together(line), &options).replace(KEPT, " "),
        false => line.to_owned(),
    };
    text.split('\n').map(broken).collect::<Vec<_>>().join("\n")
}

/// The line with [`KEPT`] for each space between a number and its unit, about ±, and within a command between
/// backticks.
fn kept_together(line: &str) -> String {
    let mut together = String::with_capacity(line.len());
    let (mut before, mut is_command) = (None, false);
    for word in line.split(' ') {
        if let Some(before) = before {
            let is_kept = is_command || belong_together(before, word);
            together.push(if is_kept { KEPT } else { ' ' });
        }
        together += word;
        is_command ^= word.matches('`').count() % 2 == 1;
        before = Some(word);
    }
    together
}

/// Whether a line must not be broken between two words.
fn belong_together(before: &str, word: &str) -> bool {
    let plain = word.trim_end_matches([',', ';', ':', '.', ')', '|']);
    let is_number = before
        .trim_start_matches(['(', '±', '+', '-', '−'])
        .starts_with(|c: char| c.is_ascii_digit());
    let ends_in_unit = matches!(before, "g" | "kg");
    let is_impulse = before == "N" && plain == "s";
    is_number && (UNITS.contains(&plain) || plain == "±")
        || before == "±"
        || ends_in_unit && plain.starts_with("m²")
        || is_impulse
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_line_is_broken_between_words_and_goes_on_indented() {
        assert_eq!(wrapped("one two three four", 12), "one two\n    three\n    four");
        assert_eq!(wrapped("one two", 7), "one two");
        assert_eq!(wrapped("a\n\nb", 7), "a\n\nb");
    }

    #[test]
    fn a_word_that_is_too_long_stays_whole() {
        assert_eq!(
            wrapped("words /a/very/long/path now", 10),
            "words\n    /a/very/long/path\n    now"
        );
    }

    #[test]
    fn spaces_within_a_line_stay() {
        assert_eq!(
            wrapped("hit   1  4:+X  rejected: weak", 22),
            "hit   1  4:+X\n    rejected: weak"
        );
    }

    #[test]
    fn a_number_stays_with_its_unit() {
        assert_eq!(wrapped("the mass is 1.23 kg here", 16), "the mass is\n    1.23 kg here");
        assert_eq!(wrapped("moments 3.451 ± 0.085 g m²", 20), "moments\n    3.451 ± 0.085 g m²");
        assert_eq!(
            wrapped("next: `massline report x y` now", 20),
            "next:\n    `massline report x y`\n    now"
        );
        assert_eq!(wrapped("a band of 10 to 120 Hz, set", 21), "a band of 10 to\n    120 Hz, set");
    }

    #[test]
    fn colours_take_no_columns() {
        assert_eq!(wrapped("\x1b[1mbold\x1b[0m text", 9), "\x1b[1mbold\x1b[0m text");
    }
}

//! Long lines of text broken between words.

use textwrap::{Options, WordSeparator, WordSplitter, WrapAlgorithm};

/// Indentation of continuation lines.
const INDENT: &str = "    ";

/// The text with every line of more than `width` columns broken at spaces; continuation lines are indented.
/// Lines that fit, such as those of tables, stay as they are, and so does a single word that is too long.
pub(super) fn wrapped(text: &str, width: usize) -> String {
    let options = Options::new(width)
        .subsequent_indent(INDENT)
        .break_words(false)
        .word_separator(WordSeparator::AsciiSpace)
        .word_splitter(WordSplitter::NoHyphenation)
        .wrap_algorithm(WrapAlgorithm::FirstFit);
    let lines: Vec<String> = text.split('\n').map(|line| textwrap::fill(line, &options)).collect();
    lines.join("\n")
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
    fn colours_take_no_columns() {
        assert_eq!(wrapped("\x1b[1mbold\x1b[0m text", 9), "\x1b[1mbold\x1b[0m text");
    }
}

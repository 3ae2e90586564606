//! Long lines of text broken between words.

/// Columns by which a line that goes on is indented.
const INDENT: usize = 4;

/// The text with every line of more than `width` columns broken at spaces; what goes on is indented.
/// Lines that fit, tables among them, stay as they are, and so does a word that is too long by itself.
pub(super) fn wrapped(text: &str, width: usize) -> String {
    let lines: Vec<String> = text.split('\n').map(|line| broken(line, width)).collect();
    lines.join("\n")
}

fn broken(line: &str, width: usize) -> String {
    if columns(line) <= width {
        return line.to_owned();
    }
    let mut text = String::new();
    let mut used = 0;
    for word in line.split(' ') {
        let size = columns(word);
        if used > INDENT && used + 1 + size > width {
            text.truncate(text.trim_end_matches(' ').len());
            text.push('\n');
            text += &" ".repeat(INDENT);
            used = INDENT;
        } else if !text.is_empty() {
            text.push(' ');
            used += 1;
        }
        text += word;
        used += size;
    }
    text
}

/// Columns of a text on a terminal, escape sequences for colours left out.
fn columns(text: &str) -> usize {
    let mut escaped = false;
    let visible = text.chars().filter(|&c| {
        let begins = c == '\x1b';
        let shown = !(escaped || begins);
        escaped = begins || (escaped && c != 'm');
        shown
    });
    visible.count()
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

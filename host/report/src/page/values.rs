//! Sentences as HTML.

use std::fmt;

use askama::filters::{Escaper, Html, HtmlSafe};

use crate::typography::with_minus_signs;

/// A sentence in the words of the program, as HTML: with a capital, a full stop and minus signs, and what stands
/// between backticks as code. Everything else in it is text.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Sentence(pub String);

impl HtmlSafe for Sentence {}

impl fmt::Display for Sentence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = capitalised(self.0.trim_end()).replace(" %", "\u{a0}%");
        let parts: Vec<&str> = text.split('`').collect();
        f.write_str("<bdi>")?;
        for (place, part) in parts.iter().enumerate() {
            let opens = place % 2 == 1;
            // A backtick without a partner is text.
            let is_code = opens && place + 1 < parts.len();
            f.write_str(if is_code {
                "<code>"
            } else if opens {
                "`"
            } else {
                ""
            })?;
            let part = if is_code { (*part).to_owned() } else { with_minus_signs(part) };
            Html.write_escaped_str(&mut *f, &part)?;
            f.write_str(if is_code { "</code>" } else { "" })?;
        }
        if !text.is_empty() && !text.ends_with(['.', '!', '?', '…']) {
            f.write_str(".")?;
        }
        f.write_str("</bdi>")
    }
}

/// The text with a capital, unless it begins with a symbol or a name: `c_x`, `test.band_hz`, `h1`.
fn capitalised(text: &str) -> String {
    let first = text.split([' ', ',', ':', ';']).next().unwrap_or_default();
    let is_word =
        first == "a" || (first.len() > 1 && first.chars().all(|c| c.is_lowercase() || c == '-'));
    let mut letters = text.chars();
    match letters.next() {
        Some(letter) if is_word => letter.to_uppercase().chain(letters).collect(),
        _ => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn html(text: &str) -> String {
        Sentence(text.into()).to_string()
    }

    #[test]
    fn a_sentence_has_a_capital_a_full_stop_and_code() {
        let sentence_html = html("a further hit helps by -2 % (`massline --seed -2`)");
        let shown =
            "<bdi>A further hit helps by −2\u{a0}% (<code>massline --seed -2</code>).</bdi>";
        assert_eq!(sentence_html, shown);
        assert_eq!(html("c_x of both differs"), "<bdi>c_x of both differs.</bdi>");
        assert_eq!(html("test.band_hz is too narrow."), "<bdi>test.band_hz is too narrow.</bdi>");
        assert_eq!(html(""), "<bdi></bdi>");
    }

    #[test]
    fn markup_in_a_sentence_is_text() {
        let sentence_html = html("<b>`<i>` & `one");
        assert_eq!(sentence_html, "<bdi>&#60;b&#62;<code>&#60;i&#62;</code> &#38; `one.</bdi>");
    }
}

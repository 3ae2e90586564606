//! Titles and other texts of a result, as long as there is room for.

use crate::export::one_line;

/// Longest text in a picture, characters.
const MOST_IN_PICTURE: usize = 40;

/// The title of a result: what its document says, or the layout's where the document has only its beginning, which is
/// all that a rig has room for.
pub(super) fn whole_title(document: Option<&str>, layout: Option<&str>) -> Option<String> {
    let [document, whole] = [document, layout].map(|title| title.map(one_line));
    match (document, whole) {
        (Some(document), Some(whole)) if whole.starts_with(document.trim_end()) => Some(whole),
        (document, whole) => document.or(whole),
    }
}

/// Text of a file as a picture shows it: in one line, and not too long.
pub fn shorten_for_picture(words: &str) -> String {
    shortened(&one_line(words), MOST_IN_PICTURE)
}

/// A text of at most so many characters; one that is cut ends with an ellipsis.
pub fn shortened(text: &str, most: usize) -> String {
    match text.char_indices().nth(most) {
        Some((end, _)) => format!("{}…", text[..end].trim_end()),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_beginning_of_a_title_gives_way_to_the_whole() {
        let whole = "three-bar frame, twelve hits, second day, after the repair of node 3";
        let title = |document, layout| whole_title(document, layout).unwrap_or_default();
        assert_eq!(title(Some(&whole[..48]), Some(whole)), whole);
        assert_eq!(title(Some("another"), Some(whole)), "another");
        assert_eq!(title(Some("another"), None), "another");
        assert_eq!(title(None, Some(whole)), whole);
        assert_eq!(shortened(whole, 40), "three-bar frame, twelve hits, second day…");
    }
}

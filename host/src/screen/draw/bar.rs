//! The first line: what it is, and on the right how far it is.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::text::Span;
use ratatui::widgets::Paragraph;

use crate::screen::Theme;

/// Draws both, and cuts the title where they do not fit beside each other.
pub(super) fn bar([title, right]: [&str; 2], frame: &mut Frame<'_>, area: Rect, theme: Theme) {
    let right = format!(" {right} ");
    let width = u16::try_from(columns(&right)).unwrap_or(area.width);
    let [left, end] =
        Layout::horizontal([Constraint::Min(0), Constraint::Length(width)]).areas(area);
    let title = cut(title, usize::from(left.width).saturating_sub(1));
    frame.render_widget(Paragraph::new(format!(" {title}")).style(theme.bar()), left);
    frame.render_widget(Paragraph::new(right).style(theme.bar()), end);
}

/// The text in at most this many columns, with `…` where it was cut.
fn cut(text: &str, room: usize) -> String {
    if columns(text) <= room {
        return text.into();
    }
    let ends = text.char_indices().map(|(end, _)| end);
    let fits = ends.take_while(|&end| columns(&text[..end]) < room).last().unwrap_or(0);
    format!("{}…", &text[..fits])
}

/// Columns that a text takes on the terminal: two for each character of a wide script.
pub(super) fn columns(text: &str) -> usize {
    Span::raw(text).width()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_cut_by_its_columns_and_never_within_a_wide_character() {
        assert_eq!(cut("frame", 5), "frame");
        assert_eq!(cut("frames", 5), "fram…");
        assert_eq!(cut("試験体", 6), "試験体");
        assert_eq!(cut("試験体", 5), "試験…");
        assert_eq!(cut("試験体", 4), "試…");
    }
}

//! What is shown where there is no room for the full view: words, the most important first, and the keys.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::Line;
use ratatui::widgets::Paragraph;

use super::keys;
use crate::screen::Theme;

/// The lines of a small terminal.
pub(super) struct SmallView {
    /// Where the words are.
    words: Rect,
    /// The last line, except on a terminal of one line.
    keys: Rect,
    lines: Vec<Line<'static>>,
}

impl SmallView {
    /// An empty view of this size.
    pub(super) fn new(area: Rect) -> Self {
        let keys = area.height.min(2) / 2;
        let words = Rect { height: area.height - keys, ..area };
        let keys = Rect { y: area.y + words.height, height: keys, ..area };
        Self { words, keys, lines: Vec::new() }
    }

    /// Adds a text, as far as there is room.
    pub(super) fn text(&mut self, text: &str, style: Style) {
        let room = self.room();
        self.lines.extend(self.wrapped(text, style).into_iter().take(room));
    }

    /// Adds a text whose end matters most.
    pub(super) fn text_to_its_end(&mut self, text: &str, style: Style) {
        let mut lines = self.wrapped(text, style);
        self.lines.extend(lines.split_off(lines.len().saturating_sub(self.room())));
    }

    /// Draws the texts and the keys. If there is room, a line says from which size on there is more to see.
    pub(super) fn draw(
        mut self,
        full: [u16; 2],
        shown: &[&str],
        frame: &mut Frame<'_>,
        theme: Theme,
    ) {
        let [width, height] = full;
        let hint = format!("enlarge the window to {width} × {height} for the full view");
        let hint = self.wrapped(&hint, theme.faint());
        if hint.len() <= self.room() {
            self.lines.extend(hint);
        }
        frame.render_widget(Paragraph::new(self.lines), self.words);
        keys::line(shown, frame, self.keys, theme);
    }

    fn room(&self) -> usize {
        usize::from(self.words.height).saturating_sub(self.lines.len())
    }

    fn wrapped(&self, text: &str, style: Style) -> Vec<Line<'static>> {
        let lines = textwrap::wrap(text, usize::from(self.words.width.max(1)));
        let lines = lines.into_iter().filter(|line| !line.is_empty());
        lines.map(|line| Line::styled(line.into_owned(), style)).collect()
    }
}

use ratatui::Terminal;
use ratatui::backend::TestBackend;

use super::*;
use crate::output::harmless;
use crate::screen::guide::tests::{ALL, layout};

/// What is on a terminal of this size.
fn shown(guide: &Guide, [width, height]: [u16; 2]) -> String {
    let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
    terminal.draw(|frame| guide.draw(frame, Theme { color: true })).unwrap();
    terminal.backend().to_string()
}

#[test]
fn titles_are_text_at_every_size() {
    let layout = layout().cast().unwrap();
    let long = "long ".repeat(820);
    for title in ["<script>alert(1)</script>", "\u{202e}abc\u{1b}[2J", &long] {
        let title = harmless(title);
        let mut guide = Guide::new(&title, "measurement", &layout, 12, ALL);
        for size in [[1, 1], [40, 10], [60, 18], [80, 24], [200, 40], [200, 60]] {
            for help in [false, true] {
                guide.pages.help = help;
                let screen = shown(&guide, size);
                assert!(!screen.contains(['\u{202e}', '\u{1b}']), "{screen}");
                let begin: String = title.chars().take(8).collect();
                assert!(size[0] < 60 || screen.contains(&begin), "{screen}");
            }
        }
    }
}

//! The keys.

use massline_shared::measurement::campaign::Phase;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};

use super::framed;
use crate::screen::Theme;
use crate::screen::guide::Guide;

/// Every key with what it does.
const KEYS: [(&str, &str); 11] = [
    ("a  Enter", "accept the hit that waits for a verdict"),
    ("r  Backspace", "reject it"),
    ("u", "undo the last accepted hit, until the next hit, even a bad one"),
    ("d", "redo the DOF: its hits are discarded"),
    ("s", "skip the DOF"),
    ("f", "finish the DOF with the hits that it has"),
    ("y  n", "answer the question at the target"),
    ("p  Ctrl-C", "pause and leave; the same command goes on"),
    ("q q", "abort: every hit of the campaign is discarded"),
    ("Tab  ← →", "another page: hit, spectra, estimate"),
    ("?", "this page"),
];

/// The last line: the keys of the moment.
pub(super) fn line(guide: &Guide, frame: &mut Frame<'_>, area: Rect, theme: Theme) {
    let keys: &[&str] = match guide.phase() {
        _ if guide.pages.help => {
            let text = Paragraph::new(" ? back  p pause").style(theme.bar());
            return frame.render_widget(text, area);
        }
        Some(Phase::Confirming) if guide.wanted.verdicts => {
            &["a accept", "r reject", "d redo", "p pause", "? help"]
        }
        Some(Phase::TargetReached) => &["y finish", "n go on", "p pause", "? help"],
        Some(Phase::Solving | Phase::Done) => &["? help"],
        _ => &["u undo", "d redo", "s skip", "f finish", "p pause", "q abort", "? help"],
    };
    let text = format!(" {}  Tab page", keys.join("  "));
    frame.render_widget(Paragraph::new(text).style(theme.bar()), area);
}

/// All keys.
pub(super) fn help(guide: &Guide, frame: &mut Frame<'_>, area: Rect, theme: Theme) {
    let mut lines: Vec<Line<'_>> = KEYS
        .iter()
        .map(|(key, does)| {
            Line::from(vec![Span::styled(format!("{key:13}"), theme.strong()), Span::raw(*does)])
        })
        .collect();
    lines.push(Line::raw(""));
    lines.push(Line::raw(
        "If the cable comes off or this program ends, nothing is lost: the same command goes on. A rig that loses power \
         keeps the DOFs that are finished.",
    ));
    if let Some(note) = &guide.note {
        lines.push(Line::raw(""));
        lines.push(Line::raw(note.as_str()));
    }
    let text = Paragraph::new(lines).block(framed(" keys ", theme)).wrap(Wrap { trim: false });
    frame.render_widget(text, area);
}

//! The keys.

use massline_shared::measurement::campaign::Phase;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::text::Line;
use ratatui::widgets::Paragraph;
use textwrap::Options;

use super::bar::columns;
use super::framed;
use crate::screen::Theme;
use crate::screen::guide::Guide;

/// Every key with what it does.
const KEYS: [(&str, &str); 11] = [
    ("a  Enter", "accept the hit that awaits your verdict"),
    ("r  Backspace", "reject it"),
    (
        "u",
        "undo the last accepted hit, even if it finished a DOF, until the next hit of any kind; not the test's last \
         hit",
    ),
    ("d", "redo the DOF: its hits are discarded"),
    ("s", "skip the DOF"),
    ("f", "finish the DOF with the hits it has"),
    ("y  n", "answer the question at the target"),
    ("p  Ctrl-C", "pause and leave; the same command resumes"),
    ("q q", "abort: all hits are discarded"),
    ("Tab  ← →", "turn the page: hit, spectra, estimate"),
    ("?", "this page"),
];

/// What is said below the keys.
const SAFE: &str = "Nothing is lost if the cable comes off or this program ends: the same command resumes. A rig that \
                    loses power keeps the DOFs that are finished.";

/// Width of the keys before what they do, and from which width on they stand in a column of their own.
const COLUMN: usize = 13;
const WIDE_ENOUGH: u16 = 40;

/// The keys of the moment, the most important first.
pub(super) fn of(guide: &Guide) -> &'static [&'static str] {
    match guide.phase() {
        _ if guide.pages.help => &["? back", "p pause"],
        Some(Phase::Confirming) if guide.wanted.verdicts => {
            &["a accept", "r reject", "p pause", "d redo", "? help", "Tab page"]
        }
        Some(Phase::TargetReached) => &["y finish", "n go on", "p pause", "? help", "Tab page"],
        Some(Phase::Solving | Phase::Done) => &["? help", "Tab page"],
        _ => {
            &["p pause", "q abort", "? help", "Tab page", "u undo", "d redo", "f finish", "s skip"]
        }
    }
}

/// The last line: those of these keys that fit.
pub(super) fn line(keys: &[&str], frame: &mut Frame<'_>, area: Rect, theme: Theme) {
    let mut text = String::new();
    for key in keys {
        let gap = if text.is_empty() { " " } else { "  " };
        if columns(&text) + gap.len() + columns(key) <= area.width.into() {
            text.extend([gap, key]);
        }
    }
    frame.render_widget(Paragraph::new(text).style(theme.bar()), area);
}

/// All keys, as far as there is room.
pub(super) fn help(frame: &mut Frame<'_>, area: Rect, theme: Theme) {
    let block = framed(" keys ", theme);
    let mut lines = explained(area.width.saturating_sub(2));
    if lines.len() + 2 <= area.height.into() {
        return frame.render_widget(Paragraph::new(lines).block(block), area);
    }
    lines = explained(area.width);
    frame.render_widget(Paragraph::new(lines), area);
}

/// Keys, each with what it does, in lines of this width.
fn explained(width: u16) -> Vec<Line<'static>> {
    let column = if width < WIDE_ENOUGH { 0 } else { COLUMN };
    let explain = |(key, does): &(&str, &str)| {
        let text = format!("{key:column$} {does}");
        let indent = " ".repeat(column + 1);
        textwrap::wrap(&text, Options::new(width.into()).subsequent_indent(&indent))
            .into_iter()
            .map(|line| Line::from(line.into_owned()))
            .collect::<Vec<_>>()
    };
    let mut lines: Vec<Line<'static>> = KEYS.iter().flat_map(explain).collect();
    lines.extend(
        textwrap::wrap(SAFE, usize::from(width))
            .into_iter()
            .map(|line| Line::from(line.into_owned())),
    );
    lines
}

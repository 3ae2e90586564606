//! How a tumble test looks: the six positions, and the sensors as they lie.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};

use massline_shared::calibration::tumble::Position;

use super::{framed, large};
use crate::screen::Theme;
use crate::screen::positions::{Lying, Positions, in_words, lies_as};

/// Everything.
pub(super) fn all(view: &Positions, frame: &mut Frame<'_>, theme: Theme) {
    let rows = [1, 4, 2, 8, 6].map(Constraint::Length);
    let [title, name, words, table, sensors, note, keys] =
        Layout::vertical(rows.into_iter().chain([Constraint::Min(1), Constraint::Length(1)]))
            .areas(frame.area());
    let read = Position::ALL.len() - view.wanted.len();
    let head = format!(" tumble test: {read} of {} positions read", Position::ALL.len());
    frame.render_widget(Paragraph::new(head).style(theme.bar()), title);
    if let Some(now) = view.now {
        large(&now.to_string(), frame, name, theme);
        let what = Paragraph::new(what_to_do(view, now)).style(theme.strong()).centered();
        frame.render_widget(what.wrap(Wrap { trim: true }), words);
    }
    positions(view, frame, table, theme);
    lying(view, frame, sensors, theme);
    let text = Paragraph::new(view.note.as_str()).style(theme.bad()).wrap(Wrap { trim: true });
    frame.render_widget(text, note);
    let text = " Enter read  p pause: what has been read is kept";
    frame.render_widget(Paragraph::new(text).style(theme.bar()), keys);
}

fn what_to_do(view: &Positions, now: Position) -> String {
    if view.reading { "reading: do not touch it".into() } else { in_words(now) }
}

fn positions(view: &Positions, frame: &mut Frame<'_>, area: Rect, theme: Theme) {
    let line = |position: Position| {
        let (word, style) = match () {
            () if !view.wanted.contains(&position) => ("read", theme.good()),
            () if view.now == Some(position) => ("now", theme.accent()),
            () => ("to do", theme.faint()),
        };
        Line::from(Span::styled(format!("{position}  {word}"), style))
    };
    let lines: Vec<Line<'_>> = Position::ALL.into_iter().map(line).collect();
    frame.render_widget(Paragraph::new(lines).block(framed(" positions ", theme)), area);
}

/// What the sensors read, and as which position they lie.
fn lying(view: &Positions, frame: &mut Frame<'_>, area: Rect, theme: Theme) {
    let lines = view.lies.iter().zip(1..).map(|(Lying { reads, moves }, number)| {
        let [x, y, z] = [reads.x, reads.y, reads.z];
        let numbers = format!("sensor {number}: x {x:+.2}  y {y:+.2}  z {z:+.2} g  ");
        let (word, style) = match lies_as(reads) {
            _ if *moves => ("moves".into(), theme.bad()),
            _ if !view.is_calibrated => ("at rest".into(), theme.good()),
            Some(lies) if Some(lies) == view.now => {
                (format!("lies as {lies}, as wanted"), theme.good())
            }
            Some(lies) => (format!("lies as {lies}"), theme.bad()),
            None => ("is held askew".into(), theme.bad()),
        };
        Line::from(vec![Span::raw(numbers), Span::styled(word, style)])
    });
    let text = Paragraph::new(lines.collect::<Vec<_>>());
    frame.render_widget(text.block(framed(" as they lie now ", theme)), area);
}

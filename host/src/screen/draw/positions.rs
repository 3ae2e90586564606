//! How a tumble test looks: the six positions, and the orientation of the sensors at the moment.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};

use massline_shared::calibration::tumble::Position;
use massline_shared::layout::AXIS_LETTERS;

use super::small::SmallView;
use super::{framed, keys, large};
use crate::screen::Theme;
use crate::screen::positions::{Positions, SensorOrientation, briefly, in_words};
use massline_analysis::calibration::orientation::lies_as;

/// From this size on, everything is shown.
const FULL: [u16; 2] = [64, 23];
/// From this height on, the readings are bars as well.
const TALL: u16 = 32;
/// Width of the name and the number of a reading.
const NUMBER: u16 = 9;
/// The keys, the most important first.
const KEYS: [&str; 3] = ["Enter read", "p pause", "(positions already read are kept)"];

/// Everything, or on a small terminal the words.
pub(super) fn all(view: &Positions, frame: &mut Frame<'_>, theme: Theme) {
    let area = frame.area();
    if area.width < FULL[0] || area.height < FULL[1] {
        return small(view, frame, theme);
    }
    let of_sensor = if area.height < TALL { 1 } else { 4 };
    let sensors = 2 + of_sensor * view.lies.len().max(3) as u16;
    let rows = [1, 4, 2, 8, sensors].map(Constraint::Length);
    let [title, name, words, table, sensors, note, keys] =
        Layout::vertical(rows.into_iter().chain([Constraint::Min(1), Constraint::Length(1)]))
            .areas(area);
    let head = format!(" tumble test: {}", progress(view));
    frame.render_widget(Paragraph::new(head).style(theme.bar()), title);
    if let Some(now) = view.now {
        large::draw(&now.to_string(), frame, name, theme);
        let instruction =
            Paragraph::new(what_to_do(view, in_words(now))).style(theme.strong()).centered();
        frame.render_widget(instruction.wrap(Wrap { trim: true }), words);
    }
    positions(view, frame, table, theme);
    orientations(view, frame, sensors, theme);
    let text = Paragraph::new(view.note.as_str()).style(theme.bad()).wrap(Wrap { trim: true });
    frame.render_widget(text, note);
    keys::line(&KEYS, frame, keys, theme);
}

/// A terminal without room for more than words.
fn small(view: &Positions, frame: &mut Frame<'_>, theme: Theme) {
    let mut small = SmallView::new(frame.area());
    if let Some(now) = view.now {
        small.text(&what_to_do(view, briefly(now)), theme.accent());
    }
    small.text(&view.note, theme.bad());
    for (lying, number) in view.lies.iter().zip(1..) {
        let (word, style) = orientation(view, lying, theme);
        small.text(&format!("sensor {number}: {word}"), style);
    }
    small.text(&progress(view), Style::new());
    small.draw(FULL, &KEYS, frame, theme);
}

/// `2 of 6 positions read`.
fn progress(view: &Positions) -> String {
    let total = Position::ALL.len();
    format!("{} of {total} positions read", total - view.wanted.len())
}

/// The position asked for, in these words, until it is read.
fn what_to_do(view: &Positions, asked: String) -> String {
    if view.reading { "reading: do not touch the block".into() } else { asked }
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

/// What the sensors read, and their orientation.
fn orientations(view: &Positions, frame: &mut Frame<'_>, area: Rect, theme: Theme) {
    let block = framed(" current orientation ", theme);
    let room = block.inner(area).width.saturating_sub(NUMBER);
    let are_bars = frame.area().height >= TALL;
    let mut lines = Vec::new();
    for (lying, number) in view.lies.iter().zip(1..) {
        let axes = AXIS_LETTERS.iter().zip(lying.reads.iter().copied());
        let (word, style) = orientation(view, lying, theme);
        let word = Span::styled(word, style);
        if are_bars {
            lines.push(Line::from(vec![Span::raw(format!("sensor {number}, g: ")), word]));
            lines.extend(axes.map(|(letter, reads)| {
                let number = Span::raw(format!("  {letter} {reads:+.2} "));
                Line::from(vec![number, Span::styled(bar(reads, room), theme.accent())])
            }));
        } else {
            let axes = axes.map(|(letter, reads)| format!("{letter} {reads:+.2}"));
            let numbers = format!("sensor {number}: {} g  ", axes.collect::<Vec<_>>().join("  "));
            lines.push(Line::from(vec![Span::raw(numbers), word]));
        }
    }
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

/// A reading as a bar from the middle of this room: to its ends for 1 g either way.
fn bar(reads: f64, room: u16) -> String {
    let half = usize::from(room.saturating_sub(1) / 2);
    let full = (reads.abs().min(1.0) * half as f64).round() as usize;
    let (bar, rest, none) = ("█".repeat(full), "·".repeat(half - full), "·".repeat(half));
    if reads < 0.0 { format!("{rest}{bar}│{none}") } else { format!("{none}│{bar}{rest}") }
}

/// The orientation of a sensor in a few words.
fn orientation(
    view: &Positions,
    SensorOrientation { reads, moves }: &SensorOrientation,
    theme: Theme,
) -> (String, Style) {
    match lies_as(reads) {
        _ if *moves => ("moving".into(), theme.bad()),
        _ if !view.is_calibrated => ("at rest".into(), theme.good()),
        Some(lies) if Some(lies) == view.now => (format!("{lies}, correct"), theme.good()),
        Some(lies) => (format!("{lies}, turn it"), theme.bad()),
        None => ("not aligned with an axis".into(), theme.bad()),
    }
}

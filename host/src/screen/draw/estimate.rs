//! The ten properties so far, and how their intervals shrink from DOF to DOF.

use massline_shared::design::Widths;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use super::bar::columns;
use super::framed;
use crate::screen::Theme;
use crate::screen::guide::Guide;
use crate::screen::interim::InterimEstimate;
use massline_report::words::two_digits;

/// Width of a property with its interval, and of the name of a width.
const PROPERTY: usize = 22;
const NAME: usize = 8;

/// The estimate after the last DOF.
pub(super) fn estimate(guide: &Guide, frame: &mut Frame<'_>, area: Rect, theme: Theme) {
    let Some(last) = guide.precision.last() else {
        let text =
            Paragraph::new("available after the first DOF").block(framed(" estimate ", theme));
        return frame.render_widget(text.style(theme.faint()), area);
    };
    let title = format!(" 95 % intervals, {} ", last.progress);
    let block = framed(&title, theme);
    let inner = block.inner(area);
    let mut lines = trend(&guide.precision, inner.width.into(), theme);
    let advice = textwrap::wrap(&last.advice, usize::from(inner.width));
    let rows = usize::from(inner.height).saturating_sub(lines.len() + advice.len());
    let cells: Vec<String> = last.properties.iter().map(property).collect();
    // Two properties in a line where all would not fit below each other, and none where even that has no room.
    let beside = (1..=2).find(|beside| {
        let width = (PROPERTY + 1) * beside - 1;
        cells.len().div_ceil(*beside) <= rows && width <= inner.width.into()
    });
    if let Some(beside) = beside {
        lines.extend(cells.chunks(beside).map(|row| Line::raw(row.join(" "))));
    }
    lines.extend(advice.into_iter().map(|line| Line::raw(line.into_owned())));
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

fn property([name, value, half, unit]: &[String; 4]) -> String {
    format!("{name:4}{value:>6} ±{half:<5} {unit:4}")
}

/// The widths after each of the last DOFs, as many as fit.
fn trend(estimates: &[InterimEstimate], room: usize, theme: Theme) -> Vec<Line<'static>> {
    let known: Vec<Widths<f64>> = estimates.iter().filter_map(|estimate| estimate.widths).collect();
    let row = |name: &'static str, unit: &'static str, property: fn(&Widths<f64>) -> f64| {
        let widths: Vec<String> = known.iter().map(|widths| two_digits(property(widths))).collect();
        let since = |first: usize| format!("±{} {unit}", widths[first..].join(" → "));
        let fits = |text: &String| NAME + columns(text) <= room;
        let text = (0..widths.len()).map(since).find(fits).unwrap_or_default();
        Line::from(vec![Span::styled(format!("{name:NAME$}"), theme.strong()), Span::raw(text)])
    };
    if known.is_empty() {
        return Vec::new();
    }
    vec![
        row("mass", "%", |widths| 100.0 * widths.mass),
        row("centre", "mm", |widths| 1e3 * widths.center),
        row("inertia", "% of m L²", |widths| 100.0 * widths.inertia),
    ]
}

//! The ten properties so far, and how their intervals shrink from DOF to DOF.

use massline_shared::design::Widths;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};

use super::framed;
use crate::report::two_digits;
use crate::screen::Theme;
use crate::screen::guide::Guide;
use crate::screen::interim::InterimEstimate;

/// Estimates of which the widths are shown.
const SHOWN: usize = 6;

/// The estimate after the last DOF.
pub(super) fn estimate(guide: &Guide, frame: &mut Frame<'_>, area: Rect, theme: Theme) {
    let Some(last) = guide.precision.last() else {
        let text = Paragraph::new("after the first DOF").block(framed(" estimate ", theme));
        return frame.render_widget(text.style(theme.faint()), area);
    };
    let title = format!(" after {}, 95 % intervals ", last.progress);
    let trend = trend(&guide.precision, theme);
    let advice = last.advice.lines().map(Line::raw);
    // Two properties in a line where all would not fit below each other.
    let wrapped = 2 + last.advice.len() / usize::from(area.width.max(1));
    let rows = usize::from(area.height.saturating_sub(2)).saturating_sub(trend.len() + wrapped);
    let columns = if rows >= last.properties.len() { 1 } else { 2 };
    let mut lines = trend;
    for row in last.properties.chunks(columns) {
        lines.push(Line::raw(row.iter().map(property).collect::<Vec<_>>().join(" ")));
    }
    lines.extend(advice);
    let text = Paragraph::new(lines).block(framed(&title, theme)).wrap(Wrap { trim: false });
    frame.render_widget(text, area);
}

fn property([name, value, half, unit]: &[String; 4]) -> String {
    format!("{name:4}{value:>6} ±{half:<5} {unit:4}")
}

/// The widths after each of the last DOFs.
fn trend(estimates: &[InterimEstimate], theme: Theme) -> Vec<Line<'static>> {
    let known: Vec<Widths<f64>> = estimates.iter().filter_map(|estimate| estimate.widths).collect();
    let known = &known[known.len().saturating_sub(SHOWN)..];
    let row = |name: &'static str, unit: &'static str, of: fn(&Widths<f64>) -> f64| {
        let widths: Vec<String> = known.iter().map(|widths| two_digits(of(widths))).collect();
        Line::from(vec![
            Span::styled(format!("{name:8}"), theme.strong()),
            Span::raw(format!("±{} {unit}", widths.join(" → "))),
        ])
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

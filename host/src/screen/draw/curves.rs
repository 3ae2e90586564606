//! How curves are drawn: in a frame, over one axis, each of them told from the others with and without colours.

use std::borrow::Cow;

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Axis, Chart, Dataset, GraphType};

use super::framed;
use crate::screen::Theme;

/// Fewest rows of a plot: its frame, the axis with its numbers, and two rows of curves.
const LOWEST: u16 = 6;
/// From this width on a plot shows a curve well, and from this height on.
const WIDE: u16 = 50;
const TALL: u16 = 12;
/// Columns and rows for each number beside an axis.
const APART: [u16; 2] = [20, 5];

/// Curves over one axis.
pub(super) struct Curves<'a> {
    /// With both units.
    pub title: &'a str,
    pub names: Vec<String>,
    pub points: Vec<Vec<(f64, f64)>>,
    /// Limits of the axes; those of the values where none are given.
    pub x: [f64; 2],
    pub y: Option<[f64; 2]>,
}

/// Places of two plots: beside each other in an area that is wide and low, else one above the other, the upper with
/// this share of the rows in percent. Where there is room for one only, the second is empty.
pub(super) fn pair(area: Rect, upper: u16) -> [Rect; 2] {
    if area.width >= 2 * WIDE && area.height < 2 * TALL {
        return Layout::horizontal([Constraint::Fill(1); 2]).areas(area);
    }
    if area.height < 2 * LOWEST {
        return [area, Rect { height: 0, ..area }];
    }
    Layout::vertical([Constraint::Percentage(upper), Constraint::Min(LOWEST)]).areas(area)
}

/// Draws curves in a frame.
pub(super) fn plot(curves: &Curves<'_>, frame: &mut Frame<'_>, area: Rect, theme: Theme) {
    let values = || curves.points.iter().flatten().map(|(_, value)| *value);
    let y = curves.y.unwrap_or_else(|| {
        let low = values().fold(0.0, f64::min);
        let high = values().fold(0.0, f64::max);
        let margin = 0.05 * (high - low).max(1e-9);
        [low - margin, high + margin]
    });
    let points = curves.points.iter().enumerate();
    let points: Vec<Cow<'_, [(f64, f64)]>> = points
        .map(|(place, points)| match drawn_as(place, theme) {
            (_, GraphType::Scatter, _) => Cow::Owned(thinned(points, curves.x, place, area.width)),
            _ => Cow::Borrowed(points.as_slice()),
        })
        .collect();
    let sets = points.iter().enumerate().map(|(place, points)| {
        let (marker, kind, _) = drawn_as(place, theme);
        let set = Dataset::default().marker(marker).graph_type(kind);
        set.style(theme.curve(place)).data(points)
    });
    let axis = |limits: [f64; 2], numbers: u16| {
        Axis::default().style(theme.faint()).bounds(limits).labels(labels(limits, numbers))
    };
    let [across, up] = [area.width / APART[0], area.height / APART[1]];
    let mut block = framed(curves.title, theme);
    if curves.points.len() > 1 {
        block = block.title_bottom(legend(&curves.names, theme));
    }
    let chart =
        Chart::new(sets.collect()).block(block).x_axis(axis(curves.x, across)).y_axis(axis(y, up));
    frame.render_widget(chart.legend_position(None), area);
}

/// The names of the curves in their colours; without colours, with their markers.
fn legend(names: &[String], theme: Theme) -> Line<'static> {
    let name = |(place, name): (usize, &String)| {
        let (_, _, sign) = drawn_as(place, theme);
        Span::styled(format!(" {sign}{name} "), theme.curve(place))
    };
    Line::from_iter(names.iter().enumerate().map(name))
}

/// Marker and kind of the curve at this place, and its sign in the legend. Without colours, only the first is a line:
/// lines of whole cells would hide each other.
fn drawn_as(place: usize, theme: Theme) -> (Marker, GraphType, &'static str) {
    match place {
        _ if theme.color => (Marker::Braille, GraphType::Line, ""),
        0 => (Marker::Braille, GraphType::Line, "⠒ "),
        1 => (Marker::Dot, GraphType::Scatter, "• "),
        _ => (Marker::Custom('+'), GraphType::Scatter, "+ "),
    }
}

/// Points of a curve in every sixth column, each curve in others: the rest of the cells is left to the curves below.
fn thinned(
    points: &[(f64, f64)],
    [from, to]: [f64; 2],
    place: usize,
    columns: u16,
) -> Vec<(f64, f64)> {
    let apart = 6.0 * (to - from) / f64::from(columns.max(1));
    let first = from + apart * place as f64 / 3.0;
    let wanted = (0..columns / 6).map(|step| first + apart * f64::from(step));
    wanted.filter_map(|x| points.get(points.partition_point(|(at, _)| *at < x)).copied()).collect()
}

/// So many numbers along an axis, at least those at its ends.
fn labels([from, to]: [f64; 2], numbers: u16) -> Vec<String> {
    let last = f64::from(numbers.max(2) - 1);
    (0..numbers.max(2)).map(|k| label(from + (to - from) * f64::from(k) / last)).collect()
}

/// A number beside an axis.
fn label(value: f64) -> String {
    match value.abs() {
        size if size >= 100.0 => format!("{value:.0}"),
        size if size >= 1.0 => format!("{value:.1}"),
        _ => format!("{value:.2}"),
    }
}

//! Frequency responses and coherence of the DOF in hand, as they build up; and how curves are drawn.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Axis, Chart, Dataset, GraphType, Paragraph};

use super::framed;
use crate::client::DofSpectra;
use crate::screen::Theme;
use crate::screen::guide::Guide;

/// Decades of an accelerance that are shown.
const DECADES: f64 = 3.0;

/// Magnitudes and the smallest coherence of the strongest responses.
pub(super) fn spectra(guide: &Guide, frame: &mut Frame<'_>, area: Rect, theme: Theme) {
    let Some(spectra) = &guide.spectra else {
        let text = Paragraph::new("no accepted hit at this DOF yet");
        let text = text.block(framed(" spectra ", theme)).style(theme.faint());
        return frame.render_widget(text, area);
    };
    let band = guide.layout.test.expected_band().map(f64::from);
    let x = [0.0, 1.5 * band[1]];
    let shown = strongest(spectra, 3 * guide.layout.sensors.len(), band);
    let [upper, lower] = Layout::vertical([Constraint::Fill(3), Constraint::Fill(2)]).areas(area);
    let names: Vec<String> = shown.iter().map(|(k, _)| guide.response(*k)).collect();
    let hits = if spectra.hits == 1 { "1 hit".into() } else { format!("{} hits", spectra.hits) };
    let title = format!(" {}, {hits}: log (m/s²)/N over Hz ", guide.name(spectra.dof));
    let top = shown.iter().map(|(_, strength)| *strength).fold(f64::MIN_POSITIVE, f64::max).log10();
    let curves = Curves {
        title: &title,
        names: names.clone(),
        points: shown.iter().map(|(k, _)| magnitude(spectra, *k, x)).collect(),
        x,
        y: Some([top - DECADES, top + 1.0]),
    };
    plot(&curves, frame, upper, theme);
    let title = if spectra.hits < 2 {
        " coherence: from the second hit on "
    } else {
        " coherence over Hz "
    };
    let coherences = shown.iter().map(|(k, _)| coherence(spectra, *k, x));
    let curves = Curves {
        title,
        names,
        points: if spectra.hits < 2 { Vec::new() } else { coherences.collect() },
        x,
        y: Some([0.0, 1.0]),
    };
    plot(&curves, frame, lower, theme);
}

/// The three responses with the largest mean magnitude in the band, and that magnitude.
fn strongest(spectra: &DofSpectra, responses: usize, band: [f64; 2]) -> Vec<(usize, f64)> {
    let strength = |response: usize| {
        let lines = spectra.h1(response)?;
        let of_band = lines
            .iter()
            .enumerate()
            .filter(|(line, _)| (band[0]..=band[1]).contains(&spectra.frequency(*line)))
            .map(|(_, value)| value.norm());
        let (sum, count) = of_band.fold((0.0, 0), |(sum, count), value| (sum + value, count + 1));
        (count > 0).then(|| (response, sum / f64::from(count)))
    };
    let mut all: Vec<(usize, f64)> = (0..responses).filter_map(strength).collect();
    all.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    all.truncate(3);
    all
}

fn magnitude(spectra: &DofSpectra, response: usize, [from, to]: [f64; 2]) -> Vec<(f64, f64)> {
    let lines = spectra.h1(response).unwrap_or_default();
    let points =
        lines.iter().enumerate().map(|(line, value)| (spectra.frequency(line), value.norm()));
    let shown =
        points.filter(|(frequency, value)| *value > 0.0 && *frequency > from && *frequency <= to);
    shown.map(|(frequency, value)| (frequency, value.log10())).collect()
}

/// `|G_XF|²/(G_FF G_XX)` line by line.
fn coherence(spectra: &DofSpectra, response: usize, [from, to]: [f64; 2]) -> Vec<(f64, f64)> {
    let (Some(cross), Some(auto)) = (spectra.cross(response), spectra.response_auto(response))
    else {
        return Vec::new();
    };
    let lines = cross.iter().zip(auto).zip(spectra.force_auto()).enumerate();
    let points = lines.filter_map(|(line, ((cross, auto), force))| {
        let product = auto * force;
        let frequency = spectra.frequency(line);
        (product > 0.0 && frequency > from && frequency <= to)
            .then(|| (frequency, (cross.norm_sqr() / product).min(1.0)))
    });
    points.collect()
}

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

/// Draws curves in a frame.
pub(super) fn plot(curves: &Curves<'_>, frame: &mut Frame<'_>, area: Rect, theme: Theme) {
    let values = || curves.points.iter().flatten().map(|(_, value)| *value);
    let y = curves.y.unwrap_or_else(|| {
        let low = values().fold(0.0, f64::min);
        let high = values().fold(0.0, f64::max);
        let margin = 0.05 * (high - low).max(1e-9);
        [low - margin, high + margin]
    });
    let sets =
        curves.points.iter().zip(&curves.names).enumerate().map(|(place, (points, name))| {
            Dataset::default()
                .name(name.clone())
                .marker(Marker::Braille)
                .graph_type(GraphType::Line)
                .style(theme.curve(place))
                .data(points)
        });
    let axis = |limits: [f64; 2]| {
        Axis::default().style(theme.faint()).bounds(limits).labels(limits.map(label))
    };
    // Without colours, curves differ by nothing, so only the first is drawn.
    let sets: Vec<Dataset<'_>> = if theme.color { sets.collect() } else { sets.take(1).collect() };
    let mut title = vec![Span::styled(curves.title, theme.strong())];
    let names = curves.names.iter().take(sets.len()).enumerate();
    if curves.names.len() > 1 {
        title.extend(
            names.map(|(place, name)| Span::styled(format!("{name} "), theme.curve(place))),
        );
    }
    let block = framed("", theme).title(Line::from(title));
    let chart = Chart::new(sets).block(block).x_axis(axis(curves.x)).y_axis(axis(y));
    frame.render_widget(chart.legend_position(None), area);
}

/// A number at the end of an axis.
fn label(value: f64) -> String {
    match value.abs() {
        size if size >= 100.0 => format!("{value:.0}"),
        size if size >= 1.0 => format!("{value:.1}"),
        _ => format!("{value:.2}"),
    }
}

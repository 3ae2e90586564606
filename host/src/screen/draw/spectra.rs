//! Frequency responses and coherence of the DOF in hand, as they build up.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::widgets::Paragraph;

use super::curves::{Curves, pair, plot};
use super::framed;
use super::hit::SLOW;
use crate::screen::Theme;
use crate::screen::guide::Guide;
use massline_files::dof_spectra::DofSpectra;

/// Decades of an accelerance that are shown.
const DECADES: f64 = 3.0;

/// Magnitudes and the smallest coherence of the strongest responses.
pub(super) fn spectra(guide: &Guide, frame: &mut Frame<'_>, area: Rect, theme: Theme) {
    let Some(spectra) = &guide.spectra else {
        let missing = if guide.slow { SLOW } else { "no accepted hit at this DOF yet" };
        let text = Paragraph::new(missing);
        let text = text.block(framed(" spectra ", theme)).style(theme.faint());
        return frame.render_widget(text, area);
    };
    let band = guide.layout.test.expected_band().map(f64::from);
    let x = [0.0, 1.5 * band[1]];
    let shown = strongest(spectra, 3 * guide.layout.sensors.len(), band);
    let [upper, lower] = pair(area, 60);
    let names: Vec<String> = shown.iter().map(|(k, _)| guide.response(*k)).collect();
    let hits = if spectra.hits == 1 { "1 hit".into() } else { format!("{} hits", spectra.hits) };
    let title = format!(" {hits}: log (m/s²)/N over Hz ");
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
        " coherence: available after the second hit "
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
    let mut strengths: Vec<(usize, f64)> = (0..responses).filter_map(strength).collect();
    strengths.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    strengths.truncate(3);
    strengths
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

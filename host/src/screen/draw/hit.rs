//! The last hit: its verdict with the reason, and its force and responses over time.

use massline_shared::layout::TestProfile;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};

use super::curves::{Curves, pair, plot};
use super::framed;
use crate::output::Tone;
use crate::screen::Theme;
use crate::screen::guide::{Guide, HitReadings};
use massline_report::words::swing_words;

/// Rows of the verdict, with its frame.
pub(super) const HEIGHT: u16 = 6;
/// Time that is shown before and after the trigger, s.
const SHOWN: [f64; 2] = [-0.004, 0.026];

/// Instead of what is not read.
pub(super) const SLOW: &str = "the link is slow: read again at the next DOF";

/// Instead of a record that a rig does not give.
const LONG: &str = "the records of 40 s stay on the rig; the spectra show what they give";

/// The verdict on the last hit.
pub(super) fn verdict(guide: &Guide, frame: &mut Frame<'_>, area: Rect, theme: Theme) {
    let block = framed(" last hit ", theme);
    let Some(hit) = &guide.hit else {
        let text = Paragraph::new("none yet").block(block).style(theme.faint());
        return frame.render_widget(text, area);
    };
    let mut numbers = format!(
        "{}: {:.1} N, {:.1} m/s²",
        guide.name(hit.dof),
        hit.peak_force,
        hit.peak_acceleration,
    );
    if let Some(swing) = &hit.swing {
        numbers += &format!(", {}", swing_words(swing));
    }
    let verdict = guide.verdict().map(|verdict| {
        let style = if verdict.tone == Tone::Good { theme.good() } else { theme.bad() };
        Line::from(Span::styled(verdict.to_string(), style))
    });
    let lines: Vec<_> = [Line::raw(numbers)].into_iter().chain(verdict).collect();
    let text = Paragraph::new(lines).block(block).wrap(Wrap { trim: true });
    frame.render_widget(text, area);
}

/// Force and responses of the last hit that was read.
pub(super) fn readings(guide: &Guide, frame: &mut Frame<'_>, area: Rect, theme: Theme) {
    let Some(hit_readings) = &guide.readings else {
        let missing = match guide.layout.test.profile {
            TestProfile::Suspension => LONG,
            TestProfile::MassLine if guide.slow => SLOW,
            TestProfile::MassLine => "no hit read yet",
        };
        let text = Paragraph::new(missing).block(framed(" hit over time ", theme));
        let text = text.wrap(Wrap { trim: true }).style(theme.faint());
        return frame.render_widget(text, area);
    };
    let [force, responses] = pair(area, 50);
    let is_last = guide.hit.as_ref().is_none_or(|hit| hit.number == hit_readings.number);
    let which = if is_last { "" } else { "last hit that was read: " };
    let title = format!(" {which}force, N, over ms ");
    let curves = Curves {
        title: &title,
        names: vec!["force".into()],
        points: vec![points(hit_readings, &hit_readings.readings.force)],
        x: SHOWN.map(|time| 1e3 * time),
        y: None,
    };
    plot(&curves, frame, force, theme);
    let largest = largest(hit_readings, guide.layout.sensors.len());
    let curves = Curves {
        title: " largest responses, m/s², over ms ",
        names: largest.iter().map(|&k| guide.response(k)).collect(),
        points: largest
            .iter()
            .map(|&k| points(hit_readings, &hit_readings.readings.responses[k]))
            .collect(),
        x: SHOWN.map(|time| 1e3 * time),
        y: None,
    };
    plot(&curves, frame, responses, theme);
}

/// Points over time in ms, as far as they are shown.
fn points(hit_readings: &HitReadings, values: &[f64]) -> Vec<(f64, f64)> {
    let [from, to] = SHOWN;
    let timed = values.iter().enumerate().map(|(scan, value)| {
        (scan as f64 * hit_readings.scan_interval_s - hit_readings.pre_trigger_s, *value)
    });
    timed
        .filter(|(time, _)| (from..=to).contains(time))
        .map(|(time, value)| (1e3 * time, value))
        .collect()
}

/// The three responses that move most, the largest first.
fn largest(hit_readings: &HitReadings, sensors: usize) -> Vec<usize> {
    let peak =
        |k: &usize| hit_readings.readings.responses[*k].iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    let mut responses: Vec<usize> =
        (0..hit_readings.readings.responses.len().min(3 * sensors)).collect();
    responses.sort_by(|a, b| peak(b).total_cmp(&peak(a)));
    responses.truncate(3);
    responses
}

//! The self-test: its faults, and what each channel reads at rest.

use massline_shared::signal::self_test::ChannelAtRest;

use super::View;
use super::canvas::{Canvas, Screen, text, top};
use super::lists::finding;
use crate::panel::number::{fitting, fixed};
use crate::panel::self_test::{CHANNELS_PER_PAGE, SelfTestState};
use crate::panel::words;

/// Right edges of the columns of the channels.
const COLUMNS: [i32; 4] = [44, 72, 100, 127];

/// The page at the cursor.
pub(super) fn page<D: Screen>(canvas: &mut Canvas<'_, D>, view: &View<'_>) {
    let state = view.model.self_test;
    let page = usize::from(view.menu.cursor());
    let pages = text(format_args!("{}/{}", page + 1, state.pages()));
    match state {
        SelfTestState::Off => {}
        SelfTestState::Running { percent } => {
            canvas.title("Self-test", &text(format_args!("{percent} %")));
            canvas.big(0, top(1), "Hands off");
            canvas.line(4, "Back: stop");
        }
        SelfTestState::Disturbed => {
            canvas.title("Self-test", "");
            canvas.lines(0, "Stopped: another\nmeasurement began.");
            canvas.line(4, "OK");
        }
        SelfTestState::Done { findings: 0, .. } if page == 0 => {
            canvas.title("Self-test", &pages);
            canvas.lines(1, "No fault found.\n(Checked at rest\nonly.)");
        }
        SelfTestState::Done { findings, .. } => {
            let first = usize::from(findings.max(1));
            match view.findings.get(page) {
                Some(diagnostic) => finding(canvas, diagnostic, None, &pages),
                None => channels(canvas, view.at_rest, page.saturating_sub(first), &pages),
            }
        }
    }
}

/// A page of the channels: level in V, and in mV noise and mains.
fn channels<D: Screen>(
    canvas: &mut Canvas<'_, D>,
    channels: &[ChannelAtRest<f32>],
    page: usize,
    pages: &str,
) {
    canvas.title("At rest", pages);
    row(canvas, 0, "", &["V", "mV", "50Hz", "60Hz"]);
    let first = page * CHANNELS_PER_PAGE;
    let shown = channels.iter().enumerate().skip(first).take(CHANNELS_PER_PAGE);
    for (line, (channel, at_rest)) in (1..).zip(shown) {
        let name = words::short_channel(channel);
        let millivolts = [at_rest.noise, at_rest.hum_50_hz, at_rest.hum_60_hz]
            .map(|volts| fitting(1e3 * volts, 2, 4));
        let [noise, hum_50, hum_60] = &millivolts;
        row(canvas, line, &name, &[&fixed(at_rest.level, 3), noise, hum_50, hum_60]);
    }
}

/// A line of the table.
fn row<D: Screen>(canvas: &mut Canvas<'_, D>, line: usize, name: &str, cells: &[&str; 4]) {
    canvas.line(line, name);
    for (edge, cell) in COLUMNS.into_iter().zip(cells) {
        canvas.text_right(edge, top(line), cell);
    }
}

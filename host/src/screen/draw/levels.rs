//! The signal levels of the channels while the rig waits: a channel without a signal is not connected.

use massline_shared::layout::AXIS_LETTERS;
use massline_shared::signal::{HAMMER, RESPONSES};
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use super::framed;
use crate::screen::Theme;
use crate::screen::guide::Guide;

/// Width of the name of a row with its gap, and of the letter of an axis with its gap.
const NAME: u16 = 8;
const LETTER: u16 = 2;

/// Rows of the bars, with their frame: one for the hammer and each sensor, or on a tall terminal one for each axis.
pub(super) fn height(guide: &Guide, is_tall: bool) -> u16 {
    let sensors = guide.layout.sensors.len().min(RESPONSES / 3) as u16;
    if is_tall { 3 + 3 * sensors } else { 6 }
}

/// A bar for the hammer and each axis of each sensor.
pub(super) fn bars(guide: &Guide, frame: &mut Frame<'_>, area: Rect, theme: Theme) {
    let block = framed(" signal level (bits) ", theme);
    let inner = block.inner(area);
    frame.render_widget(block, area);
    let Some(levels) = &guide.levels else { return };
    let bits = u16::from(guide.bits.max(1));
    let in_a_row = if inner.height < height(guide, true) - 2 { 3 } else { 1 };
    // Each bar has its letter before it and a gap after it.
    let room = (inner.width.saturating_sub(NAME) / in_a_row).saturating_sub(LETTER + 1);
    let name = |name: String| Span::styled(format!("{name:<7} "), theme.strong());
    let bar = |level: u8| {
        let full = (u16::from(level) * room).div_ceil(bits).min(room);
        format!("{}{}", "█".repeat(full.into()), "·".repeat((room - full).into()))
    };
    let mut lines = vec![Line::from(vec![
        name("hammer".into()),
        Span::raw("  "),
        Span::styled(bar(levels[HAMMER]), theme.accent()),
    ])];
    for (place, sensor) in guide.layout.sensors.iter().enumerate().take(RESPONSES / 3) {
        let channels = AXIS_LETTERS.iter().zip(&levels[HAMMER + 1 + 3 * place..]);
        let spans: Vec<_> = channels
            .map(|(letter, level)| {
                let style = if *level == 0 { theme.bad() } else { theme.accent() };
                [Span::raw(format!("{letter} ")), Span::styled(bar(*level), style), Span::raw(" ")]
            })
            .collect();
        for (row, spans) in spans.chunks(in_a_row.into()).enumerate() {
            let of_sensor = if row == 0 { format!("node {}", sensor.node) } else { String::new() };
            lines.push([name(of_sensor)].into_iter().chain(spans.concat()).collect());
        }
    }
    frame.render_widget(Paragraph::new(lines), inner);
}

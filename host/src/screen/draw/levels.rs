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

/// Rows of the bars, with their frame.
pub(super) const HEIGHT: u16 = 6;
/// Width of the name of a row with its gap.
const NAME: u16 = 8;

/// A bar for the hammer and each axis of each sensor.
pub(super) fn bars(guide: &Guide, frame: &mut Frame<'_>, area: Rect, theme: Theme) {
    let block = framed(" signal level (bits) ", theme);
    let inner = block.inner(area);
    frame.render_widget(block, area);
    let Some(levels) = &guide.levels else { return };
    let bits = u16::from(guide.bits.max(1));
    // The name of a row, and then three bars with a letter and a gap each.
    let room = (inner.width.saturating_sub(NAME) / 3).saturating_sub(3);
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
        let mut spans = vec![name(format!("node {}", sensor.node))];
        for (axis, letter) in AXIS_LETTERS.iter().enumerate() {
            let level = levels[HAMMER + 1 + 3 * place + axis];
            let style = if level == 0 { theme.bad() } else { theme.accent() };
            spans.push(Span::raw(format!("{letter} ")));
            spans.push(Span::styled(bar(level), style));
            spans.push(Span::raw(" "));
        }
        lines.push(Line::from(spans));
    }
    frame.render_widget(Paragraph::new(lines), inner);
}

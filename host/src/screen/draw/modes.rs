//! The suspension modes so far, and which point to hit next.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::text::Line;
use ratatui::widgets::Paragraph;

use super::framed;
use crate::screen::Theme;
use crate::screen::guide::Guide;
use massline_report::words::modes_so_far;

/// The modes after the last closed DOF.
pub(super) fn modes(guide: &Guide, frame: &mut Frame<'_>, area: Rect, theme: Theme) {
    let Some(seen) = &guide.modes else {
        let text = Paragraph::new("available after the first DOF").block(framed(" modes ", theme));
        return frame.render_widget(text.style(theme.faint()), area);
    };
    let title = format!(" modes after {}, best hit, Norm Indicator ", modes_so_far::progress(seen));
    let block = framed(&title, theme);
    let advice = modes_so_far::advice(seen);
    let width = usize::from(block.inner(area).width).max(1);
    // The advice comes first: it is what to do, and there may be no room for all.
    let advice = textwrap::wrap(&advice, width).into_iter();
    let mut lines: Vec<_> =
        advice.map(|line| Line::styled(line.into_owned(), theme.accent())).collect();
    lines.extend(modes_so_far::rows(seen).into_iter().map(Line::raw));
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

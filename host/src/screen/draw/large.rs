//! A name in large letters.

use font8x8::{BASIC_FONTS, UnicodeFonts};
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::text::{Line, Text};

use super::super::Theme;

/// A cell by the pixels that are set in it: 1 is its upper left quarter, 2 the upper right, 4 and 8 those below.
const CELLS: [char; 16] =
    [' ', '▘', '▝', '▀', '▖', '▌', '▞', '▛', '▗', '▚', '▐', '▜', '▄', '▙', '▟', '█'];

/// Draws a name in letters of 8 by 8 pixels: half a cell for each pixel if the name fits, else a quarter.
pub(super) fn draw(name: &str, frame: &mut Frame<'_>, area: Rect, theme: Theme) {
    let fits = 8 * name.chars().count() <= usize::from(area.width);
    let rows = if fits { rows::<1>(name) } else { rows::<2>(name) };
    let text = Text::from_iter(rows.map(Line::from)).style(theme.accent()).centered();
    frame.render_widget(text, area);
}

/// The four rows of cells of a name, with one or two pixels side by side in a cell.
fn rows<const PIXELS: usize>(name: &str) -> [String; 4] {
    [0, 2, 4, 6].map(|row| {
        let cells = name.chars().flat_map(|letter| {
            let glyph = BASIC_FONTS.get(letter).unwrap_or_default();
            (0..8).step_by(PIXELS).map(move |column| {
                // A pixel that has the cell's width to itself sets both quarters.
                let quarters = |line: u8| match PIXELS {
                    1 => 3 * (line >> column & 1),
                    _ => line >> column & 3,
                };
                usize::from(quarters(glyph[row]) | quarters(glyph[row + 1]) << 2)
            })
        });
        cells.map(|quarters| CELLS[quarters]).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_letter_is_eight_cells_wide_with_half_cells_and_four_with_quarters() {
        let [half, quarter] = [rows::<1>("1"), rows::<2>("1")];
        assert_eq!(half, [" ▄██    ", "  ██    ", "  ██    ", "▀▀▀▀▀▀  "]);
        assert_eq!(quarter, ["▗█  ", " █  ", " █  ", "▀▀▀ "]);
    }
}

//! The title block of a sheet.

use crate::pen::{Align, Pen};
use crate::source::{DrawnBoard, Parts};

/// Subject and file of each sheet.
pub const FIRST: (usize, &str) = (1, "sensors, hammer, panel");
pub const SECOND: (usize, &str) = (2, "power, cables");

const SIZE: (i32, i32) = (380, 112);

/// Draws the block into the lower right corner.
pub fn title(
    pen: &mut Pen,
    parts: &Parts,
    board: &DrawnBoard,
    (width, height): (i32, i32),
    (sheet, subject): (usize, &str),
) {
    let title = format!("massline on a {} ({})", board.title, board.chip);
    pen.text((40, 42), 20, Align::Left, &title);
    let revision = &parts.revision;
    let (x, y) = (width - SIZE.0 - 24, height - SIZE.1 - 20);
    pen.add(format_args!("<rect x=\"{x}\" y=\"{y}\" width=\"{}\" height=\"{}\"/>", SIZE.0, SIZE.1));
    for line in [1, 2, 3] {
        pen.line(&[(x, y + 28 * line), (x + SIZE.0, y + 28 * line)]);
    }
    let rows = [
        (format!("massline, {}", board.title), format!("sheet {sheet} of 2")),
        (subject.to_owned(), format!("revision {}", revision.name)),
        (revision.state.clone(), revision.date.clone()),
        (format!("licence: {}", revision.licence), board.chip.clone()),
    ];
    for (row, (left, right)) in (0..).zip(rows) {
        pen.text((x + 10, y + 28 * row + 19), 12, Align::Left, &left);
        pen.text((x + SIZE.0 - 10, y + 28 * row + 19), 12, Align::Right, &right);
    }
}

//! A line of known length in a view of space.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{Area, DrawingOutcome, tick, write};
use super::theme::{INK, SMALL};
use super::view::View;

/// Draws the line at the left edge, at this height.
pub(super) fn ruler<B: DrawingBackend>(area: &Area<B>, view: &View, y: i32) -> DrawingOutcome<B> {
    let length = ruler_length(view.scale);
    let end = (length * view.scale).round() as i32;
    area.draw(&PathElement::new([(0, y), (end, y)], INK.stroke_width(3)))?;
    for x in [0, end] {
        area.draw(&PathElement::new([(x, y - 8), (x, y + 8)], INK.stroke_width(3)))?;
    }
    write(area, &ruler_name(length), (end + 16, y), (HPos::Left, VPos::Center), SMALL)
}

/// 1, 2 or 5 times a power of ten, m, that is at most 200 pixels long at this scale, pixels per m.
fn ruler_length(scale: f64) -> f64 {
    let wanted = 200.0 / scale;
    let power = 10_f64.powf(wanted.log10().floor());
    let length = [5.0, 2.0, 1.0].map(|k| k * power).into_iter().find(|l| *l <= wanted);
    length.unwrap_or(power)
}

/// A length, m, with its unit.
fn ruler_name(length: f64) -> String {
    // Rounding may have made a little less of a metre or a millimetre.
    match length {
        _ if length > 0.99 => format!("{} m", tick(length)),
        _ if length > 0.99e-3 => format!("{} mm", tick(1e3 * length)),
        _ => format!("{} µm", tick(1e6 * length)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ruler_has_the_decimals_of_its_length() {
        for (length, name) in
            [(5e-2, "50 mm"), (2e-4, "200 µm"), (1e-3, "1 mm"), (2.0, "2 m"), (5e-7, "0.5 µm")]
        {
            assert_eq!(ruler_name(length), name);
        }
        // An object of 1 mm on 1200 pixels.
        assert_eq!(ruler_name(ruler_length(1.2e6)), "100 µm");
        assert_eq!(ruler_name(ruler_length(200.0)), "1 m");
    }
}

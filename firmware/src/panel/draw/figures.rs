//! A quantity with its standard deviation, on a line.

use massline_shared::body::INERTIAL_PARAMETERS;

use super::canvas::{Canvas, Screen, text, top};
use crate::panel::number::{Text, decimals_for, fitting};

/// Symbol of an inertial parameter, with its subscript on the line.
pub(super) fn symbol(k: usize) -> Text {
    let symbol = INERTIAL_PARAMETERS[k].symbol;
    let (letter, subscript) = symbol.split_once('_').unwrap_or((symbol, ""));
    text(format_args!("{letter}{subscript}"))
}

/// Draws a name, a value, its standard deviation with two significant digits, and a unit.
pub(super) fn quantity<D: Screen>(
    canvas: &mut Canvas<'_, D>,
    line: usize,
    name: &str,
    value: f32,
    sigma: Option<f32>,
    unit: &str,
) {
    let decimals = match sigma {
        Some(sigma) if sigma > 0.0 => decimals_for(sigma, 2),
        _ => decimals_for(value, 4),
    };
    figures(canvas, line, (name, unit), value, sigma, decimals);
}

/// Draws a name, a value with its standard deviation, both with so many decimals, and a unit.
pub(super) fn figures<D: Screen>(
    canvas: &mut Canvas<'_, D>,
    line: usize,
    (name, unit): (&str, &str),
    value: f32,
    sigma: Option<f32>,
    decimals: u8,
) {
    let y = top(line);
    canvas.text(0, y, name);
    canvas.text_right(66, y, &fitting(value, decimals, 8));
    if let Some(sigma) = sigma {
        canvas.text(70, y, &text(format_args!("\u{b1}{}", fitting(sigma, decimals, 6))));
    }
    canvas.text_right(127, y, unit);
}

//! Legends: names beside the signs that a picture draws.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{Area, DrawingOutcome, fitted, text, write};
use super::theme::{Dashes, LABEL, PAPER};

/// Height of a line, pixels.
const LINE: i32 = 34;
/// From a name to the next sign, pixels.
const GAP: i32 = 42;
/// From a sign to its name, pixels.
const BESIDE: i32 = 10;

/// How a legend shows a thing: as the picture draws it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Sign {
    /// An area.
    Patch,
    /// A line, this wide, pixels.
    Line(u32, Dashes),
    /// A filled circle.
    Disc,
    /// A circle.
    Ring,
    /// The marker of a series: see [`mark`].
    Marker(usize),
}

/// An entry of a legend.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Key {
    /// What it is.
    pub name: String,
    /// How it is drawn.
    pub sign: Sign,
    /// Its colour.
    pub color: RGBColor,
}

impl Key {
    /// An entry.
    pub fn of(name: impl Into<String>, sign: Sign, color: RGBColor) -> Self {
        Self { name: name.into(), sign, color }
    }
}

impl Sign {
    /// Its width, pixels.
    fn width(self) -> i32 {
        if matches!(self, Self::Line(..)) { 44 } else { 20 }
    }

    /// Draws it with the middle of its left edge at a place.
    fn draw<B: DrawingBackend>(
        self,
        area: &Area<B>,
        (x, y): (i32, i32),
        color: RGBColor,
    ) -> DrawingOutcome<B> {
        let middle = (x + self.width() / 2, y);
        match self {
            Self::Patch => {
                area.draw(&Rectangle::new([(x, y - 9), (x + 18, y + 9)], color.filled()))
            }
            Self::Line(width, dashes) => {
                line(area, [(x, y), (x + self.width(), y)], color.stroke_width(width), dashes)
            }
            Self::Disc => area.draw(&Circle::new(middle, 9, color.filled())),
            Self::Ring => area.draw(&Circle::new(middle, 8, color.stroke_width(3))),
            Self::Marker(cycle) => mark(area, middle, cycle, color),
        }
    }
}

/// Draws a line in pixels, dashed or not.
pub(super) fn line<B: DrawingBackend>(
    area: &Area<B>,
    [start, end]: [(i32, i32); 2],
    style: ShapeStyle,
    dashes: Dashes,
) -> DrawingOutcome<B> {
    let Some([dash, gap]) = dashes else {
        return area.draw(&PathElement::new([start, end], style));
    };
    let step = [end.0 - start.0, end.1 - start.1].map(f64::from);
    let length = step[0].hypot(step[1]);
    let at = |along: f64| {
        let [x, y] = step.map(|step| (step * (along / length).min(1.0)).round() as i32);
        (start.0 + x, start.1 + y)
    };
    let mut along = 0.0;
    while along < length {
        area.draw(&PathElement::new([at(along), at(along + f64::from(dash))], style))?;
        along += f64::from(dash + gap);
    }
    Ok(())
}

/// Draws a marker of about 7 pixels to each side; every cycle of colours has its own.
pub(super) fn mark<B: DrawingBackend>(
    area: &Area<B>,
    (x, y): (i32, i32),
    cycle: usize,
    color: RGBColor,
) -> DrawingOutcome<B> {
    match cycle % 4 {
        0 => area.draw(&Circle::new((x, y), 7, color.filled())),
        1 => area.draw(&Rectangle::new([(x - 6, y - 6), (x + 7, y + 7)], color.filled())),
        2 => {
            let corners = [(x, y - 9), (x + 9, y), (x, y + 9), (x - 9, y)];
            area.draw(&Polygon::new(corners, color.filled()))
        }
        _ => {
            area.draw(&Circle::new((x, y), 7, PAPER.filled()))?;
            area.draw(&Circle::new((x, y), 7, color.stroke_width(3)))
        }
    }
}

/// Draws signs and names in lines from the top of an area; returns the height that they take. A name that is wider than
/// the area is shortened.
pub(super) fn legend<B: DrawingBackend>(
    area: &Area<B>,
    keys: &[Key],
) -> std::result::Result<i32, DrawingAreaErrorKind<B::ErrorType>> {
    let width = area.dim_in_pixel().0 as i32;
    let (mut x, mut y) = (0, LINE / 2);
    for Key { name, sign, color } in keys {
        let before = sign.width() + BESIDE;
        let name = fitted(area, name, LABEL, width - before)?;
        let needs = before + area.estimate_text_size(&name, &text(LABEL))?.0 as i32;
        if x > 0 && x + needs > width {
            (x, y) = (0, y + LINE);
        }
        sign.draw(area, (x, y), *color)?;
        write(area, &name, (x + before, y), (HPos::Left, VPos::Center), LABEL)?;
        x += needs + GAP;
    }
    Ok(y + LINE)
}

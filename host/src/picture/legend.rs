//! Legends: names beside the signs that a picture draws.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{Area, Drawn, fitted, text, write};
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
    ) -> Drawn<B> {
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
fn line<B: DrawingBackend>(
    area: &Area<B>,
    ends: [(i32, i32); 2],
    style: ShapeStyle,
    dashes: Dashes,
) -> Drawn<B> {
    let [(start, y), (end, _)] = ends;
    let Some([length, gap]) = dashes else { return area.draw(&PathElement::new(ends, style)) };
    let mut x = start;
    while x < end {
        area.draw(&PathElement::new([(x, y), ((x + length).min(end), y)], style))?;
        x += length + gap;
    }
    Ok(())
}

/// Draws a marker of about 7 pixels to each side; every cycle of colours has its own.
pub(super) fn mark<B: DrawingBackend>(
    area: &Area<B>,
    (x, y): (i32, i32),
    cycle: usize,
    color: RGBColor,
) -> Drawn<B> {
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

/// Draws signs and names in lines from the top of an area; returns the height that they take. A name that is wider than the
/// area is shortened.
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

//! A panel: curves over one axis in a frame with grid and numbers, in the sizes and colours of all pictures.

use plotters::prelude::*;

use super::canvas::{Area, DrawingOutcome, styled, tick};
use super::clip::pieces;
use super::theme::{Dashes, FAINT};

/// A curve of a panel.
pub(super) struct Curve {
    /// Its points; it breaks at those that are not finite, and ends at the frame of its panel.
    pub points: Vec<(f64, f64)>,
    /// Its colour.
    pub color: RGBColor,
    /// Its width, pixels.
    pub width: u32,
    /// Its dashes.
    pub dashes: Dashes,
}

impl Curve {
    /// A thin curve.
    pub fn of(points: Vec<(f64, f64)>, color: RGBColor) -> Self {
        Self { points, color, width: 2, dashes: None }
    }

    /// A level from one end to the other.
    pub fn level(ends: [f64; 2], value: f64, color: RGBColor) -> Self {
        Self::of(ends.map(|x| (x, value)).into(), color)
    }

    /// The same with these dashes.
    pub fn dashed(self, dashes: Dashes) -> Self {
        Self { dashes, ..self }
    }

    /// The same, this wide.
    pub fn wide(self, width: u32) -> Self {
        Self { width, ..self }
    }
}

/// A panel with the ranges of its axes.
pub(super) struct Panel<'a> {
    /// Left and right end.
    pub x: [f64; 2],
    /// Lower and upper end.
    pub y: [f64; 2],
    /// Quantity and unit below; without it there are no numbers either.
    pub below: Option<&'a str>,
    /// Quantity and unit at the left; an empty one leaves the numbers alone.
    pub left: &'a str,
    /// Room for the numbers at the left, pixels.
    pub room: u32,
    /// A range of the horizontal axis that is shaded.
    pub shaded: Option<[f64; 2]>,
}

impl Panel<'_> {
    /// Draws the panel with its curves, which end at its frame.
    pub fn draw<B: DrawingBackend>(&self, area: &Area<B>, curves: &[Curve]) -> DrawingOutcome<B> {
        let ([start, end], [low, high]) = (self.x, self.y);
        let mut chart = ChartBuilder::on(area)
            .margin_right(18)
            .margin_top(10)
            .set_label_area_size(LabelAreaPosition::Left, self.room)
            .set_label_area_size(
                LabelAreaPosition::Bottom,
                if self.below.is_some() { 72 } else { 14 },
            )
            .build_cartesian_2d(start..end, low..high)?;
        if let Some([from, to]) = self.shaded {
            let corners = [(from.clamp(start, end), low), (to.clamp(start, end), high)];
            chart.draw_series([Rectangle::new(corners, FAINT.mix(0.45).filled())])?;
        }
        let nothing = |_: &f64| String::new();
        let mut mesh = chart.configure_mesh();
        styled(&mut mesh).x_labels(6).y_labels(5).y_desc(self.left);
        match self.below {
            Some(name) => mesh.x_desc(name),
            None => mesh.x_label_formatter(&nothing),
        };
        // What is left of a zero by the arithmetic of the ticks is small against the range.
        let plain = |value: &f64| tick((value * 1e6).round() / 1e6);
        mesh.y_label_formatter(&plain);
        if self.below.is_some() {
            mesh.x_label_formatter(&plain);
        }
        mesh.draw()?;
        for curve in curves {
            let style = curve.color.stroke_width(curve.width);
            for piece in pieces(&curve.points, [start, end], [low, high]) {
                match curve.dashes {
                    None => chart.draw_series(LineSeries::new(piece, style))?,
                    Some([length, gap]) => {
                        chart.draw_series(DashedLineSeries::new(piece, length, gap, style))?
                    }
                };
            }
        }
        Ok(())
    }
}

/// A range that holds zero and these values, with some room; the whole unit when there are none.
pub(super) fn range_of(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let widen = |[low, high]: [f64; 2], value: f64| [low.min(value), high.max(value)];
    let [low, high] = values.filter(|value| value.is_finite()).fold([0.0; 2], widen);
    let room = 0.06 * (high - low);
    if room.is_normal() { [low - room, high + room] } else { [-1.0, 1.0] }
}

#[cfg(test)]
mod tests {
    use super::range_of;

    #[test]
    fn a_range_holds_zero_and_ignores_what_is_no_number() {
        let [low, high] = range_of([2.0, f64::NAN, f64::INFINITY, 4.0].into_iter());
        assert!(low < 0.0 && 4.0 < high && high < 5.0, "{low} {high}");
        assert_eq!(range_of([f64::NAN, 0.0].into_iter()), [-1.0, 1.0]);
    }
}

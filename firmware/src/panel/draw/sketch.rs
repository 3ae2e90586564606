//! A sketch of the object: its sensors, its hit points, and an arrow at the current hit.
//!
//! The body frame is seen from the direction (1, 1, 1), z upwards. Lines run from the middle of all points
//! to each of them, to suggest a body.

use embedded_graphics::prelude::*;
use massline_shared::layout::RigLayout;

use super::canvas::{Canvas, Screen};

/// Cosine of 30°: the body's x and y axes run 30° below the horizontal.
const ACROSS: f32 = 0.866_025_4;
/// Sine of 30°.
const DOWN: f32 = 0.5;
/// Margin for the marks and the arrow, pixels.
const MARGIN: f32 = 9.0;
/// Length of the arrow, pixels.
const ARROW: f32 = 11.0;

/// A projected point (m) or unit direction: components to the right and downwards.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ProjectedPoint(f32, f32);

fn project([x, y, z]: [f32; 3]) -> ProjectedPoint {
    ProjectedPoint((y - x) * ACROSS, (x + y) * DOWN - z)
}

/// Conversion from meters to pixels.
#[derive(Clone, Copy, Debug)]
struct Frame {
    middle: ProjectedPoint,
    scale: f32,
    center: Point,
}

impl Frame {
    /// The largest scale at which all points fit the box; `None` if no point is finite.
    fn around(places: impl Iterator<Item = ProjectedPoint>, at: Point, size: Size) -> Option<Self> {
        let (mut low, mut high) =
            (ProjectedPoint(f32::MAX, f32::MAX), ProjectedPoint(f32::MIN, f32::MIN));
        for ProjectedPoint(x, y) in places.filter(|p| p.0.is_finite() && p.1.is_finite()) {
            low = ProjectedPoint(low.0.min(x), low.1.min(y));
            high = ProjectedPoint(high.0.max(x), high.1.max(y));
        }
        let room = |pixels: u32| (pixels as f32 - 2.0 * MARGIN).max(1.0);
        // The scale is infinite along an axis on which all points coincide.
        let across = room(size.width) / (high.0 - low.0);
        let down = room(size.height) / (high.1 - low.1);
        let scale = across.min(down);
        let middle = ProjectedPoint((low.0 + high.0) / 2.0, (low.1 + high.1) / 2.0);
        let center = at + Point::new(size.width as i32 / 2, size.height as i32 / 2);
        if !(middle.0.is_finite() && middle.1.is_finite()) || low.0 > high.0 {
            return None;
        }
        // A single point is drawn in the middle.
        let scale = if scale.is_finite() { scale } else { 0.0 };
        Some(Self { middle, scale, center })
    }

    /// The pixel of a point. A coordinate that is not finite is put in the middle.
    fn pixel(&self, ProjectedPoint(x, y): ProjectedPoint) -> Point {
        self.center + pixels((x - self.middle.0) * self.scale, (y - self.middle.1) * self.scale)
    }
}

fn pixels(x: f32, y: f32) -> Point {
    let near = |v: f32| {
        let v = if v.is_finite() { v.clamp(-500.0, 500.0) } else { 0.0 };
        // Rounded to the nearest, upwards at one half.
        (v + 1000.5) as i32 - 1000
    };
    Point::new(near(x), near(y))
}

/// Draws the layout into a box, with an arrow at the hit `current`.
pub(super) fn draw<D: Screen>(
    canvas: &mut Canvas<'_, D>,
    layout: &RigLayout,
    current: Option<usize>,
    at: Point,
    size: Size,
) {
    let sensors = layout.sensors.iter().map(|sensor| project(sensor.position));
    let hits = layout.hits.iter().map(|hit| project(hit.position));
    let Some(frame) = Frame::around(sensors.clone().chain(hits.clone()), at, size) else { return };
    let middle = frame.pixel(frame.middle);
    for place in sensors.clone().chain(hits.clone()) {
        canvas.stroke(middle, frame.pixel(place));
    }
    for place in sensors {
        let Point { x, y } = frame.pixel(place);
        canvas.fill(x - 1, y - 1, 3, 3);
    }
    let Some(hit) = current.and_then(|index| layout.hits.get(index)) else { return };
    arrow(canvas, frame.pixel(project(hit.position)), project(hit.direction));
}

/// Draws an arrow whose tip is at the hit point, or a square for a hit along the line of sight.
fn arrow<D: Screen>(canvas: &mut Canvas<'_, D>, tip: Point, ProjectedPoint(x, y): ProjectedPoint) {
    let length = nalgebra::ComplexField::sqrt(x * x + y * y);
    if length.is_nan() || length <= 0.1 {
        for (from, to) in
            [((-4, -4), (4, -4)), ((4, -4), (4, 4)), ((4, 4), (-4, 4)), ((-4, 4), (-4, -4))]
        {
            canvas.stroke(tip + Point::from(from), tip + Point::from(to));
        }
        return;
    }
    let (x, y) = (x / length, y / length);
    // Two lines side by side, so that the arrow stands out from the body.
    let aside = if x.abs() > y.abs() { Point::new(0, 1) } else { Point::new(1, 0) };
    let tail = tip - pixels(x * ARROW, y * ARROW);
    for offset in [Point::zero(), aside] {
        canvas.stroke(tail + offset, tip + offset);
    }
    for side in [1.0, -1.0] {
        let barb = pixels(-4.0 * x - side * 4.0 * y, -4.0 * y + side * 4.0 * x);
        canvas.stroke(tip, tip + barb);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_graphics::mock_display::MockDisplay;
    use embedded_graphics::pixelcolor::BinaryColor;
    use massline_shared::layout::{Hit, Sensor};

    const SIDE: Size = Size::new(48, 39);

    /// A mock display that permits overdrawing and drawing out of bounds.
    fn screen() -> MockDisplay<BinaryColor> {
        let mut screen = MockDisplay::new();
        screen.set_allow_overdraw(true);
        screen.set_allow_out_of_bounds_drawing(true);
        screen
    }

    fn layout(positions: &[[f32; 3]], direction: [f32; 3]) -> RigLayout {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut layout = RigLayout::default();
        for (node, &position) in (1..).zip(positions) {
            let _ = layout.sensors.push(Sensor::new(node, position, axes));
            let _ = layout.hits.push(Hit::new("1:+X".parse().unwrap(), position, direction));
        }
        layout
    }

    #[test]
    fn no_layout_is_too_strange_to_be_drawn() {
        let places: [&[[f32; 3]]; 7] = [
            &[],
            &[[0.0; 3]],
            &[[1.0, 1.0, 1.0], [2.0, 2.0, 2.0]],
            &[[f32::NAN; 3], [0.0; 3]],
            &[[f32::INFINITY, 0.0, 0.0]],
            &[[f32::MAX, 0.0, 0.0], [-f32::MAX, 0.0, 0.0]],
            &[[1e-38, 0.0, 0.0], [0.0; 3]],
        ];
        for places in places {
            for direction in [[0.0; 3], [1.0, 1.0, 1.0], [f32::NAN; 3], [0.0, 0.0, -1.0]] {
                for current in [None, Some(0), Some(99)] {
                    let layout = layout(places, direction);
                    let canvas = &mut Canvas(&mut screen());
                    draw(canvas, &layout, current, Point::zero(), SIDE);
                }
            }
        }
    }

    #[test]
    fn every_place_and_the_arrow_lie_within_the_box() {
        let places = [[0.0, 0.0, 0.0], [0.2, -0.2, 0.0], [-0.1, 0.3, 0.15]];
        for direction in [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]] {
            for hit in 0..3 {
                let mut screen = screen();
                let layout = layout(&places, direction);
                draw(&mut Canvas(&mut screen), &layout, Some(hit), Point::new(8, 8), SIDE);
                let drawn = screen.affected_area();
                // The arrow's tail may stand two pixels beyond the margin.
                let grown = embedded_graphics::primitives::Rectangle::new(
                    Point::new(5, 5),
                    SIDE + Size::new(6, 6),
                );
                assert!(grown.contains(drawn.top_left), "{drawn:?}");
                assert!(grown.contains(drawn.bottom_right().unwrap()), "{drawn:?}");
            }
        }
    }

    #[test]
    fn z_is_up_and_x_and_y_run_towards_the_eye() {
        assert_eq!(project([0.0, 0.0, 1.0]), ProjectedPoint(0.0, -1.0));
        assert!(project([1.0, 0.0, 0.0]).0 < 0.0 && project([1.0, 0.0, 0.0]).1 > 0.0);
        assert!(project([0.0, 1.0, 0.0]).0 > 0.0 && project([0.0, 1.0, 0.0]).1 > 0.0);
    }
}

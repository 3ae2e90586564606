//! How a body in space is seen on a picture: points in m become pixels.

use nalgebra::{Matrix2x3, Vector2, Vector3};

use crate::projection::across;

/// Length of an arrow in space, pixels.
const ARROW: f64 = 110.0;
/// Room for labels at the sides, and above and below, pixels.
const BORDER: [f64; 2] = [80.0, 48.0];
/// Halvings of the range in which the scale is searched: it is exact to a millionth.
const HALVINGS: usize = 40;
/// Size of a body whose points are all at one place, m.
const SMALLEST: f64 = 1e-3;

/// The view.
pub(super) struct View {
    across: Matrix2x3<f64>,
    /// The middle of all that is seen, pixels from the origin.
    middle: Vector2<f64>,
    /// Pixels per m.
    pub scale: f64,
    center: (i32, i32),
}

impl View {
    /// The largest view that shows all points in an area of this size, and whole arrows that end at some points with a
    /// direction.
    pub fn of(
        points: &[Vector3<f64>],
        arrows: &[(Vector3<f64>, Vector3<f64>)],
        (width, height): (u32, u32),
    ) -> Self {
        let across = across();
        // Where it is, m, and how far beside, pixels.
        let points = points.iter().map(|point| (across * point, Vector2::zeros()));
        let tails = arrows.iter().map(|(tip, along)| (across * tip, across * along * -ARROW));
        let places: Vec<(Vector2<f64>, Vector2<f64>)> = points.chain(tails).collect();
        let first = places.first().map_or_else(Vector2::zeros, |(at, _)| *at);
        let ends = |scale: f64| {
            let seen = places.iter().map(|(at, beside)| (at - first) * scale + beside);
            seen.fold([Vector2::zeros(); 2], |[low, high], at| [low.inf(&at), high.sup(&at)])
        };
        let room = Vector2::new(f64::from(width), f64::from(height)) - 2.0 * Vector2::from(BORDER);
        let fits = |scale: f64| {
            let [low, high] = ends(scale);
            (high - low).iter().zip(&room).all(|(size, room)| size <= room)
        };
        let size = places.iter().map(|(at, _)| (at - first).amax()).fold(SMALLEST, f64::max);
        let [mut scale, mut too_large] = [0.0, 2.0 * room.amax() / size];
        for _ in 0..HALVINGS {
            let middle = (scale + too_large) / 2.0;
            if fits(middle) {
                scale = middle;
            } else {
                too_large = middle;
            }
        }
        let [low, high] = ends(scale);
        let center = (width as i32 / 2, height as i32 / 2);
        Self { across, middle: first * scale + (low + high) / 2.0, scale, center }
    }

    /// The pixel at which a point is seen.
    pub fn at(&self, point: &Vector3<f64>) -> (i32, i32) {
        self.pixel(self.across * point * self.scale)
    }

    /// Where an arrow begins that ends at a point with a direction.
    pub fn tail(&self, tip: &Vector3<f64>, along: &Vector3<f64>) -> (i32, i32) {
        self.pixel(self.across * tip * self.scale - self.across * along * ARROW)
    }

    fn pixel(&self, seen: Vector2<f64>) -> (i32, i32) {
        let seen = seen - self.middle;
        (self.center.0 + seen.x.round() as i32, self.center.1 - seen.y.round() as i32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_and_arrows_fill_the_area_without_leaving_it() {
        let corners = [Vector3::zeros(), Vector3::new(0.2, 0.1, 0.0), Vector3::new(0.0, 0.0, 0.6)];
        let arrows = [(corners[2], -Vector3::z()), (corners[1], Vector3::y())];
        let view = View::of(&corners, &arrows, (1000, 800));
        let tails = arrows.iter().map(|(tip, along)| view.tail(tip, along));
        let seen: Vec<_> = corners.iter().map(|point| view.at(point)).chain(tails).collect();
        let ends = |coordinate: fn(&(i32, i32)) -> i32| {
            [seen.iter().map(coordinate).min().unwrap(), seen.iter().map(coordinate).max().unwrap()]
        };
        // The height limits: it is used but for the border.
        assert_eq!(ends(|at| at.1), [48, 752]);
        let [left, right] = ends(|at| at.0);
        assert!(left >= 80 && right <= 920, "{left} {right}");
    }
}

//! The test in space: sensors, hits, centre of mass, principal axes and the ellipsoid of the same inertia.

use std::f64::consts::TAU;

use massline_shared::body::RigidBody;
use massline_shared::layout::HostLayout;
use nalgebra::{Matrix2x3, Vector2, Vector3};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{Area, Drawing, Drawn, Heading, tick, write};
use super::labels::Labels;
use super::legend::{Key, Sign, legend};
use super::theme::{COLORS, INK, SMALL};
use crate::error::Result;
use crate::projection::across;
use crate::result_file::ResultFile;

/// Length of an arrow's head, pixels.
const HEAD: f64 = 24.0;
/// Colours of sensors, hits and body.
const INKS: [RGBColor; 3] = [COLORS[0], COLORS[1], COLORS[2]];
/// Points of a drawn ellipse.
const POINTS: usize = 72;

/// A layout, and the body that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct InSpace {
    /// What was measured.
    pub title: String,
    layout: HostLayout,
    body: Option<RigidBody<f64>>,
}

impl InSpace {
    /// The layout of a result with its best answer; `None` when the layout is not known.
    ///
    /// # Errors
    /// When the result is malformed.
    pub fn of(source: &ResultFile) -> Result<Option<Self>> {
        let body = source.answers()?.first().map(|answer| answer.body);
        let (title, layout) = (source.title.clone(), source.layout().cloned());
        Ok(layout.map(|layout| Self { title, layout, body }))
    }
}

/// Semi-axes, m, of the homogeneous ellipsoid with the mass and the inertia of a body; `None` for one that cannot be.
pub fn ellipsoid(body: &RigidBody<f64>) -> Option<[Vector3<f64>; 3]> {
    let principal = body.principal()?;
    let half = principal.moments.sum() / 2.0;
    // The second moment along an axis is m a²/5.
    let axis = |k: usize| {
        let second = half - principal.moments[k];
        (second > 0.0 && body.mass > 0.0)
            .then(|| principal.axes.column(k) * (5.0 * second / body.mass).sqrt())
    };
    Some([axis(0)?, axis(1)?, axis(2)?])
}

/// The view: points in m become pixels.
struct View {
    across: Matrix2x3<f64>,
    middle: Vector2<f64>,
    scale: f64,
    center: (i32, i32),
}

impl View {
    /// One that shows all points in an area of this size.
    fn of(points: &[Vector3<f64>], (width, height): (u32, u32)) -> Self {
        let across = across();
        let seen: Vec<Vector2<f64>> = points.iter().map(|p| across * p).collect();
        let start = seen.first().copied().unwrap_or_default();
        let low = seen.iter().fold(start, |a, b| a.inf(b));
        let high = seen.iter().fold(start, |a, b| a.sup(b));
        let size = (high - low).map(|v| if v > 0.0 { v } else { 1e-3 });
        let scale = (0.82 * f64::from(width) / size.x).min(0.82 * f64::from(height) / size.y);
        let center = (width as i32 / 2, height as i32 / 2);
        Self { across, middle: (low + high) / 2.0, scale, center }
    }

    fn at(&self, point: &Vector3<f64>) -> (i32, i32) {
        let seen = (self.across * point - self.middle) * self.scale;
        (self.center.0 + seen.x.round() as i32, self.center.1 - seen.y.round() as i32)
    }
}

impl Drawing for InSpace {
    fn heading(&self) -> Heading<'_> {
        Heading { subject: &self.title, shows: "the test in space".into() }
    }

    fn draw<B: DrawingBackend>(&self, area: &Area<B>) -> Drawn<B> {
        self.labelled(area).map(|_| ())
    }
}

impl InSpace {
    /// Draws the picture; returns its labels.
    fn labelled<B: DrawingBackend>(
        &self,
        area: &Area<B>,
    ) -> std::result::Result<Labels, DrawingAreaErrorKind<B::ErrorType>> {
        let [of_sensors, of_hits, of_body] = INKS;
        let arms = self.body.as_ref().and_then(ellipsoid);
        let used = legend(area, &self.keys(arms.is_some()))?;
        let (_, area) = area.split_vertically(used);
        let sensors: Vec<_> =
            self.layout.sensors.iter().map(|s| Vector3::from(s.position)).collect();
        let hits: Vec<_> = self.layout.hits.iter().map(|h| Vector3::from(h.position)).collect();
        let center = self.body.map(|body| body.center_of_mass);
        let mut points: Vec<Vector3<f64>> = vec![Vector3::zeros()];
        points.extend(sensors.iter().chain(&hits).chain(&center));
        if let Some((center, arms)) = center.zip(arms) {
            points.extend(arms.iter().flat_map(|arm| [center + arm, center - arm]));
        }
        let view = View::of(&points, area.dim_in_pixel());
        let reach = 110.0 / view.scale;
        let mut labels = Labels::within(area.dim_in_pixel());
        sensors.iter().chain(&hits).for_each(|point| labels.keep(view.at(point), 12));
        let mut ends_of_axes = Vec::new();
        for (axis, name) in [(Vector3::x(), "x"), (Vector3::y(), "y"), (Vector3::z(), "z")] {
            let ends = [Vector3::zeros(), axis * reach].map(|point| view.at(&point));
            area.draw(&PathElement::new(ends, INK.mix(0.6).stroke_width(2)))?;
            labels.keep_line(ends[0], ends[1]);
            ends_of_axes.push((name, ends[1]));
        }
        if let Some((center, arms)) = center.zip(arms) {
            for (first, second) in [(0, 1), (0, 2), (1, 2)] {
                let ellipse = (0..=POINTS).map(|k| {
                    let (sin, cos) = (TAU * k as f64 / POINTS as f64).sin_cos();
                    view.at(&(center + arms[first] * cos + arms[second] * sin))
                });
                let line: Vec<_> = ellipse.collect();
                labels.avoid(&line);
                area.draw(&PathElement::new(line, of_body.mix(0.5).stroke_width(2)))?;
            }
            for arm in arms {
                let ends = [center - arm, center + arm].map(|point| view.at(&point));
                labels.avoid(&ends);
                area.draw(&PathElement::new(ends, of_body.stroke_width(3)))?;
            }
        }
        if let Some(center) = center {
            labels.keep(view.at(&center), 10);
            area.draw(&Circle::new(view.at(&center), 9, of_body.filled()))?;
        }
        for (x, y) in sensors.iter().map(|point| view.at(point)) {
            area.draw(&Rectangle::new([(x - 9, y - 9), (x + 9, y + 9)], of_sensors.filled()))?;
        }
        let mut tails = Vec::new();
        for (hit, point) in self.layout.hits.iter().zip(&hits) {
            // The arrow ends where the hammer hits.
            let tail = view.at(&(point - Vector3::from(hit.direction) * reach));
            let tip = view.at(point);
            arrow(&area, tail, tip, of_hits)?;
            labels.keep_line(tail, tip);
            tails.push(tail);
        }
        for (sensor, point) in self.layout.sensors.iter().zip(&sensors) {
            labels.write(&area, &sensor.node.to_string(), view.at(point))?;
        }
        for (hit, tail) in self.layout.hits.iter().zip(tails) {
            labels.write(&area, &hit.dof.to_string(), tail)?;
        }
        for (name, end) in ends_of_axes {
            labels.write(&area, name, end)?;
        }
        let (_, height) = area.dim_in_pixel();
        ruler(&area, &view, height as i32 - 20)?;
        Ok(labels)
    }

    /// What is drawn how; without a body its part is missing, and one that cannot be has no ellipsoid.
    fn keys(&self, has_ellipsoid: bool) -> Vec<Key> {
        let [of_sensors, of_hits, of_body] = INKS;
        let mut keys = vec![
            Key::of("sensor at its node", Sign::Patch, of_sensors),
            Key::of("hit, along the force on the body", Sign::Line(4, None), of_hits),
        ];
        let name = match has_ellipsoid {
            true => "centre of mass, principal axes, ellipsoid of the same inertia",
            false => "centre of mass; no real body has this inertia, so there is no ellipsoid",
        };
        keys.extend(self.body.map(|_| Key::of(name, Sign::Disc, of_body)));
        keys
    }
}

/// An arrow; one that points at the viewer is a dot.
fn arrow<B: DrawingBackend>(
    area: &Area<B>,
    tail: (i32, i32),
    tip: (i32, i32),
    color: RGBColor,
) -> Drawn<B> {
    let end = |of: (i32, i32)| Vector2::new(f64::from(of.0), f64::from(of.1));
    let along = end(tip) - end(tail);
    if along.norm() < HEAD {
        return area.draw(&Circle::new(tip, 8, color.filled()));
    }
    let along = along.normalize() * HEAD;
    let across = Vector2::new(-along.y, along.x) * 0.4;
    let corner = |side: f64| {
        let at = end(tip) - along + across * side;
        (at.x.round() as i32, at.y.round() as i32)
    };
    area.draw(&PathElement::new([tail, corner(0.0)], color.stroke_width(4)))?;
    area.draw(&Polygon::new([tip, corner(1.0), corner(-1.0)], color.filled()))
}

/// A line of known length.
fn ruler<B: DrawingBackend>(area: &Area<B>, view: &View, y: i32) -> Drawn<B> {
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
    use super::super::canvas::{FONT, register};
    use super::super::vector::Vector;
    use super::*;
    use crate::layout_file::LayoutFile;

    /// The frame with every node hit along every axis.
    fn twelve_dofs() -> HostLayout {
        let file = include_str!("../../examples/three-bar-test-1.toml");
        let start = file.find("hits = [").expect("the hits of the layout");
        let end = start + file[start..].find(']').expect("the end of the list");
        let dofs: Vec<String> = (1..=4)
            .flat_map(|node| ["X", "Y", "Z"].map(|axis| format!("\"{node}:+{axis}\"")))
            .collect();
        let text = format!("{}hits = [{}{}", &file[..start], dofs.join(", "), &file[end..]);
        LayoutFile::parse(&text, "twelve.toml").unwrap().layout
    }

    #[test]
    fn the_labels_of_twelve_hits_keep_clear_of_each_other_and_of_the_arrows() {
        register().unwrap();
        let layout = twelve_dofs();
        assert_eq!(layout.hits.len(), 12);
        let picture = InSpace { title: String::new(), layout, body: None };
        let mut svg = String::new();
        let area = Vector::on(&mut svg, (1540, 900), FONT).into_drawing_area();
        let labels = picture.labelled(&area).unwrap();
        // Three sensors, twelve hits and three axes.
        assert_eq!(labels.count(), 18);
        assert!(labels.collisions().is_empty(), "{:?}", labels.collisions());
    }

    #[test]
    fn the_ellipsoid_strikes_no_label_through() {
        register().unwrap();
        let file = include_str!("../../examples/three-bar-test-1.toml");
        let of_file = LayoutFile::parse(file, "test-1.toml").unwrap();
        let body = of_file.reference.and_then(|of| of.complete()).expect("a reference");
        let body = RigidBody::from_theta(&body.into());
        let picture = InSpace { title: String::new(), layout: twelve_dofs(), body: Some(body) };
        let mut svg = String::new();
        let area = Vector::on(&mut svg, (1540, 900), FONT).into_drawing_area();
        let labels = picture.labelled(&area).unwrap();
        assert_eq!((labels.count(), labels.struck()), (18, 0));
        assert!(labels.collisions().is_empty(), "{:?}", labels.collisions());
    }

    #[test]
    fn a_body_that_cannot_be_is_said_to_have_no_ellipsoid() {
        let (title, layout) = (String::new(), twelve_dofs());
        let inertia = nalgebra::Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 9.0));
        let body = RigidBody { mass: 1.0, center_of_mass: Vector3::zeros(), inertia };
        assert!(ellipsoid(&body).is_none());
        let picture = InSpace { title, layout, body: Some(body) };
        let keys = picture.keys(false);
        assert!(keys[2].name.contains("no real body"), "{keys:?}");
    }

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

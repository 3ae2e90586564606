//! The test in space: nodes with their outline, sensors, hits, centre of mass, principal axes and the ellipsoid of the
//! same inertia.

use std::f64::consts::TAU;

use massline_shared::body::RigidBody;
use massline_shared::layout::HostLayout;
use nalgebra::{Vector2, Vector3};
use plotters::prelude::*;

use super::canvas::{Area, Drawing, DrawingOutcome, Heading};
use super::labels::Labels;
use super::legend::{Key, Sign, legend};
use super::nodes::{NamedNode, nodes_without_sensor};
use super::outline::convex_hull;
use super::ruler::ruler;
use super::theme::{COLORS, FAINT, GREY, INK, PAPER};
use super::view::View;
use crate::result_file::ResultFile;
use massline_result::Result;

/// Length of an arrow's head, pixels.
const HEAD: f64 = 24.0;
/// Colours of sensors, hits and body.
const INKS: [RGBColor; 3] = [COLORS[0], COLORS[1], COLORS[2]];
/// Points of a drawn ellipse.
const POINTS: usize = 72;
/// A layout, and the body that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct LayoutInSpace {
    /// What was measured.
    pub title: String,
    layout: HostLayout,
    /// Nodes without a sensor.
    nodes: Vec<NamedNode>,
    body: Option<RigidBody<f64>>,
}

impl LayoutInSpace {
    /// The layout of a result with its best answer; `None` when the layout is not known.
    ///
    /// # Errors
    /// When the result is malformed.
    pub fn of(source: &ResultFile) -> Result<Option<Self>> {
        let body = source.result().answer().map(|answer| answer.body());
        let (title, layout) = (source.title.clone(), source.layout().cloned());
        let nodes = nodes_without_sensor(source);
        Ok(layout.map(|layout| Self { title, layout, nodes, body }))
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

impl Drawing for LayoutInSpace {
    fn heading(&self) -> Heading<'_> {
        Heading { subject: &self.title, shows: "the test in space".into() }
    }

    fn draw<B: DrawingBackend>(&self, area: &Area<B>) -> DrawingOutcome<B> {
        self.labelled(area).map(|_| ())
    }
}

impl LayoutInSpace {
    /// Draws the picture; returns its labels.
    fn labelled<B: DrawingBackend>(
        &self,
        area: &Area<B>,
    ) -> std::result::Result<Labels, DrawingAreaErrorKind<B::ErrorType>> {
        let [of_sensors, of_hits, of_body] = INKS;
        let arms = self.body.as_ref().and_then(ellipsoid);
        let used = legend(area, &self.keys(arms.is_some()))?;
        let (_, area) = area.split_vertically(used);
        let sensors: Vec<Vector3<f64>> =
            self.layout.sensors.iter().map(|sensor| sensor.position.into()).collect();
        let nodes: Vec<Vector3<f64>> =
            self.nodes.iter().map(|(_, position)| (*position).into()).collect();
        let hits = self.layout.hits.iter().map(|hit| (hit.position.into(), hit.direction.into()));
        let hits: Vec<(Vector3<f64>, Vector3<f64>)> = hits.collect();
        let center = self.body.map(|body| body.center_of_mass);
        let solid = center.zip(arms);
        let solid = solid.map_or_else(Vec::new, |(center, arms)| lines_of(center, arms));
        let mut points: Vec<Vector3<f64>> = vec![Vector3::zeros()];
        points.extend(sensors.iter().chain(&nodes).chain(&center));
        points.extend(hits.iter().map(|(tip, _)| tip));
        points.extend(solid.iter().flat_map(|(line, _)| line));
        let axes = [(Vector3::x(), "x"), (Vector3::y(), "y"), (Vector3::z(), "z")];
        let from_origin = axes.iter().map(|(axis, _)| (Vector3::zeros(), -axis));
        let arrows: Vec<_> = hits.iter().copied().chain(from_origin).collect();
        let view = View::of(&points, &arrows, area.dim_in_pixel());
        let mut labels = Labels::within(area.dim_in_pixel());
        sensors.iter().chain(&nodes).for_each(|point| labels.keep(view.at(point), 12));
        outline(&area, &mut labels, sensors.iter().chain(&nodes).map(|point| view.at(point)))?;
        let mut ends_of_axes = Vec::new();
        for (axis, name) in axes {
            let ends = [view.at(&Vector3::zeros()), view.tail(&Vector3::zeros(), &-axis)];
            area.draw(&PathElement::new(ends, INK.mix(0.6).stroke_width(2)))?;
            labels.keep_line(ends[0], ends[1]);
            ends_of_axes.push((name, ends[1]));
        }
        for (line, style) in solid {
            let line: Vec<_> = line.iter().map(|point| view.at(point)).collect();
            labels.avoid(&line);
            area.draw(&PathElement::new(line, style))?;
        }
        if let Some(center) = center {
            labels.keep(view.at(&center), 10);
            area.draw(&Circle::new(view.at(&center), 9, of_body.filled()))?;
        }
        for node in nodes.iter().map(|point| view.at(point)) {
            area.draw(&Circle::new(node, 7, PAPER.filled()))?;
            area.draw(&Circle::new(node, 7, INK.stroke_width(2)))?;
        }
        for (x, y) in sensors.iter().map(|point| view.at(point)) {
            area.draw(&Rectangle::new([(x - 9, y - 9), (x + 9, y + 9)], of_sensors.filled()))?;
        }
        let mut tails = Vec::new();
        for (tip, along) in &hits {
            // The arrow ends where the hammer hits.
            let ends = [view.tail(tip, along), view.at(tip)];
            arrow(&area, ends[0], ends[1], of_hits)?;
            labels.keep_line(ends[0], ends[1]);
            tails.push(ends[0]);
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
        for ((name, _), point) in self.nodes.iter().zip(&nodes) {
            if !name.is_empty() {
                labels.write(&area, name, view.at(point))?;
            }
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
        if !self.nodes.is_empty() {
            keys.push(Key::of("node without a sensor", Sign::Ring, INK));
        }
        keys.push(Key::of("outline of all nodes", Sign::Line(2, None), GREY));
        let name = match has_ellipsoid {
            true => "centre of mass, principal axes, ellipsoid of the same inertia",
            false => "centre of mass; no real body has this inertia, so there is no ellipsoid",
        };
        keys.extend(self.body.map(|_| Key::of(name, Sign::Disc, of_body)));
        keys
    }
}

/// The lines of an ellipsoid with these semi-axes: its sections through each two of them, and its axes.
fn lines_of(center: Vector3<f64>, arms: [Vector3<f64>; 3]) -> Vec<(Vec<Vector3<f64>>, ShapeStyle)> {
    let [_, _, of_body] = INKS;
    let section = |(first, second): (usize, usize)| {
        let point = |k: usize| {
            let (sin, cos) = (TAU * k as f64 / POINTS as f64).sin_cos();
            center + arms[first] * cos + arms[second] * sin
        };
        ((0..=POINTS).map(point).collect(), of_body.mix(0.5).stroke_width(2))
    };
    let axis = |arm| (vec![center - arm, center + arm], of_body.stroke_width(3));
    [(0, 1), (0, 2), (1, 2)].map(section).into_iter().chain(arms.map(axis)).collect()
}

/// The convex hull of nodes.
fn outline<B: DrawingBackend>(
    area: &Area<B>,
    labels: &mut Labels,
    nodes: impl Iterator<Item = (i32, i32)>,
) -> DrawingOutcome<B> {
    let mut corners = convex_hull(nodes.collect());
    if let [_, _, _, ..] = corners[..] {
        area.draw(&Polygon::new(corners.clone(), FAINT.mix(0.3).filled()))?;
        corners.push(corners[0]);
    }
    labels.avoid(&corners);
    area.draw(&PathElement::new(corners, GREY.stroke_width(2)))
}

/// An arrow; one that points at the viewer is a dot.
fn arrow<B: DrawingBackend>(
    area: &Area<B>,
    tail: (i32, i32),
    tip: (i32, i32),
    color: RGBColor,
) -> DrawingOutcome<B> {
    let end = |point: (i32, i32)| Vector2::new(f64::from(point.0), f64::from(point.1));
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

#[cfg(test)]
mod tests {
    use super::super::canvas::{FONT, register};
    use super::super::vector::Vector;
    use super::*;
    use massline_files::layout_file::LayoutFile;

    /// The frame with every node hit along every axis.
    fn twelve_dofs() -> HostLayout {
        let file = include_str!("../../../examples/three-bar-test-1.toml");
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
        let picture = LayoutInSpace { title: String::new(), layout, nodes: Vec::new(), body: None };
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
        let file = include_str!("../../../examples/three-bar-test-1.toml");
        let of_file = LayoutFile::parse(file, "test-1.toml").unwrap();
        let body =
            of_file.reference.and_then(|reference| reference.complete()).expect("a reference");
        let body = RigidBody::from_theta(&body.into());
        let picture = LayoutInSpace {
            title: String::new(),
            layout: twelve_dofs(),
            nodes: Vec::new(),
            body: Some(body),
        };
        let mut svg = String::new();
        let area = Vector::on(&mut svg, (1540, 900), FONT).into_drawing_area();
        let labels = picture.labelled(&area).unwrap();
        assert_eq!((labels.count(), labels.struck()), (18, 0));
        assert!(labels.collisions().is_empty(), "{:?}", labels.collisions());
    }

    /// The corners of the paths of a colour.
    fn corners(svg: &str, color: &str) -> Vec<[i32; 2]> {
        let paths = svg.lines().filter(|line| line.contains(color));
        let data = paths.filter_map(|line| Some(line.split_once(" d=\"")?.1.split_once('"')?.0));
        let mut corners = Vec::new();
        for piece in data.flat_map(|data| data.split('M')).filter(|piece| !piece.is_empty()) {
            let spaced = piece.replace('l', " ").replace('-', " -");
            let numbers: Vec<i32> =
                spaced.split_whitespace().map(|number| number.parse().unwrap()).collect();
            let mut at = [0, 0];
            for step in numbers.chunks(2) {
                at = [at[0] + step[0], at[1] + step[1]];
                corners.push(at);
            }
        }
        corners
    }

    #[test]
    fn an_ellipsoid_larger_than_the_layout_is_drawn_whole() {
        register().unwrap();
        let layout = twelve_dofs();
        let center_of_mass = Vector3::new(0.3, -0.4, 0.5);
        let inertia = nalgebra::Matrix3::new(3.0, 0.4, 0.2, 0.4, 2.0, -0.5, 0.2, -0.5, 2.5);
        let body = Some(RigidBody { mass: 3.0, center_of_mass, inertia });
        let picture = LayoutInSpace { title: String::new(), layout, nodes: Vec::new(), body };
        let mut svg = String::new();
        let area = Vector::on(&mut svg, (1540, 900), FONT).into_drawing_area();
        picture.draw(&area).unwrap();
        area.present().unwrap();
        drop(area);
        let corners = corners(&svg, "#009E73");
        assert!(corners.len() > 100, "{}", corners.len());
        let is_inside = |at: &[i32; 2]| (0..1540).contains(&at[0]) && (0..900).contains(&at[1]);
        assert!(corners.iter().all(is_inside), "{corners:?}");
    }

    #[test]
    fn a_body_that_cannot_be_is_said_to_have_no_ellipsoid() {
        let (title, layout) = (String::new(), twelve_dofs());
        let inertia = nalgebra::Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 9.0));
        let body = RigidBody { mass: 1.0, center_of_mass: Vector3::zeros(), inertia };
        assert!(ellipsoid(&body).is_none());
        let picture = LayoutInSpace { title, layout, nodes: Vec::new(), body: Some(body) };
        let keys = picture.keys(false);
        assert!(keys.iter().any(|key| key.name.contains("no real body")), "{keys:?}");
    }
}

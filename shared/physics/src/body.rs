//! `[body]` of a bench file: an object composed of simple parts, or its ten inertial parameters.

use std::ops::RangeInclusive;

use massline_shared::body::RigidBody;
use nalgebra::{Matrix3, Vector3};
use serde::Deserialize;

use super::locate::{BenchFileError, LocatedText};

/// Allowed size of a part, m.
const LENGTH: RangeInclusive<f64> = 1e-6..=1e3;
/// Allowed mass of a part or an object, kg.
const MASS: RangeInclusive<f64> = 1e-9..=1e6;

/// `[body]`: parts, or the ten inertial parameters.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [body]")]
pub(super) struct BodyTable {
    #[serde(default, rename = "box")]
    boxes: Vec<BoxPart>,
    #[serde(default)]
    cylinder: Vec<CylinderPart>,
    #[serde(default)]
    point: Vec<PointPart>,
    mass_kg: Option<f64>,
    center_of_mass_m: Option<[f64; 3]>,
    inertia_kg_m2: Option<[f64; 6]>,
}

impl BodyTable {
    /// The object that the table describes, with errors located in the file.
    pub(super) fn body(&self, at: &LocatedText) -> Result<RigidBody<f64>, BenchFileError> {
        let mut parts = Vec::new();
        for (i, part) in self.boxes.iter().enumerate() {
            let key = format!("body.box[{i}]");
            let [a, b, c] = part.size_m;
            for size in part.size_m {
                at.within(size, &LENGTH, &format!("{key}.size_m"))?;
            }
            let mass = mass_of(part.mass_kg, part.density_kg_m3, a * b * c, &key, at)?;
            let axes = axes_of(part.axes, &key, at)?;
            parts.push(block(mass, part.center_m.into(), part.size_m, &axes));
        }
        for (i, part) in self.cylinder.iter().enumerate() {
            let key = format!("body.cylinder[{i}]");
            let (outer, inner) = (part.radius_m, part.inner_radius_m);
            at.within(part.length_m, &LENGTH, &format!("{key}.length_m"))?;
            at.within(outer, &LENGTH, &format!("{key}.radius_m"))?;
            let hollow = (0.0..outer).contains(&inner);
            at.require(
                hollow,
                &format!("{key}.inner_radius_m"),
                "must lie between 0 and radius_m",
            )?;
            let volume = std::f64::consts::PI * (outer * outer - inner * inner) * part.length_m;
            let mass = mass_of(part.mass_kg, part.density_kg_m3, volume, &key, at)?;
            let axes = axes_of(part.axes, &key, at)?;
            parts.push(cylinder(mass, part.center_m.into(), [outer, inner], part.length_m, &axes));
        }
        for (i, part) in self.point.iter().enumerate() {
            at.within(part.mass_kg, &MASS, &format!("body.point[{i}].mass_kg"))?;
            parts.push(point(part.mass_kg, part.position_m.into()));
        }
        let body = match (self.mass_kg, self.center_of_mass_m, self.inertia_kg_m2) {
            (None, None, None) if !parts.is_empty() => compose(&parts),
            (Some(mass), Some(center), Some([xx, yy, zz, xy, xz, yz])) if parts.is_empty() => {
                at.within(mass, &MASS, "body.mass_kg")?;
                RigidBody {
                    mass,
                    center_of_mass: center.into(),
                    inertia: Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
                }
            }
            _ => {
                return Err(at.error(
                    "body",
                    "give either parts (box, cylinder, point) or mass_kg, center_of_mass_m and \
                     inertia_kg_m2, all three",
                ));
            }
        };
        at.require(
            is_physical(&body),
            "body",
            "no object has these properties: the mass must be positive and the inertia about the centre \
             of mass must satisfy the triangle inequality in more than one dimension",
        )?;
        Ok(body)
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [[body.box]]")]
struct BoxPart {
    size_m: [f64; 3],
    center_m: [f64; 3],
    axes: Option<[[f64; 3]; 2]>,
    mass_kg: Option<f64>,
    density_kg_m3: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [[body.cylinder]]")]
struct CylinderPart {
    radius_m: f64,
    #[serde(default)]
    inner_radius_m: f64,
    length_m: f64,
    center_m: [f64; 3],
    axes: Option<[[f64; 3]; 2]>,
    mass_kg: Option<f64>,
    density_kg_m3: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [[body.point]]")]
struct PointPart {
    position_m: [f64; 3],
    mass_kg: f64,
}

fn mass_of(
    mass: Option<f64>,
    density: Option<f64>,
    volume: f64,
    key: &str,
    at: &LocatedText,
) -> Result<f64, BenchFileError> {
    let mass = match (mass, density) {
        (Some(mass), None) => mass,
        (None, Some(density)) => density * volume,
        _ => return Err(at.error(key, "give either mass_kg or density_kg_m3")),
    };
    if !MASS.contains(&mass) {
        let (from, to) = (MASS.start(), MASS.end());
        return Err(at.error(key, format!("it weighs {mass:?} kg; give it {from} to {to} kg")));
    }
    Ok(mass)
}

/// The given local x and y axes as in a layout file; the columns of the result are x, y and z.
fn axes_of(
    axes: Option<[[f64; 3]; 2]>,
    key: &str,
    at: &LocatedText,
) -> Result<Matrix3<f64>, BenchFileError> {
    let Some([x, y]) = axes else { return Ok(Matrix3::identity()) };
    let (x, y) = (Vector3::from(x), Vector3::from(y));
    let skew = (x.norm() - 1.0).abs().max((y.norm() - 1.0).abs()).max(x.dot(&y).abs());
    at.require(skew < 1e-6, &format!("{key}.axes"), "must be two orthogonal unit vectors")?;
    Ok(Matrix3::from_columns(&[x, y, x.cross(&y)]))
}

/// A rigid assembly of at least one part.
pub fn compose(parts: &[RigidBody<f64>]) -> RigidBody<f64> {
    let mass: f64 = parts.iter().map(|p| p.mass).sum();
    let center_of_mass =
        parts.iter().map(|p| p.center_of_mass * p.mass).sum::<Vector3<f64>>() / mass;
    let inertia = parts
        .iter()
        .map(|p| p.inertia + point_inertia(p.mass, &(p.center_of_mass - center_of_mass)))
        .sum();
    RigidBody { mass, center_of_mass, inertia }
}

/// A point mass.
pub fn point(mass: f64, position: Vector3<f64>) -> RigidBody<f64> {
    RigidBody { mass, center_of_mass: position, inertia: Matrix3::zeros() }
}

/// A homogeneous block of edge lengths `size` along the columns of `axes`.
pub fn block(
    mass: f64,
    center: Vector3<f64>,
    size: [f64; 3],
    axes: &Matrix3<f64>,
) -> RigidBody<f64> {
    let [a, b, c] = size.map(|v| v * v * mass / 12.0);
    let local = Matrix3::from_diagonal(&Vector3::new(b + c, a + c, a + b));
    RigidBody { mass, center_of_mass: center, inertia: axes * local * axes.transpose() }
}

/// A homogeneous cylinder or tube along the third column of `axes`.
pub fn cylinder(
    mass: f64,
    center: Vector3<f64>,
    radii: [f64; 2],
    length: f64,
    axes: &Matrix3<f64>,
) -> RigidBody<f64> {
    let rr = radii[0] * radii[0] + radii[1] * radii[1];
    let across = mass * (3.0 * rr + length * length) / 12.0;
    let local = Matrix3::from_diagonal(&Vector3::new(across, across, mass * rr / 2.0));
    RigidBody { mass, center_of_mass: center, inertia: axes * local * axes.transpose() }
}

/// True when a real object can have these values: positive mass, and principal moments that satisfy the
/// triangle inequality (theory, section 2). A flat plate is the limit; a body without thickness in two
/// directions is refused, because it has no inertia about its own axis.
pub fn is_physical(body: &RigidBody<f64>) -> bool {
    let finite = body.inertia.iter().chain(&body.center_of_mass).all(|v| v.is_finite());
    if !(finite && body.mass.is_finite() && body.mass > 0.0) {
        return false;
    }
    let second_moments = Matrix3::identity() * (0.5 * body.inertia.trace()) - body.inertia;
    let eigenvalues = second_moments.symmetric_eigenvalues();
    // The mass matrix is invertible only when two of the three second moments are above zero.
    let scale = eigenvalues.max();
    let extended = eigenvalues.iter().filter(|&&e| e > 1e-9 * scale).count();
    scale > 0.0 && eigenvalues.min() > -1e-9 * scale && extended >= 2
}

fn point_inertia(mass: f64, r: &Vector3<f64>) -> Matrix3<f64> {
    (Matrix3::identity() * r.norm_squared() - r * r.transpose()) * mass
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_of_a_block_make_the_block() {
        let axes = Matrix3::identity();
        let half = |x| block(1.5, Vector3::new(x, 0.2, 0.0), [0.1, 0.2, 0.3], &axes);
        let whole = block(3.0, Vector3::new(0.1, 0.2, 0.0), [0.2, 0.2, 0.3], &axes);
        let composed = compose(&[half(0.05), half(0.15)]);
        assert!((composed.mass_matrix() - whole.mass_matrix()).norm() < 1e-15);
    }

    #[test]
    fn a_rod_without_thickness_is_not_an_object_with_ten_properties() {
        let rod = compose(&[point(1.0, Vector3::zeros()), point(1.0, Vector3::new(0.1, 0.0, 0.0))]);
        assert!(!is_physical(&rod));
    }

    #[test]
    fn a_triangle_of_points_is_an_object() {
        let corner = |x, y| point(1.0, Vector3::new(x, y, 0.0));
        assert!(is_physical(&compose(&[corner(0.0, 0.0), corner(0.1, 0.0), corner(0.0, 0.1)])));
    }
}

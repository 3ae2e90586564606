//! The ten rigid body properties of an object composed of simple parts.

use massline_shared::body::RigidBody;
use nalgebra::{Matrix3, Vector3};

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

/// True when a real object can have these values: positive mass, and principal moments that
/// satisfy the triangle inequality (theory, section 2), a flat plate being the limit: without thickness
/// in two directions a body cannot be accelerated about its own axis.
pub fn is_physical(body: &RigidBody<f64>) -> bool {
    let finite = body.inertia.iter().chain(&body.center_of_mass).all(|v| v.is_finite());
    if !(finite && body.mass.is_finite() && body.mass > 0.0) {
        return false;
    }
    let second_moments = Matrix3::identity() * (0.5 * body.inertia.trace()) - body.inertia;
    let eigenvalues = second_moments.symmetric_eigenvalues();
    // The mass matrix must be invertible: two of the three second moments are above zero.
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

//! The ten rigid body properties of an object composed of simple parts.

use nalgebra::{Matrix3, Matrix6, Vector3};

/// Mass, centre of mass and inertia of the simulated object, in the body frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// kg.
    pub mass: f64,
    /// m.
    pub center_of_mass: Vector3<f64>,
    /// About the centre of mass, tensor elements, kg m².
    pub inertia: Matrix3<f64>,
}

impl Body {
    /// A rigid assembly of parts; an empty list is a body of zero mass.
    pub fn compose(parts: &[Body]) -> Self {
        let mass: f64 = parts.iter().map(|p| p.mass).sum();
        let center_of_mass =
            parts.iter().map(|p| p.center_of_mass * p.mass).sum::<Vector3<f64>>() / mass;
        let inertia = parts
            .iter()
            .map(|p| p.inertia + point_inertia(p.mass, &(p.center_of_mass - center_of_mass)))
            .sum();
        Self { mass, center_of_mass, inertia }
    }

    /// A point mass.
    pub fn point(mass: f64, position: Vector3<f64>) -> Self {
        Self { mass, center_of_mass: position, inertia: Matrix3::zeros() }
    }

    /// A homogeneous block of edge lengths `size` along the columns of `axes`.
    pub fn block(mass: f64, center: Vector3<f64>, size: [f64; 3], axes: &Matrix3<f64>) -> Self {
        let [a, b, c] = size.map(|v| v * v * mass / 12.0);
        let local = Matrix3::from_diagonal(&Vector3::new(b + c, a + c, a + b));
        Self { mass, center_of_mass: center, inertia: axes * local * axes.transpose() }
    }

    /// A homogeneous cylinder or tube along the third column of `axes`.
    pub fn cylinder(
        mass: f64,
        center: Vector3<f64>,
        radii: [f64; 2],
        length: f64,
        axes: &Matrix3<f64>,
    ) -> Self {
        let rr = radii[0] * radii[0] + radii[1] * radii[1];
        let across = mass * (3.0 * rr + length * length) / 12.0;
        let local = Matrix3::from_diagonal(&Vector3::new(across, across, mass * rr / 2.0));
        Self { mass, center_of_mass: center, inertia: axes * local * axes.transpose() }
    }

    /// Mass matrix about the origin (theory, section 2): `[[m I, −[h]×], [[h]×, J_O]]`.
    pub fn mass_matrix(&self) -> Matrix6<f64> {
        let h = cross_matrix(&(self.center_of_mass * self.mass));
        let about_origin = self.inertia + point_inertia(self.mass, &self.center_of_mass);
        let mut m = Matrix6::zeros();
        m.fixed_view_mut::<3, 3>(0, 0).fill_diagonal(self.mass);
        m.fixed_view_mut::<3, 3>(0, 3).copy_from(&-h);
        m.fixed_view_mut::<3, 3>(3, 0).copy_from(&h);
        m.fixed_view_mut::<3, 3>(3, 3).copy_from(&about_origin);
        m
    }

    /// True when a real object can have these values: positive mass, and principal moments that
    /// satisfy the triangle inequality with a point mass or a rod as the limit (theory, section 2).
    pub fn is_physical(&self) -> bool {
        let finite = self.inertia.iter().chain(&self.center_of_mass).all(|v| v.is_finite());
        if !(finite && self.mass.is_finite() && self.mass > 0.0) {
            return false;
        }
        let second_moments = Matrix3::identity() * (0.5 * self.inertia.trace()) - self.inertia;
        let eigenvalues = second_moments.symmetric_eigenvalues();
        // The mass matrix must be invertible: two of the three second moments are above zero.
        let scale = eigenvalues.max();
        let extended = eigenvalues.iter().filter(|&&e| e > 1e-9 * scale).count();
        scale > 0.0 && eigenvalues.min() > -1e-9 * scale && extended >= 2
    }
}

/// `[v]×`, so that `[v]× w = v × w`.
pub fn cross_matrix(v: &Vector3<f64>) -> Matrix3<f64> {
    v.cross_matrix()
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
        let half = |x| Body::block(1.5, Vector3::new(x, 0.2, 0.0), [0.1, 0.2, 0.3], &axes);
        let whole = Body::block(3.0, Vector3::new(0.1, 0.2, 0.0), [0.2, 0.2, 0.3], &axes);
        let composed = Body::compose(&[half(0.05), half(0.15)]);
        assert!((composed.mass_matrix() - whole.mass_matrix()).norm() < 1e-15);
    }

    #[test]
    fn a_rod_without_thickness_is_not_an_object_with_ten_properties() {
        let rod = Body::compose(&[
            Body::point(1.0, Vector3::zeros()),
            Body::point(1.0, Vector3::new(0.1, 0.0, 0.0)),
        ]);
        assert!(!rod.is_physical());
    }

    #[test]
    fn a_triangle_of_points_is_an_object() {
        let corner = |x, y| Body::point(1.0, Vector3::new(x, y, 0.0));
        assert!(
            Body::compose(&[corner(0.0, 0.0), corner(0.1, 0.0), corner(0.0, 0.1)]).is_physical()
        );
    }
}

//! Principal moments and axes, their uncertainty, and physical consistency.

use nalgebra::{Matrix3, SMatrix, Vector3, Vector6};

use super::{RigidBody, second_moments};
use crate::linalg::{cholesky, symmetric_eigen3};
use crate::real::Real;

/// Principal moments of inertia about the centre of mass, and their axes.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// let body = frame::body();
/// let principal = body.principal().unwrap();
/// let diagonal = principal.axes.transpose() * body.inertia * principal.axes;
/// assert!((diagonal[(2, 2)] - principal.moments[2]).abs() < 1e-12);
/// // No moment of a real body exceeds the sum of the other two.
/// assert!(principal.moments[2] < principal.moments[0] + principal.moments[1]);
/// assert!(body.is_physically_consistent());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrincipalInertia<R> {
    /// Principal moments in ascending order, kg m².
    pub moments: Vector3<R>,
    /// Principal axes as columns: unit vectors in the body frame, right-handed.
    pub axes: Matrix3<R>,
}

impl<R: Real> RigidBody<R> {
    /// Principal moments and axes; `None` when the inertia is not finite.
    pub fn principal(&self) -> Option<PrincipalInertia<R>> {
        let (moments, mut axes) = symmetric_eigen3(&self.inertia)?;
        let third = axes.column(0).cross(&axes.column(1));
        axes.set_column(2, &third);
        Some(PrincipalInertia { moments, axes })
    }

    /// Smallest eigenvalue of `½ tr(J) I − J`, J about the centre of mass, kg m²: half of the sum of the two
    /// smaller principal moments minus the largest. `None` when the inertia is not finite.
    pub fn physical_margin(&self) -> Option<R> {
        let moments = self.principal()?.moments;
        Some((moments[0] + moments[1] - moments[2]) * R::of(0.5))
    }

    /// A nearby physically consistent body: the eigenvalues of `½ tr(J) I − J` are raised to at least `part`
    /// times the largest (theory, section 4). `None` when the mass or all eigenvalues are not positive.
    ///
    /// ```
    /// # use massline_shared::body::RigidBody;
    /// # use massline_shared::nalgebra::{Matrix3, Vector3};
    /// let impossible = RigidBody {
    ///     mass: 1.0,
    ///     center_of_mass: Vector3::zeros(),
    ///     inertia: Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 2.5)),
    /// };
    /// assert!(!impossible.is_physically_consistent());
    /// assert!(impossible.made_consistent(0.05).unwrap().is_physically_consistent());
    /// ```
    pub fn made_consistent(&self, part: R) -> Option<Self> {
        let (moments, axes) = symmetric_eigen3(&second_moments(&self.inertia))?;
        let largest = moments[2];
        if self.mass <= R::zero() || largest <= R::zero() {
            return None;
        }
        let raised = moments.map(|moment| moment.max(largest * part));
        let second = axes * Matrix3::from_diagonal(&raised) * axes.transpose();
        let inertia = Matrix3::from_diagonal_element(second.trace()) - second;
        Some(Self { inertia, ..*self })
    }

    /// True when the mass is positive and the principal moments satisfy the triangle inequalities, so that
    /// the pseudo-inertia is positive definite (Rucker & Wensing 2022).
    pub fn is_physically_consistent(&self) -> bool {
        // The matrix is positive definite exactly when its smallest eigenvalue, the margin, is above zero.
        self.mass > R::zero() && cholesky(&second_moments(&self.inertia)).is_some()
    }
}

impl<R: Real> PrincipalInertia<R> {
    /// Standard deviations of the moments from the covariance of `theta`, to first order: a moment with the
    /// axis `n` changes by `nᵀ dJ n`. For two moments closer than their standard deviations the figures are
    /// too small or too large by about the distance of the two.
    pub fn moment_sigmas(&self, covariance: &SMatrix<R, 10, 10>) -> Vector3<R> {
        let inertia = covariance.fixed_view::<6, 6>(4, 4);
        Vector3::from_fn(|k, _| {
            let n = self.axes.column(k);
            let two = R::of(2.0);
            let slope = Vector6::new(
                n[0] * n[0],
                n[1] * n[1],
                n[2] * n[2],
                two * n[0] * n[1],
                two * n[0] * n[2],
                two * n[1] * n[2],
            );
            slope.dot(&(inertia * slope)).max(R::zero()).sqrt()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::bodies;
    use super::*;
    use nalgebra::SVector;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn axes_and_moments_make_the_inertia(body in bodies()) {
            let p = body.principal().unwrap();
            let back = p.axes * Matrix3::from_diagonal(&p.moments) * p.axes.transpose();
            // Rounding of the eigenvalue problem in double precision.
            prop_assert!((back - body.inertia).norm() < 1e-13 * body.inertia.norm());
            prop_assert!((p.axes.determinant() - 1.0).abs() < 1e-13);
            prop_assert!(p.moments[0] <= p.moments[1] && p.moments[1] <= p.moments[2]);
            prop_assert!(body.is_physically_consistent());
        }

        #[test]
        fn a_moments_sigma_is_its_slope_along_a_rank_one_covariance(
            body in bodies(),
            direction in prop::array::uniform6(-1.0..1.0_f64),
        ) {
            let p = body.principal().unwrap();
            let gap = (p.moments[1] - p.moments[0]).min(p.moments[2] - p.moments[1]);
            prop_assume!(gap > 0.05 * p.moments[2]);
            let mut d = SVector::<f64, 10>::zeros();
            d.fixed_rows_mut::<6>(4).copy_from(&Vector6::from(direction));
            let step = 1e-6 * gap;
            let moved = RigidBody::from_theta(&(body.theta() + d * step)).principal().unwrap();
            let slope = (moved.moments - p.moments) / step;
            let sigma = p.moment_sigmas(&(d * d.transpose()));
            // The second-order error is step over gap, times |dJ|² of at most 12.
            prop_assert!((slope.abs() - sigma).norm() < 1e-4);
        }
    }

    #[test]
    fn a_violated_triangle_inequality_is_inconsistent() {
        let body = RigidBody {
            mass: 1.0_f32,
            center_of_mass: Vector3::zeros(),
            inertia: Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 2.1)),
        };
        assert!(!body.is_physically_consistent());
        assert!((body.physical_margin().unwrap() + 0.05).abs() < 1e-6);
        let negative = RigidBody { mass: -1.0, inertia: Matrix3::identity(), ..body };
        assert!(!negative.is_physically_consistent());
    }

    #[test]
    fn an_inertia_that_is_not_finite_has_no_principal_axes() {
        let body = RigidBody {
            mass: 1.0_f32,
            center_of_mass: Vector3::zeros(),
            inertia: Matrix3::from_diagonal_element(f32::NAN),
        };
        assert!(body.principal().is_none() && !body.is_physically_consistent());
    }
}

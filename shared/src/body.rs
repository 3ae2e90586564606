//! The ten rigid body properties and their transforms.
//!
//! Two vectors hold the same ten numbers:
//!
//! * `theta` = [m, c_x, c_y, c_z, J_xx, J_yy, J_zz, J_xy, J_xz, J_yz] is reported to the user: the inertia is about
//!   the **centre of mass**;
//! * `phi` = [m, m cx, m cy, m cz, and the inertia about the **origin** in the same order]: the equations of
//!   motion are linear in it.
//!
//! Products of inertia are tensor elements: `Jxy = −∫ x y dm`. Theory, section 1.

mod log_cholesky;
mod parameters;
mod principal;

pub use log_cholesky::LogCholesky;
pub use parameters::{INERTIAL_PARAMETERS, InertialParameter, scale};
pub use principal::PrincipalInertia;

use nalgebra::{Matrix3, Matrix4, Matrix6, SMatrix, SVector, Vector3, Vector6};

use crate::linalg::skew;
use crate::real::Real;

/// Row and column of the six inertia elements: xx, yy, zz, xy, xz, yz.
pub const INERTIA_ELEMENTS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// Mass, centre of mass and inertia of a rigid body.
///
/// ```
/// # use massline_shared::body::RigidBody;
/// # use massline_shared::nalgebra::{Matrix3, Vector3};
/// // A solid cube of 6 kg and 0.1 m, its centre 0.2 m from the origin.
/// let moment = 6.0 * 0.1 * 0.1 / 6.0;
/// let cube = RigidBody {
///     mass: 6.0_f64,
///     center_of_mass: Vector3::new(0.2, 0.0, 0.0),
///     inertia: Matrix3::from_diagonal_element(moment),
/// };
/// // Huygens and Steiner: about the origin m |c|² more, but not about the x axis.
/// let about_origin = cube.inertia_about(&Vector3::zeros());
/// assert!((about_origin[(0, 0)] - moment).abs() < 1e-15);
/// assert!((about_origin[(1, 1)] - (moment + 6.0 * 0.04)).abs() < 1e-15);
/// let back = RigidBody::from_phi(&cube.phi()).unwrap();
/// assert!((back.theta() - cube.theta()).norm() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidBody<R> {
    /// Mass, kg.
    pub mass: R,
    /// Position of the centre of mass in the body frame, m.
    pub center_of_mass: Vector3<R>,
    /// Inertia tensor about the centre of mass, kg m².
    pub inertia: Matrix3<R>,
}

impl<R: Real> RigidBody<R> {
    /// Body from [m, c, J about the centre of mass].
    pub fn from_theta(theta: &SVector<R, 10>) -> Self {
        Self {
            mass: theta[0],
            center_of_mass: Vector3::new(theta[1], theta[2], theta[3]),
            inertia: tensor(&theta.fixed_rows::<6>(4).into_owned()),
        }
    }

    /// The ten properties as [m, c, J about the centre of mass].
    pub fn theta(&self) -> SVector<R, 10> {
        ten(self.mass, &self.center_of_mass, &self.inertia)
    }

    /// Body from [m, m c, J about the origin]; `None` when the mass is zero or a number is not finite.
    pub fn from_phi(phi: &SVector<R, 10>) -> Option<Self> {
        let mass = phi[0];
        let center_of_mass = Vector3::new(phi[1], phi[2], phi[3]) / mass;
        let about_origin = tensor(&phi.fixed_rows::<6>(4).into_owned());
        let inertia = about_origin - point_inertia(mass, &center_of_mass);
        let body = Self { mass, center_of_mass, inertia };
        body.is_finite().then_some(body)
    }

    /// The ten properties as [m, m c, J about the origin].
    pub fn phi(&self) -> SVector<R, 10> {
        let first_moment = self.center_of_mass * self.mass;
        ten(self.mass, &first_moment, &self.inertia_about(&Vector3::zeros()))
    }

    /// True when no number is NaN or infinite.
    pub fn is_finite(&self) -> bool {
        self.theta().iter().all(|v| v.finite())
    }

    /// Inertia about a point by the parallel axis theorem (Huygens-Steiner), kg m².
    pub fn inertia_about(&self, point: &Vector3<R>) -> Matrix3<R> {
        self.inertia + point_inertia(self.mass, &(self.center_of_mass - point))
    }

    /// The same body relative to another origin, which is given in the present frame.
    pub fn shifted_to(&self, origin: &Vector3<R>) -> Self {
        Self { center_of_mass: self.center_of_mass - origin, ..*self }
    }

    /// `M₀` of `f₀ = M₀ [a_O; α]`: force and torque about the origin from the acceleration of the
    /// origin and the angular acceleration. Theory, section 2.
    pub fn mass_matrix(&self) -> Matrix6<R> {
        let first_moment = skew(&(self.center_of_mass * self.mass));
        let mut m = Matrix6::zeros();
        m.fixed_view_mut::<3, 3>(0, 0).fill_diagonal(self.mass);
        m.fixed_view_mut::<3, 3>(0, 3).copy_from(&-first_moment);
        m.fixed_view_mut::<3, 3>(3, 0).copy_from(&first_moment);
        m.fixed_view_mut::<3, 3>(3, 3).copy_from(&self.inertia_about(&Vector3::zeros()));
        m
    }

    /// Motion `[a_O; α] = M₀⁻¹ f₀` under the force and torque `[F; T]` about the origin. It is computed
    /// through the centre of mass, so only the 3×3 inertia is inverted. `None` when the mass is zero or the
    /// inertia is singular.
    pub fn acceleration(&self, force: &Vector6<R>) -> Option<Vector6<R>> {
        let inverse = self.inertia.try_inverse()?;
        let acceleration = accelerate(self, &inverse, force);
        acceleration.iter().all(|v| v.finite()).then_some(acceleration)
    }

    /// `M₀⁻¹`; `None` when the mass is zero or the inertia is singular.
    pub fn inverse_mass_matrix(&self) -> Option<Matrix6<R>> {
        let inverse = self.inertia.try_inverse()?;
        let mut m = Matrix6::zeros();
        for j in 0..6 {
            let mut unit = Vector6::zeros();
            unit[j] = R::one();
            m.set_column(j, &accelerate(self, &inverse, &unit));
        }
        m.iter().all(|v| v.finite()).then_some(m)
    }

    /// `∂theta/∂phi`, 10 × 10. Theory, section 1:
    /// `dJ_C = dJ_O + dm (|c|² I − c cᵀ) − Σₖ dhₖ (2 cₖ I − eₖ cᵀ − c eₖᵀ)`.
    pub fn dtheta_dphi(&self) -> SMatrix<R, 10, 10> {
        let by_mass = -self.center_of_mass / self.mass;
        change_of_ten(&self.center_of_mass, &by_mass, R::one() / self.mass, -R::one())
    }

    /// `∂phi/∂theta`, 10 × 10: the inverse of [`Self::dtheta_dphi`].
    pub fn dphi_dtheta(&self) -> SMatrix<R, 10, 10> {
        let c = &self.center_of_mass;
        change_of_ten(c, c, self.mass, self.mass)
    }

    /// `[[½ tr(J_O) I − J_O, h], [hᵀ, m]]`, positive definite exactly when a body of positive density with
    /// these properties exists (Rucker & Wensing 2022).
    pub fn pseudo_inertia(&self) -> Matrix4<R> {
        let second_moments = second_moments(&self.inertia_about(&Vector3::zeros()));
        let first_moment = self.center_of_mass * self.mass;
        let mut p = Matrix4::zeros();
        p.fixed_view_mut::<3, 3>(0, 0).copy_from(&second_moments);
        p.fixed_view_mut::<3, 1>(0, 3).copy_from(&first_moment);
        p.fixed_view_mut::<1, 3>(3, 0).copy_from(&first_moment.transpose());
        p[(3, 3)] = self.mass;
        p
    }
}

/// The regressor of the equations of motion: row `i` of `f₀ = Y phi`, given the acceleration
/// `[a; α]` of the origin. Theory, section 3.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::body::regressor;
/// # use massline_shared::nalgebra::Vector3;
/// let body = frame::body();
/// let force = frame::layout().hits[2].unit_force(&Vector3::zeros());
/// let rows = regressor(&body.acceleration(&force).unwrap());
/// for (row, force) in rows.iter().zip(&force) {
///     let product: f64 = row.iter().zip(&body.phi()).map(|(y, phi)| y * phi).sum();
///     assert!((product - force).abs() < 1e-12);
/// }
/// ```
pub fn regressor<R: Real>(acceleration: &Vector6<R>) -> [[R; 10]; 6] {
    let o = R::zero();
    let [ax, ay, az, wx, wy, wz] = (*acceleration).into();
    [
        [ax, o, -wz, wy, o, o, o, o, o, o],
        [ay, wz, o, -wx, o, o, o, o, o, o],
        [az, -wy, wx, o, o, o, o, o, o, o],
        [o, o, az, -ay, wx, o, o, wy, wz, o],
        [o, -az, o, ax, o, wy, o, wx, o, wz],
        [o, ay, -ax, o, o, o, wz, o, wx, wy],
    ]
}

/// The six elements of a symmetric tensor in the order xx, yy, zz, xy, xz, yz.
pub fn elements<R: Real>(tensor: &Matrix3<R>) -> Vector6<R> {
    Vector6::from_fn(|k, _| tensor[INERTIA_ELEMENTS[k]])
}

/// The symmetric tensor with the six elements xx, yy, zz, xy, xz, yz.
pub fn tensor<R: Real>(elements: &Vector6<R>) -> Matrix3<R> {
    let [xx, yy, zz, xy, xz, yz] = (*elements).into();
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}

/// The second moments of mass `∫ r rᵀ dm = ½ tr(J) I − J`.
pub(crate) fn second_moments<R: Real>(inertia: &Matrix3<R>) -> Matrix3<R> {
    Matrix3::from_diagonal_element(inertia.trace() * R::of(0.5)) - inertia
}

/// Inertia of a point mass about the origin: `m (|c|² I − c cᵀ)`.
fn point_inertia<R: Real>(mass: R, c: &Vector3<R>) -> Matrix3<R> {
    (Matrix3::from_diagonal_element(c.dot(c)) - c * c.transpose()) * mass
}

/// Derivative between phi and theta, in either direction. The centre of mass and the first moment change with
/// the mass by `by_mass` and with each other by `own`; the inertia changes with them by
/// `Σₖ (2 cₖ I − eₖ cᵀ − c eₖᵀ)` times `factor`.
fn change_of_ten<R: Real>(
    c: &Vector3<R>,
    by_mass: &Vector3<R>,
    own: R,
    factor: R,
) -> SMatrix<R, 10, 10> {
    let mut d = SMatrix::<R, 10, 10>::identity();
    d.fixed_view_mut::<6, 1>(4, 0).copy_from(&elements(&point_inertia(R::one(), c)));
    for k in 0..3 {
        d[(1 + k, 0)] = by_mass[k];
        d[(1 + k, 1 + k)] = own;
        let mut by_place = Matrix3::from_diagonal_element(c[k] * R::of(2.0));
        for i in 0..3 {
            by_place[(k, i)] -= c[i];
            by_place[(i, k)] -= c[i];
        }
        d.fixed_view_mut::<6, 1>(4, 1 + k).copy_from(&elements(&(by_place * factor)));
    }
    d
}

fn ten<R: Real>(mass: R, moment: &Vector3<R>, inertia: &Matrix3<R>) -> SVector<R, 10> {
    let mut v = SVector::<R, 10>::zeros();
    v[0] = mass;
    v.fixed_rows_mut::<3>(1).copy_from(moment);
    v.fixed_rows_mut::<6>(4).copy_from(&elements(inertia));
    v
}

fn accelerate<R: Real>(
    body: &RigidBody<R>,
    inverse_inertia: &Matrix3<R>,
    force: &Vector6<R>,
) -> Vector6<R> {
    let c = &body.center_of_mass;
    let (f, t) = (force.fixed_rows::<3>(0), force.fixed_rows::<3>(3));
    let angular = inverse_inertia * (t - c.cross(&f));
    let linear = f / body.mass - angular.cross(c);
    let mut x = Vector6::zeros();
    x.fixed_rows_mut::<3>(0).copy_from(&linear);
    x.fixed_rows_mut::<3>(3).copy_from(&angular);
    x
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Bodies of six to nine point masses within a cube of 0.4 m about a point up to 0.3 m away; they are
    /// physically consistent by construction.
    pub(crate) fn bodies() -> impl Strategy<Value = RigidBody<f64>> {
        let offset = prop::array::uniform3(-0.3..0.3_f64);
        let points = prop::collection::vec((0.1..1.0_f64, prop::array::uniform3(-0.2..0.2)), 6..10);
        (offset, points).prop_filter_map("nearly flat", |(offset, points)| {
            let mass: f64 = points.iter().map(|p| p.0).sum();
            let c: Vector3<f64> =
                points.iter().map(|p| Vector3::from(p.1) * p.0).sum::<Vector3<f64>>() / mass;
            let inertia = points.iter().fold(Matrix3::zeros(), |sum, p| {
                sum + point_inertia(p.0, &(Vector3::from(p.1) - c))
            });
            let body = RigidBody { mass, center_of_mass: c + Vector3::from(offset), inertia };
            (body.physical_margin()? > 0.02 * inertia.trace()).then_some(body)
        })
    }

    proptest! {
        #[test]
        fn theta_and_phi_read_back(body in bodies()) {
            prop_assert_eq!(RigidBody::from_theta(&body.theta()), body);
            let back = RigidBody::from_phi(&body.phi()).unwrap();
            // Rounding of m c² in double precision.
            prop_assert!((back.theta() - body.theta()).norm() < 1e-12);
        }

        #[test]
        fn the_jacobian_is_the_slope_of_theta_over_phi(body in bodies()) {
            let phi = body.phi();
            let jacobian = body.dtheta_dphi();
            for k in 0..10 {
                let mut step = SVector::<f64, 10>::zeros();
                step[k] = 1e-5;
                let ahead = RigidBody::from_phi(&(phi + step)).unwrap().theta();
                let behind = RigidBody::from_phi(&(phi - step)).unwrap().theta();
                let slope = (ahead - behind) / 2e-5;
                // The error is the third derivative of c c^T m times step², plus rounding over the step.
                prop_assert!((slope - jacobian.column(k)).norm() < 1e-8);
            }
            // The tolerance covers rounding.
            let product = jacobian * body.dphi_dtheta();
            prop_assert!((product - SMatrix::identity()).norm() < 1e-12);
        }

        #[test]
        fn the_acceleration_solves_newton_and_euler(body in bodies(), force in prop::array::uniform6(-5.0..5.0_f64)) {
            let force = Vector6::from(force);
            let x = body.acceleration(&force).unwrap();
            // Rounding times the condition of a nearly flat body.
            prop_assert!((body.mass_matrix() * x - force).norm() < 1e-10);
            prop_assert!((body.inverse_mass_matrix().unwrap() * force - x).norm() < 1e-10);
            let rows = regressor(&x);
            for i in 0..6 {
                let f = SVector::from(rows[i]).dot(&body.phi());
                prop_assert!((f - force[i]).abs() < 1e-10);
            }
        }

        #[test]
        fn shifting_there_and_back_changes_nothing(body in bodies(), p in prop::array::uniform3(-1.0..1.0_f64)) {
            let p = Vector3::from(p);
            let back = body.shifted_to(&p).shifted_to(&-p);
            prop_assert!((back.theta() - body.theta()).norm() < 1e-14);
            let shifted_matrix = body.shifted_to(&p).mass_matrix();
            let inertia: Matrix3<f64> = shifted_matrix.fixed_view::<3, 3>(3, 3).into_owned();
            prop_assert!((inertia - body.inertia_about(&p)).norm() < 1e-14);
        }
    }

    #[test]
    fn a_body_without_mass_is_refused() {
        assert!(RigidBody::from_phi(&SVector::<f32, 10>::zeros()).is_none());
        let none = RigidBody::from_theta(&SVector::<f32, 10>::zeros());
        assert!(none.acceleration(&Vector6::repeat(1.0)).is_none());
    }
}

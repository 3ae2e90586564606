//! Log-Cholesky parameters: ten unconstrained numbers, every choice of which gives a physically consistent
//! body (Rucker & Wensing 2022).

use nalgebra::{Matrix3, Matrix4, SMatrix, SVector, Vector3};

use super::{INERTIA_ELEMENTS, RigidBody, second_moments};
use crate::real::Real;

/// [a, d1, d2, d3, s12, s23, s13, t1, t2, t3] with the pseudo-inertia `P = U Uᵀ` of
///
/// ```text
/// U = e^a [ e^d1  s12   s13   t1 ]
///         [ 0     e^d2  s23   t2 ]
///         [ 0     0     e^d3  t3 ]
///         [ 0     0     0     1  ]
/// ```
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::body::LogCholesky;
/// let parameters = LogCholesky::from_body(&frame::body()).unwrap();
/// assert!((parameters.body().theta() - frame::body().theta()).norm() < 1e-12);
/// // A step in any direction stays a body that can exist.
/// let moved = LogCholesky(parameters.0.map(|value| value - 0.7)).body();
/// assert!(moved.is_physically_consistent());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogCholesky<R>(pub SVector<R, 10>);

/// Row and column in `U` of each parameter after the first.
const PLACES: [(usize, usize); 9] =
    [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)];

impl<R: Real> LogCholesky<R> {
    /// Parameters of a body; `None` unless it is physically consistent.
    ///
    /// The last column gives `m = e^2a` and `t = c`, which leaves the second moments about the centre of mass
    /// over the mass to be factored.
    pub fn from_body(body: &RigidBody<R>) -> Option<Self> {
        let positive = |v: R| (v > R::zero() && v.finite()).then(|| v.sqrt());
        let root_mass = positive(body.mass)?;
        let s = second_moments(&body.inertia) / body.mass;
        let u33 = positive(s[(2, 2)])?;
        let s23 = s[(1, 2)] / u33;
        let s13 = s[(0, 2)] / u33;
        let u22 = positive(s[(1, 1)] - s23 * s23)?;
        let s12 = (s[(0, 1)] - s13 * s23) / u22;
        let u11 = positive(s[(0, 0)] - s12 * s12 - s13 * s13)?;
        let c = &body.center_of_mass;
        let values = [root_mass.ln(), u11.ln(), u22.ln(), u33.ln(), s12, s23, s13, c.x, c.y, c.z];
        Some(Self(SVector::from(values)))
    }

    /// The body with these parameters, physically consistent by construction.
    pub fn body(&self) -> RigidBody<R> {
        let u = self.factor();
        let mass = u[(3, 3)] * u[(3, 3)];
        let triangle: Matrix3<R> = u.fixed_view::<3, 3>(0, 0).into_owned();
        let second = triangle * triangle.transpose();
        RigidBody {
            mass,
            center_of_mass: Vector3::new(self.0[7], self.0[8], self.0[9]),
            inertia: Matrix3::from_diagonal_element(second.trace()) - second,
        }
    }

    /// `∂phi/∂(log-Cholesky)`, 10 × 10: `dP = dU Uᵀ + U dUᵀ`. Each parameter but the first changes one
    /// element of `U`.
    pub fn dphi(&self) -> SMatrix<R, 10, 10> {
        let u = self.factor();
        let scale = u[(3, 3)];
        let mut d = SMatrix::<R, 10, 10>::zeros();
        d.set_column(0, &phi_of(&(u * u.transpose() * R::of(2.0))));
        for (k, &(row, column)) in PLACES.iter().enumerate() {
            // On the diagonal the parameter is a logarithm, elsewhere the element over e^a.
            let slope = if row == column { u[(row, row)] } else { scale };
            let mut change = Matrix4::zeros();
            for i in 0..4 {
                change[(row, i)] += slope * u[(i, column)];
                change[(i, row)] += slope * u[(i, column)];
            }
            d.set_column(1 + k, &phi_of(&change));
        }
        d
    }

    fn factor(&self) -> Matrix4<R> {
        let scale = self.0[0].exp();
        let mut u = Matrix4::zeros();
        for (k, &(row, column)) in PLACES.iter().enumerate() {
            let value = self.0[1 + k];
            u[(row, column)] = scale * if row == column { value.exp() } else { value };
        }
        u[(3, 3)] = scale;
        u
    }
}

/// phi from a pseudo-inertia: `J_O = tr(S) I − S` with `S` its upper left block.
fn phi_of<R: Real>(p: &Matrix4<R>) -> SVector<R, 10> {
    let trace = p[(0, 0)] + p[(1, 1)] + p[(2, 2)];
    let mut phi = SVector::<R, 10>::zeros();
    phi[0] = p[(3, 3)];
    for k in 0..3 {
        phi[1 + k] = p[(k, 3)];
    }
    for (k, &(i, j)) in INERTIA_ELEMENTS.iter().enumerate() {
        phi[4 + k] = if i == j { trace - p[(i, j)] } else { -p[(i, j)] };
    }
    phi
}

#[cfg(test)]
mod tests {
    use super::super::tests::bodies;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_body_reads_back(body in bodies()) {
            let back = LogCholesky::from_body(&body).unwrap().body();
            // The tolerance covers the rounding of square roots and exponentials.
            prop_assert!((back.theta() - body.theta()).norm() < 1e-12);
        }

        #[test]
        fn any_ten_numbers_are_a_physical_body(v in prop::array::uniform10(-2.0..2.0_f64)) {
            prop_assert!(LogCholesky(SVector::from(v)).body().is_physically_consistent());
        }

        #[test]
        fn the_jacobian_is_the_slope_of_phi(body in bodies()) {
            let at = LogCholesky::from_body(&body).unwrap();
            let jacobian = at.dphi();
            for k in 0..10 {
                let mut step = SVector::<f64, 10>::zeros();
                step[k] = 1e-5;
                let slope = (LogCholesky(at.0 + step).body().phi()
                    - LogCholesky(at.0 - step).body().phi()) / 2e-5;
                // The error is the third derivative times step², plus rounding over the step.
                prop_assert!((slope - jacobian.column(k)).norm() < 1e-8);
            }
        }
    }

    #[test]
    fn an_inconsistent_body_has_no_parameters() {
        let body = RigidBody {
            mass: 1.0_f64,
            center_of_mass: Vector3::zeros(),
            inertia: Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 2.1)),
        };
        assert!(LogCholesky::from_body(&body).is_none());
    }
}

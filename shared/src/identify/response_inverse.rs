//! Computes the motion of the body from the readings by the pseudo-inverse of the response matrix.

use nalgebra::{SVector, Vector6};

use crate::capacity::Capacity;
use crate::linalg::{Spectrum, spectrum};
use crate::real::Real;
use crate::responses::{ResponseRows, Responses};

/// `G⁺` of `xm = G [a; α]` (theory, section 3), by QR in balanced variables.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::identify::ResponseInverse;
/// # use massline_shared::nalgebra::Vector3;
/// let layout = frame::layout();
/// let response = layout.response_matrix(&Vector3::zeros());
/// let inverse = ResponseInverse::new(&response, layout.characteristic_length()).unwrap();
/// assert_eq!(inverse.rank, 6);
/// let force = layout.hits[0].unit_force(&Vector3::zeros());
/// let motion = frame::body().acceleration(&force).unwrap();
/// let readings = response.times(&motion);
/// assert!((inverse.motion(&readings) - motion).norm() < 1e-12 * motion.norm());
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseInverse<R: Real, C: Capacity> {
    /// Transpose of `G⁺`, which maps readings in m/s² to [a in m/s²; α in rad/s²]. All zero when the rank is
    /// below six.
    pub transposed: ResponseRows<R, C, 6>,
    /// Rank of `G diag(1, 1, 1, 1/L, 1/L, 1/L)`.
    pub rank: usize,
    /// Condition of that matrix; infinite when the smallest singular value is zero.
    pub condition: R,
}

impl<R: Real, C: Capacity> ResponseInverse<R, C> {
    /// Inverts a response matrix; `length` is L in m. `None` when a number is not finite.
    pub fn new(response: &ResponseRows<R, C, 6>, length: R) -> Option<Self> {
        let mut q = response.clone();
        q.0.iter_mut().skip(3).flat_map(Responses::iter_mut).for_each(|value| *value /= length);
        let factor = orthonormalise(&mut q);
        let Spectrum { rank, condition } = spectrum(&factor)?;
        let mut transposed = ResponseRows::zeros(response.sensors());
        if rank == 6 {
            for k in 0..3 * response.sensors() {
                let mut motion = SVector::from(q.row(k));
                back_substitute(&factor, &mut motion);
                motion.fixed_rows_mut::<3>(3).unscale_mut(length);
                for (column, value) in transposed.0.iter_mut().zip(&motion) {
                    column[k] = *value;
                }
            }
        }
        Some(Self { transposed, rank, condition })
    }

    /// Least squares motion `[a; α]` from the readings of one hit.
    pub fn motion(&self, readings: &Responses<R, C>) -> Vector6<R> {
        Vector6::from_fn(|i, _| self.transposed.0[i].dot(readings))
    }
}

/// Replaces the columns by orthonormal ones and returns the triangular factor. Gram-Schmidt with a second
/// pass where a column loses more than half of its square is as good as Householder (Giraud et al. 2005) and
/// leaves Q explicit. A dependent column becomes zero or leaves rounding in the factor, which its singular
/// values show.
fn orthonormalise<R: Real, C: Capacity>(q: &mut ResponseRows<R, C, 6>) -> [[R; 6]; 6] {
    let mut factor = [[R::zero(); 6]; 6];
    for k in 0..6 {
        let mut column = q.0[k].clone();
        let mut square = column.norm_squared();
        for _pass in 0..2 {
            for i in 0..k {
                let part = q.0[i].dot(&column);
                factor[i][k] += part;
                column.add_multiple(&q.0[i], -part);
            }
            let before = square;
            square = column.norm_squared();
            if square > before * R::of(0.5) {
                break;
            }
        }
        let norm = square.sqrt();
        factor[k][k] = norm;
        if norm > R::zero() {
            column.iter_mut().for_each(|value| *value /= norm);
        }
        q.0[k] = column;
    }
    factor
}

fn back_substitute<R: Real>(factor: &[[R; 6]; 6], b: &mut Vector6<R>) {
    for i in (0..6).rev() {
        for k in i + 1..6 {
            let known = b[k];
            b[i] -= factor[i][k] * known;
        }
        b[i] /= factor[i][i];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::tests::bar_layout;
    use nalgebra::{Matrix6, Vector3};

    #[test]
    fn the_response_inverse_inverts_the_response_matrix() {
        let layout = bar_layout();
        let g = layout.response_matrix(&Vector3::zeros());
        let inverse = ResponseInverse::new(&g, layout.characteristic_length()).unwrap();
        assert_eq!(inverse.rank, 6);
        // The tolerance covers rounding times the condition, 4.
        let product = Matrix6::from_fn(|i, j| inverse.transposed.0[i].dot(&g.0[j]));
        assert!((product - Matrix6::identity()).norm() < 1e-14);
        // A pseudo-inverse projects orthogonally: G G⁺ is symmetric.
        let element =
            |i, j| g.row(i).iter().zip(inverse.transposed.row(j)).map(|(a, b)| a * b).sum::<f64>();
        for i in 0..9 {
            assert!((0..i).all(|j| (element(i, j) - element(j, i)).abs() < 1e-14));
        }
    }

    #[test]
    fn too_few_sensors_show_in_the_rank() {
        let mut layout = bar_layout();
        for rank in [5, 3, 0] {
            layout.sensors.pop();
            let g = layout.response_matrix(&Vector3::zeros());
            let inverse = ResponseInverse::new(&g, layout.characteristic_length()).unwrap();
            assert_eq!(inverse.rank, rank);
            assert_eq!(inverse.transposed, ResponseRows::zeros(3));
        }
    }

    #[test]
    fn a_matrix_that_is_not_finite_is_refused() {
        let g = ResponseRows::<f32, crate::capacity::Rig, 6>(core::array::from_fn(|_| {
            Responses::repeat(3, f32::NAN)
        }));
        assert!(ResponseInverse::new(&g, 1.0).is_none());
    }
}

//! The step of Levenberg and Marquardt.

use nalgebra::{SMatrix, SVector};

use crate::linalg::{all_finite, back_substitute_transposed, cholesky, forward_substitute};
use crate::real::Real;

/// `(I + λ D)⁻¹ g` with diagonal `D`; `None` when that is not positive definite.
pub(super) fn damped_step<R: Real>(
    information: &SMatrix<R, 10, 10>,
    gradient: &SVector<R, 10>,
    damping: R,
    levels: &SVector<R, 10>,
) -> Option<SVector<R, 10>> {
    // Scaled to a unit diagonal, since the properties have different units.
    let scale = information.diagonal().zip_map(levels, |i, d| (i + damping * d).sqrt().recip());
    let mut scaled =
        SMatrix::<R, 10, 10>::from_fn(|i, j| information[(i, j)] * scale[i] * scale[j]);
    for i in 0..10 {
        scaled[(i, i)] = R::one();
    }
    if !all_finite(&scaled) {
        return None;
    }
    let factor = cholesky(&scaled)?;
    let mut step = gradient.component_mul(&scale);
    forward_substitute(&factor, &mut step);
    back_substitute_transposed(&factor, &mut step);
    step.component_mul_assign(&scale);
    all_finite(&step).then_some(step)
}

//! Checks whether an inertia tensor is that of a physical body.

use nalgebra::Matrix3;

use super::error::Fault;

/// How far the tensor may be from symmetry, relative to its trace: the rounding error of six typed digits.
const SYMMETRY_TOLERANCE: f64 = 1e-5;

/// Why a tensor is not that of a body: `tr(J)/2·I − J` must be positive semidefinite.
pub(super) fn tensor_fault(tensor: &Matrix3<f64>) -> Option<Fault> {
    let trace = tensor.trace();
    if (tensor - tensor.transpose()).amax() > SYMMETRY_TOLERANCE * trace.abs() {
        return Some(Fault::NotSymmetric);
    }
    let symmetric = (tensor + tensor.transpose()) * 0.5;
    let margin = Matrix3::identity() * (0.5 * trace) - symmetric;
    let moments = margin.try_symmetric_eigen(f64::EPSILON, 1000)?.eigenvalues;
    // For a thin rod the smallest eigenvalue is exactly zero, which typed digits can make slightly negative.
    (trace <= 0.0 || moments.min() < -SYMMETRY_TOLERANCE * trace).then_some(Fault::NoBody)
}

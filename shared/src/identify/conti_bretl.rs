//! The method of Conti and Bretl: the mass matrix as the inverse of the six mode shapes.
//!
//! Mass-normalised shapes satisfy `Φᵀ M₀ Φ = I`, so six of them give `M₀ = Φ⁻ᵀ Φ⁻¹`. The ten properties are read from
//! its elements, of which there are more than ten (theory, section 7).

use heapless::Vec;
use nalgebra::{Matrix3, Matrix6, SVector, Vector3};

use super::method::{Entry, Observable};
use super::suspension::{Answer, DOUBTS_OF_SHAPES, Suspension, is_blocked, refuse_mixed_modes};
use crate::body::{RigidBody, elements};
use crate::diagnosis::{Code, Diagnostics, fatal};
use crate::layout::balanced_motion;
use crate::linalg::spectrum;
use crate::modes::SUSPENSION_MODES;
use crate::real::Real;

/// Description of the method for the registry.
pub const ENTRY: Entry = Entry {
    name: "conti-bretl",
    short_name: "conti-bretl",
    title: "Conti-Bretl",
    summary: "Mass matrix from six mode shapes, of Conti and Bretl",
    observes: Observable::Suspension,
    uses_priors: false,
    off_when: "a mode is missing, complex or mixed with its neighbour",
    doubted_by: DOUBTS_OF_SHAPES,
    is_blocked,
    workspace: |_, _| 0,
};

/// The answer of the method, or why there is none.
pub(super) fn answer<R: Real>(suspension: &Suspension<'_, R>) -> Result<Answer<R>, Diagnostics> {
    let modes = &suspension.modes.modes;
    if modes.len() != SUSPENSION_MODES {
        return Err(fatal(Code::SixModesNeeded, R::of(modes.len() as f64)));
    }
    let length = suspension.responses.length;
    refuse_mixed_modes(suspension.modes, length)?;
    let balanced: Vec<_, SUSPENSION_MODES> =
        modes.iter().map(|mode| balanced_motion(&mode.shape, length)).collect();
    let columns = core::array::from_fn(|i| core::array::from_fn(|k| balanced[k][i]));
    let condition = spectrum::<R, 6>(&columns).map_or(R::zero(), |spectrum| spectrum.condition);
    let (_, body) = body_from_shapes(&Matrix6::from_fn(|i, k| modes[k].shape[i]))
        .ok_or_else(|| fatal(Code::TenParametersNotIdentifiable, R::zero()))?;
    Ok(Answer { body, condition, misfit: None })
}

/// The mass matrix about the origin from six mass-normalised shapes as columns, and the body that it describes; `None`
/// when the shapes are linearly dependent or a number is not finite.
///
/// The mass is the mean of three elements, `m c` the mean of the pairs of opposite sign, and the inertia about the
/// origin the symmetric part of its block. An inexact mass matrix is not quite that of a body.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::identify::conti_bretl::body_from_shapes;
/// let exact = frame::body().mass_matrix();
/// // Any Φ with M₀ = Φ⁻ᵀ Φ⁻¹ will do: here the inverse of the transposed Cholesky factor.
/// let shapes = exact.cholesky().unwrap().l().transpose().try_inverse().unwrap();
/// let (mass_matrix, body) = body_from_shapes(&shapes).unwrap();
/// assert!((mass_matrix - exact).norm() < 1e-12);
/// assert!((body.theta() - frame::body().theta()).norm() < 1e-12);
/// ```
pub fn body_from_shapes<R: Real>(shapes: &Matrix6<R>) -> Option<(Matrix6<R>, RigidBody<R>)> {
    let inverse = shapes.try_inverse()?;
    let mass_matrix = inverse.transpose() * inverse;
    let half = R::of(0.5);
    let mass = (mass_matrix[(0, 0)] + mass_matrix[(1, 1)] + mass_matrix[(2, 2)]) / R::of(3.0);
    // [h]ₓ is the block below the mass.
    let block = mass_matrix.fixed_view::<3, 3>(3, 0);
    let moment = Vector3::new(
        (block[(2, 1)] - block[(1, 2)]) * half,
        (block[(0, 2)] - block[(2, 0)]) * half,
        (block[(1, 0)] - block[(0, 1)]) * half,
    );
    let inertia: Matrix3<R> = mass_matrix.fixed_view::<3, 3>(3, 3).into_owned();
    let mut phi = SVector::<R, 10>::zeros();
    phi[0] = mass;
    phi.fixed_rows_mut::<3>(1).copy_from(&moment);
    phi.fixed_rows_mut::<6>(4).copy_from(&elements(&((inertia + inertia.transpose()) * half)));
    Some((mass_matrix, RigidBody::from_phi(&phi)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dependent_shapes_have_no_mass_matrix() {
        let mut shapes = Matrix6::<f64>::identity();
        shapes.set_column(5, &shapes.column(0).into_owned());
        assert!(body_from_shapes(&shapes).is_none());
        shapes[(0, 0)] = f64::NAN;
        assert!(body_from_shapes(&shapes).is_none());
    }
}

//! A start for mistakes with one hit that works however large they are: the linear equations of the inertia restraint
//! method (theory, section 3) with the size of the mistake as a further unknown.
//!
//! The motion `x = G⁺ a` of a hit satisfies `M(phi) x = f`. A hit of gain g satisfies `M x − g f = 0`, and one that
//! landed beside its node `M x − Σ δₖ [0; tₖ × d] = f`.

use massline_shared::body::{RigidBody, regressor};
use massline_shared::capacity::Unbounded;
use massline_shared::identify::DofMassLines;
use massline_shared::layout::HostLayout;
use nalgebra::{DMatrix, DVector, Vector2, Vector3, Vector6};

use super::sized::{Size, SizedFault, across};

/// Singular values below this part of the largest one are zero.
const SINGULAR: f64 = 1e-9;

/// Body, with everything attached to it, and size of a mistake with a hit; `None` for any other mistake, and when
/// sensors or hits do not determine them.
pub(super) fn start(
    fault: SizedFault,
    layout: &HostLayout,
    lines: &[DofMassLines<f64, Unbounded>],
) -> Option<(RigidBody<f64>, Size)> {
    let (wrong, unknowns) = match fault {
        SizedFault::HitGain { hit } => (hit, 1),
        SizedFault::HitDisplaced { hit } => (hit, 2),
        _ => return None,
    };
    let origin = Vector3::zeros();
    let channels = 3 * layout.sensors.len();
    let rows = layout.response_matrix(&origin);
    let response = DMatrix::from_fn(channels, 6, |k, j| rows.0[j][k]);
    let response = determined(response, 6)?;
    let mut left = DMatrix::zeros(6 * lines.len(), 10 + unknowns);
    let mut right = DVector::zeros(6 * lines.len());
    for (place, (index, own)) in lines.iter().enumerate() {
        let readings = DVector::from_fn(channels, |k, _| own.accelerance[k]);
        if readings.iter().any(|reading| !reading.is_finite()) {
            return None;
        }
        let motion = response.solve(&readings, 0.0).ok()?;
        let hit = layout.hits.get(*index)?;
        let mut force = hit.unit_force(&origin);
        for (i, row) in
            regressor(&Vector6::from_iterator(motion.iter().copied())).iter().enumerate()
        {
            for (k, value) in row.iter().enumerate() {
                left[(6 * place + i, k)] = *value;
            }
        }
        if *index == wrong {
            let columns = match fault {
                SizedFault::HitGain { .. } => vec![core::mem::take(&mut force)],
                _ => across(&hit.direction)
                    .column_iter()
                    .map(|t| {
                        let torque = t.cross(&Vector3::from(hit.direction));
                        Vector6::new(0.0, 0.0, 0.0, torque.x, torque.y, torque.z)
                    })
                    .collect(),
            };
            for (k, column) in columns.iter().enumerate() {
                for i in 0..6 {
                    left[(6 * place + i, 10 + k)] = -column[i];
                }
            }
        }
        for i in 0..6 {
            right[6 * place + i] = force[i];
        }
    }
    // Columns of equal length: masses and moments have different units.
    let lengths: Vec<f64> = left.column_iter().map(|column| column.norm()).collect();
    if lengths.iter().any(|length| !(*length > 0.0 && length.is_finite())) {
        return None;
    }
    for (mut column, length) in left.column_iter_mut().zip(&lengths) {
        column /= *length;
    }
    let solved = determined(left, 10 + unknowns)?.solve(&right, 0.0).ok()?;
    let value = |k: usize| solved[k] / lengths[k];
    let body = RigidBody::from_phi(&nalgebra::SVector::from_fn(|k, _| value(k)))?;
    let size = Vector2::from_fn(|k, _| if k < unknowns { value(10 + k) } else { 0.0 });
    (size.iter().all(|number| number.is_finite())).then_some((body, size))
}

/// The singular value decomposition of a finite matrix of this rank.
fn determined(
    matrix: DMatrix<f64>,
    rank: usize,
) -> Option<nalgebra::SVD<f64, nalgebra::Dyn, nalgebra::Dyn>> {
    if matrix.iter().any(|element| !element.is_finite()) {
        return None;
    }
    let decomposed = matrix.svd(true, true);
    let largest = decomposed.singular_values.max();
    (decomposed.rank(largest * SINGULAR) >= rank).then_some(decomposed)
}

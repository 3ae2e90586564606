//! More than six forces as six.
//!
//! A body on its suspension answers to a force and a torque, six numbers, whatever the number of hits. With the forces
//! as columns of `F` and the responses as columns of `Y = H F`, an orthonormal `V` that spans the rows of `F` gives
//! `Y V = H (F V)` with the same white noise, and nothing is lost.

use heapless::Vec;
use nalgebra::{Vector3, Vector6};

use super::MOST_FORCES;
use crate::Real;
use crate::layout::Layout;

/// A row whose part across the others is a smaller share of its size than this adds nothing.
const DEPENDENT: f64 = 1e-6;

/// Combinations of the hits of a layout that are used instead of the hits.
#[derive(Clone, Debug, PartialEq)]
pub struct ForceMixing<R, const H: usize> {
    /// Orthonormal columns of `V`.
    columns: Vec<[R; H], MOST_FORCES>,
    hits: usize,
}

impl<R: Real, const H: usize> ForceMixing<R, H> {
    /// The hits themselves where there are at most six, otherwise at most six combinations of them; `reference` is the
    /// point about which the torques are taken.
    pub fn of<const S: usize>(layout: &Layout<R, S, H>, reference: &Vector3<R>) -> Self {
        let hits = layout.hits.len();
        let mut columns = Vec::new();
        if hits <= MOST_FORCES {
            for hit in 0..hits {
                let mut column = [R::zero(); H];
                column[hit] = R::one();
                // There is room for every one of them.
                let _ = columns.push(column);
            }
            return Self { columns, hits };
        }
        let length = layout.characteristic_length();
        for row in 0..6 {
            let mut column = [R::zero(); H];
            for (to, hit) in column.iter_mut().zip(&layout.hits) {
                let force = hit.unit_force(reference)[row];
                *to = if row < 3 { force } else { force / length };
            }
            let size = norm(&column);
            // Twice, since once leaves rounding errors.
            for _pass in 0..2 {
                for other in &columns {
                    let along = dot(&column, other);
                    column.iter_mut().zip(other).for_each(|(to, v)| *to -= along * *v);
                }
            }
            let left = norm(&column);
            if left > size * R::of(DEPENDENT) {
                column.iter_mut().for_each(|v| *v /= left);
                // There is room for every row.
                let _ = columns.push(column);
            }
        }
        Self { columns, hits }
    }

    /// The mixed forces `[F; T]` about the reference point.
    pub(super) fn forces<const S: usize>(
        &self,
        layout: &Layout<R, S, H>,
        reference: &Vector3<R>,
    ) -> Vec<Vector6<R>, MOST_FORCES> {
        let mixed = |column: &[R; H]| {
            let parts = layout.hits.iter().zip(column);
            parts.fold(Vector6::zeros(), |sum, (hit, part)| sum + hit.unit_force(reference) * *part)
        };
        self.columns.iter().map(mixed).collect()
    }

    /// What `of_hit` gives, mixed for one force.
    pub(super) fn mixed<T>(&self, force: usize, of_hit: impl Fn(usize) -> T) -> T
    where
        T: nalgebra::ComplexField<RealField = R>,
    {
        let column = self.columns.get(force).map_or(&[][..], |column| &column[..self.hits]);
        let parts = column.iter().enumerate().filter(|(_, part)| **part != R::zero());
        parts.fold(T::zero(), |sum, (hit, part)| sum + of_hit(hit).scale(*part))
    }
}

fn dot<R: Real, const H: usize>(a: &[R; H], b: &[R; H]) -> R {
    a.iter().zip(b).fold(R::zero(), |sum, (a, b)| sum + *a * *b)
}

fn norm<R: Real, const H: usize>(a: &[R; H]) -> R {
    dot(a, a).sqrt()
}

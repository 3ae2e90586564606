//! More than six forces as six.
//!
//! A body on its suspension answers to a force and a torque, six numbers, whatever the number of hits. With the forces
//! as columns of `F` and the responses as columns of `Y = H F`, an orthonormal `V` that spans the rows of `F` gives
//! `Y V = H (F V)` with the same white noise, and nothing is lost.

use heapless::Vec;
use nalgebra::{Vector3, Vector6};

use super::MOST_FORCES;
use crate::capacity::Capacity;
use crate::layout::{Hit, Layout};
use crate::linalg::dot;
use crate::real::Real;

/// A row whose part across the others is a smaller share of its size than this adds nothing.
const DEPENDENT: f64 = 1e-6;

/// Combinations of the hits of a layout that are used instead of the hits.
#[derive(Clone, Debug, PartialEq)]
pub struct ForceMixing<R: Real, C: Capacity> {
    /// Orthonormal columns of `V`.
    columns: Vec<C::Hits<R>, MOST_FORCES>,
}

impl<R: Real, C: Capacity> ForceMixing<R, C> {
    /// The hits themselves where there are at most six, otherwise at most six combinations of them; `reference` is the
    /// point about which the torques are taken.
    pub fn of(layout: &Layout<R, C>, reference: &Vector3<R>) -> Self {
        let hits = layout.hits.len();
        let mut columns = Vec::new();
        if hits <= MOST_FORCES {
            for hit in 0..hits {
                let only = |other| if other == hit { R::one() } else { R::zero() };
                // There is room for every one of them.
                let _ = columns.push((0..hits).map(only).collect());
            }
            return Self { columns };
        }
        let length = layout.characteristic_length();
        for row in 0..6 {
            let of_hit = |hit: &Hit<R>| {
                let force = hit.unit_force(reference)[row];
                if row < 3 { force } else { force / length }
            };
            let mut column: C::Hits<R> = layout.hits.iter().map(of_hit).collect();
            let size = norm(&column);
            // Twice, since once leaves rounding errors.
            for _pass in 0..2 {
                for other in &columns {
                    let other: &C::Hits<R> = other;
                    let along = dot(&column, other);
                    column.iter_mut().zip(other.iter()).for_each(|(to, v)| *to -= along * *v);
                }
            }
            let left = norm(&column);
            if left > size * R::of(DEPENDENT) {
                column.iter_mut().for_each(|v| *v /= left);
                // There is room for every row.
                let _ = columns.push(column);
            }
        }
        Self { columns }
    }

    /// The mixed forces `[F; T]` about the reference point.
    pub(super) fn forces(
        &self,
        layout: &Layout<R, C>,
        reference: &Vector3<R>,
    ) -> Vec<Vector6<R>, MOST_FORCES> {
        let mixed = |column: &C::Hits<R>| {
            let parts = layout.hits.iter().zip(column.iter());
            parts.fold(Vector6::zeros(), |sum, (hit, part)| sum + hit.unit_force(reference) * *part)
        };
        self.columns.iter().map(mixed).collect()
    }

    /// What `of_hit` gives, mixed for one force.
    pub(super) fn mixed<T>(&self, force: usize, of_hit: impl Fn(usize) -> T) -> T
    where
        T: nalgebra::ComplexField<RealField = R>,
    {
        let column = self.columns.get(force).map_or(&[][..], |column| &column[..]);
        let parts = column.iter().enumerate().filter(|(_, part)| **part != R::zero());
        parts.fold(T::zero(), |sum, (hit, part)| sum + of_hit(hit).scale(*part))
    }
}

fn norm<R: Real>(a: &[R]) -> R {
    dot(a, a).sqrt()
}

//! Weights of the equations of a hit.
//!
//! The actual force differs from the nominal one: the hammer lands beside its mark and is tilted. Along the
//! push the force is measured by the hammer; its transverse components and the torques are known only as well
//! as the person hits. When hits scatter by 2 mm and 30 mrad, equations with these weights are on average 1.2
//! times better over the paper's four tests than equal ones, and 1.5 times better in the worst property;
//! weights from 2 to 4 times those numbers work equally well.

use nalgebra::{Matrix3, Matrix6, Vector3};

use crate::linalg::{cholesky, lower_places, skew};
use crate::real::Real;

/// The weights of the equations of the inertia restraint method.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Weighting<R> {
    /// Equal weights, as in the literature.
    #[default]
    Equal,
    /// Weights from the placement errors.
    Placement(PlacementErrors<R>),
}

/// Expected errors of a person with a hammer and of the responses, as standard deviations. Only their ratios
/// matter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacementErrors<R> {
    /// Position error of one hit across its direction, m.
    pub hit_position: R,
    /// Direction error of one hit about each axis across its direction, rad.
    pub hit_direction: R,
    /// Error of the measured motion, times the mass matrix, over the force.
    pub response: R,
}

impl<R: Real> Default for PlacementErrors<R> {
    /// The budget of theory, section 9: 3 mm, 50 mrad; gain, cross-axis and rotation of the sensors together
    /// give 2 %.
    fn default() -> Self {
        Self { hit_position: R::of(0.003), hit_direction: R::of(0.05), response: R::of(0.02) }
    }
}

impl<R: Real> PlacementErrors<R> {
    /// Lower triangular `C` with `C Cᵀ` the covariance of the balanced force and torque (torque over
    /// `length`) of a unit force along `direction` at `arm` from the reference point, averaged over
    /// `hits` hits: `[s_q² F_q F_qᵀ + s_d² F_d F_dᵀ]/n + s_r² I` (theory, section 4). `None` when it
    /// is not positive definite.
    pub(crate) fn factor(
        &self,
        arm: &Vector3<R>,
        direction: &Vector3<R>,
        length: R,
        hits: u16,
    ) -> Option<Triangle6<R>> {
        // With P = I − d dᵀ: P P = P and [d]ₓ P [d]ₓᵀ = P, so few products remain.
        let across = Matrix3::identity() - direction * direction.transpose();
        let lever = skew(&(arm / length));
        let turning = lever * across;
        let averaged = R::of(f64::from(hits.max(1))).recip();
        let direction_error = self.hit_direction * self.hit_direction * averaged;
        let position_error = self.hit_position / length;
        let position_error = position_error * position_error * averaged;
        let mut covariance = Matrix6::<R>::zeros();
        let mut lower = |i, j, block: Matrix3<R>| {
            covariance.fixed_view_mut::<3, 3>(i, j).copy_from(&block);
        };
        // The factor reads the lower triangle only.
        lower(0, 0, across * direction_error);
        lower(3, 0, turning * direction_error);
        lower(3, 3, turning * lever.transpose() * direction_error + across * position_error);
        for i in 0..6 {
            covariance[(i, i)] += self.response * self.response;
        }
        cholesky(&covariance).map(|factor| Triangle6::of(&factor))
    }
}

/// A lower triangular matrix of six rows, row by row. The upper half would waste memory for every hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Triangle6<R>([R; 21]);

impl<R: Real> Triangle6<R> {
    fn of(factor: &Matrix6<R>) -> Self {
        let mut places = lower_places();
        Self([(); 21].map(|()| places.next().map_or_else(R::zero, |place| factor[place])))
    }
}

/// `C⁻¹ rows` in place, by forward substitution.
pub(crate) fn whiten<R: Real, const N: usize>(factor: &Triangle6<R>, rows: &mut [[R; N]; 6]) {
    let mut left = factor.0.as_slice();
    for i in 0..6 {
        let (done, rest) = rows.split_at_mut(i);
        let Some(row) = rest.first_mut() else { return };
        let Some((factors, below)) = left.split_at_checked(i) else { return };
        for (f, above) in factors.iter().zip(done) {
            for (value, above) in row.iter_mut().zip(above) {
                *value -= *f * *above;
            }
        }
        let Some((pivot, next)) = below.split_first() else { return };
        let pivot = pivot.recip();
        for value in row {
            *value *= pivot;
        }
        left = next;
    }
}

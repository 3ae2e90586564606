//! What all hits at a DOF have in common: the errors of the mark, the side of it on which they land, and how
//! the tip of the hammer pushes.

use massline_shared::layout::HitUncertainty;
use nalgebra::{Matrix3, Vector3};
use rand_chacha::ChaCha8Rng;

use super::error_sizes::ErrorSizes;
use super::errors::{normal, normal_vector};
use super::faults;
use crate::bench::Bench;

/// Forces of the tip that the hammer does not measure, in addition to the force along its axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tip {
    /// Lateral force per unit force, body frame.
    pub lateral: Vector3<f64>,
    /// Free moment per unit force, body frame, m.
    pub moment_m: Vector3<f64>,
}

/// What all hits at a DOF have in common.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct HitHabit {
    /// From the mark to the mean point of impact, body frame, m.
    pub(super) offset: Vector3<f64>,
    /// What turns the unit vector along the mark to the mean direction of the force, across it.
    pub(super) turn: Vector3<f64>,
    pub(super) tip: Tip,
    /// Relative error of the hammer's gain at this DOF against the others.
    pub(super) gain_error: f64,
}

impl HitHabit {
    /// Draws the directions for a DOF that is hit along this unit vector.
    ///
    /// The same random numbers are drawn whatever the settings.
    pub(super) fn draw(
        bench: &Bench,
        sizes: &ErrorSizes,
        dof: usize,
        along: &Vector3<f64>,
        hits_axis: &Vector3<f64>,
        rng: &mut ChaCha8Rng,
    ) -> Self {
        let tap = &bench.tap;
        let of_mark = sizes.hits.get(dof).copied().unwrap_or_else(HitUncertainty::none);
        let across = Matrix3::identity() - along * along.transpose();
        let [beside, lateral] = [(); 2].map(|()| (across * normal_vector(rng)).normalize());
        let axis = normal_vector(rng).normalize();
        let [displaced, turned] = [(); 2].map(|()| across * normal_vector(rng));
        Self {
            offset: beside * (tap.offset_m + faults::beside(bench, dof))
                + displaced * of_mark.node_position,
            turn: turned * of_mark.node_direction
                + turned.normalize() * faults::lean(bench, dof)
                + hits_axis.cross(along) * faults::common_turn(bench),
            tip: Tip { lateral: lateral * tap.lateral, moment_m: axis * tap.free_moment_m },
            gain_error: normal(rng) * sizes.apparatus.hit_gain,
        }
    }
}

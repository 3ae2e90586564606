//! Whether the points that are hit move at the resonances as accelerations do.

use nalgebra::Vector3;

use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostics, fatal};
use crate::frequency_responses::FrequencyResponses;
use crate::identify::driving_points::{
    AGAINST_THE_FORCE, PointMotion, point_motions, reversed_points,
};
use crate::layout::Layout;
use crate::modes::Lines;
use crate::real::Real;

/// Part of the lines at which the real part of a mobility has one sign: all, but for noise. That of an accelerance
/// changes its sign at every mode.
const OF_ONE_SIGN: f64 = 0.85;

/// Errors for hits whose point moves against the force at these lines, near which an accelerance is imaginary, and for
/// responses of another quantity.
pub(super) fn suspect_points<R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    readings: &FrequencyResponses<'_, R>,
    reference: &Vector3<R>,
    lines: &Lines,
) -> Diagnostics {
    let all_lines = lines.below.iter().chain(&lines.above).copied();
    let points = point_motions(layout, readings, reference, all_lines);
    points.map_or_else(Diagnostics::new, |points| suspects(&points))
}

/// The same from the motions of these points.
fn suspects<R: Real>(points: &[PointMotion<R>]) -> Diagnostics {
    // Of all hits together: the real part of one accelerance may have its sign at nearly all lines.
    let mean = |part: fn(&PointMotion<R>) -> R| {
        points.iter().fold(R::zero(), |sum, point| sum + part(point)) / R::of(points.len() as f64)
    };
    let is_kept = |part: R, share: f64| part > R::of(share) || part < R::of(1.0 - share);
    let real_is_kept = is_kept(mean(|point| point.real_negative), OF_ONE_SIGN);
    if real_is_kept && !is_kept(mean(|point| point.imaginary_negative), AGAINST_THE_FORCE) {
        return fatal(Code::LooksLikeMobility, R::zero());
    }
    reversed_points(points, PointMotion::gives_power)
}

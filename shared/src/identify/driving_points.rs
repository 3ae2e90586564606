//! How the points that are hit move: with, against or a quarter of a period behind the force, line by line.
//!
//! A body moves with the force above its suspension modes and takes up power at every line. A point that does neither
//! has a reversed hammer or is not where the layout has it; points that all do so have responses of another quantity.

use nalgebra::{Complex, Vector3, Vector6};

use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity, Subject, fatal};
use crate::frequency_responses::FrequencyResponses;
use crate::layout::Layout;
use crate::modes::reduce_line;
use crate::real::Real;

/// Part of the lines at which a point moves against its force from which it is reversed. Noise looks like that at half
/// of them, and an elastic mode turns a point for a part of the band.
pub(in crate::identify) const AGAINST_THE_FORCE: f64 = 0.75;

/// How the point of a hit moves over some lines, in the direction of the hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointMotion<R> {
    /// Sum of the imaginary parts of its accelerance, (m/s²)/N: the power that a resonance takes up.
    pub power: R,
    /// Part of the lines at which the imaginary part is negative.
    pub imaginary_negative: R,
    /// Part of the lines at which the real part is negative: the point moves against the force.
    pub real_negative: R,
}

impl<R: Real> PointMotion<R> {
    /// True for a point that moves against the force at nearly all lines, where the body moves with it.
    pub fn is_against_force(&self) -> bool {
        self.real_negative > R::of(AGAINST_THE_FORCE)
    }

    /// True for a point that gives power at nearly all lines, which lie near resonances.
    pub(in crate::identify) fn gives_power(&self) -> bool {
        self.power < R::zero() && self.imaginary_negative > R::of(AGAINST_THE_FORCE)
    }
}

/// The motion of the point of each hit of the layout at these lines; `None` when the sensors do not see all motions of
/// the body, and without lines.
pub fn point_motions<R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    readings: &FrequencyResponses<'_, R>,
    reference: &Vector3<R>,
    lines: impl Iterator<Item = usize>,
) -> Option<C::Hits<PointMotion<R>>> {
    points_at_lines(layout, reference, lines, |line, motions| {
        reduce_line(layout, readings, reference, line, motions).map(|_| ())
    })
}

/// The same from the motion of the reference point under every hit: `motions` gives those of a line.
pub(in crate::identify) fn points_at_lines<R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    reference: &Vector3<R>,
    lines: impl Iterator<Item = usize>,
    mut motions: impl FnMut(usize, &mut [Vector6<Complex<R>>]) -> Option<()>,
) -> Option<C::Hits<PointMotion<R>>> {
    let forces: C::Hits<_> = layout.hits.iter().map(|hit| hit.unit_force(reference)).collect();
    let none =
        PointMotion { power: R::zero(), imaginary_negative: R::zero(), real_negative: R::zero() };
    let mut points: C::Hits<_> = forces.iter().map(|_| none).collect();
    let mut of_hits: C::Hits<_> = forces.iter().map(|_| Vector6::zeros()).collect();
    let mut count = R::zero();
    let one_if = |is: bool| if is { R::one() } else { R::zero() };
    for line in lines {
        motions(line, &mut of_hits)?;
        count += R::one();
        for (point, (force, motion)) in points.iter_mut().zip(forces.iter().zip(of_hits.iter())) {
            let [real, imaginary] =
                [motion.map(|y| y.re), motion.map(|y| y.im)].map(|part| part.dot(force));
            point.power += imaginary;
            point.imaginary_negative += one_if(imaginary < R::zero());
            point.real_negative += one_if(real < R::zero());
        }
    }
    if count == R::zero() {
        return None;
    }
    for point in points.iter_mut() {
        point.imaginary_negative /= count;
        point.real_negative /= count;
    }
    Some(points)
}

/// The error about points that are reversed: `driving_point_reversed` for each, or `all_points_reversed` when several
/// are hit and all are.
pub fn reversed_points<R>(
    points: &[PointMotion<R>],
    is_reversed: impl Fn(&PointMotion<R>) -> bool,
) -> Diagnostics {
    if points.len() > 1 && points.iter().all(&is_reversed) {
        return fatal(Code::AllPointsReversed, 0.0);
    }
    let reversed = points.iter().enumerate().filter(|(_, point)| is_reversed(point));
    let named = |(hit, _): (usize, &PointMotion<R>)| {
        let subject = Subject::hit(hit);
        Diagnostic::about(Code::DrivingPointReversed, Severity::Error, subject, 0.0)
    };
    // More than there is room for are not named.
    reversed.map(named).take(Diagnostics::new().capacity()).collect()
}

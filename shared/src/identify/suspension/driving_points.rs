//! How the points that are hit move at the resonances: with, against or a quarter of a period behind the force.

use nalgebra::{Complex, Vector3, Vector6};

use crate::Real;
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity, Subject, fatal};
use crate::frequency_responses::FrequencyResponses;
use crate::layout::Layout;
use crate::modes::{Lines, reduce_line};

/// Part of the lines at which a point moves against its force from which it is reversed. A body takes up power at every line;
/// noise looks like that at half of them.
const AGAINST_THE_FORCE: f64 = 0.75;
/// Part of the lines at which the real part of a mobility has one sign: all, but for noise. That of an accelerance changes its
/// sign at every mode.
const OF_ONE_SIGN: f64 = 0.85;

/// At how many lines the response of a point has which sign.
#[derive(Clone, Copy)]
struct Signs<R> {
    power: R,
    imaginary_negative: usize,
    real_negative: usize,
}

/// Errors for hits whose point moves against the force at these lines, near which an accelerance is imaginary, and for responses
/// of another quantity.
pub(super) fn suspect_points<R: Real, const S: usize, const H: usize>(
    layout: &Layout<R, S, H>,
    readings: &FrequencyResponses<'_, R>,
    reference: &Vector3<R>,
    lines: &Lines,
) -> Diagnostics {
    let none = Signs { power: R::zero(), imaginary_negative: 0, real_negative: 0 };
    let mut signs = [none; H];
    let signs = &mut signs[..layout.hits.len()];
    let mut motions = [Vector6::<Complex<R>>::zeros(); H];
    let motions = &mut motions[..layout.hits.len()];
    for line in lines.below.iter().chain(&lines.above) {
        if reduce_line(layout, readings, reference, *line, motions).is_none() {
            return Diagnostics::new();
        }
        for (hit, (motion, signs)) in motions.iter().zip(signs.iter_mut()).enumerate() {
            let force = layout.hits[hit].unit_force(reference);
            let [real, imaginary] =
                [motion.map(|y| y.re), motion.map(|y| y.im)].map(|part| part.dot(&force));
            signs.power += imaginary;
            signs.imaginary_negative += usize::from(imaginary < R::zero());
            signs.real_negative += usize::from(real < R::zero());
        }
    }
    let count = (lines.below.len() + lines.above.len()) as f64;
    let negative = |number: usize| number as f64 / count;
    let is_reversed = |signs: &Signs<R>| {
        signs.power < R::zero() && negative(signs.imaginary_negative) > AGAINST_THE_FORCE
    };
    // Of all hits together: the real part of one accelerance may have its sign at nearly all lines.
    let share = |number: fn(&Signs<R>) -> usize| {
        let all = signs.iter().fold(0, |sum, signs| sum + number(signs));
        negative(all) / signs.len() as f64
    };
    let [real, imaginary] =
        [share(|signs| signs.real_negative), share(|signs| signs.imaginary_negative)];
    let is_kept = |part: f64, of: f64| part > of || part < 1.0 - of;
    if is_kept(real, OF_ONE_SIGN) && !is_kept(imaginary, AGAINST_THE_FORCE) {
        return fatal(Code::LooksLikeMobility, R::zero());
    }
    if layout.hits.len() > 1 && signs.iter().all(is_reversed) {
        return fatal(Code::AllPointsReversed, R::zero());
    }
    let reversed = signs.iter().enumerate().filter(|(_, signs)| is_reversed(signs));
    let named = |(hit, _): (usize, &Signs<R>)| {
        let subject = Subject::hit(hit);
        Diagnostic::about(Code::DrivingPointReversed, Severity::Error, subject, 0.0)
    };
    // More than there is room for are not named.
    reversed.map(named).take(Diagnostics::new().capacity()).collect()
}

//! The answers of the methods for the object itself, and the modes again after a change.

use heapless::Vec;
use nalgebra::{Complex, SVector, Vector3};

use super::known::known_properties;
use super::{Answer, Suspension};
use crate::body::RigidBody;
use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostics, fatal};
use crate::identify::{Method, random_signs};
use crate::layout::Layout;
use crate::modes::{
    Lines, LinesPerSide, MOST_LINES, MOST_PAIRS, Modes, OriginResponses, Peak, Poles, choose_lines,
};
use crate::real::Real;

/// What the methods see of a test or of a change of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct MethodInput<'a, R> {
    pub(super) responses: &'a OriginResponses<'a, R>,
    pub(super) modes: &'a Modes<R>,
    pub(super) lines: &'a Lines,
    /// Standard deviation of the noise of a reading, (m/s²)/N, of a complex number.
    pub(super) noise: R,
}

/// The answer of a method, as a body in the body frame without the attached ones.
///
/// # Errors
/// Those of the method, and `mass_not_positive`.
pub(super) fn answer<R: Real, C: Capacity>(
    method: Method,
    layout: &Layout<R, C>,
    reference: &Vector3<R>,
    observed: &MethodInput<'_, R>,
) -> Result<Answer<R>, Diagnostics> {
    // About the reference point, with the attached bodies, for this expected mass in kg.
    let with_mass = |mass: R| {
        let known = known_properties(layout, reference, mass);
        let MethodInput { responses, modes, lines, noise } = *observed;
        let suspension = Suspension { responses, modes, lines, noise, known: &known };
        method.of_suspension(&suspension).unwrap_or_else(|| Err(fatal(Code::FrfMissing, R::zero())))
    };
    let mut answer = with_mass(R::one())?;
    // The weight of a known centre of mass depends on the mass.
    if layout.priors.iter().any(|prior| (1..4).contains(&prior.property)) {
        answer = with_mass(answer.body.mass)?;
    }
    of_object(layout, reference, &answer)
}

/// An answer about the reference point with the attached bodies, as a body in the body frame without them.
///
/// # Errors
/// `mass_not_positive`.
fn of_object<R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    reference: &Vector3<R>,
    answer: &Answer<R>,
) -> Result<Answer<R>, Diagnostics> {
    let mut phi = answer.body.shifted_to(&-*reference).phi();
    for attached in &layout.attached {
        phi -= SVector::from(attached.phi);
    }
    let body = RigidBody::from_phi(&phi).filter(|body| body.mass > R::zero());
    let body = body.ok_or_else(|| fatal(Code::MassNotPositive, phi[0]))?;
    Ok(Answer { body, ..*answer })
}

/// The noise of the reading with this place in a draw; `sigma` is the standard deviation of a complex number.
pub(super) fn noise_in_draw<R: Real>(sigma: R, draw: u32, place: usize) -> Complex<R> {
    let part = sigma * R::of(core::f64::consts::FRAC_1_SQRT_2);
    let [re, im] = random_signs(draw, place).map(|sign| part * R::of(f64::from(sign)));
    Complex::new(re, im)
}

/// The places among `new_poles` of those poles that `kept` are places of in `poles`. Noise may change the order of
/// close modes, or find one where there was none. `None` when two of them are found as one.
pub(super) fn found_again<R: Real>(
    new_poles: &Poles<R>,
    poles: &Poles<R>,
    kept: impl Iterator<Item = usize>,
) -> Option<Vec<usize, MOST_PAIRS>> {
    let nearest = |kept: usize| {
        let distance = |place: &usize| (new_poles[*place] - poles[kept]).norm_sqr();
        let nearer = |a: usize, b: usize| if distance(&b) < distance(&a) { b } else { a };
        (0..new_poles.len()).reduce(nearer)
    };
    let places: Vec<usize, MOST_PAIRS> = kept.map(nearest).collect::<Option<_>>()?;
    let twice = places.iter().enumerate().any(|(k, place)| places[..k].contains(place));
    (!twice).then_some(places)
}

/// The lines about these poles.
pub(super) fn lines_about<R: Real>(
    poles: &Poles<R>,
    s: &[Complex<R>],
    per_side: LinesPerSide,
) -> Lines {
    let peak = |pole: &Complex<R>| {
        let size = pole.norm_sqr().sqrt();
        Peak { frequency_hz: size / R::two_pi(), damping_ratio: -pole.re / size }
    };
    let peaks: Vec<_, MOST_PAIRS> = poles.iter().map(peak).collect();
    let frequencies: Vec<R, MOST_LINES> = s.iter().map(|s| s.im / R::two_pi()).collect();
    choose_lines(&frequencies, &peaks, per_side)
}

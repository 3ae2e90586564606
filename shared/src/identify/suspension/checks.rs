//! What the modes of a test say about its quality.

use nalgebra::{Complex, SVector};

use crate::body::scale;
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity, Subject};
use crate::modes::{Mode, Modes, OriginResponses, best_force, norm_indicator};
use crate::real::Real;
use crate::sorting::sort_short;

use super::selection::NO_MODE;

/// Imaginary over real part of the residues above which a mode is complex. Modal methods are off by its square.
const COMPLEX: f64 = 0.1;
/// Bandwidths between two modes below which their shapes mix.
const CLOSE: f64 = 1.0;
/// Bandwidths that the band must reach beyond a mode.
const BEYOND: f64 = 1.0;
/// Largest Norm Indicator of a mode over the median below which it is poorly excited.
const POOR: f64 = 0.1;
/// Imaginary over real part of the residues from which a pole within the band may be noise as well as a mode.
const DOUBTFUL: f64 = 0.5;
/// Share of the residues of a mode that no shape explains from which it is two modes.
const MIXED: f64 = 0.2;
/// Standard deviation of a property relative to its scale above which it is not determined: the interval then contains
/// zero and twice the property of a body as large as the layout.
const UNDETERMINED: f64 = 0.5;

/// Share of a mode's amplitude at the end of a record above which there is no answer: at 3 % the methods are off by
/// twenty of their standard deviations, and in proportion below.
const LEFT: f64 = 0.01;
/// The same above which an answer may be off by its standard deviation.
const LEFT_NOTICEABLE: f64 = 0.001;
/// Part by which the common phase of a mode may differ from that of a record that ends too early.
const AS_EXPECTED: f64 = 0.5;
/// Common phase of a mode over its complexity from which its residues are turned alike. Noise has the root of one over
/// the number of their elements, 0.2 for four forces.
const ALIKE: f64 = 0.7;

/// Warnings about modes: at the end of the band, complex, close to each other, poorly excited. `lines` are those of the
/// fit, ascending.
pub fn mode_findings<R: Real>(modes: &Modes<R>, responses: &OriginResponses<'_, R>) -> Diagnostics {
    let mut diagnostics = Diagnostics::new();
    let mut warn = |code: Code, place: usize, value: R| {
        let subject = Subject::mode(place);
        // There is room for sixteen diagnostics; any others are dropped.
        let _ =
            diagnostics.push(Diagnostic::about(code, Severity::Warning, subject, value.to_f32()));
    };
    let hertz = |s: Option<&Complex<R>>| s.map_or(R::zero(), |s| s.im / R::two_pi());
    let (low, high) = (hertz(responses.s.first()), hertz(responses.s.last()));
    let median = median_indicator(modes, responses.length);
    let width = |mode: &Mode<R>| R::of(2.0) * mode.damping_ratio * mode.frequency_hz;
    for (place, mode) in modes.modes.iter().enumerate() {
        let beyond = width(mode) * R::of(BEYOND);
        if mode.frequency_hz - low < beyond || high - mode.frequency_hz < beyond {
            warn(Code::ModeAtBandEdge, place, mode.frequency_hz);
        }
        if mode.complexity > R::of(COMPLEX) {
            warn(Code::ModeComplex, place, mode.complexity);
        }
        if let Some(next) = modes.modes.get(place + 1) {
            let mean = (width(mode) + width(next)) / R::of(2.0);
            let distance = (next.frequency_hz - mode.frequency_hz) / mean;
            if distance < R::of(CLOSE) {
                warn(Code::ModesClose, place, distance);
            }
        }
        let share = largest_indicator(mode, responses.length) / median;
        if share < R::of(POOR) {
            warn(Code::ModePoorlyExcited, place, share);
        } else if mode.second_shape > R::of(MIXED) {
            warn(Code::ModesNotSeparated, place, mode.frequency_hz);
        }
    }
    diagnostics
}

/// The modes that show clearly: excited well by a hit, in phase with its force, and not damped so heavily that they may
/// stand for what is smooth. `length` is L in m.
pub fn clear_modes<R: Real>(modes: &Modes<R>, length: R) -> impl Iterator<Item = &Mode<R>> {
    let least = median_indicator(modes, length) * R::of(POOR);
    modes.modes.iter().filter(move |mode| {
        largest_indicator(mode, length) >= least
            && mode.complexity < R::of(DOUBTFUL)
            && mode.damping_ratio < R::of(NO_MODE)
    })
}

/// The first mode that is two modes at nearly the same frequency, which have no common shape.
pub fn mixed_mode<R: Real>(modes: &Modes<R>, length: R) -> Option<usize> {
    let median = median_indicator(modes, length);
    modes.modes.iter().position(|mode| {
        let excited = largest_indicator(mode, length) >= median * R::of(POOR);
        excited && mode.second_shape > R::of(MIXED)
    })
}

/// The refusal of a method that needs the shape of every mode.
pub(in crate::identify) fn refuse_mixed_modes<R: Real>(
    modes: &Modes<R>,
    length: R,
) -> Result<(), Diagnostics> {
    let Some(place) = mixed_mode(modes, length) else { return Ok(()) };
    let (code, subject) = (Code::ModesNotSeparated, Subject::mode(place));
    let value = modes.modes[place].frequency_hz.to_f32();
    let reason = Diagnostic::about(code, Severity::Error, subject, value);
    Err(core::iter::once(reason).collect())
}

/// A finding about the mode of which most is left at the end of a record of this length, s, where the shapes show that
/// the records really ended there; `decay` is σ of the exponential window, 1/s. An error where too much is left for an
/// answer.
///
/// A record that ends after `T` multiplies the residues of a mode by `1 − e^{(p − σ)T}` at the lines `k/T`, which turns
/// all of them by the same known angle. Responses of another origin (stepped sines, a longer record) are not turned
/// like that, and noise and other damping turn them to either side.
pub fn truncated_mode<R: Real>(modes: &Modes<R>, record_s: R, decay: R) -> Option<Diagnostic> {
    let one = Complex::new(R::one(), R::zero());
    let figures = modes.modes.iter().zip(&modes.poles).map(|(mode, pole)| {
        let left = ((pole.re - decay) * record_s).exp();
        let (sin, cos) = (pole.im * record_s).sin_cos();
        let factor = one - Complex::new(left * cos, left * sin);
        let expected = factor.im / factor.re;
        let as_expected =
            (mode.common_phase - expected).abs() < expected.abs() * R::of(AS_EXPECTED);
        (left, as_expected && mode.common_phase.abs() > mode.complexity * R::of(ALIKE))
    });
    // Most modes have to show it.
    let shows = figures.clone().filter(|(_, is_shown)| *is_shown).count();
    let (place, (left, ..)) =
        figures.enumerate().reduce(|most, next| if next.1.0 > most.1.0 { next } else { most })?;
    let severity = if left > R::of(LEFT) { Severity::Error } else { Severity::Warning };
    let truncated = left > R::of(LEFT_NOTICEABLE) && 2 * shows > modes.modes.len();
    let subject = Subject::mode(place);
    let finding = Diagnostic::about(Code::RecordTooShort, severity, subject, left.to_f32());
    truncated.then_some(finding)
}

/// The property of which the data say least, and its standard deviation relative to its scale, where that is so large
/// that there is no answer; `theta` and its standard deviations in SI units, `length` is L in m.
pub fn undetermined_property<R: Real>(
    theta: &SVector<R, 10>,
    sigma: &SVector<R, 10>,
    length: R,
) -> Option<(usize, R)> {
    let scale = scale(theta[0].abs(), length);
    let relative = (0..10).map(|k| (k, sigma[k] / scale[k]));
    let (property, share) = relative.reduce(|a, b| if b.1 > a.1 { b } else { a })?;
    (share > R::of(UNDETERMINED)).then_some((property, share))
}

fn largest_indicator<R: Real>(mode: &Mode<R>, length: R) -> R {
    let best = mode.residues.get(best_force(&mode.residues, length));
    best.map_or(R::zero(), |residue| norm_indicator(residue, length))
}

fn median_indicator<R: Real>(modes: &Modes<R>, length: R) -> R {
    let mut indicators: heapless::Vec<R, { crate::modes::MOST_PAIRS }> =
        modes.modes.iter().map(|mode| largest_indicator(mode, length)).collect();
    sort_short(&mut indicators, |a, b| a < b);
    indicators.get(indicators.len() / 2).copied().unwrap_or(R::one())
}

#[cfg(test)]
mod tests {
    use heapless::Vec;
    use nalgebra::Vector6;

    use super::*;

    fn mode(damping_ratio: f64, complexity: f64, residue: f64) -> Mode<f64> {
        Mode {
            frequency_hz: 3.0,
            damping_ratio,
            shape: Vector6::x(),
            residues: Vec::from_slice(&[Vector6::x() * residue]).unwrap(),
            complexity,
            common_phase: 0.0,
            second_shape: 0.0,
        }
    }

    #[test]
    fn a_mode_that_is_weak_out_of_phase_or_heavily_damped_is_not_clear() {
        let clear = |last: Mode<f64>| {
            let modes = [mode(0.01, 0.05, 1.0), mode(0.02, 0.05, 1.0), last];
            let modes = modes.into_iter().collect();
            let modes = Modes { modes, poles: Vec::new(), rigid: Vec::new(), residual: 0.0 };
            clear_modes(&modes, 1.0).count()
        };
        // Just inside the three limits, and just beyond each.
        assert_eq!(clear(mode(0.29, 0.49, 0.11)), 3);
        for doubtful in [mode(0.31, 0.05, 1.0), mode(0.01, 0.51, 1.0), mode(0.01, 0.05, 0.09)] {
            assert_eq!(clear(doubtful.clone()), 2, "{doubtful:?}");
        }
    }
}

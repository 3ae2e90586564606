//! What the modes of a test say about its quality.

use nalgebra::Complex;

use crate::Real;
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity, Subject};
use crate::modes::{Mode, Modes, OriginResponses, best_force, norm_indicator};

/// Imaginary over real part of the residues above which a mode is complex. Modal methods are off by its square.
const COMPLEX: f64 = 0.1;
/// Bandwidths between two modes below which their shapes mix.
const CLOSE: f64 = 1.0;
/// Bandwidths that the band must reach beyond a mode.
const BEYOND: f64 = 1.0;
/// Largest Norm Indicator of a mode over the median below which it is poorly excited.
const POOR: f64 = 0.1;

/// Share of a mode's amplitude at the end of a record above which its shape is wrong by more than the methods are.
const LEFT: f64 = 0.05;

/// Warnings about modes: at the end of the band, complex, close to each other, poorly excited. `lines` are those of the
/// fit, ascending.
pub fn mode_findings<R: Real>(modes: &Modes<R>, responses: &OriginResponses<'_, R>) -> Diagnostics {
    let mut found = Diagnostics::new();
    let mut warn = |code: Code, place: usize, value: R| {
        let subject = Subject::mode(place);
        // There is room for sixteen diagnostics; any others are dropped.
        let _ = found.push(Diagnostic::about(code, Severity::Warning, subject, value.to_f32()));
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
        }
    }
    found
}

/// The mode of which most is left at the end of a record of this length, s, and the share that is left, where the shapes
/// show that the records really ended there.
///
/// A record that ends after `T` multiplies the residues of a mode by `1 − e^{pT}` at the lines `k/T`, which makes its shape
/// complex by a known amount. Responses of another origin (stepped sines, a longer record) have no such shapes.
pub fn truncated_mode<R: Real>(modes: &Modes<R>, record_s: R) -> Option<(usize, R)> {
    let one = Complex::new(R::one(), R::zero());
    let figures = modes.modes.iter().zip(&modes.poles).map(|(mode, pole)| {
        let left = (pole.re * record_s).exp();
        let (sin, cos) = (pole.im * record_s).sin_cos();
        let factor = one - Complex::new(left * cos, left * sin);
        (left, (factor.im / factor.re).abs(), mode.complexity)
    });
    let square = |sum: R, v: R| sum + v * v;
    let expected = figures.clone().map(|(_, expected, _)| expected).fold(R::zero(), square).sqrt();
    let seen = figures.clone().map(|(_, _, seen)| seen).fold(R::zero(), square).sqrt();
    let (place, (left, ..)) =
        figures.enumerate().reduce(|most, next| if next.1.0 > most.1.0 { next } else { most })?;
    let truncated = left > R::of(LEFT) && seen > expected * R::of(0.5);
    truncated.then_some((place, left))
}

fn largest_indicator<R: Real>(mode: &Mode<R>, length: R) -> R {
    let best = mode.residues.get(best_force(&mode.residues, length));
    best.map_or(R::zero(), |residue| norm_indicator(residue, length))
}

fn median_indicator<R: Real>(modes: &Modes<R>, length: R) -> R {
    let mut all: heapless::Vec<R, { crate::modes::MOST_PAIRS }> =
        modes.modes.iter().map(|mode| largest_indicator(mode, length)).collect();
    all.sort_unstable_by(|a, b| a.partial_cmp(b).unwrap_or(core::cmp::Ordering::Equal));
    all.get(all.len() / 2).copied().unwrap_or(R::one())
}

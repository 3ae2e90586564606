//! Which of the modes that a fit has found are those of a rigid body on its suspension.

use heapless::Vec;
use nalgebra::Complex;

use crate::diagnosis::{Code, Diagnostic, Severity};
use crate::modes::{MOST_PAIRS, Mode, Modes, SUSPENSION_MODES, norm_indicator};
use crate::real::Real;

/// Imaginary over real part of the residues up to which a narrow peak is a mode. Hum has 0.35 and more, since it has
/// any phase.
const IN_PHASE: f64 = 0.25;
/// Imaginary over real part of the residues from which a pole is no mode at all, but noise.
const OUT_OF_PHASE: f64 = 1.0;
/// Imaginary over real part of the residues up to which a peak of more than two lines is a mode: several elastic modes
/// may be found as one.
const PARTLY_IN_PHASE: f64 = 1.0;
/// Part of scale by which answers may be off from which one more mode is noticed: the height of its peak over the
/// lowest of the six, of which noise has less than 0.002, or what it makes of the body below its frequency.
const NOTICEABLE: f64 = 0.02;
/// The same from which there is no answer.
const TOO_MUCH: f64 = 0.1;
/// Damping ratio from which a pair of poles is no mode but stands for what is smooth within the band.
pub(super) const NO_MODE: f64 = 0.3;

/// The suspension modes, and what speaks against them.
pub(super) struct Selection {
    /// Places of the suspension modes.
    pub(super) kept: Vec<usize, MOST_PAIRS>,
    /// A finding about one more mode.
    pub(super) one_more: Option<Diagnostic>,
}

/// Selects the modes within the band, and at most six, since a body on its suspension has no more and any others are
/// hum, drift or an elastic mode. Those with the highest peaks are kept. `s` has the lines of the fit, ascending, and
/// `length` is L in m.
pub(super) fn select<R: Real>(modes: &Modes<R>, s: &[Complex<R>], length: R) -> Selection {
    let hertz = |s: Option<&Complex<R>>| s.map_or(R::zero(), |s| s.im / R::two_pi());
    let (low, high) = (hertz(s.first()), hertz(s.last()));
    let inside = |place: &usize| {
        let frequency = modes.modes[*place].frequency_hz;
        let in_phase = modes.modes[*place].complexity < R::of(OUT_OF_PHASE);
        in_phase && low < frequency && frequency < high
    };
    let height = |place: usize| peak(&modes.modes[place], length);
    let lower = |a: usize, b: usize| if height(b) < height(a) { b } else { a };
    let mut kept: Vec<usize, MOST_PAIRS> = (0..modes.modes.len()).filter(inside).collect();
    while kept.len() > SUSPENSION_MODES {
        let lowest = kept.iter().copied().reduce(lower);
        kept.retain(|place| Some(*place) != lowest);
    }
    let spacing = (high - low) / R::of(s.len().saturating_sub(1).max(1) as f64);
    let lowest = kept.iter().copied().reduce(lower).map_or(R::zero(), height);
    let six: Vec<&Mode<R>, MOST_PAIRS> = kept.iter().map(|place| &modes.modes[*place]).collect();
    let error = |place: usize| {
        let mode = &modes.modes[place];
        if inside(&place) { height(place) / lowest } else { flexibility(mode, &six, length) }
    };
    let others = (0..modes.modes.len()).filter(|place| !kept.contains(place));
    let others = others.filter(|place| is_mode(&modes.modes[*place], spacing));
    let worst = others.reduce(|a, b| if error(b) > error(a) { b } else { a });
    let whole = kept.len() == SUSPENSION_MODES;
    let one_more = worst.filter(|_| whole).and_then(|place| {
        let error = error(place);
        let severity = if error > R::of(TOO_MUCH) { Severity::Error } else { Severity::Warning };
        let frequency = modes.modes[place].frequency_hz.to_f32();
        let finding = Diagnostic::whole(Code::MoreModesThanSix, severity, frequency);
        (error > R::of(NOTICEABLE)).then_some(finding)
    });
    Selection { kept, one_more }
}

/// Height of the peak of a mode under all forces.
fn peak<R: Real>(mode: &Mode<R>, length: R) -> R {
    size(mode, length) / mode.damping_ratio
}

/// Norm of the residues of a mode under all forces.
fn size<R: Real>(mode: &Mode<R>, length: R) -> R {
    let square = |sum: R, residue| {
        let indicator = norm_indicator(residue, length);
        sum + indicator * indicator
    };
    mode.residues.iter().fold(R::zero(), square).sqrt()
}

/// By how much of its scale a body seems heavier at the highest of its suspension modes than it is, because a part of
/// it moves on a spring of its own with this mode outside the band: the share of the part, which is that of the
/// residues, times x²/|1 − x²| with the ratio x of the frequencies.
fn flexibility<R: Real>(mode: &Mode<R>, six: &[&Mode<R>], length: R) -> R {
    if mode.damping_ratio > R::of(NO_MODE) {
        return R::zero();
    }
    let most = |quantity: fn(&Mode<R>, R) -> R| {
        six.iter().fold(R::zero(), |top, m| top.max(quantity(m, length)))
    };
    let ratio = most(|mode, _| mode.frequency_hz) / mode.frequency_hz;
    let share = size(mode, length) / most(size);
    share * ratio * ratio / (R::one() - ratio * ratio).abs()
}

/// True for what moves in phase with the force, as modes do; `spacing` is the distance of the lines, Hz.
fn is_mode<R: Real>(mode: &Mode<R>, spacing: R) -> bool {
    let width = R::of(2.0) * mode.damping_ratio * mode.frequency_hz;
    let wide = width > R::of(2.0) * spacing;
    mode.complexity < R::of(if wide { PARTLY_IN_PHASE } else { IN_PHASE })
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector6;

    use super::*;

    /// The lines of a band up to 12.5 Hz, 0.05 Hz apart.
    fn lines() -> [Complex<f64>; 241] {
        core::array::from_fn(|line| {
            Complex::new(0.0, core::f64::consts::TAU * (0.5 + 0.05 * line as f64))
        })
    }

    fn mode(frequency_hz: f64, damping_ratio: f64, residue: f64) -> Mode<f64> {
        Mode {
            frequency_hz,
            damping_ratio,
            shape: Vector6::x() * residue.sqrt(),
            residues: Vec::from_slice(&[Vector6::x() * residue]).unwrap(),
            complexity: 0.0,
            common_phase: 0.0,
            second_shape: 0.0,
        }
    }

    /// Six modes with residues of 0.1/kg and damping of 1 %, and one more.
    fn with(one_more: Mode<f64>) -> Option<Diagnostic> {
        let (modes, poles, rigid) = (Vec::new(), Vec::new(), Vec::new());
        let mut modes = Modes { modes, poles, rigid, residual: 0.0 };
        for place in 1..=SUSPENSION_MODES {
            modes.modes.push(mode(1.5 * place as f64, 0.01, 0.1)).unwrap();
        }
        modes.modes.push(one_more).unwrap();
        let selection = select(&modes, &lines(), 1.0);
        assert_eq!(selection.kept.len(), SUSPENSION_MODES);
        selection.one_more
    }

    #[test]
    fn a_mode_outside_the_band_counts_by_what_it_makes_of_the_body() {
        // The highest of the six is at 9 Hz: (9/28)²/(1 − (9/28)²) = 0.115. With a tenth of their residues that is 1.2
        // %.
        assert_eq!(with(mode(28.0, 0.005, 0.01)), None);
        // Half of them: 5.8 %, whatever the height of the peak.
        for damping_ratio in [0.002, 0.02, 0.2] {
            let warning = with(mode(28.0, damping_ratio, 0.05)).expect("a warning");
            assert_eq!(warning.severity, Severity::Warning);
        }
        // As much: 11.5 %.
        let error = with(mode(28.0, 0.005, 0.1)).expect("an error");
        assert_eq!(error.severity, Severity::Error);
        // Two real poles, in place of which there is a pair, stand for what is smooth.
        assert_eq!(with(mode(28.0, 0.7, 1.0)), None);
    }

    #[test]
    fn a_mode_within_the_band_counts_by_its_peak() {
        assert_eq!(with(mode(11.0, 0.01, 0.001)), None);
        let severity =
            |residue| with(mode(11.0, 0.01, residue)).map(|diagnostic| diagnostic.severity);
        assert_eq!(severity(0.005), Some(Severity::Warning));
        assert_eq!(severity(0.015), Some(Severity::Error));
    }
}

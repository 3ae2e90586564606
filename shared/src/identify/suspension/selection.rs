//! Which of the modes that a fit has found are those of a rigid body on its suspension.

use heapless::Vec;
use nalgebra::Complex;

use crate::Real;
use crate::diagnosis::{Code, Diagnostic, Severity};
use crate::modes::{MOST_PAIRS, Mode, Modes, SUSPENSION_MODES, norm_indicator};

/// Imaginary over real part of the residues up to which a narrow peak is a mode. Hum has 0.35 and more, since it has any phase.
const IN_PHASE: f64 = 0.25;
/// Imaginary over real part of the residues from which a pole is no mode at all, but noise.
const OUT_OF_PHASE: f64 = 1.0;
/// Imaginary over real part of the residues up to which a peak of more than two lines is a mode: several elastic modes may be
/// found as one.
const PARTLY_IN_PHASE: f64 = 1.0;
/// What one more mode adds within the band, over the lowest peak of the six, from which answers may be off by as large a part
/// of scale. Noise has less than 0.002.
const NOTICEABLE: f64 = 0.02;
/// The same from which there is no answer.
const TOO_MUCH: f64 = 0.1;

/// The same for a mode outside the band, of which the global fit can take account unless it is larger than the modes.
const TOO_MUCH_OUTSIDE: f64 = 1.0;

/// The suspension modes, and what speaks against them.
pub(in crate::identify) struct Selection {
    /// Places of the suspension modes.
    pub(in crate::identify) kept: Vec<usize, MOST_PAIRS>,
    /// A finding about one more mode.
    pub(in crate::identify) one_more: Option<Diagnostic>,
}

/// Selects the modes within the band, and at most six, since a body on its suspension has no more and any others are hum,
/// drift or an elastic mode. Those with the highest peaks are kept. `s` has the lines of the fit, ascending, and `length`
/// is L in m.
pub(in crate::identify) fn select<R: Real>(
    all: &Modes<R>,
    s: &[Complex<R>],
    length: R,
) -> Selection {
    let hertz = |s: Option<&Complex<R>>| s.map_or(R::zero(), |s| s.im / R::two_pi());
    let (low, high) = (hertz(s.first()), hertz(s.last()));
    let inside = |place: &usize| {
        let frequency = all.modes[*place].frequency_hz;
        let in_phase = all.modes[*place].complexity < R::of(OUT_OF_PHASE);
        in_phase && low < frequency && frequency < high
    };
    let height = |place: usize| {
        let mode = &all.modes[place];
        peak(mode, length, mode.frequency_hz.max(low).min(high))
    };
    let lower = |a: usize, b: usize| if height(b) < height(a) { b } else { a };
    let mut kept: Vec<usize, MOST_PAIRS> = (0..all.modes.len()).filter(inside).collect();
    while kept.len() > SUSPENSION_MODES {
        let lowest = kept.iter().copied().reduce(lower);
        kept.retain(|place| Some(*place) != lowest);
    }
    let spacing = (high - low) / R::of(s.len().saturating_sub(1).max(1) as f64);
    let lowest = kept.iter().copied().reduce(lower).map_or(R::zero(), height);
    let others = (0..all.modes.len()).filter(|place| !kept.contains(place));
    let others = others.filter(|place| is_mode(&all.modes[*place], spacing));
    let highest = others.reduce(|a, b| if height(b) > height(a) { b } else { a });
    let whole = kept.len() == SUSPENSION_MODES;
    let one_more = highest.filter(|_| whole).and_then(|place| {
        let share = height(place) / lowest;
        let most = if inside(&place) { TOO_MUCH } else { TOO_MUCH_OUTSIDE };
        let severity = if share > R::of(most) { Severity::Error } else { Severity::Warning };
        let frequency = all.modes[place].frequency_hz.to_f32();
        let finding = Diagnostic::whole(Code::MoreModesThanSix, severity, frequency);
        (share > R::of(NOTICEABLE)).then_some(finding)
    });
    Selection { kept, one_more }
}

/// What a mode adds to the accelerances under all forces at this frequency in Hz, times two. Noise finds modes outside the
/// band whose peaks would be high, of which the band sees nothing.
fn peak<R: Real>(mode: &Mode<R>, length: R, frequency_hz: R) -> R {
    let square = |sum: R, residue| {
        let indicator = norm_indicator(residue, length);
        sum + indicator * indicator
    };
    let ratio = frequency_hz / mode.frequency_hz;
    let squared = ratio * ratio;
    let damped = R::of(2.0) * mode.damping_ratio * ratio;
    let gain = R::of(2.0) * squared / (R::one() - squared).hypot(damped);
    mode.residues.iter().fold(R::zero(), square).sqrt() * gain
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
        let mut all = Modes::empty();
        for place in 1..=SUSPENSION_MODES {
            all.modes.push(mode(1.5 * place as f64, 0.01, 0.1)).unwrap();
        }
        all.modes.push(one_more).unwrap();
        let selection = select(&all, &lines(), 1.0);
        assert_eq!(selection.kept.len(), SUSPENSION_MODES);
        selection.one_more
    }

    #[test]
    fn a_mode_outside_the_band_counts_by_what_it_adds_within() {
        // Its peak at 28 Hz would be four times as high as those of the six. At 12.5 Hz it adds twice
        // 0.2 · (12.5/28)²/(1 − (12.5/28)²) = 0.1 of the 0.1/0.01 = 10 of a peak.
        assert_eq!(with(mode(28.0, 0.005, 0.2)), None);
        // Twice 1.0 · 0.249 of 10: five per cent, which is worth a warning.
        let warning = with(mode(28.0, 0.005, 1.0)).expect("a warning");
        assert_eq!(warning.severity, Severity::Warning);
        // Just beyond the band the peak itself is nearly within: more than any of the six.
        let error = with(mode(12.6, 0.01, 0.2)).expect("an error");
        assert_eq!(error.severity, Severity::Error);
    }

    #[test]
    fn a_mode_within_the_band_counts_by_its_peak() {
        assert_eq!(with(mode(11.0, 0.01, 0.001)), None);
        let severity = |residue| with(mode(11.0, 0.01, residue)).map(|said| said.severity);
        assert_eq!(severity(0.005), Some(Severity::Warning));
        assert_eq!(severity(0.015), Some(Severity::Error));
    }
}

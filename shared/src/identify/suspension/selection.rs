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
/// Peak of one more mode over the lowest of the six from which answers may be off by as large a part of scale. Noise has
/// less than 0.002.
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
    let height = |place: usize| peak(&all.modes[place], length);
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

/// Height of the peak of a mode under all forces.
fn peak<R: Real>(mode: &Mode<R>, length: R) -> R {
    let square = |sum: R, residue| {
        let indicator = norm_indicator(residue, length);
        sum + indicator * indicator
    };
    mode.residues.iter().fold(R::zero(), square).sqrt() / mode.damping_ratio
}

/// True for what moves in phase with the force, as modes do; `spacing` is the distance of the lines, Hz.
fn is_mode<R: Real>(mode: &Mode<R>, spacing: R) -> bool {
    let width = R::of(2.0) * mode.damping_ratio * mode.frequency_hz;
    let wide = width > R::of(2.0) * spacing;
    mode.complexity < R::of(if wide { PARTLY_IN_PHASE } else { IN_PHASE })
}

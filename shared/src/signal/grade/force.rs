//! Checks the force of a hit for double hits and for excitation of the whole band.

use super::channel::Survey;
use crate::real::Real;
use crate::signal::Samples;
use crate::signal::chain::HAMMER;

/// Smallest ratio of a second peak to the largest one in a double hit.
pub(super) const SECOND_PEAK: f64 = 0.1;
/// The force has fallen back when it is below this fraction of the previous peak.
const FALLEN_BACK: f64 = 0.5;
/// A hammer cannot pull: a swing below the rest value is ringing of hammer or filter, and a swing above it of
/// less than this multiple may be ringing, too.
const ABOVE_RINGING: f64 = 2.0;
/// A second peak exceeds the noise by this number of standard deviations.
const ABOVE_NOISE: f64 = 6.0;

/// The largest peak of the force besides the main one, before or after it, relative to the main one; 0 when
/// there is none.
///
/// A second peak rises by [`SECOND_PEAK`] of the main one after the force has fallen back, and exceeds the
/// ringing of the force.
pub(super) fn second_peak<R: Real, D: Samples<R> + ?Sized>(
    record: &D,
    scale: R,
    survey: &Survey<R>,
) -> R {
    let main = survey.highest;
    let least = (main.value * R::of(SECOND_PEAK)).max(survey.spread * R::of(ABOVE_NOISE));
    if main.value <= least {
        return R::zero();
    }
    let force = |reading: R| (reading - survey.rest) * scale;
    let before = record.readings(HAMMER, 0).take(main.at).map(force);
    let after = record.readings(HAMMER, main.at).map(force);
    let second = peak_before(before, least).max(peak_after(after, main.value, least));
    second / main.value
}

/// The largest peak before the main one from which the force has fallen back.
fn peak_before<R: Real>(force: impl Iterator<Item = R>, least: R) -> R {
    let (mut peak, mut fallen, mut greatest) = (R::zero(), false, R::zero());
    let mut close = |peak: R, fallen: bool| {
        if fallen && peak >= least {
            greatest = greatest.max(peak);
        }
    };
    for value in force {
        if value > peak {
            close(peak, fallen);
            (peak, fallen) = (value, false);
        } else if value <= peak - least && value <= peak * R::of(FALLEN_BACK) {
            fallen = true;
        }
    }
    close(peak, fallen);
    greatest
}

/// The largest peak after the main one.
fn peak_after<R: Real>(force: impl Iterator<Item = R>, main: R, least: R) -> R {
    let (mut lowest, mut greatest) = (main, R::zero());
    for value in force {
        lowest = lowest.min(value);
        let risen = value - lowest.max(R::zero()) >= least;
        let rings = value < -lowest * R::of(ABOVE_RINGING);
        if lowest <= main * R::of(FALLEN_BACK) && risen && !rings {
            greatest = greatest.max(value);
        }
    }
    greatest
}

/// Level of the force's spectrum at `frequency` relative to 0 Hz, dB, for the force within `half_width` scans
/// of its peak at `rate` scans per second. `None` without an impulse.
pub(super) fn spectrum_drop<R: Real, D: Samples<R> + ?Sized>(
    record: &D,
    survey: &Survey<R>,
    half_width: usize,
    frequency: R,
    rate: R,
) -> Option<R> {
    let start = survey.highest.at.saturating_sub(half_width);
    let count = survey.highest.at + half_width + 1 - start;
    let (sin, cos) = (R::two_pi() * frequency / rate).sin_cos();
    // The window has about a hundred scans on the rig, so the recursion of the phase loses only the last few
    // digits.
    let (mut re, mut im) = (R::one(), R::zero());
    let (mut impulse, mut x, mut y) = (R::zero(), R::zero(), R::zero());
    for reading in record.readings(HAMMER, start).take(count) {
        let force = reading - survey.rest;
        impulse += force;
        x += force * re;
        y += force * im;
        (re, im) = (re * cos - im * sin, re * sin + im * cos);
    }
    let ratio = (x * x + y * y) / (impulse * impulse);
    (ratio.finite() && ratio > R::zero()).then(|| ratio.log10() * R::of(10.0))
}

//! Finds signals that an earlier stage has clipped: plateaus, at whatever level.

use core::ops::Range;

use nalgebra::{Matrix3, Vector3};

use super::channel::{ChannelRange, Extreme, Survey, moments};
use crate::Real;
use crate::signal::{HAMMER, Samples};

/// The hammer is in contact while the force is above this fraction of its peak.
const CONTACT: f64 = 0.1;
/// Readings within this fraction of the extreme count as its level; noise widens it.
const LEVEL: f64 = 0.003;
/// Largest fraction to which noise widens the level.
const NOISY_LEVEL: f64 = 0.01;
/// Smallest number of consecutive readings at the level that form a plateau.
const PLATEAU_SCANS: usize = 3;
/// Smallest ratio of the length of a plateau to the time that the signal spends above half the extreme. A
/// half sine is within 0.3 % of its peak for 7 % of that time and within 1 % for 13 %; clipped at 90 % of its
/// peak, it stays at that level for 41 %.
const PLATEAU_SHARE: f64 = 0.25;
/// A signal of fewer steps than this always has plateaus: one step is half a percent.
const STEPS: f64 = 200.0;

/// Readings within this number of standard deviations of the noise, on either side of a level, may all be at it.
const NOISE: f64 = 3.0;
/// Largest scatter of readings at one level relative to the extreme: hum before the hit is no noise.
const LEVEL_SCATTER: f64 = 0.006;
/// Smallest number of readings at one level that make a response flat.
const FLAT_SCANS: usize = 5;
/// Elastic modes that ring on after the contact may hold a response at one level during the contact for a part of
/// their period: where they ring as much as the response should have changed, it takes this many readings more.
const RINGING_SCANS: f64 = 4.0;
/// Readings at one level scatter by less than this many standard deviations of the noise.
const QUIET: f64 = 1.4;
/// A response is flat when by the change of the force it should have changed by more than this many standard
/// deviations of the noise.
const FLAT: f64 = 25.0;
/// Elastic modes that follow the force may flatten a response, and then it is a sum of the force and its second
/// derivative. It is flat when that sum misses it by more than this many standard deviations of the noise, rms.
const MISSED: f64 = 8.0;
/// What is clipped is the part of a response about its peak, and with it that of the force: the force reaches this
/// fraction of its peak on the plateau.
const AT_PEAK: f64 = 0.97;
/// Distance over which the second derivative of the force is taken, readings.
const CURVATURE_SCANS: usize = 2;

/// The readings of one channel about its rest value.
struct Signal<'a, R, D: ?Sized> {
    record: &'a D,
    channel: usize,
    rest: R,
    /// Scale that makes the extreme in question positive.
    side: R,
}

impl<R: Real, D: Samples<R> + ?Sized> Signal<'_, R, D> {
    fn value(&self, scan: usize) -> Option<R> {
        Some((self.record.reading(self.channel, scan)? - self.rest) * self.side)
    }

    /// The scans about `at` during which the signal stays at or above a bound.
    fn above(&self, at: usize, bound: R) -> Range<usize> {
        let above = |scan: &usize| self.value(*scan).is_some_and(|value| value >= bound);
        let after = (at..self.record.scans()).take_while(above).count();
        let before = (0..at).rev().take_while(above).count();
        at - before..at + after
    }
}

/// True when the signal has a plateau at its extreme, like a clipped one.
///
/// During the contact the response of a rigid body has the shape of the force, so a response that stays at one
/// level while the force changes is clipped, at whatever level. At other times, and for the force itself, the
/// plateau is compared with the shape of a half sine.
pub(super) fn flat_top<R: Real, D: Samples<R> + ?Sized>(
    record: &D,
    channel: usize,
    range: &ChannelRange<R>,
    survey: &Survey<R>,
    extreme: &Extreme<R>,
    force: Option<(&Survey<R>, R)>,
) -> bool {
    let height = extreme.value.abs();
    // Makes the extreme positive even when it is below the rest value.
    let side = if extreme.value < R::zero() { -range.scale } else { range.scale };
    let signal = Signal { record, channel, rest: survey.rest, side };
    if let Some((force, scale)) = force {
        let push = Signal { record, channel: HAMMER, rest: force.rest, side: scale };
        let contact = push.above(force.highest.at, force.highest.value * R::of(CONTACT));
        if contact.contains(&extreme.at) {
            let noise = survey.spread.max(range.resolution * R::of(0.5));
            return ignores_force(&signal, &push, extreme.at, contact, noise);
        }
    }
    if height < range.resolution * R::of(STEPS) || height <= R::zero() {
        return false;
    }
    let noise = (survey.spread * R::of(NOISE)).min(height * R::of(NOISY_LEVEL));
    let level = height - noise.max(height * R::of(LEVEL));
    let plateau = signal.above(extreme.at, level).len();
    let half = signal.above(extreme.at, height * R::of(0.5)).len();
    plateau >= PLATEAU_SCANS && plateau as f64 >= PLATEAU_SHARE * half as f64
}

/// Root mean square of what a sum of the force, its second derivative and a constant leaves of a response over
/// these scans; `None` when they do not determine the sum.
fn missed_by_force<R: Real, D: Samples<R> + ?Sized>(
    response: &Signal<'_, R, D>,
    push: &Signal<'_, R, D>,
    scans: Range<usize>,
) -> Option<R> {
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    let (mut squares, mut count) = (R::zero(), R::zero());
    for scan in scans {
        let at = |scan: usize| push.value(scan);
        let force = at(scan)?;
        let curvature =
            at(scan + CURVATURE_SCANS)? + at(scan.checked_sub(CURVATURE_SCANS)?)? - force - force;
        let row = Vector3::new(force, curvature, R::one());
        let value = response.value(scan)?;
        normal += row * row.transpose();
        right += row * value;
        squares += value * value;
        count += R::one();
    }
    let solved = normal.try_inverse()? * right;
    Some(((squares - solved.dot(&right)).max(R::zero()) / count).sqrt())
}

/// Amplitude at which a response rings on, over a time as long as the contact from a quarter of it after its end:
/// until then the low-pass filters pass on the end of the contact.
fn ringing<R: Real, D: Samples<R> + ?Sized>(
    response: &Signal<'_, R, D>,
    contact: &Range<usize>,
) -> R {
    let start = contact.end + contact.len() / 4;
    let mut values = (start..start + contact.len()).filter_map(|scan| response.value(scan));
    let Some(first) = values.next() else { return R::zero() };
    let (low, high) =
        values.fold((first, first), |(low, high), value| (low.min(value), high.max(value)));
    (high - low) * R::of(0.5)
}

/// True when a response stays at its extreme, which it has at a scan of the contact, while the force changes.
fn ignores_force<R: Real, D: Samples<R> + ?Sized>(
    response: &Signal<'_, R, D>,
    push: &Signal<'_, R, D>,
    at: usize,
    contact: Range<usize>,
    noise: R,
) -> bool {
    let Some(height) = response.value(at) else { return false };
    let plateau = response.above(at, height - noise * R::of(2.0 * NOISE));
    if plateau.len() < FLAT_SCANS {
        return false;
    }
    let (mut low, mut high) = (R::zero(), R::zero());
    for (count, force) in plateau.clone().filter_map(|scan| push.value(scan)).enumerate() {
        low = if count == 0 { force } else { low.min(force) };
        high = high.max(force);
    }
    let peak = contact.clone().filter_map(|scan| push.value(scan)).fold(R::zero(), R::max);
    let expected = height * (high - low) / peak;
    let elastic = ringing(response, &contact) / expected.max(noise);
    if (plateau.len() as f64) < FLAT_SCANS as f64 + RINGING_SCANS * elastic.to_f64() {
        return false;
    }
    let inner = plateau.start + 1..plateau.end - 1;
    let (_, scatter) = moments(inner.filter_map(|scan| response.value(scan)));
    scatter < (noise * R::of(QUIET)).min(height * R::of(LEVEL_SCATTER))
        && expected > noise * R::of(FLAT)
        && high > peak * R::of(AT_PEAK)
        && missed_by_force(response, push, contact).is_none_or(|left| left > noise * R::of(MISSED))
}

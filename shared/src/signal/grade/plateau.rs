//! Finds signals that an earlier stage has clipped: plateaus, at whatever level.

use core::f64::consts::SQRT_2;
use core::ops::Range;

use nalgebra::{Matrix3, Vector3};

use super::channel::{ChannelRange, Extreme, Survey, moments};
use crate::real::Real;
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
/// The noise is the scatter about lines through this many readings each, over which hum of 50 Hz hardly bends.
const LINE_SCANS: usize = 8;
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
/// Unrest before the hit of more than this many standard deviations of the noise is hum.
const HUM: f64 = 3.0;
/// The sum also misses hum, of whose amplitude a contact of a quarter of its period shows less than this, rms.
const HUM_MISSED: f64 = 0.5;
/// What is clipped is the part of a response about its peak, and with it that of the force: the force reaches this
/// fraction of its peak on the plateau.
const AT_PEAK: f64 = 0.97;
/// Distance over which the second derivative of the force is taken, readings.
const CURVATURE_SCANS: usize = 2;

/// The force of a hit, with which the responses are compared.
pub(super) struct Push<R> {
    rest: R,
    scale: R,
    /// The scans during which the hammer is in contact.
    contact: Range<usize>,
}

impl<R: Real> Push<R> {
    /// The force of a record whose hammer has this scale and survey.
    pub(super) fn of<D: Samples<R> + ?Sized>(record: &D, scale: R, survey: &Survey<R>) -> Self {
        let push = Self { rest: survey.rest, scale, contact: 0..0 };
        let highest = survey.highest;
        let contact = push.signal(record).above(highest.at, highest.value * R::of(CONTACT));
        Self { contact, ..push }
    }

    fn signal<'a, D: ?Sized>(&self, record: &'a D) -> Signal<'a, R, D> {
        Signal { record, channel: HAMMER, rest: self.rest, side: self.scale }
    }
}

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

    /// Standard deviation of the first `before` readings without hum and slow motion.
    fn noise(&self, before: usize) -> R {
        let starts = (0..before).step_by(LINE_SCANS).take_while(|at| at + LINE_SCANS <= before);
        let lines = starts.map(|at| self.variance_about_line(at..at + LINE_SCANS));
        let (sum, count) =
            lines.fold((R::zero(), 0), |(sum, count), variance| (sum + variance, count + 1));
        if count > 0 { (sum / R::of(f64::from(count))).sqrt() } else { R::zero() }
    }

    /// Variance of three or more readings about the straight line through them; 0 of fewer.
    fn variance_about_line(&self, scans: Range<usize>) -> R {
        let count = scans.len();
        let Some(first) = self.value(scans.start).filter(|_| count > 2) else { return R::zero() };
        let middle = R::of((count - 1) as f64 / 2.0);
        let (mut sum, mut squares, mut slope) = (R::zero(), R::zero(), R::zero());
        let mut time = -middle;
        for value in scans.filter_map(|scan| self.value(scan)) {
            let d = value - first;
            sum += d;
            squares += d * d;
            slope += d * time;
            time += R::one();
        }
        let n = R::of(count as f64);
        let times = n * (n * n - R::one()) / R::of(12.0);
        let left = squares - sum * sum / n - slope * slope / times;
        left.max(R::zero()) / R::of((count - 2) as f64)
    }
}

/// The scans about `at` that may all be at the level of its reading, if they are enough to be a plateau, for noise of
/// this standard deviation and hum of this amplitude.
fn level_at<R: Real, D: Samples<R> + ?Sized>(
    response: &Signal<'_, R, D>,
    at: usize,
    noise: R,
    hum: R,
) -> Option<Range<usize>> {
    let height = response.value(at)?;
    let plateau = response.above(at, height - noise * R::of(2.0 * NOISE) - hum);
    (plateau.len() >= FLAT_SCANS).then_some(plateau)
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
    push: Option<&Push<R>>,
) -> bool {
    let height = extreme.value.abs();
    // Makes the extreme positive even when it is below the rest value.
    let side = if extreme.value < R::zero() { -range.scale } else { range.scale };
    let signal = Signal { record, channel, rest: survey.rest, side };
    if let Some(push) = push
        && push.contact.contains(&extreme.at)
    {
        let least = range.resolution * R::of(0.5);
        // The spread, which is known, contains noise and hum.
        let spread = survey.spread.max(least);
        if level_at(&signal, extreme.at, spread, R::zero()).is_none() {
            return false;
        }
        let noise = signal.noise(survey.before).max(least);
        let hum = (spread * spread - noise * noise).max(R::zero()).sqrt() * R::of(SQRT_2);
        let unrest = if hum > noise * R::of(HUM) { [noise, hum] } else { [spread, R::zero()] };
        let contact = push.contact.clone();
        return ignores_force(&signal, &push.signal(record), extreme.at, contact, unrest);
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
///
/// `noise` is its standard deviation, and `hum` the amplitude of what else moves the response before the hit, if that
/// is more.
fn ignores_force<R: Real, D: Samples<R> + ?Sized>(
    response: &Signal<'_, R, D>,
    push: &Signal<'_, R, D>,
    at: usize,
    contact: Range<usize>,
    [noise, hum]: [R; 2],
) -> bool {
    let Some(height) = response.value(at) else { return false };
    let Some(plateau) = level_at(response, at, noise, hum) else { return false };
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
    // Hum tilts a level.
    let scatter = match hum > R::zero() {
        true => response.variance_about_line(inner).sqrt(),
        false => moments(inner.filter_map(|scan| response.value(scan))).1,
    };
    scatter < (noise * R::of(QUIET)).min(height * R::of(LEVEL_SCATTER))
        && expected > noise * R::of(FLAT)
        && high > peak * R::of(AT_PEAK)
        && missed_by_force(response, push, contact)
            .is_none_or(|left| left > noise * R::of(MISSED) + hum * R::of(HUM_MISSED))
}

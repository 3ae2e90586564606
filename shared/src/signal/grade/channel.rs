//! One channel of a record: rest value, extremes, and its level before the hit and at the end.

use crate::real::Real;
use crate::signal::Samples;

/// Properties of a channel that the grading needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelRange<R> {
    /// Scale, N or m/s² per reading.
    pub scale: R,
    /// Lowest and highest reading of the converter; infinite when unknown.
    pub rails: [R; 2],
    /// Distance from the rest value at which the sensor is certainly at the end of its range, N or m/s²;
    /// infinite when unknown.
    pub range: R,
    /// Smallest step of the readings, N or m/s².
    pub resolution: R,
    /// Largest standard deviation of the channel without motion, N or m/s².
    pub noise: R,
}

/// An extreme of a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extreme<R> {
    /// Index of the first scan with this reading.
    pub at: usize,
    pub reading: R,
    /// Value relative to the rest value, N or m/s².
    pub value: R,
}

/// Statistics of a channel from two passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Survey<R> {
    /// Number of readings before the hit.
    pub before: usize,
    /// Their mean, the rest value.
    pub rest: R,
    /// Standard deviation before the hit, N or m/s².
    pub spread: R,
    pub highest: Extreme<R>,
    pub lowest: Extreme<R>,
    /// Mean over the end of the record relative to the rest value, N or m/s².
    pub end_mean: R,
    /// Standard deviation over the end of the record, N or m/s².
    pub end_spread: R,
}

impl<R: Real> Survey<R> {
    /// The end of a record is its last sixteenth.
    const END: usize = 16;

    /// Statistics of a channel whose rest value is the mean of the first `before` readings.
    pub fn of<D: Samples<R> + ?Sized>(record: &D, channel: usize, scale: R, before: usize) -> Self {
        let (rest, spread) = moments(record.readings(channel, 0).take(before.max(1)));
        let [low, high] = record.extremes(channel).unwrap_or([(0, rest); 2]);
        let scans = record.scans();
        let end = scans - (scans / Self::END).max(1).min(scans);
        let (end_mean, end_spread) = moments(record.readings(channel, end));
        let extreme =
            |(at, reading): (usize, R)| Extreme { at, reading, value: (reading - rest) * scale };
        let (highest, lowest) = if scale < R::zero() { (low, high) } else { (high, low) };
        Self {
            before,
            rest,
            spread: spread * scale.abs(),
            highest: extreme(highest),
            lowest: extreme(lowest),
            end_mean: (end_mean - rest) * scale,
            end_spread: end_spread * scale.abs(),
        }
    }

    /// Largest distance from the rest value, N or m/s².
    pub fn peak(&self) -> R {
        self.highest.value.max(-self.lowest.value)
    }
}

/// Mean and standard deviation. The first reading is subtracted before squaring, so single precision suffices
/// for codes.
pub(super) fn moments<R: Real>(mut readings: impl Iterator<Item = R>) -> (R, R) {
    let Some(first) = readings.next() else { return (R::zero(), R::zero()) };
    let (mut count, mut sum, mut squares) = (R::one(), R::zero(), R::zero());
    readings.for_each(|reading| {
        let d = reading - first;
        count += R::one();
        sum += d;
        squares += d * d;
    });
    let mean = sum / count;
    let variance = (squares / count - mean * mean).max(R::zero());
    (first + mean, variance.sqrt())
}

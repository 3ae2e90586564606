//! Input of the signal chain.

use super::{CHANNELS, Scan};
use crate::real::Real;

/// Scale and low-pass of the readings of a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Signal<R> {
    /// N or m/s² per reading.
    pub scale: R,
    /// Time constant of the channel's low-pass, s; zero without one.
    pub lag: R,
}

impl<R: Real> Signal<R> {
    /// Readings of this scale, N or m/s², behind a first-order low-pass with this cutoff frequency, Hz; zero without
    /// one.
    pub fn new(scale: R, cutoff: R) -> Self {
        let lag = R::one() / (R::two_pi() * cutoff);
        Self { scale, lag: if lag.finite() { lag } else { R::zero() } }
    }
}

/// Equally spaced readings of several channels: a record of codes, or any other signals.
pub trait Samples<R: Real> {
    /// Number of readings of each channel.
    fn scans(&self) -> usize;

    /// The readings of one channel from scan `from` on; empty for a channel that does not exist.
    fn readings(&self, channel: usize, from: usize) -> impl Iterator<Item = R> + '_;

    /// One reading; `None` past the end and for a channel that does not exist.
    fn reading(&self, channel: usize, scan: usize) -> Option<R> {
        self.readings(channel, scan).next()
    }

    /// The lowest and the highest reading of one channel, each with the index of the first scan that has it;
    /// `None` for a channel without readings. NaN readings are ignored.
    fn extremes(&self, channel: usize) -> Option<[(usize, R); 2]> {
        let readings = self.readings(channel, 0).enumerate();
        extremes(readings.filter(|(_, reading)| reading.finite()))
    }

    /// Writes the readings of one channel in order to the front of `samples` and returns their number; 0 for
    /// a channel that does not exist.
    fn copy_channel(&self, channel: usize, samples: &mut [R]) -> usize {
        let mut count = 0;
        for (sample, reading) in samples.iter_mut().zip(self.readings(channel, 0)) {
            *sample = reading;
            count += 1;
        }
        count
    }

    /// Writes the sums of `GROUP` readings each of one channel, relative to `rest`, from scan `from` on to the front of
    /// `sums` and returns their number. Codes are relative to a whole `rest`.
    fn sum_groups<const GROUP: usize>(
        &self,
        (channel, rest): (usize, R),
        from: usize,
        sums: &mut [R],
    ) -> usize {
        let mut readings = self.readings(channel, from).map(|reading| reading - rest);
        let mut count = 0;
        for place in sums {
            let mut sum = R::zero();
            for _ in 0..GROUP {
                let Some(reading) = readings.next() else { return count };
                sum += reading;
            }
            *place = sum;
            count += 1;
        }
        count
    }
}

/// The lowest and the highest value, each with its first index.
pub(super) fn extremes<T: PartialOrd + Copy>(
    values: impl Iterator<Item = (usize, T)>,
) -> Option<[(usize, T); 2]> {
    let mut extremes: Option<[(usize, T); 2]> = None;
    // `for_each` takes the two pieces of a ring one after the other; a `for` loop would check at every scan
    // which piece it is in.
    values.for_each(|(at, value)| match &mut extremes {
        None => extremes = Some([(at, value); 2]),
        Some([low, high]) => {
            if value > high.1 {
                *high = (at, value);
            }
            if value < low.1 {
                *low = (at, value);
            }
        }
    });
    extremes
}

/// A code as a reading. Every `Real` represents every code exactly.
pub(super) fn reading_of<R: Real>(code: u16) -> R {
    R::from_u16(code).unwrap_or_else(R::zero)
}

impl<R: Real> Samples<R> for [Scan] {
    fn scans(&self) -> usize {
        self.len()
    }

    fn copy_channel(&self, channel: usize, samples: &mut [R]) -> usize {
        if channel >= CHANNELS {
            return 0;
        }
        for (sample, scan) in samples.iter_mut().zip(self) {
            *sample = reading_of(scan[channel]);
        }
        self.len().min(samples.len())
    }

    fn sum_groups<const GROUP: usize>(
        &self,
        (channel, rest): (usize, R),
        from: usize,
        sums: &mut [R],
    ) -> usize {
        let scans = if channel < CHANNELS { self.get(from..).unwrap_or_default() } else { &[] };
        let channel = channel.min(CHANNELS - 1);
        let (groups, _) = scans.as_chunks::<GROUP>();
        // Whole numbers are added up and converted once. The cast turns NaN into 0.
        let rest = -(GROUP as i32) * (rest.to_f64() as i32);
        for (place, group) in sums.iter_mut().zip(groups) {
            let sum = group.iter().fold(rest, |sum, scan| sum + i32::from(scan[channel]));
            *place = R::from_i32(sum).unwrap_or_else(R::zero);
        }
        groups.len().min(sums.len())
    }

    fn readings(&self, channel: usize, from: usize) -> impl Iterator<Item = R> + '_ {
        let scans = if channel < CHANNELS { self.get(from..).unwrap_or_default() } else { &[] };
        // The compiler can see that this index is in bounds; this is the innermost loop of the grading.
        let channel = channel.min(CHANNELS - 1);
        scans.iter().map(move |scan| reading_of(scan[channel]))
    }
}

impl<R: Real, const N: usize> Samples<R> for [&[R]; N] {
    fn scans(&self) -> usize {
        self.as_slice().scans()
    }

    fn readings(&self, channel: usize, from: usize) -> impl Iterator<Item = R> + '_ {
        self.as_slice().readings(channel, from)
    }
}

impl<R: Real> Samples<R> for [&[R]] {
    fn scans(&self) -> usize {
        self.iter().map(|channel| channel.len()).min().unwrap_or(0)
    }

    fn readings(&self, channel: usize, from: usize) -> impl Iterator<Item = R> + '_ {
        let readings = self.get(channel).and_then(|readings| readings.get(from..));
        readings.unwrap_or_default().iter().copied()
    }
}

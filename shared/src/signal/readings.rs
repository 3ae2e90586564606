//! Where the signal chain gets its numbers from.

use super::Scan;
use crate::Real;

/// Equally spaced readings of several channels: a record of codes, or any other signals.
pub trait Readings<R> {
    /// How many of each channel.
    fn scans(&self) -> usize;

    /// Hands over the readings of one channel, the first to the last; none of a channel that does
    /// not exist.
    fn each(&self, channel: usize, take: impl FnMut(R));
}

impl<R: Real> Readings<R> for [Scan] {
    fn scans(&self) -> usize {
        self.len()
    }

    fn each(&self, channel: usize, mut take: impl FnMut(R)) {
        for scan in self {
            if let Some(reading) = scan.get(channel).and_then(|&code| R::from_u16(code)) {
                take(reading);
            }
        }
    }
}

impl<R: Real, const N: usize> Readings<R> for [&[R]; N] {
    fn scans(&self) -> usize {
        self.iter().map(|channel| channel.len()).min().unwrap_or(0)
    }

    fn each(&self, channel: usize, mut take: impl FnMut(R)) {
        let scans = self.scans();
        for &reading in self.get(channel).iter().flat_map(|readings| readings.iter().take(scans)) {
            take(reading);
        }
    }
}

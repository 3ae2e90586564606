//! Where the signal chain gets its numbers from.

use super::Scan;
use crate::Real;

/// Equally spaced readings of several channels: a record of codes, or any other signals.
pub trait Readings<R> {
    /// How many of each channel.
    fn scans(&self) -> usize;

    /// Writes the readings of one channel, the first to the last, to the front of `samples` and says
    /// how many: 0 of a channel that does not exist.
    fn copy_channel(&self, channel: usize, samples: &mut [R]) -> usize;
}

impl<R: Real> Readings<R> for [Scan] {
    fn scans(&self) -> usize {
        self.len()
    }

    fn copy_channel(&self, channel: usize, samples: &mut [R]) -> usize {
        if channel >= super::CHANNELS {
            return 0;
        }
        for (sample, scan) in samples.iter_mut().zip(self) {
            // Every `Real` holds every code.
            *sample = R::from_u16(scan[channel]).unwrap_or_else(R::zero);
        }
        self.len().min(samples.len())
    }
}

impl<R: Real, const N: usize> Readings<R> for [&[R]; N] {
    fn scans(&self) -> usize {
        self.iter().map(|channel| channel.len()).min().unwrap_or(0)
    }

    fn copy_channel(&self, channel: usize, samples: &mut [R]) -> usize {
        let readings = self.get(channel).copied().unwrap_or(&[]);
        for (sample, reading) in samples.iter_mut().zip(readings) {
            *sample = *reading;
        }
        readings.len().min(samples.len())
    }
}

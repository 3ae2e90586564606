//! The self-test: what each channel reads while nothing moves, and what that says about wiring and parts.
//!
//! An ADXL326 at rest has an output between 1.14 and 1.86 V (zero of 1.2 to 1.8 V and 1 g of 57 mV, by its data sheet at 3 V),
//! and noise of 8 mg in the band of the rig. A broken wire, a swapped supply, a hammer that is not plugged in, the mains and
//! the screen leave marks of their own in level, noise and a few tones.
//!
//! A channel is measured by [`SelfTest::add`], one at a time, so that a rig can do other work in between;
//! [`SelfTest::findings`] names the faults.

mod findings;
mod tones;

pub use findings::{Circuit, KnownSensors};

use super::{AdcProperties, CHANNELS, Samples};
use crate::Real;
use tones::{Tone, amplitude};

/// Scans over which a slow motion is averaged: 32 ms at 4000 Hz.
const BLOCK: usize = 128;

/// What a channel reads while nothing moves, V.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelAtRest<R> {
    /// Mean.
    pub level: R,
    /// Standard deviation, without the tones below.
    pub noise: R,
    /// Amplitude at 50 Hz, or at twice that where it is larger.
    pub hum_50_hz: R,
    /// Amplitude at 60 Hz, or at twice that where it is larger.
    pub hum_60_hz: R,
    /// Amplitude at the refresh rate of the screen.
    pub screen: R,
    /// Range of the means of blocks of 32 ms.
    pub slow_range: R,
    /// True when every reading is the same.
    pub is_stuck: bool,
    /// True when an earlier channel has read the same at every instant, except for level and noise of a code.
    pub is_alike: bool,
}

/// A self-test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SelfTest<R> {
    channels: [ChannelAtRest<R>; CHANNELS],
    count: usize,
    rate: R,
    volts_per_code: R,
}

impl<R: Real> SelfTest<R> {
    /// A test of which no channel has been measured.
    pub fn new(adc: &AdcProperties) -> Self {
        Self {
            channels: [ChannelAtRest::new(); CHANNELS],
            count: usize::from(adc.channels).min(CHANNELS),
            rate: R::of(f64::from(adc.rate.0)),
            volts_per_code: R::of(f64::from(adc.volts_per_code())),
        }
    }

    /// Number of channels that are measured.
    pub fn count(&self) -> usize {
        self.count
    }

    /// What the channels read, the hammer first.
    pub fn channels(&self) -> &[ChannelAtRest<R>] {
        &self.channels[..self.count]
    }

    /// Measures a channel of a record without motion. `room` holds one channel. Nothing happens when it is too short, and for
    /// a record of less than two blocks.
    pub fn add<D: Samples<R> + ?Sized>(&mut self, record: &D, channel: usize, room: &mut [R]) {
        let scans = record.copy_channel(channel, room);
        if channel >= self.count || scans < record.scans() || scans < 2 * BLOCK {
            return;
        }
        let readings = &mut room[..scans];
        let is_stuck = readings.iter().all(|reading| *reading == readings[0]);
        let mean = take_mean(readings);
        let blocks = readings.chunks_exact(BLOCK).map(|block| sum(block) / R::of(BLOCK as f64));
        let (least, most) = blocks.fold((R::zero(), R::zero()), |(least, most), block| {
            (least.min(block), most.max(block))
        });
        let [mains_50, mains_60, screen] =
            Tone::ALL.map(|tone| amplitude(readings, tone, self.rate));
        // The two of the screen overlap.
        let tones = [mains_50[0], mains_50[1], mains_60[0], mains_60[1], screen[0].max(screen[1])];
        let of_tones = tones.iter().fold(R::zero(), |sum, a| sum + *a * *a / R::of(2.0));
        let square = readings.iter().fold(R::zero(), |sum, v| sum + *v * *v) / R::of(scans as f64);
        let is_alike = (0..channel).any(|other| is_alike(record, other, readings, square));
        let volts = self.volts_per_code;
        let largest = |of: [R; 2]| of[0].max(of[1]) * volts;
        self.channels[channel] = ChannelAtRest {
            level: mean * volts,
            noise: (square - of_tones).max(R::zero()).sqrt() * volts,
            hum_50_hz: largest(mains_50),
            hum_60_hz: largest(mains_60),
            screen: largest(screen),
            slow_range: (most - least) * volts,
            is_stuck,
            is_alike,
        };
    }
}

impl<R: Real> ChannelAtRest<R> {
    /// A channel that has not been measured.
    fn new() -> Self {
        let zero = R::zero();
        Self {
            level: zero,
            noise: zero,
            hum_50_hz: zero,
            hum_60_hz: zero,
            screen: zero,
            slow_range: zero,
            is_stuck: false,
            is_alike: false,
        }
    }
}

fn sum<R: Real>(values: &[R]) -> R {
    values.iter().fold(R::zero(), |sum, value| sum + *value)
}

/// Takes the mean out of the readings, relative to the first, so that single precision suffices.
fn take_mean<R: Real>(readings: &mut [R]) -> R {
    let first = readings[0];
    readings.iter_mut().for_each(|reading| *reading -= first);
    let mean = sum(readings) / R::of(readings.len() as f64);
    readings.iter_mut().for_each(|reading| *reading -= mean);
    first + mean
}

/// True when another channel of the record is these readings, whose mean is taken out and whose mean square is `square`:
/// the correlation is 0.95 or more.
fn is_alike<R: Real, D: Samples<R> + ?Sized>(
    record: &D,
    other: usize,
    readings: &[R],
    square: R,
) -> bool {
    let Some(first) = record.reading(other, 0) else { return false };
    let number = R::of(readings.len() as f64);
    let (mut sum, mut squares, mut product) = (R::zero(), R::zero(), R::zero());
    for (mine, theirs) in readings.iter().zip(record.readings(other, 0)) {
        let theirs = theirs - first;
        sum += theirs;
        squares += theirs * theirs;
        product += theirs * *mine;
    }
    let mean = sum / number;
    let variance = (squares / number - mean * mean).max(R::zero());
    let covariance = product / number;
    covariance > R::zero()
        && covariance * covariance >= R::of(0.9) * variance * square
        && square > R::zero()
}

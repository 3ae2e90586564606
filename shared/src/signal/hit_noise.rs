//! Noise and motion of a hit, estimated before its spectra are known.

use super::chain::HAMMER;
use super::{Samples, Signal};
use crate::real::Real;

/// Noise and motion of one hit, summed over its responses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HitNoise<R> {
    /// Variance of the readings before the hit, (m/s²)².
    pub variance: R,
    /// Squared accelerance, ((m/s²)/N)²: the energy of the responses during the contact over that of the
    /// force. A rigid body's response has the shape of the force.
    pub accelerance_squared: R,
}

impl<R: Real> HitNoise<R> {
    /// Noise and motion in a record with `rest` scans before the hit and `contact` scans that contain it;
    /// `signals` are those of the channels in use.
    pub(super) fn of<D: Samples<R> + ?Sized>(
        record: &D,
        signals: &[Signal<R>],
        rest: usize,
        contact: usize,
    ) -> Self {
        let mut sum = Self { variance: R::zero(), accelerance_squared: R::zero() };
        let mut force = R::zero();
        for (channel, Signal { scale, .. }) in signals.iter().enumerate() {
            let before = || record.readings(channel, 0).take(rest);
            let count = R::of(rest.max(1) as f64);
            let mean = rest_value(record, channel, rest);
            let squares = |readings: &mut dyn Iterator<Item = R>| {
                let from_rest = |reading: R| (reading - mean) * *scale;
                readings
                    .fold(R::zero(), |sum, reading| sum + from_rest(reading) * from_rest(reading))
            };
            let energy = squares(&mut record.readings(channel, rest).take(contact));
            if channel == HAMMER {
                force = energy;
                continue;
            }
            sum.variance += squares(&mut before()) / count;
            sum.accelerance_squared += energy;
        }
        sum.accelerance_squared /= force;
        sum
    }
}

/// Mean squared reading of a channel over `contact` scans after the first `rest`, weighted with the reading itself:
/// `Σ r³ / Σ r`, with `r` from the rest value. A channel that reads `r (1 + c r²)` is wrong by `c` times this.
pub(super) fn mean_cube<R: Real, D: Samples<R> + ?Sized>(
    record: &D,
    channel: usize,
    rest: usize,
    contact: usize,
) -> R {
    let mean = rest_value(record, channel, rest);
    let readings = record.readings(channel, rest).take(contact).map(|reading| reading - mean);
    let sums = readings.fold([R::zero(); 2], |[cubes, sum], r| [cubes + r * r * r, sum + r]);
    sums[0] / sums[1]
}

/// Mean of the first `rest` readings.
fn rest_value<R: Real, D: Samples<R> + ?Sized>(record: &D, channel: usize, rest: usize) -> R {
    let before = record.readings(channel, 0).take(rest);
    before.fold(R::zero(), |sum, reading| sum + reading) / R::of(rest.max(1) as f64)
}

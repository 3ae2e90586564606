//! The 1/f noise of the sensors.
//!
//! White noise passes a filter whose poles and zeros alternate at equal ratios of frequency, so that its density
//! falls by 10 dB in a decade (A. Oustaloup, *La commande CRONE*, 1991). The filter is a sum of first-order
//! low-passes with a common input, one for each pole; that makes the state of a sensor that has been on for long a
//! vector with a covariance of closed form.

use std::f64::consts::TAU;

use massline_shared::signal::CHANNELS;
use nalgebra::{Complex, SMatrix, SVector};
use rand_chacha::ChaCha8Rng;

use super::channels::Channels;
use super::errors::normal;

/// Number of poles.
const POLES: usize = 9;
/// Ratio of neighbouring poles; the zeros lie in the middle. The ripple of the density is 0.5 %.
const RATIO: f64 = 4.0;
/// The lowest pole, Hz. Below it the density is constant, and above the highest pole it falls faster.
const LOWEST_HZ: f64 = 0.004;

/// Time from one value of the noise to the next, between which it is straight, s: higher frequencies than some 50 Hz
/// drown in the white noise.
const KNOT_S: f64 = 2e-3;

/// 1/f noise of all channels, at the scans.
#[derive(Clone, Debug)]
pub(super) struct Flicker {
    /// Amplitude of each channel, in its unit: the square root of its density times frequency, one-sided.
    amplitude: Channels,
    /// What is left of each low-pass from one knot to the next.
    memory: [f64; POLES],
    /// Factor of the white noise of a knot in each low-pass.
    fresh: [f64; POLES],
    /// Factor of the covariance of the low-passes in steady state.
    steady: SMatrix<f64, POLES, POLES>,
    /// The low-passes of all channels, for an amplitude of one.
    states: [Channels; POLES],
    /// Scans from one knot to the next, and those that remain of them.
    interval: u32,
    remaining: u32,
    value: Channels,
    step: Channels,
}

impl Flicker {
    /// Noise whose one-sided density is `white √(corner_hz / f)`, in the unit of each channel over √Hz, for scans at
    /// this interval, s; none when no channel has any.
    pub(super) fn new(white: &Channels, corner_hz: f64, scan: f64) -> Option<Self> {
        let amplitude = white.map(|density| density * corner_hz.sqrt());
        if amplitude.iter().all(|amplitude| *amplitude == 0.0) {
            return None;
        }
        let poles: [f64; POLES] = std::array::from_fn(|i| LOWEST_HZ * RATIO.powi(i as i32));
        let zeros: [f64; POLES - 1] = std::array::from_fn(|i| poles[i] * RATIO.sqrt());
        let interval = (KNOT_S / scan).max(1.0) as u32;
        let knot = f64::from(interval) * scan;
        // White noise of unit variance at the knots has a one-sided density of 2 × their interval.
        let gain = (2.0 * knot * mean_power_times_frequency(&poles, &zeros)).sqrt().recip();
        let memory = poles.map(|pole| (-TAU * pole * knot).exp());
        let fresh = std::array::from_fn(|i| gain * residue(&poles, &zeros, i) * (1.0 - memory[i]));
        let covariance = SMatrix::<f64, POLES, POLES>::from_fn(|i, j| {
            fresh[i] * fresh[j] / (1.0 - memory[i] * memory[j])
        });
        let steady = covariance.cholesky()?.l();
        Some(Self {
            amplitude,
            memory,
            fresh,
            steady,
            states: [[0.0; CHANNELS]; POLES],
            interval,
            remaining: 0,
            value: [0.0; CHANNELS],
            step: [0.0; CHANNELS],
        })
    }

    /// Draws the state of sensors that have been on for long.
    pub(super) fn settle(&mut self, rng: &mut ChaCha8Rng) {
        for k in 0..CHANNELS {
            let state = self.steady * SVector::<f64, POLES>::from_fn(|_, _| normal(rng));
            for (states, value) in self.states.iter_mut().zip(&state) {
                states[k] = *value;
            }
            self.value[k] = self.amplitude[k] * state.sum();
        }
        self.remaining = 0;
    }

    /// Adds the noise of the next scan.
    pub(super) fn add(&mut self, values: &mut Channels, rng: &mut ChaCha8Rng) {
        if self.remaining == 0 {
            self.remaining = self.interval;
            let next = self.next_knot(rng);
            for k in 0..CHANNELS {
                self.step[k] = (next[k] - self.value[k]) / f64::from(self.interval);
            }
        }
        self.remaining -= 1;
        for k in 0..CHANNELS {
            values[k] += self.value[k];
            self.value[k] += self.step[k];
        }
    }

    /// The noise at the next knot.
    fn next_knot(&mut self, rng: &mut ChaCha8Rng) -> Channels {
        let white = self.amplitude.map(|a| if a > 0.0 { normal(rng) } else { 0.0 });
        let mut sum = [0.0; CHANNELS];
        for ((states, memory), fresh) in self.states.iter_mut().zip(self.memory).zip(self.fresh) {
            for k in 0..CHANNELS {
                states[k] = memory * states[k] + fresh * white[k];
                sum[k] += states[k];
            }
        }
        std::array::from_fn(|k| self.amplitude[k] * sum[k])
    }
}

/// Residue of the filter at a pole over the pole: its gain at zero frequency in the sum of low-passes.
fn residue(poles: &[f64], zeros: &[f64], i: usize) -> f64 {
    let at_pole = |zero: &f64| 1.0 - poles[i] / zero;
    let others = poles.iter().enumerate().filter(|(j, _)| *j != i);
    zeros.iter().map(at_pole).product::<f64>()
        / others.map(|(_, pole)| 1.0 - poles[i] / pole).product::<f64>()
}

/// The squared gain times frequency, Hz, averaged over one ratio in the middle of the filter.
fn mean_power_times_frequency(poles: &[f64; POLES], zeros: &[f64]) -> f64 {
    const POINTS: i32 = 16;
    let power = |hz: f64| {
        let factor = |corner: &f64| Complex::new(1.0, hz / corner).norm_sqr();
        zeros.iter().map(factor).product::<f64>() / poles.iter().map(factor).product::<f64>()
    };
    let middle = poles[POLES / 2];
    let points = (0..POINTS).map(|n| middle * RATIO.powf(f64::from(n) / f64::from(POINTS)));
    points.map(|hz| power(hz) * hz).sum::<f64>() / f64::from(POINTS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::channels::per_channel;
    use rand::SeedableRng;

    const RATE: f64 = 4000.0;
    const DENSITY: f64 = 300e-6;
    const CORNER: f64 = 0.5;

    /// The noise of each channel, in runs of this many scans.
    fn record(scans: usize, seed: u64) -> Vec<Channels> {
        let white = per_channel(0.0, DENSITY);
        let mut flicker = Flicker::new(&white, CORNER, RATE.recip()).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        flicker.settle(&mut rng);
        let scan = |_| {
            let mut values = [0.0; CHANNELS];
            flicker.add(&mut values, &mut rng);
            values
        };
        (0..scans).map(scan).collect()
    }

    #[test]
    fn the_density_by_formula_falls_with_the_root_of_the_frequency_from_0_02_hz_on() {
        let white = per_channel(0.0, DENSITY);
        let flicker = Flicker::new(&white, CORNER, RATE.recip()).unwrap();
        for n in 0..200 {
            let hz = 0.02 * 2500.0_f64.powf(f64::from(n) / 199.0);
            let knot = f64::from(flicker.interval) / RATE;
            let turn = Complex::new(0.0, -TAU * hz * knot).exp();
            let gain: Complex<f64> = (0..POLES)
                .map(|i| {
                    (Complex::new(1.0, 0.0) - turn * flicker.memory[i]).inv() * flicker.fresh[i]
                })
                .sum();
            // Straight lines between knots take the square of sin x / x.
            let phase = 0.5 * TAU * hz * knot;
            let straight = (phase.sin() / phase).powi(2);
            let density = gain.norm() * straight * (2.0 * knot).sqrt() * flicker.amplitude[1];
            let expected = DENSITY * (CORNER / hz).sqrt();
            // The ripple, the lowest pole, five times below, and the knots, 500 in a second, are up to 1.5 % of
            // the power.
            assert!((density / expected - 1.0).abs() < 0.0075, "{hz}: {density} {expected}");
        }
        assert_eq!(flicker.amplitude[0], 0.0, "a hammer has none");
    }

    #[test]
    fn a_periodogram_of_records_of_50_seconds_has_this_density() {
        // Sums over channels and records at single frequencies; a Hann window keeps the low frequencies out.
        let scans = 200_000;
        let window = |n: usize| 1.0 - (TAU * n as f64 / scans as f64).cos();
        let hz = [0.08, 0.24, 1.0, 5.0, 12.5];
        let mut power = [0.0; 5];
        let records = 6;
        for seed in 0..records {
            let record = record(scans, seed);
            for (power, hz) in power.iter_mut().zip(hz) {
                let mut sums = [Complex::new(0.0, 0.0); CHANNELS];
                for (n, values) in record.iter().enumerate() {
                    let turn = Complex::new(0.0, -TAU * hz * n as f64 / RATE).exp() * window(n);
                    for (sum, value) in sums.iter_mut().zip(values) {
                        *sum += turn * value;
                    }
                }
                // One-sided; the mean square of the window is 1.5.
                let scale = 2.0 / (1.5 * RATE * scans as f64);
                *power += sums.iter().map(|sum| sum.norm_sqr() * scale).sum::<f64>();
            }
        }
        let count = 9.0 * records as f64;
        for (power, hz) in power.into_iter().zip(hz) {
            let expected = DENSITY * DENSITY * CORNER / hz;
            // The mean of 54 periodograms with an exponential distribution has 1 σ of 1/√54 = 13.6 %; three
            // times that is allowed, and the seeds are fixed. The window's main lobe of 0.08 Hz, over which
            // 1/f is curved, adds a few per cent at the lowest frequency.
            let ratio = power / count / expected;
            assert!((ratio - 1.0).abs() < 0.41, "{hz}: {ratio}");
        }
    }

    #[test]
    fn a_sensor_is_in_steady_state_from_the_first_scan_on() {
        let (mut first, mut last) = (0.0, 0.0);
        let runs = 400;
        for seed in 0..runs {
            // Scan 1992 is at a knot.
            let record = record(1993, seed);
            first += record[0].iter().map(|v| v * v).sum::<f64>();
            last += record[1992].iter().map(|v| v * v).sum::<f64>();
        }
        let white = per_channel(0.0, DENSITY);
        let flicker = Flicker::new(&white, CORNER, RATE.recip()).unwrap();
        let variance =
            (flicker.steady * flicker.steady.transpose()).sum() * flicker.amplitude[1].powi(2);
        for sum in [first, last] {
            // 3600 normal numbers determine a variance to 2.4 %; four times that is allowed.
            let ratio = sum / (9.0 * runs as f64) / variance;
            assert!((ratio - 1.0).abs() < 0.096, "{ratio}");
        }
        // From 0.004 Hz to 262 Hz are 11.1 powers of e, each with the square of the density at the corner times the
        // corner; the constant density below adds one, and what is left above the highest pole about another.
        let powers = variance / (DENSITY * DENSITY * CORNER);
        assert!((12.1..14.1).contains(&powers), "{powers}");
    }
}

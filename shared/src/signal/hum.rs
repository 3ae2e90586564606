//! Hum of the mains in the channels: a tone of 50 or 60 Hz and its harmonics, estimated from the record of a hit
//! and taken out of its readings.
//!
//! After the contact a hanging object moves at a few hertz and rings far above; between them a Hann window of the
//! rest of the record shows a tone of a tenth of a code. The frequency, which the mains keep within half a hertz,
//! comes from the turn of the phase between the two halves of it, over all channels together; amplitude and phase
//! of each channel follow. Nothing is locked to the mains: every record has its own phase.

use nalgebra::Complex;

use super::CHANNELS;
use crate::Real;
use crate::diagnosis::Code;

/// Nominal frequencies of the mains, Hz, each with the code of its hum.
const MAINS: [(f64, Code); 2] = [(50.0, Code::HumOf50Hz), (60.0, Code::HumOf60Hz)];
/// Number of harmonics that are taken out, the fundamental included: those that reach into the band of a rigid
/// body, and one more.
const HARMONICS: usize = 3;
/// Smallest amplitude of a tone, in steps of the readings: ten standard deviations of what noise shows.
const LEAST: f64 = 0.8;
/// Readings that are added up before they are multiplied, which saves most of the work.
const GROUP: usize = 5;

/// A search for hum in one record, channel by channel, so that a rig can do other work in between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HumSearch<R> {
    window: Window<R>,
    /// Complex amplitudes at the nominal frequencies in both halves of the window, readings.
    halves: [[[Complex<R>; 2]; MAINS.len()]; CHANNELS],
}

/// Hum in the channels of one record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hum<R> {
    /// The code that names its nominal frequency.
    pub code: Code,
    /// Frequency, Hz.
    pub frequency: R,
    window: Window<R>,
    /// Complex amplitudes of each channel, harmonic by harmonic, readings: the tone is `Re Σ a e^{i 2π h f t}`
    /// with the time from the first scan of the record.
    amplitudes: [[Complex<R>; HARMONICS]; CHANNELS],
}

impl<R: Real> HumSearch<R> {
    /// A search in a record of this many scans, whose contact is over before scan `quiet`; `rate` is in scans a
    /// second. `None` for a record that is too short to tell 50 from 60 Hz.
    pub fn new(scans: usize, quiet: usize, rate: R) -> Option<Self> {
        let groups = scans.checked_sub(quiet)? / (2 * GROUP);
        let window = Window { quiet, groups, rate };
        let long = window.half_duration() > R::of(0.15);
        let none = Complex::new(R::zero(), R::zero());
        long.then_some(Self { window, halves: [[[none; 2]; MAINS.len()]; CHANNELS] })
    }

    /// Adds the readings of a channel; one that does not exist is ignored.
    pub fn add(&mut self, channel: usize, readings: &[R]) {
        if let Some(halves) = self.halves.get_mut(channel) {
            *halves = self.window.halves(readings, MAINS.map(|(nominal, _)| R::of(nominal)));
        }
    }

    /// The fundamental of the hum in the channels that were added; `None` when there is none.
    pub fn found(&self) -> Option<Hum<R>> {
        let mut best: Option<(R, usize, R)> = None;
        for place in 0..MAINS.len() {
            let (mut turned, mut largest) = (Complex::new(R::zero(), R::zero()), R::zero());
            for [first, second] in self.halves.iter().map(|halves| halves[place]) {
                turned += first.conj() * second;
                largest = largest.max((first + second).norm_sqr());
            }
            // The mean of both halves, which may be turned against each other.
            let tone = largest.sqrt() * R::of(0.5);
            if tone > R::of(LEAST) && best.is_none_or(|(most, ..)| tone > most) {
                let turns = turned.im.atan2(turned.re) / R::two_pi();
                best = Some((tone, place, turns / self.window.half_duration()));
            }
        }
        let (_, place, off) = best?;
        let (nominal, code) = MAINS[place];
        let none = [[Complex::new(R::zero(), R::zero()); HARMONICS]; CHANNELS];
        let window = self.window;
        let mut hum = Hum { code, frequency: R::of(nominal) + off, window, amplitudes: none };
        for (amplitudes, halves) in hum.amplitudes.iter_mut().zip(&self.halves) {
            let [first, second] = window.at_frequency(halves[place], off);
            amplitudes[0] = significant((first + second) * R::of(0.5));
        }
        Some(hum)
    }
}

impl<R: Real> Hum<R> {
    /// Adds the harmonics in the readings of a channel; one that does not exist is ignored.
    pub fn add_harmonics(&mut self, channel: usize, readings: &[R]) {
        let Some(amplitudes) = self.amplitudes.get_mut(channel) else { return };
        let frequencies: [R; HARMONICS - 1] =
            core::array::from_fn(|k| self.frequency * R::of((k + 2) as f64));
        let halves = self.window.halves(readings, frequencies);
        for (amplitude, [first, second]) in amplitudes.iter_mut().skip(1).zip(halves) {
            *amplitude = significant((first + second) * R::of(0.5));
        }
    }

    /// Largest amplitude of a harmonic in a channel, readings.
    pub fn amplitude(&self, channel: usize) -> R {
        let of = self.amplitudes.get(channel).into_iter().flatten();
        of.fold(R::zero(), |most, a| most.max(a.norm_sqr())).sqrt()
    }

    /// Takes the hum out of the readings of a channel, the first of which is the first scan of the record.
    pub fn remove(&self, channel: usize, samples: &mut [R]) {
        let Some(amplitudes) = self.amplitudes.get(channel) else { return };
        for (harmonic, amplitude) in (1..).zip(amplitudes) {
            if amplitude.norm_sqr() == R::zero() {
                continue;
            }
            let step = turn(self.frequency * R::of(f64::from(harmonic)) / self.window.rate);
            let mut tone = *amplitude;
            for sample in samples.iter_mut() {
                *sample -= tone.re;
                tone *= step;
            }
        }
    }
}

/// The amplitude of a tone, or zero when it may be noise.
fn significant<R: Real>(amplitude: Complex<R>) -> Complex<R> {
    if amplitude.norm_sqr() > R::of(0.25 * LEAST * LEAST) {
        amplitude
    } else {
        Complex::new(R::zero(), R::zero())
    }
}

/// `e^{i 2π x}`.
fn turn<R: Real>(x: R) -> Complex<R> {
    let (sin, cos) = (R::two_pi() * x).sin_cos();
    Complex::new(cos, sin)
}

/// Two Hann windows, one after the other, over the end of a record.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Window<R> {
    quiet: usize,
    /// Number of groups of readings in each half.
    groups: usize,
    rate: R,
}

impl<R: Real> Window<R> {
    /// Duration of a half, s.
    fn half_duration(&self) -> R {
        R::of((self.groups * GROUP) as f64) / self.rate
    }

    /// The complex amplitude of some tones in each half, at the time of the record's first scan.
    fn halves<const N: usize>(&self, readings: &[R], frequencies: [R; N]) -> [[Complex<R>; 2]; N] {
        let per_scan = frequencies.map(|frequency| frequency / self.rate);
        let steps = per_scan.map(|per_scan| turn(-per_scan * R::of(GROUP as f64)));
        // A group stands for the time of its middle.
        let middle = R::of(self.quiet as f64 + 0.5 * (GROUP as f64 - 1.0));
        let mut phases = per_scan.map(|per_scan| turn(-per_scan * middle));
        let taper_step = turn(R::one() / R::of(self.groups as f64));
        // The taper is zero half a group before the first.
        let mut taper = turn(R::of(0.5) / R::of(self.groups as f64));
        let mut sums = [[Complex::new(R::zero(), R::zero()); 2]; N];
        let readings = readings.get(self.quiet..).unwrap_or_default();
        // Single precision needs the readings relative to the first.
        let rest = readings.first().map_or_else(R::zero, |first| *first * R::of(GROUP as f64));
        for (half, readings) in readings.chunks(self.groups * GROUP).take(2).enumerate() {
            for group in readings.chunks_exact(GROUP) {
                let value = group.iter().fold(-rest, |sum, reading| sum + *reading);
                let weighted = value * (R::one() - taper.re);
                for ((sums, phase), step) in sums.iter_mut().zip(&mut phases).zip(&steps) {
                    sums[half] += *phase * weighted;
                    *phase *= *step;
                }
                taper *= taper_step;
            }
        }
        // The mean of the Hann window is one; a real tone has half its amplitude at each sign of f.
        for (sums, per_scan) in sums.iter_mut().zip(per_scan) {
            let half = per_scan * R::pi();
            let group_gain = (half * R::of(GROUP as f64)).sin() / half.sin();
            let scale = R::of(2.0) / (group_gain * R::of(self.groups as f64));
            sums.iter_mut().for_each(|sum| *sum *= scale);
        }
        sums
    }

    /// Amplitudes of both halves at a frequency that is off by this, Hz, from the one they were computed at.
    fn at_frequency(&self, halves: [Complex<R>; 2], off: R) -> [Complex<R>; 2] {
        let start = R::of(self.quiet as f64) / self.rate;
        let half = self.half_duration();
        // A tone that is off turns as at the middle of the window, and loses what the window does not pass.
        let x = off * half;
        let passed = if x.abs() < R::of(1e-3) {
            R::one()
        } else {
            (R::pi() * x).sin() / (R::pi() * x * (R::one() - x * x))
        };
        let middle = [R::of(0.5), R::of(1.5)].map(|part| start + part * half);
        [0, 1].map(|k| halves[k] * turn(-off * middle[k]) * passed.recip())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    const RATE: f64 = 4000.0;
    const QUIET: usize = 176;

    /// Ten channels of a hit: a pulse, slow motion, ringing, noise, and what `hum` adds to each channel.
    fn record(hum: impl Fn(usize, f64) -> f64) -> Vec<Vec<f64>> {
        let noise = |k: usize, n: usize| {
            let mixed =
                (n as u32).wrapping_mul(2_654_435_761) ^ (k as u32 * 97).wrapping_mul(40_503);
            let hashed = (mixed ^ (mixed >> 15)).wrapping_mul(2_246_822_519);
            f64::from(hashed >> 16) / 65_536.0 * 3.0 - 1.5
        };
        let reading = |k: usize, n: usize| {
            let t = n as f64 / RATE;
            let pulse = if (80..100).contains(&n) { 500.0 } else { 0.0 };
            let after = if n < 90 || k == 0 { 0.0 } else { 1.0 };
            let slow = 15.0 * (12.0 * t).sin() * after;
            let ringing = 40.0 * (-20.0 * t).exp() * (1970.0 * t).sin() * after;
            (2000.0 + pulse + slow + ringing + noise(k, n) + hum(k, t)).round()
        };
        (0..CHANNELS).map(|k| (0..2048).map(|n| reading(k, n)).collect()).collect()
    }

    fn found(hum: impl Fn(usize, f64) -> f64) -> Option<Hum<f64>> {
        let channels = record(hum);
        let slices: Vec<&[f64]> = channels.iter().map(Vec::as_slice).collect();
        searched(slices.as_slice(), RATE)
    }

    fn searched<R: Real>(record: &[&[R]], rate: R) -> Option<Hum<R>> {
        let mut search = HumSearch::new(record[0].len(), QUIET, rate)?;
        record.iter().enumerate().for_each(|(channel, readings)| search.add(channel, readings));
        let mut hum = search.found()?;
        record.iter().enumerate().for_each(|(k, readings)| hum.add_harmonics(k, readings));
        Some(hum)
    }

    #[test]
    fn without_hum_there_is_none() {
        assert_eq!(found(|_, _| 0.0), None);
    }

    #[test]
    fn frequency_amplitude_and_phase_are_found_and_taken_out() {
        for frequency in [49.6, 50.0, 50.4, 59.7, 60.2] {
            let tone = |k: usize, t: f64| {
                (3.0 + k as f64) * (core::f64::consts::TAU * frequency * t + 0.7 * k as f64).cos()
            };
            let hum = found(tone).unwrap();
            assert_eq!(hum.code, MAINS[usize::from(frequency > 55.0)].1);
            // Noise of one code over a quarter of a second, twice.
            assert!((hum.frequency - frequency).abs() < 0.03, "{frequency}: {}", hum.frequency);
            for k in 0..CHANNELS {
                let mut left: Vec<f64> = (0..2048).map(|n| tone(k, n as f64 / RATE)).collect();
                hum.remove(k, &mut left);
                let rms = (left.iter().map(|v| v * v).sum::<f64>() / 2048.0).sqrt();
                // The tone is 2 to 8 codes rms; what is left comes from noise and slow motion.
                assert!(rms < 0.3, "{frequency} Hz, channel {k}: {rms}");
            }
        }
    }

    #[test]
    fn harmonics_are_taken_out_too() {
        let tone = |_: usize, t: f64| {
            let phase = core::f64::consts::TAU * 50.1 * t;
            4.0 * phase.cos() + 2.0 * (2.0 * phase + 1.0).cos() + 1.5 * (3.0 * phase - 2.0).cos()
        };
        let hum = found(tone).unwrap();
        let mut left: Vec<f64> = (0..2048).map(|n| tone(0, n as f64 / RATE)).collect();
        hum.remove(2, &mut left);
        let rms = (left.iter().map(|v| v * v).sum::<f64>() / 2048.0).sqrt();
        assert!(rms < 0.4, "{rms}");
    }

    #[test]
    fn a_record_that_is_too_short_shows_nothing() {
        let channels = record(|_, t| 9.0 * (314.0 * t).cos());
        let slices: Vec<&[f64]> = channels.iter().map(|channel| &channel[..1000]).collect();
        assert_eq!(searched(slices.as_slice(), RATE), None);
    }

    #[test]
    fn single_precision_suffices() {
        let channels = record(|k, t| (3.0 + k as f64) * (315.0 * t).cos());
        let single: Vec<Vec<f32>> =
            channels.iter().map(|c| c.iter().map(|&v| v as f32).collect()).collect();
        let slices: Vec<&[f64]> = channels.iter().map(Vec::as_slice).collect();
        let double = searched(slices.as_slice(), RATE).unwrap();
        let slices: Vec<&[f32]> = single.iter().map(Vec::as_slice).collect();
        let single = searched(slices.as_slice(), RATE as f32).unwrap();
        // Running products over 374 groups: 374 roundings of 6e-8 at worst, times 13 codes.
        for k in 0..CHANNELS {
            assert!((double.amplitude(k) - f64::from(single.amplitude(k))).abs() < 2e-3, "{k}");
        }
    }
}

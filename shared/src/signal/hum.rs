//! Hum of the mains in the channels: a tone of 50 or 60 Hz and its harmonics, estimated from the record of a hit
//! and taken out of its readings.
//!
//! After the contact a hanging object moves at a few hertz and rings far above; between them a Hann window of the
//! rest of the record shows a tone of a tenth of a code. The frequency, which the mains keep within half a hertz,
//! comes from the turn of the phase between the two halves of it, over all channels together; amplitude and phase
//! of each channel follow. Nothing is locked to the mains: every record has its own phase. A rectifier gives twice
//! the frequency of the mains and nothing at it, so that is searched for as well.
//!
//! A tone that is taken out has to be steady, because it is known after the contact and disturbs most before and
//! during it. What changes between the halves and a third window across their border shows how steady it is.

use nalgebra::Complex;

use super::{CHANNELS, Samples};
use crate::Real;
use crate::diagnosis::Code;

/// Nominal frequencies of the mains, Hz, each with the code of its hum.
const MAINS: [(f64, Code); 2] = [(50.0, Code::HumOf50Hz), (60.0, Code::HumOf60Hz)];
/// Number of harmonics that a search looks at: the fundamental and what a rectifier makes of it.
const SEARCHED: usize = 2;
/// Number of tones that a search looks at.
const TONES: usize = MAINS.len() * SEARCHED;
/// Number of harmonics that are taken out, the fundamental included: those that reach into the band of a rigid
/// body, and one more.
const HARMONICS: usize = 3;
/// Smallest amplitude of a tone, in steps of the readings: ten standard deviations of what noise shows.
const LEAST: f64 = 0.8;
/// Readings that are added up before they are multiplied, which saves most of the work.
const GROUP: usize = 5;
/// Readings that are rid of a harmonic by a recurrence before it starts anew from an exact rotation.
const BLOCK: usize = 128;

/// A search for hum in one record, channel by channel, so that a rig can do other work in between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HumSearch<R> {
    window: Window<R>,
    tones: [Tone<R>; TONES],
    /// Turn of each tone from the first half of the window to the second, summed over the channels.
    turned: [Complex<R>; TONES],
    /// Largest sum of the squared amplitudes of each tone in both halves, in a channel, readings.
    largest: [R; TONES],
}

/// The amplitudes of hum whose frequency is known, channel by channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HumFit<R> {
    hum: Hum<R>,
    window: Window<R>,
    tones: [Tone<R>; HARMONICS],
    /// What may be left of the hum at the contact, readings.
    left: [R; CHANNELS],
}

/// Hum in the channels of one record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hum<R> {
    /// The code that names its nominal frequency.
    pub code: Code,
    /// Frequency of the fundamental, Hz.
    pub frequency: R,
    /// Turn of the fundamental from one scan to the next.
    step: Complex<R>,
    /// Complex amplitudes of each channel, harmonic by harmonic, readings: the tone is `Re Σ a e^{i 2π h f t}`
    /// with the time from the first scan of the record.
    amplitudes: [[Complex<R>; HARMONICS]; CHANNELS],
}

impl<R: Real> HumSearch<R> {
    /// A search in a record of this many scans, whose contact is over before scan `quiet`; `rate` is in scans a
    /// second. `None` for a record that is too short to tell 50 from 60 Hz.
    pub fn new(scans: usize, quiet: usize, rate: R) -> Option<Self> {
        // An even number: the third window begins in the middle of the first half.
        let groups = scans.checked_sub(quiet)? / (4 * GROUP) * 2;
        if R::of((groups * GROUP) as f64) <= R::of(0.15) * rate {
            return None;
        }
        let taper = [-0.5, 0.5, 1.0].map(|on| turn(R::of(on / groups as f64)).re);
        let window = Window { quiet, groups, rate, taper };
        let tones = core::array::from_fn(|k| window.tone(R::of(searched(k).0)));
        let none = Complex::new(R::zero(), R::zero());
        Some(Self { window, tones, turned: [none; TONES], largest: [R::zero(); TONES] })
    }

    /// Adds a channel of the record. `room` is scratch memory with a fifth of its length.
    pub fn add<D: Samples<R> + ?Sized>(&mut self, record: &D, channel: usize, room: &mut [R]) {
        let sums = self.window.sums(record, channel, room);
        let [first, second] = [0, 2].map(|place| self.window.project(sums, place, &self.tones));
        for k in 0..TONES {
            self.turned[k] += first[k].conj() * second[k];
            // The halves may be turned against each other.
            self.largest[k] = self.largest[k].max(first[k].norm_sqr() + second[k].norm_sqr());
        }
    }

    /// The hum in the channels that were added, whose amplitudes are still to be determined; `None` when there is
    /// none.
    pub fn found(&self) -> Option<HumFit<R>> {
        let mut best: Option<(R, usize)> = None;
        for (k, &largest) in self.largest.iter().enumerate() {
            let tone = (largest * R::of(0.5)).sqrt();
            if tone > R::of(LEAST) && best.is_none_or(|(most, _)| tone > most) {
                best = Some((tone, k));
            }
        }
        let (_, k) = best?;
        let (nominal, harmonic, code) = searched(k);
        let turns = self.turned[k].im.atan2(self.turned[k].re) / R::two_pi();
        let off = turns / self.window.half_duration();
        Some(HumFit::new((R::of(nominal) + off) / R::of(harmonic), code, self.window))
    }
}

impl<R: Real> HumFit<R> {
    fn new(frequency: R, code: Code, window: Window<R>) -> Self {
        let none = Complex::new(R::zero(), R::zero());
        let step = turn(frequency / window.rate);
        let amplitudes = [[none; HARMONICS]; CHANNELS];
        let tones = core::array::from_fn(|k| window.tone(frequency * R::of((k + 1) as f64)));
        let hum = Hum { code, frequency, step, amplitudes };
        Self { hum, window, tones, left: [R::zero(); CHANNELS] }
    }

    /// Adds a channel of the record; one that does not exist is ignored. `room` is scratch memory with a fifth of the
    /// record's length.
    pub fn add<D: Samples<R> + ?Sized>(&mut self, record: &D, channel: usize, room: &mut [R]) {
        let amplitudes = self.hum.amplitudes.get_mut(channel);
        let (Some(amplitudes), Some(left)) = (amplitudes, self.left.get_mut(channel)) else {
            return;
        };
        let sums = self.window.sums(record, channel, room);
        let [first, second] = [0, 2].map(|place| self.window.project(sums, place, &self.tones));
        let mean: [_; HARMONICS] = core::array::from_fn(|k| (first[k] + second[k]) * R::of(0.5));
        *amplitudes = mean.map(significant);
        let mut loudest = 0;
        for (k, amplitude) in amplitudes.iter().enumerate().skip(1) {
            if amplitude.norm_sqr() > amplitudes[loudest].norm_sqr() {
                loudest = k;
            }
        }
        if amplitudes[loudest].norm_sqr() > R::zero() {
            // What changes the loudest harmonic changes the others by less.
            let [across] = self.window.project(sums, 1, &[self.tones[loudest]]);
            let change = (second[loudest] - first[loudest]).norm_sqr().sqrt();
            let bend = (across - mean[loudest]).norm_sqr().sqrt();
            *left = left.max(self.window.at_contact(change, bend));
        }
    }

    /// The hum in the channels that were added.
    pub fn hum(&self) -> &Hum<R> {
        &self.hum
    }

    /// What may be left in a channel at the contact when the hum is taken out, readings: its amplitude and phase
    /// change after the contact, and this is what a parabola through the change comes to at the contact.
    pub fn left(&self, channel: usize) -> R {
        self.left.get(channel).copied().unwrap_or_else(R::zero)
    }
}

impl<R: Real> Hum<R> {
    /// Largest amplitude of a harmonic in a channel, readings.
    pub fn amplitude(&self, channel: usize) -> R {
        let of = self.amplitudes.get(channel).into_iter().flatten();
        of.fold(R::zero(), |most, a| most.max(a.norm_sqr())).sqrt()
    }

    /// Takes the hum out of the readings of a channel, the first of which is the first scan of the record.
    pub fn remove(&self, channel: usize, samples: &mut [R]) {
        let Some(amplitudes) = self.amplitudes.get(channel) else { return };
        let none = Complex::new(R::zero(), R::zero());
        let (mut tones, mut count, mut step) = ([[none; 2]; HARMONICS], 0, self.step);
        for &amplitude in amplitudes {
            if amplitude.norm_sqr() > R::zero() {
                tones[count] = [amplitude, step];
                count += 1;
            }
            step *= self.step;
        }
        match tones {
            [first, ..] if count == 1 => subtract([first], samples),
            [first, second, _] if count == 2 => subtract([first, second], samples),
            all if count == 3 => subtract(all, samples),
            _ => {}
        }
    }
}

/// Subtracts tones, each given by its amplitude `a` and its step `eⁱᵠ`: `Re a eⁱᵠⁿ` from sample `n`.
///
/// Within a block two consecutive values give the next, `y₊ = 2 cos φ y − y₋`, which costs half a rotation. A
/// rotation takes the tone from block to block, because the recurrence multiplies its roundings by up to `1/φ`.
fn subtract<const N: usize, R: Real>(tones: [[Complex<R>; 2]; N], samples: &mut [R]) {
    let twice = tones.map(|[_, step]| step.re + step.re);
    let to_next =
        tones.map(|[_, step]| (0..BLOCK.trailing_zeros()).fold(step, |step, _| step * step));
    let mut tones = tones;
    for block in samples.chunks_mut(BLOCK) {
        let mut now = tones.map(|[tone, _]| tone.re);
        let mut next = tones.map(|[tone, step]| (tone * step).re);
        let (pairs, last) = block.as_chunks_mut::<2>();
        for [even, odd] in pairs {
            for k in 0..N {
                *even -= now[k];
                *odd -= next[k];
                now[k] = twice[k] * next[k] - now[k];
                next[k] = twice[k] * now[k] - next[k];
            }
        }
        last.iter_mut().for_each(|sample| now.iter().for_each(|&tone| *sample -= tone));
        tones.iter_mut().zip(&to_next).for_each(|([tone, _], turn)| *tone *= *turn);
    }
}

/// Frequency of the tone with this place in a search, Hz, which harmonic it is, and the code of its hum.
fn searched(place: usize) -> (f64, f64, Code) {
    let (mains, code) = MAINS[place / SEARCHED];
    let harmonic = (place % SEARCHED + 1) as f64;
    (mains * harmonic, harmonic, code)
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

/// Two Hann windows, one after the other, over the end of a record, and a third across their border.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Window<R> {
    quiet: usize,
    /// Number of groups of readings in each half.
    groups: usize,
    rate: R,
    /// Cosines of the taper: before the first group, at the first, which is half a group after its zero, and of its
    /// turn from group to group.
    taper: [R; 3],
}

/// What is needed to project on a tone; sines are expensive on a microcontroller, so it is computed once for all
/// channels.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Tone<R> {
    /// `eⁱᵠ`, where `φ` is the turn from group to group.
    step: Complex<R>,
    /// Factor from the end of the first half to the amplitude at the record's first scan.
    end: Complex<R>,
    /// Turn from one window to the next, half their duration later.
    shift: Complex<R>,
}

impl<R: Real> Window<R> {
    /// Duration of a half, s.
    fn half_duration(&self) -> R {
        R::of((self.groups * GROUP) as f64) / self.rate
    }

    /// Amplitude at the contact of a tone that changes by `change` from half to half, and in whose middle it
    /// differs by `bend` from the mean of both.
    fn at_contact(&self, change: R, bend: R) -> R {
        // In durations of a half: the middles of the halves are half of one from the border, and the contact is
        // one and what lies before the window. A parabola bends by a quarter of its second coefficient.
        let distance = R::one() + R::of(0.5 * self.quiet as f64 / (self.groups * GROUP) as f64);
        change * distance + bend * (R::of(4.0) * distance * distance - R::one())
    }

    /// The tone of this frequency, Hz.
    fn tone(&self, frequency: R) -> Tone<R> {
        let per_scan = frequency / self.rate;
        let per_group = per_scan * R::of(GROUP as f64);
        // A group stands for the time of its middle.
        let middle = self.quiet as f64 + 0.5 * (GROUP as f64 - 1.0);
        let last = R::of(middle + ((self.groups - 1) * GROUP) as f64);
        // The mean of the Hann window is one; a real tone has half its amplitude at each sign of f.
        let half = per_scan * R::pi();
        let group_gain = (half * R::of(GROUP as f64)).sin() / half.sin();
        let scale = R::of(2.0) / (group_gain * R::of(self.groups as f64));
        Tone {
            step: turn(per_group),
            end: turn(-per_scan * last) * scale,
            shift: turn(-per_group * R::of((self.groups / 2) as f64)),
        }
    }

    /// The sums of the groups of a channel, relative to the first reading: single precision needs it. At the front of `room`.
    fn sums<'r, D: Samples<R> + ?Sized>(
        &self,
        record: &D,
        channel: usize,
        room: &'r mut [R],
    ) -> &'r [R] {
        let count = room.len().min(2 * self.groups);
        let room = room.get_mut(..count).unwrap_or_default();
        let first = record.reading(channel, self.quiet).unwrap_or_else(R::zero);
        let count = record.sum_groups::<GROUP>((channel, first), self.quiet, room);
        room.get(..count).unwrap_or_default()
    }

    /// The complex amplitudes of tones at the time of the record's first scan, from the window that begins `place`
    /// times half its duration after the first.
    fn project<const N: usize>(
        &self,
        sums: &[R],
        place: usize,
        tones: &[Tone<R>; N],
    ) -> [Complex<R>; N] {
        let sums = sums.get(place * (self.groups / 2)..).unwrap_or_default();
        let [mut last, mut taper, step] = self.taper;
        let taper_twice = step + step;
        let twice = tones.map(|tone| tone.step.re + tone.step.re);
        // The recurrence of Goertzel: at the end, `now − e^{−iφ} before` is the sum turned to the last group. Two
        // groups at a time leave all values where they are.
        let (mut now, mut before) = ([R::zero(); N], [R::zero(); N]);
        let (pairs, _) = sums.get(..self.groups).unwrap_or(sums).as_chunks::<2>();
        for &[even, odd] in pairs {
            let even = even - even * taper;
            last = taper_twice * taper - last;
            let odd = odd - odd * last;
            taper = taper_twice * last - taper;
            for k in 0..N {
                before[k] = twice[k] * now[k] - before[k] + even;
                now[k] = twice[k] * before[k] - now[k] + odd;
            }
        }
        core::array::from_fn(|k| {
            let tone = &tones[k];
            let sum = Complex::new(now[k], R::zero()) - tone.step.conj() * before[k];
            (0..place).fold(sum * tone.end, |sum, _| sum * tone.shift)
        })
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

    fn fitted<R: Real>(record: &[&[R]], rate: R) -> Option<HumFit<R>> {
        let mut search = HumSearch::new(record[0].len(), QUIET, rate)?;
        let mut room = std::vec![R::zero(); 2048 / GROUP];
        (0..CHANNELS).for_each(|channel| search.add(record, channel, &mut room));
        let mut fit = search.found()?;
        (0..CHANNELS).for_each(|channel| fit.add(record, channel, &mut room));
        Some(fit)
    }

    fn searched<R: Real>(record: &[&[R]], rate: R) -> Option<Hum<R>> {
        fitted(record, rate).map(|fit| *fit.hum())
    }

    /// What may be left at the contact, in the channel with most of it.
    fn left(hum: impl Fn(usize, f64) -> f64) -> f64 {
        let channels = record(hum);
        let slices: Vec<&[f64]> = channels.iter().map(Vec::as_slice).collect();
        let fit = fitted(slices.as_slice(), RATE).unwrap();
        (0..CHANNELS).map(|k| fit.left(k)).fold(0.0, f64::max)
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
    fn the_ripple_of_a_rectifier_is_found_without_its_fundamental() {
        for frequency in [100.3, 119.8] {
            let tone = |_: usize, t: f64| 5.0 * (core::f64::consts::TAU * frequency * t).cos();
            let hum = found(tone).unwrap();
            assert_eq!(hum.code, MAINS[usize::from(frequency > 110.0)].1);
            let mut left: Vec<f64> = (0..2048).map(|n| tone(0, n as f64 / RATE)).collect();
            hum.remove(0, &mut left);
            let rms = (left.iter().map(|v| v * v).sum::<f64>() / 2048.0).sqrt();
            // 3.5 codes rms; what is left comes from noise.
            assert!(rms < 0.3, "{frequency} Hz: {rms}");
        }
    }

    #[test]
    fn hum_that_changes_is_told_from_steady_hum() {
        let tone = |t: f64| 20.0 * (core::f64::consts::TAU * 50.1 * t).cos();
        // Noise, slow motion and ringing alone come to this.
        let steady = left(|_, t| tone(t));
        assert!(steady < 1.5, "{steady}");
        // It grows by 40 % a second: from the middle of the quiet part, 0.28 s, to the contact at 0.02 s by 2.1 codes.
        let growing = left(|_, t| tone(t) * (1.0 + 0.4 * t));
        assert!((1.5..4.5).contains(&growing), "{growing}");
        // It stops where the first half of the quiet part ends.
        let stopping = left(|_, t| if t < 0.28 { tone(t) } else { 0.0 });
        assert!(stopping > 20.0, "{stopping}");
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

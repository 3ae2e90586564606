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
//! It also has to be there before the contact: an elastic mode near one of these frequencies begins to ring with the
//! hit.

use core::ops::Range;

use nalgebra::Complex;

use super::{CHANNELS, PRE_TRIGGER_SCANS, Samples};
use crate::diagnosis::Code;
use crate::real::Real;
use windows::{Tone, Window};

mod windows;

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
/// Least part of a hum that the readings before the contact must show; of the ringing of a mode they show nothing.
const THERE: f64 = 0.5;
/// A channel takes the place of the loudest one before when its squared amplitude is larger by this factor.
const LOUDER: f64 = 1.5;
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
    /// The loudest channel's squared amplitude.
    loudest: R,
    /// Sums over its readings before the contact: hum times reading, and hum squared.
    before: [R; 2],
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
    /// A search in a record of this many scans, whose contact lies within the scans `contact`; `rate` is in scans a
    /// second. `None` for a record that is too short to tell 50 from 60 Hz.
    pub fn new(scans: usize, contact: Range<usize>, rate: R) -> Option<Self> {
        let window = Window::new(scans, contact, rate)?;
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
    pub fn start_fit(&self) -> Option<HumFit<R>> {
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
        let step = window.turn_per_scan(frequency);
        let amplitudes = [[none; HARMONICS]; CHANNELS];
        let tones = core::array::from_fn(|k| window.tone(frequency * R::of((k + 1) as f64)));
        let hum = Hum { code, frequency, step, amplitudes };
        let (left, loudest, before) = ([R::zero(); CHANNELS], R::zero(), [R::zero(); 2]);
        Self { hum, window, tones, left, loudest, before }
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
        let squared = amplitudes[loudest].norm_sqr();
        if squared > R::zero() {
            // What changes the loudest harmonic changes the others by less.
            let [across] = self.window.project(sums, 1, &[self.tones[loudest]]);
            let change = (second[loudest] - first[loudest]).norm_sqr().sqrt();
            let bend = (across - mean[loudest]).norm_sqr().sqrt();
            *left = left.max(self.window.at_contact(change, bend));
        }
        if squared > self.loudest * R::of(LOUDER) {
            self.loudest = squared;
            self.before = self.compare_before(record, channel);
        }
    }

    /// The sums of [`Self::before`] for a channel, without the means and the trends of both.
    fn compare_before<D: Samples<R> + ?Sized>(&self, record: &D, channel: usize) -> [R; 2] {
        let mut hum = [R::zero(); PRE_TRIGGER_SCANS];
        let hum = &mut hum[..self.window.rest().min(PRE_TRIGGER_SCANS)];
        // Two readings are always a mean and a trend.
        if hum.len() <= 2 {
            return [R::zero(); 2];
        }
        // Taken out of nothing: its negative.
        self.hum.remove(channel, hum);
        let middle = R::of((hum.len() as f64 - 1.0) / 2.0);
        let first = record.reading(channel, 0).unwrap_or_else(R::zero);
        let zero = R::zero();
        let (mut sums, mut slopes, mut products, mut number) =
            ([zero; 2], [zero; 2], [zero; 2], zero);
        let mut times = zero;
        for (n, (hum, reading)) in hum.iter().zip(record.readings(channel, 0)).enumerate() {
            let time = R::of(n as f64) - middle;
            let (hum, reading) = (-*hum, reading - first);
            number += R::one();
            times += time * time;
            for (k, value) in [hum, reading].into_iter().enumerate() {
                sums[k] += value;
                slopes[k] += value * time;
                products[k] += value * hum;
            }
        }
        let [squared, product] = core::array::from_fn(|k| {
            products[k] - sums[0] * sums[k] / number - slopes[0] * slopes[k] / times
        });
        [product, squared]
    }

    /// False for a tone that begins with the contact: the ringing of the object. True where there is nothing before
    /// the contact to compare with.
    pub fn is_there_before(&self) -> bool {
        let [product, squared] = self.before;
        product >= squared * R::of(THERE)
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
        let amplitudes = self.amplitudes.get(channel).into_iter().flatten();
        amplitudes.fold(R::zero(), |most, a| most.max(a.norm_sqr())).sqrt()
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
            tones if count == 3 => subtract(tones, samples),
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

#[cfg(test)]
mod tests;

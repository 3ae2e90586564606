//! The windows over the end of a record, and projecting a channel on a tone in them.

use core::ops::Range;

use nalgebra::Complex;

use crate::real::Real;
use crate::signal::Samples;

/// Readings that are added up before they are multiplied, which saves most of the work.
pub(super) const GROUP: usize = 5;

/// Two Hann windows, one after the other, over the end of a record, and a third across their border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Window<R> {
    /// Scans before the contact.
    rest: usize,
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
pub(super) struct Tone<R> {
    /// `eⁱᵠ`, where `φ` is the turn from group to group.
    step: Complex<R>,
    /// Factor from the end of the first half to the amplitude at the record's first scan.
    end: Complex<R>,
    /// Turn from one window to the next, half their duration later.
    shift: Complex<R>,
}

impl<R: Real> Window<R> {
    /// The windows of a record of this many scans, whose contact lies within the scans `contact`; `rate` is in scans a
    /// second. `None` for a record that is too short to tell 50 from 60 Hz.
    pub(super) fn new(scans: usize, contact: Range<usize>, rate: R) -> Option<Self> {
        let Range { start: rest, end: quiet } = contact;
        // An even number: the third window begins in the middle of the first half.
        let groups = scans.checked_sub(quiet)? / (4 * GROUP) * 2;
        if R::of((groups * GROUP) as f64) <= R::of(0.15) * rate {
            return None;
        }
        let taper = [-0.5, 0.5, 1.0].map(|on| turn(R::of(on / groups as f64)).re);
        Some(Self { rest, quiet, groups, rate, taper })
    }

    /// Number of scans before the contact.
    pub(super) fn rest(&self) -> usize {
        self.rest
    }

    /// Turn of a tone of this frequency, Hz, from one scan to the next.
    pub(super) fn turn_per_scan(&self, frequency: R) -> Complex<R> {
        turn(frequency / self.rate)
    }

    /// Duration of a half, s.
    pub(super) fn half_duration(&self) -> R {
        R::of((self.groups * GROUP) as f64) / self.rate
    }

    /// Amplitude at the contact of a tone that changes by `change` from half to half, and in whose middle it
    /// differs by `bend` from the mean of both.
    pub(super) fn at_contact(&self, change: R, bend: R) -> R {
        // In durations of a half: the middles of the halves are half of one from the border, and the contact is
        // one and what lies before the window. A parabola bends by a quarter of its second coefficient.
        let distance = R::one() + R::of(0.5 * self.quiet as f64 / (self.groups * GROUP) as f64);
        change * distance + bend * (R::of(4.0) * distance * distance - R::one())
    }

    /// The tone of this frequency, Hz.
    pub(super) fn tone(&self, frequency: R) -> Tone<R> {
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

    /// The sums of the groups of a channel, at the front of `room`; relative to the first reading, which single
    /// precision needs.
    pub(super) fn sums<'r, D: Samples<R> + ?Sized>(
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
    pub(super) fn project<const N: usize>(
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

/// `e^{i 2π x}`.
fn turn<R: Real>(x: R) -> Complex<R> {
    let (sin, cos) = (R::two_pi() * x).sin_cos();
    Complex::new(cos, sin)
}

//! The supply of sensors and converter: ripple by the screen, and droops when a load changes.
//!
//! With a supply of `V (1 + e)` a converter reads a voltage as `1/(1 + e)` of itself. The output of a sensor, which is
//! a share of its supply, is then `1 + f` of what it is at a steady supply, where `f` is `e` behind the sensor's
//! low-pass: `τ f' + f = e`. The output of the hammer is a voltage, so that its `f` is zero.

use std::f64::consts::TAU;

use massline_shared::signal::{CHANNELS, HAMMER};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::channels::Channels;
use crate::bench::Bench;

/// A supply that is not steady.
#[derive(Clone, Debug)]
pub(super) struct Supply {
    ripple: Ripple,
    droops: Option<Droops>,
}

impl Supply {
    /// The supply of a bench whose low-passes have these time constants, s; none when it is steady.
    pub(super) fn new(bench: &Bench, tau: &Channels) -> Option<Self> {
        let (ripple, droops) = (Ripple::new(bench, tau), Droops::new(bench, tau));
        (!ripple.amplitudes.is_empty() || droops.is_some()).then_some(Self { ripple, droops })
    }

    /// Sets the time to zero, with a ripple at another phase and without a sag.
    pub(super) fn restart(&mut self, mut rng: ChaCha8Rng) {
        self.ripple.phase = TAU * rng.random::<f64>();
        if let Some(droops) = &mut self.droops {
            droops.restart(rng);
        }
    }

    /// Prepares the times from `start` to `end`, a scan, s.
    pub(super) fn begin(&mut self, start: f64, end: f64) {
        if let Some(droops) = &mut self.droops {
            droops.begin(start, end);
        }
    }

    /// What a channel reads at a time, s, over what it would read on a steady supply.
    pub(super) fn factor(&self, channel: usize, time: f64) -> f64 {
        let [mut present, mut followed] = self.ripple.deviation(channel, time);
        if let Some(droops) = &self.droops {
            let [sag, of_sag] = droops.sag(channel, time);
            present -= sag;
            followed -= of_sag;
        }
        if channel == HAMMER {
            followed = 0.0;
        }
        (1.0 + followed) / (1.0 + present)
    }
}

/// A periodic deviation whose phase is random.
#[derive(Clone, Debug)]
struct Ripple {
    /// Angular frequency of the fundamental, rad/s.
    omega: f64,
    /// Amplitudes of the fundamental and its harmonics over the supply; empty without a ripple.
    amplitudes: Vec<f64>,
    /// Phase of the fundamental at time zero, rad.
    phase: f64,
    /// Time constants of the low-passes, s.
    tau: Channels,
}

impl Ripple {
    fn new(bench: &Bench, tau: &Channels) -> Self {
        let supply = &bench.supply;
        let fundamental = supply.ripple_v / supply.voltage_v;
        let amplitudes = if fundamental > 0.0 {
            let harmonics = supply.ripple_harmonics.iter().map(|share| fundamental * share);
            std::iter::once(fundamental).chain(harmonics).collect()
        } else {
            Vec::new()
        };
        Self { omega: TAU * supply.ripple_hz, amplitudes, phase: 0.0, tau: *tau }
    }

    /// The deviation of the supply at a time, and what the output of a channel has followed of it.
    fn deviation(&self, channel: usize, time: f64) -> [f64; 2] {
        let angle = self.omega * time + self.phase;
        let mut sum = [0.0; 2];
        for (number, amplitude) in (1_u32..).zip(&self.amplitudes) {
            let number = f64::from(number);
            let (sine, cosine) = (number * angle).sin_cos();
            let x = number * self.omega * self.tau[channel];
            sum[0] += amplitude * sine;
            sum[1] += amplitude * (sine - x * cosine) / (1.0 + x * x);
        }
        sum
    }
}

/// Sags at random times, one in a scan at most. One that comes before the supply has recovered begins anew.
#[derive(Clone, Debug)]
struct Droops {
    /// Mean number in a second.
    rate: f64,
    /// How far, over the supply.
    depth: f64,
    /// Time in which a sag falls to 1/e, s.
    recovery: f64,
    /// Time constants of the low-passes, s.
    tau: Channels,
    /// The sag before the last and the last.
    sags: [Sag; 2],
    /// Time of the next, s.
    next: f64,
    rng: ChaCha8Rng,
}

/// A sag from its beginning on.
#[derive(Clone, Copy, Debug)]
struct Sag {
    /// When it begins, s.
    start: f64,
    /// How far the supply is down then, relative.
    depth: f64,
    /// How far the output of each channel is down then.
    followed: Channels,
}

impl Sag {
    const NONE: Self = Self { start: 0.0, depth: 0.0, followed: [0.0; CHANNELS] };
}

impl Droops {
    fn new(bench: &Bench, tau: &Channels) -> Option<Self> {
        let supply = &bench.supply;
        (supply.droop_v > 0.0 && supply.droop_rate_per_s > 0.0).then(|| Self {
            rate: supply.droop_rate_per_s,
            depth: supply.droop_v / supply.voltage_v,
            recovery: supply.droop_s,
            tau: *tau,
            sags: [Sag::NONE; 2],
            next: f64::INFINITY,
            rng: ChaCha8Rng::seed_from_u64(0),
        })
    }

    fn restart(&mut self, rng: ChaCha8Rng) {
        self.rng = rng;
        self.sags = [Sag::NONE; 2];
        self.next = self.interval();
    }

    /// Draws the time from one sag to the next, s.
    fn interval(&mut self) -> f64 {
        -(1.0 - self.rng.random::<f64>()).ln() / self.rate
    }

    fn begin(&mut self, start: f64, end: f64) {
        if self.next >= end {
            return;
        }
        let at = self.next.max(start);
        let followed = std::array::from_fn(|channel| self.sag(channel, at)[1]);
        self.sags = [self.sags[1], Sag { start: at, depth: self.depth, followed }];
        self.next += self.interval();
    }

    /// How far the supply is down at a time, and how far the output of a channel is.
    fn sag(&self, channel: usize, time: f64) -> [f64; 2] {
        let [before, last] = &self.sags;
        let sag = if time < last.start { before } else { last };
        let since = time - sag.start;
        let tau = self.tau[channel];
        let [remains, forgets] = [(-since / self.recovery).exp(), (-since / tau).exp()];
        let difference = tau.recip() - self.recovery.recip();
        // Where both times are the same, the quotient below is 0/0.
        let follows = if (difference * since).abs() < 1e-6 {
            since / tau * forgets
        } else {
            (remains - forgets) / (difference * tau)
        };
        [sag.depth * remains, sag.followed[channel] * forgets + sag.depth * follows]
    }
}

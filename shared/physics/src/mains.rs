//! The hum of the mains.

use std::f64::consts::TAU;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::faults;
use crate::bench::Bench;

/// A periodic voltage whose phase is random, because a hit is not locked to the mains.
#[derive(Clone, Debug)]
pub(super) struct Mains {
    /// Angular frequency of the fundamental, rad/s.
    omega: f64,
    /// Amplitudes of the fundamental and its harmonics, V; empty without a hum.
    amplitudes: Vec<f64>,
    /// Phase of the fundamental at time zero, rad.
    phase: f64,
    /// Share of the amplitude by which it rises and falls.
    modulation: f64,
    /// Angular frequency of that, rad/s.
    modulation_omega: f64,
    /// Its phase at time zero, rad.
    modulation_phase: f64,
}

impl Mains {
    pub(super) fn new(bench: &Bench) -> Self {
        let mains = &bench.mains;
        let fundamental = mains.amplitude_v + faults::hum(bench);
        let amplitudes = if fundamental > 0.0 {
            let harmonics = mains.harmonics.iter().map(|share| fundamental * share);
            std::iter::once(fundamental).chain(harmonics).collect()
        } else {
            Vec::new()
        };
        Self {
            omega: TAU * mains.frequency_hz,
            amplitudes,
            phase: 0.0,
            modulation: mains.modulation,
            modulation_omega: TAU * mains.modulation_hz,
            modulation_phase: 0.0,
        }
    }

    /// Draws another phase. It shifts the whole waveform in time, harmonics included.
    pub(super) fn draw_phase(&mut self, rng: &mut ChaCha8Rng) {
        self.phase = TAU * rng.random::<f64>();
        // A steady hum draws no more, so its numbers are those of before.
        if self.modulation > 0.0 {
            self.modulation_phase = TAU * rng.random::<f64>();
        }
    }

    /// The voltage at a time, V.
    pub(super) fn voltage(&self, time: f64) -> f64 {
        if self.amplitudes.is_empty() {
            return 0.0;
        }
        let angle = self.omega * time + self.phase;
        let harmonic =
            |(number, amplitude): (u32, &f64)| amplitude * (f64::from(number) * angle).sin();
        let steady: f64 = (1..).zip(&self.amplitudes).map(harmonic).sum();
        if self.modulation == 0.0 {
            return steady;
        }
        let swing = self.modulation_omega * time + self.modulation_phase;
        steady * (1.0 + self.modulation * swing.sin())
    }
}

//! From the outputs of the low-passes to codes: buffers, supply, hum of the mains, multiplexer and converter.
//!
//! ```text
//! low-pass + noise ─▶ rails of the buffer ─▶ zero, drift, wander ─▶ supply ─▶ mains ─▶ memory ─▶ nonlinearity ─▶ code
//! ```

use massline_shared::signal::{CHANNELS, Scan};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::channels::{Channels, SampledOutputs, per_channel};
use super::errors::{TestErrors, normal};
use super::faults;
use super::mains::Mains;
use super::nonlinearity::Nonlinearity;
use super::slow::Slow;
use super::streams::{Branch, branch};
use super::supply::Supply;
use crate::bench::Bench;

/// Everything between the filters and the codes.
#[derive(Clone, Debug)]
pub(super) struct Converter {
    /// How far the buffer of each channel follows from the value at rest, N or m/s².
    rails: Channels,
    /// Value of each channel at rest, N or m/s².
    rest: Channels,
    volts_per_unit: Channels,
    /// The same without a drift.
    nominal_volts_per_unit: Channels,
    zero: Channels,
    /// V/s.
    drift: Channels,
    /// V.
    wander: Option<Slow<CHANNELS>>,
    /// `None` when it is steady.
    supply: Option<Supply>,
    mains: Mains,
    /// Share of the voltage sampled before.
    memory: f64,
    /// Voltage sampled last.
    held: f64,
    /// The last channel that is sampled.
    last: usize,
    nonlinearity: Nonlinearity,
    reference_v: f64,
    volts_per_code: f64,
    /// True interval of the scans and of the channels within a scan, s.
    interval: f64,
    channel_delay: f64,
    jitter_s: f64,
    /// Source of the jitter.
    rng: ChaCha8Rng,
    /// Source of the wander.
    wander_rng: ChaCha8Rng,
    /// Scans since the restart.
    scans: u64,
}

impl Converter {
    /// `tau` are the time constants of the low-passes, s.
    pub(super) fn new(bench: &Bench, errors: &TestErrors, tau: &Channels) -> Self {
        let (sensor, hammer, adc) = (&bench.sensor, &bench.hammer, &bench.adc);
        let nominal = per_channel(hammer.zero_v, sensor.zero_v);
        let interval = adc.clock_stretch() / adc.rate_hz;
        let per_g = sensor.sensitivity_v_per_g / massline_shared::STANDARD_GRAVITY;
        let volts_per_unit = per_channel(hammer.sensitivity_v_per_n, per_g);
        Self {
            rails: faults::rails(bench),
            rest: [0.0; CHANNELS],
            volts_per_unit,
            nominal_volts_per_unit: volts_per_unit,
            zero: std::array::from_fn(|k| nominal[k] + errors.zero_v[k]),
            drift: per_channel(0.0, sensor.drift_v_per_s),
            wander: Slow::new(per_channel(0.0, sensor.wander_v), sensor.wander_s, interval),
            supply: Supply::new(bench, tau),
            mains: Mains::new(bench),
            memory: adc.memory,
            held: 0.0,
            last: (3 * errors.sensors.len()).min(CHANNELS - 1),
            nonlinearity: Nonlinearity::new(bench, errors),
            reference_v: adc.reference_v,
            volts_per_code: adc.reference_v / f64::from(1_u32 << adc.bits),
            interval,
            channel_delay: adc.clock_stretch() * adc.channel_delay_s,
            jitter_s: adc.jitter_s,
            rng: ChaCha8Rng::seed_from_u64(0),
            wander_rng: ChaCha8Rng::seed_from_u64(0),
            scans: 0,
        }
    }

    /// Sets the gain of each channel, which is one at first.
    pub(super) fn set_gains(&mut self, gains: &Channels) {
        let nominal = self.nominal_volts_per_unit;
        self.volts_per_unit = std::array::from_fn(|k| nominal[k] * gains[k]);
    }

    /// Sets the time to zero with all channels at rest. Mains and jitter are drawn from `rng`, wander and supply from
    /// branches of it.
    pub(super) fn restart(&mut self, rest: &Channels, mut rng: ChaCha8Rng) {
        self.wander_rng = branch(&rng, Branch::Wander);
        if let Some(wander) = &mut self.wander {
            wander.settle(&mut self.wander_rng);
        }
        if let Some(supply) = &mut self.supply {
            supply.restart(branch(&rng, Branch::Supply));
        }
        self.mains.draw_phase(&mut rng);
        self.rng = rng;
        self.rest = *rest;
        self.held = self.zero[self.last] + self.volts_per_unit[self.last] * rest[self.last];
        self.scans = 0;
    }

    /// The codes of the next scan, whose channels move no further than `limits` from their values at
    /// rest.
    pub(super) fn convert(
        &mut self,
        sampled: &SampledOutputs,
        noise: &Channels,
        limits: &Channels,
    ) -> Scan {
        let late = if self.jitter_s > 0.0 { self.jitter_s * normal(&mut self.rng) } else { 0.0 };
        let scan = self.scans as f64 * self.interval;
        let start = scan + late;
        if let Some(supply) = &mut self.supply {
            supply.begin(scan, scan + self.interval);
        }
        let mut held = self.held;
        let volts: Channels = std::array::from_fn(|k| {
            let value = sampled.value[k] + sampled.slope[k] * late + noise[k];
            let limit = self.rails[k].min(limits[k]);
            let value = value.clamp(self.rest[k] - limit, self.rest[k] + limit);
            let volts = self.voltage(k, value, start + k as f64 * self.channel_delay);
            // Without memory no channel has to wait for the one before.
            if self.memory > 0.0 {
                held = volts + self.memory * (held - volts);
                held
            } else {
                volts
            }
        });
        self.held = volts[self.last];
        self.scans += 1;
        if let Some(wander) = &mut self.wander {
            wander.advance(&mut self.wander_rng);
        }
        volts.map(|volts| self.nonlinearity.code(volts / self.volts_per_code))
    }

    /// The voltage of a channel at the input of the multiplexer, whose protection ends at the supply.
    fn voltage(&self, channel: usize, value: f64, time: f64) -> f64 {
        let output = self.zero[channel] + self.volts_per_unit[channel] * value;
        let wandered = self.wander.as_ref().map_or(0.0, |wander| wander.value()[channel]);
        let mut volts = output + self.drift[channel] * time + wandered;
        if let Some(supply) = &self.supply {
            volts *= supply.factor(channel, time);
        }
        volts += self.mains.voltage(time);
        volts.clamp(0.0, self.reference_v)
    }
}

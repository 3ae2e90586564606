//! `[adc]`.

use serde::Deserialize;

use super::{SettingProblem, out_of_range};

/// `[adc]`: the multiplexed converter.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default, expecting = "a table [adc]")]
pub struct AdcSettings {
    /// Scans per second.
    pub rate_hz: f64,
    /// Resolution in bits.
    pub bits: u8,
    /// Voltage of code `2^bits`.
    pub reference_v: f64,
    /// Channel `k` is sampled `k` times this after the hammer, s.
    pub channel_delay_s: f64,
    /// Steps of the simulation per scan.
    pub oversampling: u16,
}

impl Default for AdcSettings {
    fn default() -> Self {
        Self {
            rate_hz: 4000.0,
            bits: 12,
            reference_v: 3.0,
            channel_delay_s: 10e-6,
            oversampling: 16,
        }
    }
}

impl AdcSettings {
    pub(in crate::bench) fn problem(&self) -> SettingProblem {
        let last_channel = (massline_shared::signal::CHANNELS - 1) as f64;
        let too_late = self.channel_delay_s * last_channel * self.rate_hz >= 1.0;
        out_of_range(&[
            (self.rate_hz, "rate_hz", 100.0..=1e6),
            (self.bits.into(), "bits", 8.0..=16.0),
            (self.reference_v, "reference_v", 0.01..=100.0),
            (self.channel_delay_s, "channel_delay_s", 0.0..=1.0),
            (self.oversampling.into(), "oversampling", 1.0..=256.0),
        ])
        .or(too_late
            .then(|| ("channel_delay_s", "the last channel would fall into the next scan".into())))
    }
}

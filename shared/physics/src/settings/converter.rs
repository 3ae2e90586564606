//! `[adc]` and `[mains]`.

use std::ops::RangeInclusive;

use serde::Deserialize;

use super::{MAINS_AMPLITUDE, SHARE, SettingProblem, out_of_range};

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
    /// Integral nonlinearity: peak of a sine of three periods over the codes, LSB; its phase is drawn
    /// once per test.
    pub inl_lsb: f64,
    /// Integral nonlinearity: a parabola over the codes with this value at mid scale and zero at both
    /// ends, LSB.
    pub bow_lsb: f64,
    /// Differential nonlinearity: largest deviation of the width of a code from one LSB. Each transition
    /// between two codes is displaced evenly by up to half of this, drawn once per test, so that no code
    /// is missing and the errors of the widths do not add up.
    pub dnl_lsb: f64,
    /// Share of the voltage sampled before that each sampled voltage keeps; the hammer, which is sampled
    /// first, keeps it of the last channel of the scan before.
    pub memory: f64,
    /// Relative error of the sampling clock: all intervals are longer by this than the nominal ones.
    pub clock_error: f64,
    /// Error of the instant of each scan, common to its channels, 1 σ, s.
    pub jitter_s: f64,
    /// Share of the scans that vanish on the way to the rig, which takes the next one for them.
    pub lost_rate: f64,
}

/// Allowed integral nonlinearity, LSB.
const INL: RangeInclusive<f64> = 0.0..=1000.0;
/// Allowed bow, LSB.
const BOW: RangeInclusive<f64> = -1000.0..=1000.0;
/// Allowed differential nonlinearity, LSB: above one the converter would not be monotone.
const DNL: RangeInclusive<f64> = 0.0..=1.0;
/// Allowed share of the voltage sampled before.
const MEMORY: RangeInclusive<f64> = 0.0..=0.5;
/// Allowed relative error of the clock.
const CLOCK_ERROR: RangeInclusive<f64> = -0.1..=0.1;
/// Allowed share of lost scans.
const LOST: RangeInclusive<f64> = 0.0..=0.5;
/// Largest allowed jitter as a share of the interval between scans: it is modelled to first order.
const MOST_JITTER: f64 = 0.1;

impl Default for AdcSettings {
    fn default() -> Self {
        Self {
            rate_hz: 4000.0,
            bits: 12,
            reference_v: 3.0,
            channel_delay_s: 10e-6,
            oversampling: 16,
            inl_lsb: 0.0,
            bow_lsb: 0.0,
            dnl_lsb: 0.0,
            memory: 0.0,
            clock_error: 0.0,
            jitter_s: 0.0,
            lost_rate: 0.0,
        }
    }
}

impl AdcSettings {
    /// True interval of the clock over the nominal one.
    pub(crate) fn clock_stretch(&self) -> f64 {
        1.0 + self.clock_error
    }

    pub(crate) fn problem(&self) -> SettingProblem {
        let last_channel = (massline_shared::signal::CHANNELS - 1) as f64;
        let too_late = self.channel_delay_s * last_channel * self.rate_hz >= 1.0;
        out_of_range(&[
            (self.rate_hz, "rate_hz", 100.0..=1e6),
            (self.bits.into(), "bits", 8.0..=16.0),
            (self.reference_v, "reference_v", 0.01..=100.0),
            (self.channel_delay_s, "channel_delay_s", 0.0..=1.0),
            (self.oversampling.into(), "oversampling", 1.0..=256.0),
            (self.inl_lsb, "inl_lsb", INL),
            (self.bow_lsb, "bow_lsb", BOW),
            (self.dnl_lsb, "dnl_lsb", DNL),
            (self.memory, "memory", MEMORY),
            (self.clock_error, "clock_error", CLOCK_ERROR),
            (self.jitter_s, "jitter_s", 0.0..=MOST_JITTER / self.rate_hz.max(100.0)),
            (self.lost_rate, "lost_rate", LOST),
        ])
        .or(too_late
            .then(|| ("channel_delay_s", "the last channel would fall into the next scan".into())))
    }
}

/// `[mains]`: the hum of the mains in all channels, the hammer's included.
///
/// Its phase is drawn for each arming and is the same in all channels; each channel reads it at its own
/// instant.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default, expecting = "a table [mains]")]
pub struct MainsSettings {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Amplitude of the fundamental at the converter, V; zero is no hum.
    pub amplitude_v: f64,
    /// Amplitudes of the second, third, … harmonic relative to that of the fundamental.
    pub harmonics: Vec<f64>,
    /// Share of the amplitude, harmonics included, by which it rises and falls; zero is a steady hum.
    pub modulation: f64,
    /// Frequency at which the amplitude rises and falls, Hz; its phase is drawn for each arming.
    pub modulation_hz: f64,
}

impl Default for MainsSettings {
    fn default() -> Self {
        Self {
            frequency_hz: 50.0,
            amplitude_v: 0.0,
            harmonics: Vec::new(),
            modulation: 0.0,
            modulation_hz: 1.0,
        }
    }
}

impl MainsSettings {
    pub(crate) fn problem(&self) -> SettingProblem {
        let harmonics: Vec<_> =
            self.harmonics.iter().map(|&share| (share, "harmonics", SHARE)).collect();
        out_of_range(&[
            (self.frequency_hz, "frequency_hz", 1.0..=1000.0),
            (self.amplitude_v, "amplitude_v", MAINS_AMPLITUDE),
            (self.modulation, "modulation", SHARE),
            (self.modulation_hz, "modulation_hz", 0.01..=100.0),
        ])
        .or_else(|| out_of_range(&harmonics))
    }
}

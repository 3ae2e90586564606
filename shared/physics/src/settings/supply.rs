//! `[supply]`.

use std::ops::RangeInclusive;

use serde::Deserialize;

use super::{SHARE, SettingProblem, out_of_range};

/// `[supply]`: how the supply of the sensors, which is also the converter's reference, is not steady.
///
/// A converter reads shares of its supply. The output of a sensor is a share of it as well, but follows it through the
/// sensor's low-pass, so that the codes show what the supply does until the output has followed. The hammer's output
/// does not follow at all. 1 mV of ripple at 105 Hz on a supply of 3.3 V reads as 0.1 mV at a sensor in the middle of
/// it: 1.8 mg.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default, expecting = "a table [supply]")]
pub struct SupplySettings {
    /// Voltage of the supply, V.
    pub voltage_v: f64,
    /// Amplitude of the ripple by which the screen's pictures follow one another, V; zero is no ripple.
    pub ripple_v: f64,
    /// Its frequency, Hz; that of an SSD1306 is 105 Hz within 10 %.
    pub ripple_hz: f64,
    /// Amplitudes of the second, third, … harmonic relative to that of the fundamental.
    pub ripple_harmonics: Vec<f64>,
    /// How far the supply sags when a load changes, as with a tone, a light, another picture, V; zero is not at all.
    pub droop_v: f64,
    /// Time in which the sag falls to 1/e, s.
    pub droop_s: f64,
    /// Mean number of such changes in a second.
    pub droop_rate_per_s: f64,
}

/// Allowed supply, V.
const VOLTAGE: RangeInclusive<f64> = 1.0..=10.0;
/// Allowed ripple and droop, V.
const DEVIATION: RangeInclusive<f64> = 0.0..=5.0;
/// Largest allowed deviation as a share of the supply: at one the converter would have no reference.
const MOST_DEVIATION: f64 = 0.5;
/// Allowed times of recovery, s.
const RECOVERY: RangeInclusive<f64> = 1e-6..=100.0;
/// Allowed rate of droops, 1/s.
const DROOP_RATE: RangeInclusive<f64> = 0.0..=100.0;

impl Default for SupplySettings {
    fn default() -> Self {
        Self {
            voltage_v: 3.3,
            ripple_v: 0.0,
            ripple_hz: 105.0,
            ripple_harmonics: Vec::new(),
            droop_v: 0.0,
            droop_s: 1e-3,
            droop_rate_per_s: 0.0,
        }
    }
}

impl SupplySettings {
    pub(crate) fn problem(&self) -> SettingProblem {
        let harmonics: Vec<_> =
            self.ripple_harmonics.iter().map(|&share| (share, "ripple_harmonics", SHARE)).collect();
        out_of_range(&[
            (self.voltage_v, "voltage_v", VOLTAGE),
            (self.ripple_v, "ripple_v", DEVIATION),
            (self.ripple_hz, "ripple_hz", 1.0..=1000.0),
            (self.droop_v, "droop_v", DEVIATION),
            (self.droop_s, "droop_s", RECOVERY),
            (self.droop_rate_per_s, "droop_rate_per_s", DROOP_RATE),
        ])
        .or_else(|| out_of_range(&harmonics))
        .or_else(|| {
            let ripple = self.ripple_v * (1.0 + self.ripple_harmonics.iter().sum::<f64>());
            let message = "ripple with its harmonics, and droop, exceed half of the supply";
            let too_much = ripple + self.droop_v > MOST_DEVIATION * self.voltage_v;
            too_much.then(|| {
                (if ripple > self.droop_v { "ripple_v" } else { "droop_v" }, message.into())
            })
        })
    }
}

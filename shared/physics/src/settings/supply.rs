//! `[supply]`.

use super::{SHARE, SettingProblem};

/// Largest allowed deviation as a share of the supply: at one the converter would have no reference.
const MOST_DEVIATION: f64 = 0.5;

settings! {
    /// `[supply]`: how the supply of the sensors, which is also the converter's reference, is not steady.
    ///
    /// A converter reads shares of its supply. The output of a sensor is a share of it as well, but follows it through
    /// the sensor's low-pass, so that the codes show what the supply does until the output has followed. The hammer's
    /// output does not follow at all. 1 mV of ripple at 105 Hz on a supply of 3.3 V reads as 0.1 mV at a sensor in the
    /// middle of it: 1.8 mg.
    SupplySettings, "a table [supply]", contradiction {
        /// Voltage of the supply, V.
        voltage_v: f64 = 3.3, 1.0..=10.0;
        /// Amplitude of the ripple by which the screen's pictures follow one another, V; zero is no ripple.
        ripple_v: f64 = 0.0, 0.0..=5.0;
        /// Its frequency, Hz; that of an SSD1306 is 105 Hz within 10 %.
        ripple_hz: f64 = 105.0, 1.0..=1000.0;
        /// Amplitudes of the second, third, … harmonic relative to that of the fundamental.
        ripple_harmonics: Vec<f64> = Vec::new(), SHARE;
        /// How far the supply sags when a load changes, as with a tone, a light, another picture, V; zero is not at
        /// all.
        droop_v: f64 = 0.0, 0.0..=5.0;
        /// Time in which the sag falls to 1/e, s.
        droop_s: f64 = 1e-3, 1e-6..=100.0;
        /// Mean number of such changes in a second.
        droop_rate_per_s: f64 = 0.0, 0.0..=100.0;
    }
}

impl SupplySettings {
    fn contradiction(&self) -> SettingProblem {
        let ripple = self.ripple_v * (1.0 + self.ripple_harmonics.iter().sum::<f64>());
        let too_much = ripple + self.droop_v > MOST_DEVIATION * self.voltage_v;
        let key = if ripple > self.droop_v { "ripple_v" } else { "droop_v" };
        too_much.then(|| {
            (key, "ripple with its harmonics, and droop, exceed half of the supply".into())
        })
    }
}

//! `[adc]` and `[mains]`.

use massline_shared::signal::CHANNELS;

use super::{MAINS_AMPLITUDE, SHARE, SettingProblem};

/// Largest allowed jitter as a share of the interval between scans: it is modelled to first order.
const MOST_JITTER: f64 = 0.1;

settings! {
    /// `[adc]`: the multiplexed converter.
    AdcSettings(adc), "a table [adc]", contradiction {
        /// Scans per second.
        rate_hz: f64 = 4000.0, 100.0..=1e6;
        /// Resolution in bits.
        bits: u8 = 12, 8.0..=16.0;
        /// Voltage of code `2^bits`.
        reference_v: f64 = 3.0, 0.01..=100.0;
        /// Channel `k` is sampled `k` times this after the hammer, s.
        channel_delay_s: f64 = 10e-6, 0.0..=1.0;
        /// Steps of the simulation per scan.
        oversampling: u16 = 16, 1.0..=256.0;
        /// Integral nonlinearity: peak of a sine of three periods over the codes, LSB; its phase is drawn
        /// once per test.
        inl_lsb: f64 = 0.0, 0.0..=1000.0;
        /// Integral nonlinearity: a parabola over the codes with this value at mid scale and zero at both
        /// ends, LSB.
        bow_lsb: f64 = 0.0, -1000.0..=1000.0;
        /// Differential nonlinearity: largest deviation of the width of a code from one LSB. Each transition
        /// between two codes is displaced evenly by up to half of this, drawn once per test, so that no code
        /// is missing and the errors of the widths do not add up. Above one the converter would not be monotone.
        dnl_lsb: f64 = 0.0, 0.0..=1.0;
        /// Share of the voltage sampled before that each sampled voltage keeps; the hammer, which is sampled
        /// first, keeps it of the last channel of the scan before.
        memory: f64 = 0.0, 0.0..=0.5;
        /// Relative error of the sampling clock: all intervals are longer by this than the nominal ones.
        clock_error: f64 = 0.0, -0.1..=0.1;
        /// Error of the instant of each scan, common to its channels, 1 σ, s.
        jitter_s: f64 = 0.0, 0.0..=MOST_JITTER / adc.rate_hz;
        /// Share of the scans that vanish on the way to the rig, which takes the next one for them.
        lost_rate: f64 = 0.0, 0.0..=0.5;
    }
}

impl AdcSettings {
    /// True interval of the clock over the nominal one.
    pub(crate) fn clock_stretch(&self) -> f64 {
        1.0 + self.clock_error
    }

    fn contradiction(&self) -> SettingProblem {
        let last_channel = (CHANNELS - 1) as f64;
        let too_late = self.channel_delay_s * last_channel * self.rate_hz >= 1.0;
        too_late
            .then(|| ("channel_delay_s", "the last channel would fall into the next scan".into()))
    }
}

settings! {
    /// `[mains]`: the hum of the mains in all channels, the hammer's included.
    ///
    /// Its phase is drawn for each arming and is the same in all channels; each channel reads it at its own
    /// instant.
    MainsSettings, "a table [mains]" {
        /// Frequency, Hz.
        frequency_hz: f64 = 50.0, 1.0..=1000.0;
        /// Amplitude of the fundamental at the converter, V; zero is no hum.
        amplitude_v: f64 = 0.0, MAINS_AMPLITUDE;
        /// Amplitudes of the second, third, … harmonic relative to that of the fundamental.
        harmonics: Vec<f64> = Vec::new(), SHARE;
        /// Share of the amplitude, harmonics included, by which it rises and falls; zero is a steady hum.
        modulation: f64 = 0.0, SHARE;
        /// Frequency at which the amplitude rises and falls, Hz; its phase is drawn for each arming.
        modulation_hz: f64 = 1.0, 0.01..=100.0;
    }
}

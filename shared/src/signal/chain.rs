//! The electrical chain between a quantity and its ADC code.

use serde::{Deserialize, Serialize};

use super::CHANNELS;
use crate::units::{Hertz, Seconds, Volts};

/// The hammer's channel; response `k` is channel `k + 1`.
pub const HAMMER: usize = 0;

/// What a sampler states of itself.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AdcProperties {
    /// Scans per second.
    pub rate: Hertz,
    /// Channels in use, the hammer included; the rest of a scan is meaningless.
    pub channels: u8,
    /// Resolution; a code runs from 0 to `2^bits − 1`.
    pub bits: u8,
    /// Voltage of code `2^bits`.
    pub reference: Volts,
    /// Channel `k` is sampled `k` times this after channel 0.
    pub channel_delay: Seconds,
}

impl AdcProperties {
    /// Volts per code.
    pub fn volts_per_code(&self) -> f32 {
        self.reference.0 / (1_u32 << self.bits) as f32
    }

    /// The largest code.
    pub fn full_scale(&self) -> u16 {
        ((1_u32 << self.bits) - 1) as u16
    }

    /// Response channels in use.
    pub fn responses(&self) -> usize {
        usize::from(self.channels).clamp(1, CHANNELS) - 1
    }
}

/// Zero and sensitivity of one channel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChannelCalibration {
    /// Output at zero force or zero acceleration.
    pub zero: Volts,
    /// V/N for the hammer, V/(m/s²) for an accelerometer.
    pub sensitivity: f32,
}

/// Zeros and sensitivities of all channels: the hammer, then sensor 1 x, y, z, …
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// Channel by channel.
    pub channels: [ChannelCalibration; CHANNELS],
    /// An accelerometer is overloaded beyond this, m/s².
    pub sensor_range: f32,
}

impl Calibration {
    /// Nominal sensitivity of the ADXL326 at 3 V, V/g.
    pub const ADXL326_VOLT_PER_G: f64 = 0.057;
    /// Nominal output of the ADXL326 at rest on a 3 V supply.
    pub const ADXL326_ZERO: Volts<f64> = Volts(1.5);
    /// Range of the ADXL326, g.
    pub const ADXL326_RANGE_G: f64 = 16.0;
    /// Hammer with conditioner, V/N.
    pub const HAMMER_VOLT_PER_NEWTON: f64 = 0.0225;
    /// Output of the hammer's conditioner at rest.
    pub const HAMMER_ZERO: Volts<f64> = Volts(0.1);
    /// Least [`Calibration::sensor_range`], m/s²: gravity takes one g of the range, and a hit needs
    /// room beside it.
    pub const SMALLEST_RANGE: f32 = (2.0 * crate::STANDARD_GRAVITY) as f32;

    /// N (hammer) or m/s² (accelerometer) per code of a channel; 0 for a channel that does not
    /// exist or whose sensitivity is zero or not finite, so that it reads as rest.
    pub fn per_code(&self, adc: &AdcProperties, channel: usize) -> f32 {
        let scale =
            self.channels.get(channel).map_or(0.0, |c| adc.volts_per_code() / c.sensitivity);
        if scale.is_finite() { scale } else { 0.0 }
    }

    /// True when every number is finite, no sensitivity is zero and the range of the sensors is
    /// more than [`Self::SMALLEST_RANGE`].
    pub fn is_usable(&self) -> bool {
        let usable = |c: &ChannelCalibration| c.zero.0.is_finite() && c.sensitivity.is_normal();
        self.channels.iter().all(usable)
            && self.sensor_range.is_finite()
            && self.sensor_range > Self::SMALLEST_RANGE
    }
}

impl Default for Calibration {
    /// The data sheet's nominal values.
    fn default() -> Self {
        let g = crate::STANDARD_GRAVITY as f32;
        let mut channels = [ChannelCalibration {
            zero: Volts(Self::ADXL326_ZERO.0 as f32),
            sensitivity: Self::ADXL326_VOLT_PER_G as f32 / g,
        }; CHANNELS];
        channels[0] = ChannelCalibration {
            zero: Volts(Self::HAMMER_ZERO.0 as f32),
            sensitivity: Self::HAMMER_VOLT_PER_NEWTON as f32,
        };
        Self { channels, sensor_range: Self::ADXL326_RANGE_G as f32 * g }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_that_leaves_no_room_for_a_hit_or_is_no_number_is_not_usable() {
        let usable =
            |sensor_range| Calibration { sensor_range, ..Calibration::default() }.is_usable();
        assert!(Calibration::default().is_usable());
        assert!(usable(Calibration::SMALLEST_RANGE * 1.01));
        for range in [Calibration::SMALLEST_RANGE, 9.0, 0.0, -157.0, f32::NAN, f32::INFINITY] {
            assert!(!usable(range), "{range} m/s²");
        }
    }

    #[test]
    fn a_sensitivity_or_zero_that_is_no_number_is_not_usable() {
        for bad in [0.0, f32::NAN, f32::INFINITY] {
            let mut calibration = Calibration::default();
            calibration.channels[4].sensitivity = bad;
            assert!(!calibration.is_usable(), "sensitivity {bad}");
        }
        let mut calibration = Calibration::default();
        calibration.channels[4].zero = Volts(f32::NAN);
        assert!(!calibration.is_usable());
    }
}

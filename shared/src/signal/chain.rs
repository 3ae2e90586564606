//! The electrical chain between a physical quantity and its ADC code.

use nalgebra::{ComplexField, Matrix3};

use super::{CHANNELS, DECIMATION, RESPONSES, ROW_BITS};
use crate::real::Real;
use crate::units::{Hertz, Seconds, Volts};

/// The hammer's channel; response `k` is channel `k + 1`.
pub const HAMMER: usize = 0;

/// Properties of a sampler.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AdcProperties {
    /// Scans per second.
    pub rate: Hertz,
    /// Number of channels in use, including the hammer; the rest of a scan is undefined.
    pub channels: u8,
    /// Resolution, bits; a code ranges from 0 to `2^bits − 1`.
    pub bits: u8,
    /// Voltage of code `2^bits`.
    pub reference: Volts,
    /// Channel `k` is sampled `k` times this delay after channel 0.
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

    /// The properties of the codes in a long record: those of its rows of responses. The hammer's codes have the same
    /// resolution, but the full rate.
    pub fn of_rows(&self) -> Self {
        Self { rate: Hertz(self.rate.0 / DECIMATION as f32), bits: ROW_BITS, ..*self }
    }

    /// Factor from a code to one with the resolution of a long record.
    pub fn to_row_code(&self) -> u16 {
        1 << ROW_BITS.saturating_sub(self.bits)
    }

    /// Number of response channels in use.
    pub fn responses(&self) -> usize {
        usize::from(self.channels).clamp(1, CHANNELS) - 1
    }
}

/// Zero, sensitivity and low-pass of one channel.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ChannelCalibration {
    /// Output at zero force or zero acceleration.
    pub zero: Volts,
    /// V/N for the hammer, V/(m/s²) for an accelerometer.
    pub sensitivity: f32,
    /// Cutoff frequency of its first-order low-pass, which is compensated; zero when it is unknown, as with
    /// equal channels, or when there is no low-pass.
    pub cutoff: Hertz,
}

/// Readings of a triaxial sensor's channels for motion along the other two axes, relative to those along
/// their own: `xy` is channel x for acceleration along y.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct CrossAxis {
    /// Channel x for y.
    pub xy: f32,
    /// Channel x for z.
    pub xz: f32,
    /// Channel y for x.
    pub yx: f32,
    /// Channel y for z.
    pub yz: f32,
    /// Channel z for x.
    pub zx: f32,
    /// Channel z for y.
    pub zy: f32,
}

impl CrossAxis {
    /// Limit below which each of them must be: the axes of a sensor are distinct.
    pub const LARGEST: f32 = 0.3;

    /// Ones on the diagonal, cross-axis sensitivities off it: the readings of the channels, scaled by their
    /// sensitivities, for an acceleration.
    pub fn matrix<R: Real>(&self) -> Matrix3<R> {
        let real = |value: f32| R::of(f64::from(value));
        let Self { xy, xz, yx, yz, zx, zy } = *self;
        Matrix3::new(1.0, xy, xz, yx, 1.0, yz, zx, zy, 1.0).map(real)
    }

    /// True when the magnitude of every number is below [`Self::LARGEST`].
    pub fn is_usable(&self) -> bool {
        let Self { xy, xz, yx, yz, zx, zy } = *self;
        // NaN also fails this comparison.
        [xy, xz, yx, yz, zx, zy].iter().all(|v| v.abs() < Self::LARGEST)
    }
}

/// Number of triaxial sensors in a scan.
const SENSORS: usize = RESPONSES / 3;

/// Calibration of all channels: the hammer, then sensor 1 x, y, z, …
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Calibration {
    /// Zero, sensitivity and low-pass of each channel.
    pub channels: [ChannelCalibration; CHANNELS],
    /// Cross-axis sensitivities of each sensor.
    pub cross_axis: [CrossAxis; SENSORS],
    /// Range of the accelerometers, m/s²; beyond it they are overloaded.
    pub sensor_range: f32,
}

impl Calibration {
    /// Nominal sensitivity of the ADXL326 at 3 V, V/g.
    pub const ADXL326_VOLT_PER_G: f64 = 0.057;
    /// Nominal output of the ADXL326 at zero acceleration on a 3 V supply.
    pub const ADXL326_ZERO: Volts<f64> = Volts(1.5);
    /// Range of the ADXL326, g.
    pub const ADXL326_RANGE_G: f64 = 16.0;
    /// Sensitivity of the hammer with its conditioner, V/N.
    pub const HAMMER_VOLT_PER_NEWTON: f64 = 0.0225;
    /// Output of the hammer's conditioner without force.
    pub const HAMMER_ZERO: Volts<f64> = Volts(0.1);
    /// Resistance in each output of an ADXL326, ohm.
    pub const ADXL326_OUTPUT_OHM: f64 = 32e3;
    /// Cutoff of the low-pass formed by 10 nF and the output of an ADXL326; that of the hammer is equal.
    pub const RC_CUTOFF: Hertz<f64> =
        Hertz(1.0 / (core::f64::consts::TAU * Self::ADXL326_OUTPUT_OHM * 10e-9));
    /// Lower limit of [`Calibration::sensor_range`], m/s²: gravity takes one g of the range, and the hit
    /// needs some as well.
    pub const SMALLEST_RANGE: f32 = (2.0 * crate::units::STANDARD_GRAVITY) as f32;

    /// N (hammer) or m/s² (accelerometer) per code of a channel. 0 for a channel that does not exist or whose
    /// sensitivity is zero or not finite, so that it reads its rest value.
    pub fn per_code(&self, adc: &AdcProperties, channel: usize) -> f32 {
        let scale =
            self.channels.get(channel).map_or(0.0, |c| adc.volts_per_code() / c.sensitivity);
        if scale.is_finite() { scale } else { 0.0 }
    }

    /// Corrects the readings of the sensors for cross-axis sensitivity, in place. `readings` has three
    /// numbers per sensor in the order of the channels: in m/s² by [`Self::per_code`], or any quantity that
    /// depends on these readings linearly and equally for all channels, such as frequency responses and mass
    /// lines. An incomplete sensor at the end is left unchanged.
    ///
    /// ```
    /// # use massline_shared::signal::{Calibration, CrossAxis};
    /// let mut calibration = Calibration::default();
    /// // Channel x of the first sensor reads 2 % of what moves along y.
    /// calibration.cross_axis[0] = CrossAxis { xy: 0.02, ..CrossAxis::default() };
    /// let mut readings = [0.2_f64, 10.0, 0.0];
    /// calibration.undo_cross_axis(&mut readings);
    /// assert!(readings[0].abs() < 1e-6 && (readings[1] - 10.0).abs() < 1e-6);
    /// ```
    pub fn undo_cross_axis<T>(&self, readings: &mut [T])
    where
        T: ComplexField<RealField: Real>,
    {
        for (sensor, axes) in readings.as_chunks_mut().0.iter_mut().enumerate() {
            self.to_own_axes(sensor, axes);
        }
    }

    /// Removes the cross-axis sensitivities from the readings of one sensor: what is left is the motion along its own
    /// axes.
    pub fn to_own_axes<T>(&self, sensor: usize, axes: &mut [T; 3])
    where
        T: ComplexField<RealField: Real>,
    {
        // A usable matrix is diagonally dominant, so it has an inverse.
        let inverse = self
            .cross_axis
            .get(sensor)
            .and_then(|cross_axis| cross_axis.matrix::<T::RealField>().try_inverse());
        let Some(inverse) = inverse else { return };
        let [x, y, z] = axes.clone();
        for (axis, row) in axes.iter_mut().zip(inverse.row_iter()) {
            *axis = x.clone().scale(row[0]) + y.clone().scale(row[1]) + z.clone().scale(row[2]);
        }
    }

    /// The time constant of a channel's low-pass, s; zero without one.
    pub fn lag(&self, channel: usize) -> f32 {
        let cutoff = self.channels.get(channel).map_or(0.0, |channel| channel.cutoff.0);
        if cutoff > 0.0 { (core::f32::consts::TAU * cutoff).recip() } else { 0.0 }
    }

    /// Sensitivity of a sensor, V/(m/s²): row `k` is the output of its channel `k` for unit acceleration
    /// along each of its axes. Zero for a sensor that does not exist.
    pub fn sensor_sensitivity(&self, sensor: usize) -> Matrix3<f64> {
        let Some(cross_axis) = self.cross_axis.get(sensor) else { return Matrix3::zeros() };
        let mut matrix = cross_axis.matrix();
        for (k, mut row) in matrix.row_iter_mut().enumerate() {
            row *= f64::from(self.channels[1 + 3 * sensor + k].sensitivity);
        }
        matrix
    }

    /// Sets the sensitivity of a sensor in the form of [`Self::sensor_sensitivity`]; no effect for a sensor
    /// that does not exist.
    pub fn set_sensor_sensitivity(&mut self, sensor: usize, matrix: &Matrix3<f64>) {
        let Some(cross_axis) = self.cross_axis.get_mut(sensor) else { return };
        for k in 0..3 {
            self.channels[1 + 3 * sensor + k].sensitivity = matrix[(k, k)] as f32;
        }
        let relative = |row, column| (matrix[(row, column)] / matrix[(row, row)]) as f32;
        *cross_axis = CrossAxis {
            xy: relative(0, 1),
            xz: relative(0, 2),
            yx: relative(1, 0),
            yz: relative(1, 2),
            zx: relative(2, 0),
            zy: relative(2, 1),
        };
    }

    /// True when every number is finite, no sensitivity is zero, no cutoff is negative, no cross-axis
    /// sensitivity reaches [`CrossAxis::LARGEST`] and the range of the sensors is above
    /// [`Self::SMALLEST_RANGE`].
    pub fn is_usable(&self) -> bool {
        let usable = |c: &ChannelCalibration| {
            let low_pass = c.cutoff.0 == 0.0 || c.cutoff.0.is_normal() && c.cutoff.0 > 0.0;
            c.zero.0.is_finite() && c.sensitivity.is_normal() && low_pass
        };
        self.channels.iter().all(usable)
            && self.cross_axis.iter().all(CrossAxis::is_usable)
            && self.sensor_range.is_finite()
            && self.sensor_range > Self::SMALLEST_RANGE
    }
}

impl Default for Calibration {
    /// The data sheet's nominal values.
    fn default() -> Self {
        let g = crate::units::STANDARD_GRAVITY as f32;
        let mut channels = [ChannelCalibration {
            zero: Volts(Self::ADXL326_ZERO.0 as f32),
            sensitivity: Self::ADXL326_VOLT_PER_G as f32 / g,
            cutoff: Hertz(Self::RC_CUTOFF.0 as f32),
        }; CHANNELS];
        channels[0] = ChannelCalibration {
            zero: Volts(Self::HAMMER_ZERO.0 as f32),
            sensitivity: Self::HAMMER_VOLT_PER_NEWTON as f32,
            ..channels[0]
        };
        let cross_axis = [CrossAxis::default(); SENSORS];
        Self { channels, cross_axis, sensor_range: Self::ADXL326_RANGE_G as f32 * g }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

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
    fn cross_axis_sensitivities_are_taken_out_of_what_the_sensors_read() {
        let mut calibration = Calibration::default();
        #[rustfmt::skip]
        let sensitivity = Matrix3::new(
            6.1e-3, 4e-5, -6e-5,
            3e-5, 5.6e-3, 2e-5,
            -5e-5, 1e-5, 5.9e-3,
        );
        calibration.set_sensor_sensitivity(1, &sensitivity);
        assert!(calibration.is_usable());
        // Stored in single precision.
        let kept = calibration.sensor_sensitivity(1);
        assert!((kept - sensitivity).amax() < 1e-9, "{kept}");
        let truth = Vector3::new(1.0, -2.0, 0.5);
        let volts = sensitivity * truth;
        let mut readings = [0.0; 8];
        readings[..3].copy_from_slice(truth.as_slice());
        for k in 0..3 {
            readings[3 + k] = volts[k] / f64::from(calibration.channels[4 + k].sensitivity);
        }
        // The two readings of an incomplete sensor are left unchanged.
        readings[6..].copy_from_slice(&[3.0, 4.0]);
        calibration.undo_cross_axis(&mut readings);
        for (k, expected) in [1.0, -2.0, 0.5, 1.0, -2.0, 0.5, 3.0, 4.0].into_iter().enumerate() {
            assert!((readings[k] - expected).abs() < 1e-6, "{k}: {}", readings[k]);
        }
    }

    #[test]
    fn a_cross_axis_sensitivity_that_makes_two_axes_one_is_not_usable() {
        for bad in [CrossAxis::LARGEST, -0.5, f32::NAN, f32::INFINITY] {
            let mut calibration = Calibration::default();
            calibration.cross_axis[2].zy = bad;
            assert!(!calibration.is_usable(), "{bad}");
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
        for (cutoff, usable) in [(0.0, true), (497.4, true), (-1.0, false), (f32::NAN, false)] {
            let mut calibration = Calibration::default();
            calibration.channels[4].cutoff = Hertz(cutoff);
            assert_eq!(calibration.is_usable(), usable, "{cutoff} Hz");
        }
    }
}

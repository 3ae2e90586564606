//! A calibration with its origin, as a rig stores it.

use heapless::String;
use num_enum::{FromPrimitive, IntoPrimitive};

use super::block::ForceRatio;
use super::tumble::SensorSensitivity;
use crate::capacity::Capacity;
use crate::layout::{DEFAULT_HAMMER_GAIN, Layout, RIG_SENSORS, SensorUncertainty};
use crate::real::Real;
use crate::signal::{Calibration, HAMMER};
use crate::units::Volts;

/// Relative drift of a gain after its calibration, for each month: 0.05 %, from temperature, humidity and the
/// ageing of sensor, amplifier and hammer.
pub const GAIN_DRIFT_PER_MONTH: f64 = 0.0005;
/// Mean length of a month, days.
const DAYS_PER_MONTH: f64 = 365.25 / 12.0;

/// How a calibration was made. The numbers never change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, FromPrimitive, IntoPrimitive)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(into = "u8", from = "u8")
)]
#[repr(u8)]
pub enum CalibrationMethod {
    /// Nominal values of the data sheets.
    DataSheet = 0,
    /// Sensors calibrated by a tumble test; hammer unchanged.
    Tumble = 1,
    /// Sensors calibrated against the hammer by a block of known mass.
    Block = 2,
    /// Sensors calibrated by a tumble test, then the hammer against them by a block of known mass.
    TumbleAndBlock = 3,
    /// Made by other means, read from a file, or made by a method that this program does not know.
    #[num_enum(default)]
    Other = 4,
}

#[expect(
    clippy::derivable_impls,
    reason = "num_enum takes the derived default for unknown numbers"
)]
impl Default for CalibrationMethod {
    fn default() -> Self {
        Self::DataSheet
    }
}

impl CalibrationMethod {
    /// Every method.
    pub const ALL: [Self; 5] =
        [Self::DataSheet, Self::Tumble, Self::Block, Self::TumbleAndBlock, Self::Other];

    /// Name of the method in reports and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::DataSheet => "data-sheet",
            Self::Tumble => "tumble",
            Self::Block => "block",
            Self::TumbleAndBlock => "tumble-and-block",
            Self::Other => "other",
        }
    }

    /// True when the sensitivities of the sensors are known absolutely, not only against the hammer.
    pub fn knows_sensors(self) -> bool {
        matches!(self, Self::Tumble | Self::TumbleAndBlock)
    }
}

/// Relative standard deviations (1 σ) of a calibration: the gain terms of an error budget.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct CalibrationSigma {
    /// Sensitivity of each axis: relative to the hammer after a block test alone, otherwise absolute.
    pub gain: f32,
    /// Each cross-axis sensitivity over the sensitivity of its channel.
    pub cross_axis: f32,
    /// Hammer against the sensors; 0 after a block test alone, whose error is contained in `gain`.
    pub hammer_gain: f32,
}

impl Default for CalibrationSigma {
    /// Values of the data sheets: ±10 % gain of an ADXL326, 1 % cross-axis, and the hammer from theory,
    /// section 9.
    fn default() -> Self {
        Self { gain: 0.05, cross_axis: 0.01, hammer_gain: DEFAULT_HAMMER_GAIN as f32 }
    }
}

impl CalibrationSigma {
    /// True when every number is finite and not negative.
    pub fn is_usable(&self) -> bool {
        [self.gain, self.cross_axis, self.hammer_gain].iter().all(|s| s.is_finite() && *s >= 0.0)
    }

    /// The standard deviations after this number of days, with the drift of the gains
    /// ([`GAIN_DRIFT_PER_MONTH`]).
    pub fn aged(&self, days: u16) -> Self {
        let drift = (GAIN_DRIFT_PER_MONTH / DAYS_PER_MONTH * f64::from(days)) as f32;
        let with_drift = |sigma: f32| libm::hypotf(sigma, drift);
        Self {
            gain: with_drift(self.gain),
            hammer_gain: with_drift(self.hammer_gain),
            cross_axis: self.cross_axis,
        }
    }

    /// Supplies the standard deviations that the layout takes from a calibration
    /// ([`CalibratedGains`](crate::layout::CalibratedGains)).
    pub fn apply_to<R: Real, C: Capacity>(&self, layout: &mut Layout<R, C>) {
        supply(layout, [self.gain, self.cross_axis, self.hammer_gain].map(f64::from));
    }
}

/// Gives a layout that takes standard deviations from a calibration the default ones, as in its file.
///
/// ```
/// # use massline_shared::calibration::{CalibrationSigma, without_calibration};
/// # use massline_shared::layout::RigLayout;
/// let as_stated = RigLayout { calibrated_hammer: true, ..RigLayout::default() };
/// let mut layout = as_stated.clone();
/// CalibrationSigma { hammer_gain: 0.003, ..Default::default() }.apply_to(&mut layout);
/// assert_eq!(layout.apparatus.hammer_gain, 0.003);
/// without_calibration(&mut layout);
/// assert_eq!(layout, as_stated);
/// ```
pub fn without_calibration<R: Real, C: Capacity>(layout: &mut Layout<R, C>) {
    let SensorUncertainty { gain, cross_axis, .. } = SensorUncertainty::<f64>::default();
    supply(layout, [gain, cross_axis, DEFAULT_HAMMER_GAIN]);
}

fn supply<R: Real, C: Capacity>(
    layout: &mut Layout<R, C>,
    [gain, cross_axis, hammer_gain]: [f64; 3],
) {
    for sensor in layout.sensors.iter_mut() {
        if sensor.calibrated.gain {
            sensor.uncertainty.gain = R::of(gain);
        }
        if sensor.calibrated.cross_axis {
            sensor.uncertainty.cross_axis = R::of(cross_axis);
        }
    }
    if layout.calibrated_hammer {
        layout.apparatus.hammer_gain = R::of(hammer_gain);
    }
}

/// A calibration with its origin.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CalibrationRecord {
    /// Zeros and sensitivities.
    pub calibration: Calibration,
    /// How it was made.
    pub method: CalibrationMethod,
    /// Standard deviations of the calibration.
    pub sigma: CalibrationSigma,
    /// Date, `yyyy-mm-dd`; empty when unknown.
    pub date: String<10>,
    /// Name or serial number of the hammer, may be empty.
    pub hammer: String<12>,
    /// Names or serial numbers of the sensors, in the order of the inputs, may be empty.
    pub sensors: [String<12>; RIG_SENSORS],
    /// Temperature during the calibration, °C.
    pub temperature: Option<f32>,
}

impl CalibrationRecord {
    /// True when a rig can use this calibration.
    pub fn is_usable(&self) -> bool {
        self.calibration.is_usable() && self.sigma.is_usable()
    }

    /// The standard deviations that the calibration contributes to an error budget; `None` for one from data
    /// sheets or of unknown origin.
    pub fn budget(&self) -> Option<CalibrationSigma> {
        let known = !matches!(self.method, CalibrationMethod::DataSheet | CalibrationMethod::Other);
        known.then_some(self.sigma)
    }

    /// Applies the result of a tumble test of the first sensors and the hammer's output without force, V. The
    /// standard deviations become those of the worst sensor; that of the hammer against the sensors returns
    /// to its default.
    pub fn take_tumble<R: Real>(&mut self, sensors: &[SensorSensitivity<R>], hammer_zero: R) {
        let worst = |sigma_of: fn(&SensorSensitivity<R>) -> R| {
            sensors.iter().map(sigma_of).fold(R::zero(), |worst, sigma| worst.max(sigma)).to_f32()
        };
        self.method = CalibrationMethod::Tumble;
        self.sigma = CalibrationSigma {
            gain: worst(SensorSensitivity::relative_gain_sigma),
            cross_axis: worst(SensorSensitivity::relative_cross_axis_sigma),
            ..CalibrationSigma::default()
        };
        let calibration = &mut self.calibration;
        calibration.channels[HAMMER].zero = Volts(hammer_zero.to_f32());
        for (k, sensor) in sensors.iter().enumerate() {
            calibration.set_sensor_sensitivity(k, &sensor.sensitivity.map(R::to_f64));
            for (channel, zero) in calibration.channels.iter_mut().skip(1 + 3 * k).zip(&sensor.zero)
            {
                channel.zero = Volts(zero.to_f32());
            }
        }
    }

    /// Applies the result of a block test: the hammer against sensors of known sensitivity
    /// ([`CalibrationMethod::knows_sensors`]).
    pub fn take_block<R: Real>(&mut self, hammer: &ForceRatio<R>) {
        let sensitivity = &mut self.calibration.channels[HAMMER].sensitivity;
        *sensitivity = (R::of(f64::from(*sensitivity)) / hammer.ratio).to_f32();
        self.method = CalibrationMethod::TumbleAndBlock;
        self.sigma.hammer_gain = (hammer.sigma / hammer.ratio).to_f32();
    }
}

impl From<Calibration> for CalibrationRecord {
    /// A calibration of unknown origin.
    fn from(calibration: Calibration) -> Self {
        Self { calibration, method: CalibrationMethod::Other, ..Self::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_calibration_the_data_sheets_hold() {
        let record = CalibrationRecord::default();
        assert_eq!(record.method, CalibrationMethod::DataSheet);
        assert_eq!(record.calibration, Calibration::default());
        assert!(record.is_usable());
    }

    #[test]
    fn a_block_changes_the_hammer_and_nothing_else() {
        let before = CalibrationRecord { method: CalibrationMethod::Tumble, ..Default::default() };
        let mut record = before.clone();
        record.take_block(&ForceRatio { ratio: 1.02_f32, sigma: 0.003, departure: (0.0, 1.0) });
        let was = before.calibration.channels[HAMMER].sensitivity;
        assert_eq!(record.calibration.channels[HAMMER].sensitivity, was / 1.02);
        assert_eq!(record.method, CalibrationMethod::TumbleAndBlock);
        assert_eq!(record.sigma.hammer_gain, 0.003 / 1.02);
        assert_eq!(
            (record.sigma.gain, record.sigma.cross_axis),
            (before.sigma.gain, before.sigma.cross_axis)
        );
        assert_eq!(record.calibration.channels[1..], before.calibration.channels[1..]);
    }

    #[test]
    fn a_method_survives_the_wire() {
        for method in CalibrationMethod::ALL {
            assert_eq!(CalibrationMethod::from(method as u8), method);
        }
        assert_eq!(CalibrationMethod::from(99), CalibrationMethod::Other);
    }

    #[test]
    fn gains_drift_and_cross_axis_sensitivities_do_not() {
        let fresh = CalibrationSigma { gain: 0.0, cross_axis: 0.003, hammer_gain: 0.004 };
        assert_eq!(fresh.aged(0), fresh);
        let old = fresh.aged(365);
        // Twelve months, up to a quarter of a day; the rest is rounding in single precision.
        assert!((old.gain / 0.006 - 1.0).abs() < 1e-3, "{old:?}");
        assert!((old.hammer_gain - libm::hypotf(0.004, 0.006)).abs() < 1e-5, "{old:?}");
        assert_eq!(old.cross_axis, fresh.cross_axis);
    }

    #[test]
    fn only_a_test_of_one_s_own_contributes_to_a_budget() {
        let budget_of = |method| CalibrationRecord { method, ..Default::default() }.budget();
        for method in CalibrationMethod::ALL {
            let unknown =
                [CalibrationMethod::DataSheet, CalibrationMethod::Other].contains(&method);
            assert_eq!(budget_of(method).is_none(), unknown, "{method:?}");
        }
    }

    #[test]
    fn a_sigma_that_is_no_number_or_negative_is_not_usable() {
        for bad in [-0.1, f32::NAN, f32::INFINITY] {
            let mut record = CalibrationRecord::default();
            record.sigma.cross_axis = bad;
            assert!(!record.is_usable(), "{bad}");
        }
    }
}

//! The tables of a bench file about sensors, hammer, converter, taps and operator, with the defaults of
//! the default bench.

use std::ops::RangeInclusive;

use massline_shared::signal::Calibration;
use serde::Deserialize;

/// A key and what is wrong with its value, if anything.
pub(super) type SettingProblem = Option<(&'static str, String)>;

/// Allowed standard deviations in m, rad or relative.
const SIGMA: RangeInclusive<f64> = 0.0..=1.0;
/// Allowed standard deviations and outputs at rest, V.
const VOLTS: RangeInclusive<f64> = 0.0..=100.0;
/// Allowed cutoff of a filter, Hz.
const CUTOFF: RangeInclusive<f64> = 0.1..=1e6;
/// Allowed tolerance of a cutoff, relative: parts are sorted at three times this.
const TOLERANCE: RangeInclusive<f64> = 0.0..=0.2;
/// Allowed peak of a force, N.
const FORCE: RangeInclusive<f64> = 1e-3..=1e6;
/// Allowed share of the taps.
const SHARE: RangeInclusive<f64> = 0.0..=1.0;

/// Cutoff of the output filter of the ADXL326, from 32 kΩ and 10 nF, Hz.
const RC_CUTOFF_HZ: f64 = Calibration::RC_CUTOFF.0;

/// `[sensor]`: the triaxial accelerometers, all of one type; errors with a `sigma` are drawn once per
/// test.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default, expecting = "a table [sensor]")]
pub struct SensorSettings {
    /// Error of each coordinate of the position, 1 σ, m.
    pub position_sigma_m: f64,
    /// Rotation about each axis, 1 σ, rad.
    pub rotation_sigma_rad: f64,
    /// Relative gain error that remains after calibration, 1 σ.
    pub gain_sigma: f64,
    /// Sensitivity to each of the two other axes relative to that of the axis itself, 1 σ.
    pub cross_axis_sigma: f64,
    /// Output at rest without gravity, V.
    pub zero_v: f64,
    /// Tolerance of `zero_v`, 1 σ, V.
    pub zero_sigma_v: f64,
    /// Sensitivity, V per standard gravity.
    pub sensitivity_v_per_g: f64,
    /// Range: the output clips at plus and minus this, g.
    pub range_g: f64,
    /// One-sided density of the white noise before the filter, g/√Hz.
    pub noise_g_per_sqrt_hz: f64,
    /// Cutoff of the first-order low-pass, Hz.
    pub rc_cutoff_hz: f64,
    /// Relative tolerance of the cutoff, 1 σ.
    pub rc_tolerance: f64,
}

impl Default for SensorSettings {
    fn default() -> Self {
        Self {
            position_sigma_m: 0.001,
            rotation_sigma_rad: 0.010,
            gain_sigma: 0.005,
            cross_axis_sigma: 0.01,
            zero_v: Calibration::ADXL326_ZERO.0,
            zero_sigma_v: 0.05,
            sensitivity_v_per_g: Calibration::ADXL326_VOLT_PER_G,
            range_g: Calibration::ADXL326_RANGE_G,
            noise_g_per_sqrt_hz: 300e-6,
            rc_cutoff_hz: RC_CUTOFF_HZ,
            rc_tolerance: 0.02,
        }
    }
}

impl SensorSettings {
    pub(super) fn problem(&self) -> SettingProblem {
        out_of_range(&[
            (self.position_sigma_m, "position_sigma_m", SIGMA),
            (self.rotation_sigma_rad, "rotation_sigma_rad", SIGMA),
            (self.gain_sigma, "gain_sigma", SIGMA),
            (self.cross_axis_sigma, "cross_axis_sigma", SIGMA),
            (self.zero_v, "zero_v", VOLTS),
            (self.zero_sigma_v, "zero_sigma_v", VOLTS),
            (self.sensitivity_v_per_g, "sensitivity_v_per_g", 1e-6..=1e3),
            (self.range_g, "range_g", 1e-3..=1e6),
            (self.noise_g_per_sqrt_hz, "noise_g_per_sqrt_hz", SIGMA),
            (self.rc_cutoff_hz, "rc_cutoff_hz", CUTOFF),
            (self.rc_tolerance, "rc_tolerance", TOLERANCE),
        ])
    }
}

/// `[hammer]`: the force transducer and its conditioner.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default, expecting = "a table [hammer]")]
pub struct HammerSettings {
    /// Sensitivity, V/N.
    pub sensitivity_v_per_n: f64,
    /// Relative gain error, 1 σ, drawn once per test. Zero by default: a calibration with a known mass
    /// leaves one error per response, that of its ratio to the hammer.
    pub gain_sigma: f64,
    /// Output at rest, V.
    pub zero_v: f64,
    /// Tolerance of `zero_v`, 1 σ, V.
    pub zero_sigma_v: f64,
    /// One-sided density of the white noise before the filter, N/√Hz.
    pub noise_n_per_sqrt_hz: f64,
    /// Cutoff of the first-order low-pass, Hz.
    pub rc_cutoff_hz: f64,
    /// Relative tolerance of the cutoff, 1 σ.
    pub rc_tolerance: f64,
}

impl Default for HammerSettings {
    fn default() -> Self {
        Self {
            sensitivity_v_per_n: Calibration::HAMMER_VOLT_PER_NEWTON,
            gain_sigma: 0.0,
            zero_v: Calibration::HAMMER_ZERO.0,
            zero_sigma_v: 0.005,
            noise_n_per_sqrt_hz: 0.0005,
            rc_cutoff_hz: RC_CUTOFF_HZ,
            rc_tolerance: 0.02,
        }
    }
}

impl HammerSettings {
    pub(super) fn problem(&self) -> SettingProblem {
        out_of_range(&[
            (self.sensitivity_v_per_n, "sensitivity_v_per_n", 1e-9..=1e3),
            (self.gain_sigma, "gain_sigma", SIGMA),
            (self.zero_v, "zero_v", VOLTS),
            (self.zero_sigma_v, "zero_sigma_v", VOLTS),
            (self.noise_n_per_sqrt_hz, "noise_n_per_sqrt_hz", SIGMA),
            (self.rc_cutoff_hz, "rc_cutoff_hz", CUTOFF),
            (self.rc_tolerance, "rc_tolerance", TOLERANCE),
        ])
    }
}

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
    pub(super) fn problem(&self) -> SettingProblem {
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

/// `[tap]`: the distribution from which each good tap is drawn.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default, expecting = "a table [tap]")]
pub struct TapSettings {
    /// Peak force, from and to, N.
    pub force_n: [f64; 2],
    /// Contact time, from and to, s.
    pub duration_s: [f64; 2],
    /// Error of the point of impact along each axis normal to the direction, 1 σ, m.
    pub point_sigma_m: f64,
    /// Tilt of the hammer about each axis normal to the direction, 1 σ, rad.
    pub direction_sigma_rad: f64,
}

impl Default for TapSettings {
    fn default() -> Self {
        Self {
            force_n: [18.0, 30.0],
            duration_s: [0.004, 0.006],
            point_sigma_m: 0.002,
            direction_sigma_rad: 0.030,
        }
    }
}

impl TapSettings {
    pub(super) fn problem(&self) -> SettingProblem {
        out_of_range(&[
            (self.point_sigma_m, "point_sigma_m", SIGMA),
            (self.direction_sigma_rad, "direction_sigma_rad", SIGMA),
        ])
        .or(range_problem(self.force_n, "force_n", FORCE))
        .or(range_problem(self.duration_s, "duration_s", 1e-5..=1.0))
    }
}

/// `[operator]`: the person with the hammer.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default, expecting = "a table [operator]")]
pub struct OperatorSettings {
    /// Rig time between *armed* and the tap, s.
    pub delay_s: f64,
    /// Rig time between a tap that does not trigger and the next one, s; after ten such taps the operator
    /// waits for the next arming.
    pub patience_s: f64,
    /// Share of the taps that are too weak.
    pub too_weak_rate: f64,
    /// Peak force of these, from and to, N.
    pub too_weak_n: [f64; 2],
    /// Share of the taps that are too hard.
    pub too_hard_rate: f64,
    /// Peak force of these, from and to, N; more than the hammer channel can measure.
    pub too_hard_n: [f64; 2],
    /// Share of the taps that bounce: a second, weaker one follows.
    pub double_rate: f64,
    /// Time between the two, from and to, s.
    pub double_gap_s: [f64; 2],
    /// Share of the taps before which the hammer brushes the object.
    pub grazing_rate: f64,
    /// Share of the taps after which the hammer stays on the object.
    pub sustained_contact_rate: f64,
    /// Share of the taps made with a soft tip: the contact is five times as long.
    pub soft_rate: f64,
    /// Share of the taps that land 80 mm beside the mark.
    pub misplaced_rate: f64,
    /// Tilt of each position of a tumble test about each of two axes, 1 σ, rad.
    pub tilt_sigma_rad: f64,
}

impl Default for OperatorSettings {
    fn default() -> Self {
        Self {
            delay_s: 0.3,
            patience_s: 3.0,
            too_weak_rate: 0.03,
            too_weak_n: [4.5, 6.5],
            too_hard_rate: 0.02,
            too_hard_n: [150.0, 200.0],
            double_rate: 0.0,
            double_gap_s: [0.03, 0.08],
            grazing_rate: 0.0,
            sustained_contact_rate: 0.0,
            soft_rate: 0.0,
            misplaced_rate: 0.0,
            tilt_sigma_rad: 0.003,
        }
    }
}

impl OperatorSettings {
    /// Shares of the bad taps: too weak, too hard, double, grazing, sustained contact, soft, misplaced.
    pub(super) fn rates(&self) -> [f64; 7] {
        [
            self.too_weak_rate,
            self.too_hard_rate,
            self.double_rate,
            self.grazing_rate,
            self.sustained_contact_rate,
            self.soft_rate,
            self.misplaced_rate,
        ]
    }

    pub(super) fn problem(&self) -> SettingProblem {
        let share: f64 = self.rates().into_iter().sum();
        out_of_range(&[
            (self.delay_s, "delay_s", 0.0..=600.0),
            (self.patience_s, "patience_s", 1e-3..=600.0),
            (self.too_weak_rate, "too_weak_rate", SHARE),
            (self.too_hard_rate, "too_hard_rate", SHARE),
            (self.double_rate, "double_rate", SHARE),
            (self.grazing_rate, "grazing_rate", SHARE),
            (self.sustained_contact_rate, "sustained_contact_rate", SHARE),
            (self.soft_rate, "soft_rate", SHARE),
            (self.misplaced_rate, "misplaced_rate", SHARE),
            (self.tilt_sigma_rad, "tilt_sigma_rad", SIGMA),
        ])
        .or(range_problem(self.too_weak_n, "too_weak_n", FORCE))
        .or(range_problem(self.too_hard_n, "too_hard_n", FORCE))
        .or(range_problem(self.double_gap_s, "double_gap_s", 1e-4..=10.0))
        .or((share > 1.0).then(|| ("too_weak_rate", "the rates add up to more than 1".into())))
    }
}

/// The first of these values that lies outside its range.
fn out_of_range(values: &[(f64, &'static str, RangeInclusive<f64>)]) -> SettingProblem {
    let (value, key, range) = values.iter().find(|(value, _, range)| !range.contains(value))?;
    Some((key, refusal(*value, range)))
}

/// The message for a value outside its range.
pub(super) fn refusal(value: f64, range: &RangeInclusive<f64>) -> String {
    let (from, to) = (range.start(), range.end());
    format!("{value:?} is out of range; give a number from {from} to {to}")
}

fn range_problem(
    [low, high]: [f64; 2],
    key: &'static str,
    within: RangeInclusive<f64>,
) -> SettingProblem {
    let good = low <= high && within.contains(&low) && within.contains(&high);
    (!good).then(|| {
        let (from, to) = (within.start(), within.end());
        (key, format!("[{low:?}, {high:?}] must be [from, to] with {from} <= from <= to <= {to}"))
    })
}

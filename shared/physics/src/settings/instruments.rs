//! `[sensor]` and `[hammer]`.

use std::ops::RangeInclusive;

use massline_shared::signal::Calibration;
use serde::Deserialize;

use super::{
    BOARD_MASS, CORRELATION, CUTOFF, SIGMA, SettingProblem, TOLERANCE, VOLTS, out_of_range,
};

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
    /// Cutoff of the first-order low-pass that the data sheets state, Hz.
    pub rc_cutoff_hz: f64,
    /// Relative tolerance of the cutoff, 1 σ.
    pub rc_tolerance: f64,
    /// Largest relative error of the cutoff that is drawn evenly, in addition to the tolerance.
    pub rc_within: f64,
    /// Cutoffs of the x, y and z axes that act in place of `rc_cutoff_hz`, Hz: for example the sensor's
    /// own bandwidth when the capacitors are missing. A calibration from the data sheets does not know
    /// them.
    pub bandwidth_hz: Option<[f64; 3]>,
    /// Mass of each sensor board, kg. It moves with the object at the sensor's position, although neither
    /// the layout nor [`Bench::truth`](crate::Bench::truth) includes it.
    pub board_mass_kg: f64,
    /// Linear drift of every output since arming, V/s.
    pub drift_v_per_s: f64,
    /// Frequency at which the 1/f noise has the density of the white noise, Hz; zero is no 1/f noise. Its
    /// density falls with the root of the frequency, from 0.02 Hz to 50 Hz.
    pub noise_corner_hz: f64,
    /// Slow wander of every output, as with the temperature, rms, V; it is independent in each output.
    pub wander_v: f64,
    /// Time over which the wander forgets its value: its correlation falls to 1/e, s.
    pub wander_s: f64,
}

/// Allowed drift, V/s.
const DRIFT: RangeInclusive<f64> = -10.0..=10.0;
/// Allowed corner of the 1/f noise, Hz.
const NOISE_CORNER: RangeInclusive<f64> = 0.0..=100.0;
/// Allowed wander, V.
const WANDER: RangeInclusive<f64> = 0.0..=10.0;

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
            rc_within: 0.0,
            bandwidth_hz: None,
            board_mass_kg: 0.0,
            drift_v_per_s: 0.0,
            noise_corner_hz: 0.0,
            wander_v: 0.0,
            wander_s: 300.0,
        }
    }
}

impl SensorSettings {
    pub(crate) fn problem(&self) -> SettingProblem {
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
            (self.rc_within, "rc_within", WITHIN),
            (self.board_mass_kg, "board_mass_kg", BOARD_MASS),
            (self.drift_v_per_s, "drift_v_per_s", DRIFT),
            (self.noise_corner_hz, "noise_corner_hz", NOISE_CORNER),
            (self.wander_v, "wander_v", WANDER),
            (self.wander_s, "wander_s", CORRELATION),
        ])
        .or_else(|| out_of_range(&self.bandwidth_hz?.map(|hz| (hz, "bandwidth_hz", CUTOFF))))
    }
}

/// Allowed even errors of a cutoff, relative.
const WITHIN: RangeInclusive<f64> = 0.0..=0.9;
/// Allowed relative errors of every test.
const FIXED_ERROR: RangeInclusive<f64> = -0.9..=9.0;

/// `[hammer]`: the force transducer and its conditioner.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default, expecting = "a table [hammer]")]
pub struct HammerSettings {
    /// Sensitivity, V/N.
    pub sensitivity_v_per_n: f64,
    /// Relative gain error, 1 σ, drawn once per test. Zero by default: a calibration with a known mass
    /// leaves one error per response, that of its ratio to the hammer.
    pub gain_sigma: f64,
    /// Relative gain error that every test has, in addition to the drawn one.
    pub gain_error: f64,
    /// Relative error of the gain at each DOF against the others, 1 σ, drawn once for each DOF: an amplifier that is not
    /// linear, an unlike grip.
    pub hit_gain_sigma: f64,
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
    /// Largest relative error of the cutoff that is drawn evenly, in addition to the tolerance.
    pub rc_within: f64,
    /// Relative error of the cutoff that every test has, in addition to the drawn one.
    pub rc_error: f64,
}

impl Default for HammerSettings {
    fn default() -> Self {
        Self {
            sensitivity_v_per_n: Calibration::HAMMER_VOLT_PER_NEWTON,
            gain_sigma: 0.0,
            gain_error: 0.0,
            hit_gain_sigma: 0.0,
            zero_v: Calibration::HAMMER_ZERO.0,
            zero_sigma_v: 0.005,
            noise_n_per_sqrt_hz: 0.0005,
            rc_cutoff_hz: RC_CUTOFF_HZ,
            rc_tolerance: 0.02,
            rc_within: 0.0,
            rc_error: 0.0,
        }
    }
}

impl HammerSettings {
    pub(crate) fn problem(&self) -> SettingProblem {
        out_of_range(&[
            (self.sensitivity_v_per_n, "sensitivity_v_per_n", 1e-9..=1e3),
            (self.gain_sigma, "gain_sigma", SIGMA),
            (self.gain_error, "gain_error", FIXED_ERROR),
            (self.hit_gain_sigma, "hit_gain_sigma", SIGMA),
            (self.zero_v, "zero_v", VOLTS),
            (self.zero_sigma_v, "zero_sigma_v", VOLTS),
            (self.noise_n_per_sqrt_hz, "noise_n_per_sqrt_hz", SIGMA),
            (self.rc_cutoff_hz, "rc_cutoff_hz", CUTOFF),
            (self.rc_tolerance, "rc_tolerance", TOLERANCE),
            (self.rc_within, "rc_within", WITHIN),
            (self.rc_error, "rc_error", FIXED_ERROR),
        ])
    }
}

//! `[sensor]` and `[hammer]`.

use massline_shared::signal::Calibration;

use super::{BOARD_MASS, CORRELATION, CUTOFF, SIGMA, TOLERANCE, VOLTS};

/// Cutoff of the output filter of the ADXL326, from 32 kΩ and 10 nF, Hz.
const RC_CUTOFF_HZ: f64 = Calibration::RC_CUTOFF.0;

settings! {
    /// `[sensor]`: the triaxial accelerometers, all of one type; errors with a `sigma` are drawn once per
    /// test.
    SensorSettings, "a table [sensor]" {
        /// Error of each coordinate of the position, 1 σ, m.
        position_sigma_m: f64 = 0.001, SIGMA;
        /// Rotation about each axis, 1 σ, rad.
        rotation_sigma_rad: f64 = 0.010, SIGMA;
        /// Relative gain error that remains after calibration, 1 σ.
        gain_sigma: f64 = 0.005, SIGMA;
        /// Sensitivity to each of the two other axes relative to that of the axis itself, 1 σ.
        cross_axis_sigma: f64 = 0.01, SIGMA;
        /// Output at rest without gravity, V.
        zero_v: f64 = Calibration::ADXL326_ZERO.0, VOLTS;
        /// Tolerance of `zero_v`, 1 σ, V.
        zero_sigma_v: f64 = 0.05, VOLTS;
        /// Sensitivity, V per standard gravity.
        sensitivity_v_per_g: f64 = Calibration::ADXL326_VOLT_PER_G, 1e-6..=1e3;
        /// Range: the output clips at plus and minus this, g.
        range_g: f64 = Calibration::ADXL326_RANGE_G, 1e-3..=1e6;
        /// One-sided density of the white noise before the filter, g/√Hz.
        noise_g_per_sqrt_hz: f64 = 300e-6, SIGMA;
        /// Cutoff of the first-order low-pass that the data sheets state, Hz.
        rc_cutoff_hz: f64 = RC_CUTOFF_HZ, CUTOFF;
        /// Relative tolerance of the cutoff, 1 σ.
        rc_tolerance: f64 = 0.02, TOLERANCE;
        /// Largest relative error of the cutoff that is drawn evenly, in addition to the tolerance.
        rc_within: f64 = 0.0, 0.0..=0.9;
        /// Cutoffs of the x, y and z axes that act in place of `rc_cutoff_hz`, Hz: for example the sensor's
        /// own bandwidth when the capacitors are missing. A calibration from the data sheets does not know
        /// them.
        bandwidth_hz: Option<[f64; 3]> = None, CUTOFF;
        /// Mass of each sensor board, kg. It moves with the object at the sensor's position, although neither
        /// the layout nor [`Bench::truth`](crate::Bench::truth) includes it.
        board_mass_kg: f64 = 0.0, BOARD_MASS;
        /// Linear drift of every output since arming, V/s.
        drift_v_per_s: f64 = 0.0, -10.0..=10.0;
        /// Frequency at which the 1/f noise has the density of the white noise, Hz; zero is no 1/f noise. Its
        /// density falls with the root of the frequency, from 0.02 Hz to 50 Hz.
        noise_corner_hz: f64 = 0.0, 0.0..=100.0;
        /// Slow wander of every output, as with the temperature, rms, V; it is independent in each output.
        wander_v: f64 = 0.0, 0.0..=10.0;
        /// Time over which the wander forgets its value: its correlation falls to 1/e, s.
        wander_s: f64 = 300.0, CORRELATION;
    }
}

settings! {
    /// `[hammer]`: the force transducer and its conditioner.
    HammerSettings, "a table [hammer]" {
        /// Sensitivity, V/N.
        sensitivity_v_per_n: f64 = Calibration::HAMMER_VOLT_PER_NEWTON, 1e-9..=1e3;
        /// Relative gain error, 1 σ, drawn once per test. Zero by default: a calibration with a known mass
        /// leaves one error per response, that of its ratio to the hammer.
        gain_sigma: f64 = 0.0, SIGMA;
        /// Relative gain error that every test has, in addition to the drawn one.
        gain_error: f64 = 0.0, -0.9..=9.0;
        /// Relative error of the gain at each DOF against the others, 1 σ, drawn once for each DOF: an amplifier that
        /// is not linear, an unlike grip.
        hit_gain_sigma: f64 = 0.0, SIGMA;
        /// Output at rest, V.
        zero_v: f64 = Calibration::HAMMER_ZERO.0, VOLTS;
        /// Tolerance of `zero_v`, 1 σ, V.
        zero_sigma_v: f64 = 0.005, VOLTS;
        /// One-sided density of the white noise before the filter, N/√Hz.
        noise_n_per_sqrt_hz: f64 = 0.0005, SIGMA;
        /// Cutoff of the first-order low-pass, Hz.
        rc_cutoff_hz: f64 = RC_CUTOFF_HZ, CUTOFF;
        /// Relative tolerance of the cutoff, 1 σ.
        rc_tolerance: f64 = 0.02, TOLERANCE;
        /// Largest relative error of the cutoff that is drawn evenly, in addition to the tolerance.
        rc_within: f64 = 0.0, 0.0..=0.9;
        /// Relative error of the cutoff that every test has, in addition to the drawn one.
        rc_error: f64 = 0.0, -0.9..=9.0;
    }
}

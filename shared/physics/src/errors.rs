//! Errors that stay constant over one test, drawn once from the seed.

use massline_shared::signal::CHANNELS;
use nalgebra::{Matrix3, Rotation3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::error_sizes::ErrorSizes;
use super::suspension::Suspension;
use crate::bench::Bench;

/// Errors of one triaxial sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorErrors {
    /// True minus nominal position, body frame, m.
    pub position: Vector3<f64>,
    /// Rotation vector from the nominal to the true sensor axes, in sensor axes, rad.
    pub rotation: Vector3<f64>,
    /// Maps the ideal reading to the true one: gain errors on the diagonal, cross-axis sensitivity off
    /// it.
    pub sensitivity: Matrix3<f64>,
}

/// Errors that stay constant over one test.
#[derive(Clone, Debug, PartialEq)]
pub struct TestErrors {
    /// Errors of each sensor.
    pub sensors: Vec<SensorErrors>,
    /// Relative error of the hammer's gain, drawn and fixed part together.
    pub hammer_gain: f64,
    /// Output at rest of each channel minus the nominal one, V.
    pub zero_v: [f64; CHANNELS],
    /// Relative error of the cutoff of each channel's filter, drawn and fixed part together.
    pub rc: [f64; CHANNELS],
    /// Phase of the converter's integral nonlinearity at code zero, rad.
    pub inl_phase: f64,
    /// Determines the widths of the converter's codes.
    pub dnl_seed: u64,
    /// Rotation vector from the gravity of the bench to the true one, before its part along gravity is taken out, rad.
    pub gravity_turn: Vector3<f64>,
    /// Axis about which all hits are turned where they are, a unit vector in the body frame.
    pub hits_axis: Vector3<f64>,
}

impl TestErrors {
    /// Draws the errors of a test.
    ///
    /// The same random numbers are drawn whatever the standard deviations, so that two benches that
    /// differ in one of them differ in nothing else.
    pub(super) fn draw(bench: &Bench, sizes: &ErrorSizes, rng: &mut ChaCha8Rng) -> Self {
        let (sensor, hammer) = (&bench.sensor, &bench.hammer);
        let mut zero_v = [0.0; CHANNELS];
        let mut rc = [0.0; CHANNELS];
        let hammer_gain = normal(rng) * sizes.apparatus.hammer_gain + hammer.gain_error;
        zero_v[0] = normal(rng) * hammer.zero_sigma_v;
        rc[0] = tolerance(rng, hammer.rc_tolerance) + hammer.rc_error;
        for (zero, cutoff) in zero_v.iter_mut().zip(&mut rc).skip(1) {
            *zero = normal(rng) * sensor.zero_sigma_v;
            *cutoff = tolerance(rng, sensor.rc_tolerance);
        }
        let sensors: Vec<_> = sizes
            .sensors
            .iter()
            .map(|sigmas| SensorErrors {
                position: normal_vector(rng) * sigmas.position,
                rotation: normal_vector(rng) * sigmas.rotation,
                sensitivity: Matrix3::from_fn(|row, column| {
                    let sigma = if row == column { sigmas.gain } else { sigmas.cross_axis };
                    f64::from(u8::from(row == column)) + normal(rng) * sigma
                }),
            })
            .collect();
        let inl_phase = std::f64::consts::TAU * rng.random::<f64>();
        for (k, cutoff) in rc.iter_mut().enumerate() {
            let within = if k == 0 { hammer.rc_within } else { sensor.rc_within };
            *cutoff += within * (2.0 * rng.random::<f64>() - 1.0);
        }
        let dnl_seed = rng.random();
        let gravity_turn = normal_vector(rng) * sizes.apparatus.gravity_direction;
        let hits_axis = normal_vector(rng).normalize();
        Self { sensors, hammer_gain, zero_v, rc, inl_phase, dnl_seed, gravity_turn, hits_axis }
    }
}

impl TestErrors {
    /// Draws the position and rotation errors again, as when the same sensors are glued on again.
    pub(super) fn mount_again(&mut self, sizes: &ErrorSizes, rng: &mut ChaCha8Rng) {
        for (sensor, sigmas) in self.sensors.iter_mut().zip(&sizes.sensors) {
            sensor.position = normal_vector(rng) * sigmas.position;
            sensor.rotation = normal_vector(rng) * sigmas.rotation;
        }
    }

    /// The bench with the object as it really hangs: gravity and the cords that carry it are tilted in its frame.
    pub(super) fn hung(&self, bench: &Bench) -> Bench {
        let mut bench = bench.clone();
        let tilted = bench.gravity + self.gravity_turn.cross(&bench.gravity);
        let Some(turn) = Rotation3::rotation_between(&bench.gravity, &tilted) else { return bench };
        if tilted == bench.gravity {
            return bench;
        }
        bench.gravity = tilted.normalize() * bench.gravity.norm();
        if let Suspension::Cords { cords, .. } = &mut bench.suspension {
            for cord in cords {
                cord.direction = (turn * Vector3::from(cord.direction)).into();
            }
        }
        bench
    }
}

/// A standard normal random number.
pub(super) fn normal(rng: &mut ChaCha8Rng) -> f64 {
    rng.sample(StandardNormal)
}

pub(super) fn normal_vector(rng: &mut ChaCha8Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| normal(rng))
}

/// Parts are sorted: none beyond three standard deviations is used.
fn tolerance(rng: &mut ChaCha8Rng, sigma: f64) -> f64 {
    normal(rng).clamp(-3.0, 3.0) * sigma
}

//! From a tap to the codes of one scan after another, for one layout with one test's errors.

use massline_shared::layout::{HostLayout, Sensor};
use massline_shared::signal::{CHANNELS, RESPONSES, Scan};
use nalgebra::{Matrix3, Rotation3, Vector3};
use rand_chacha::ChaCha8Rng;

use super::chain::{Chain, Channels};
use super::dynamics::{Oscillators, PointShape, check_node, point_shapes};
use super::errors::{SensorErrors, TestErrors};
use super::suspension::{RigidMode, rigid_modes};
use super::taps::Tap;
use super::{Bench, BenchError};

/// The object with its sensors, its chains and the state of all of them.
#[derive(Clone, Debug)]
pub(super) struct Simulation {
    rigid: [RigidMode; 6],
    oscillators: Oscillators,
    chain: Chain,
    /// Reading of every channel per unit of each mode's acceleration.
    per_acceleration: Vec<Channels>,
    /// Reading of every channel per unit of each mode's displacement: rotation in the field of gravity.
    per_displacement: Vec<Channels>,
    at_rest: Channels,
    hammer_gain: f64,
    /// Interval of the grid, s.
    h: f64,
    steps_per_scan: usize,
    /// True from the first touch on.
    moving: bool,
    /// Scans since the last reset.
    scans: u64,
    forces: Vec<f64>,
    next_forces: Vec<f64>,
}

/// A tap and how much it drives every mode.
#[derive(Clone, Debug)]
pub(super) struct Drive {
    pub(super) tap: Tap,
    participation: Vec<f64>,
}

impl Simulation {
    pub(super) fn new(
        bench: &Bench,
        layout: &HostLayout,
        errors: &TestErrors,
    ) -> Result<Self, BenchError> {
        if layout.sensors.len() * 3 > RESPONSES {
            return Err(BenchError::TooManySensors(layout.sensors.len()));
        }
        let rigid = rigid_modes(&bench.body, &bench.suspension, &bench.gravity)?;
        let h = (bench.adc.rate_hz * f64::from(bench.adc.oversampling)).recip();
        let elastic =
            bench.elastic.iter().map(|m| (m.frequency_hz * std::f64::consts::TAU, m.damping_ratio));
        let all = rigid.iter().map(|m| (m.omega, m.damping_ratio)).chain(elastic);
        let modes = rigid.len() + bench.elastic.len();
        let mut simulation = Self {
            rigid,
            oscillators: Oscillators::new(all, h),
            chain: Chain::new(bench, errors),
            per_acceleration: vec![[0.0; CHANNELS]; modes],
            per_displacement: vec![[0.0; CHANNELS]; modes],
            at_rest: [0.0; CHANNELS],
            hammer_gain: 1.0 + errors.hammer_gain,
            h,
            steps_per_scan: usize::from(bench.adc.oversampling),
            moving: false,
            scans: 0,
            forces: vec![0.0; modes],
            next_forces: vec![0.0; modes],
        };
        for (i, (sensor, error)) in layout.sensors.iter().zip(&errors.sensors).enumerate() {
            simulation.attach(bench, 1 + 3 * i, sensor, error)?;
        }
        Ok(simulation)
    }

    /// Puts a sensor on the object, its x axis on `channel`.
    ///
    /// The reading is `Rᵀ (a − [g]× θ)` beside the constant `−Rᵀ g` (theory, section 2).
    fn attach(
        &mut self,
        bench: &Bench,
        channel: usize,
        sensor: &Sensor<f64>,
        error: &SensorErrors,
    ) -> Result<(), BenchError> {
        let nominal = Matrix3::from_fn(|row, column| sensor.axes[row][column]);
        let reads = error.sensitivity * Rotation3::new(-error.rotation).matrix() * nominal;
        let gravity = if sensor.senses_gravity { bench.gravity } else { Vector3::zeros() };
        check_node(bench, sensor.node, sensor.position)?;
        let point = Vector3::from(sensor.position) + error.position;
        let shapes = point_shapes(bench, &self.rigid, sensor.node, &point)?;
        let put = |channels: &mut Channels, reading: Vector3<f64>| {
            channels[channel..channel + 3].copy_from_slice(reading.as_slice());
        };
        put(&mut self.at_rest, reads * -gravity);
        for (i, shape) in shapes.iter().enumerate() {
            put(&mut self.per_acceleration[i], reads * shape.translation);
            put(&mut self.per_displacement[i], reads * shape.rotation.cross(&gravity));
        }
        Ok(())
    }

    /// A tap, ready to act on the object at a node.
    pub(super) fn drive(&self, bench: &Bench, node: u16, tap: Tap) -> Result<Drive, BenchError> {
        let along = |s: &PointShape| s.translation.dot(&tap.direction);
        let shapes = point_shapes(bench, &self.rigid, node, &tap.point)?;
        let participation = shapes.iter().map(along).collect();
        Ok(Drive { tap, participation })
    }

    /// Steadies the object; time begins again at zero.
    pub(super) fn reset(&mut self, rng: &mut ChaCha8Rng) {
        self.oscillators.stop();
        self.forces.fill(0.0);
        self.chain.settle(&self.at_rest, rng);
        self.moving = false;
        self.scans = 0;
    }

    /// Time of the next scan, s.
    pub(super) fn time(&self) -> f64 {
        self.grid_time(0)
    }

    /// The codes of the next scan. `drives` are the taps that are not over; before the first, nothing
    /// moves.
    pub(super) fn scan(&mut self, drives: &[Drive], rng: &mut ChaCha8Rng) -> Scan {
        let sampled = self.scan_inputs(drives);
        self.chain.convert(&sampled, rng)
    }

    /// What the low-passes put out at the next scan, N and m/s², without noise and converter.
    pub(super) fn scan_inputs(&mut self, drives: &[Drive]) -> Channels {
        let end = self.grid_time(self.steps_per_scan);
        self.moving |= drives.iter().any(|d| d.tap.start() < end);
        let mut sampled = self.chain.at_rest();
        if self.moving {
            for step in 0..self.steps_per_scan {
                let input = self.step(drives, self.grid_time(step + 1));
                self.chain.advance(step, &input, &mut sampled);
            }
        }
        self.scans += 1;
        sampled
    }

    fn grid_time(&self, step: usize) -> f64 {
        (self.scans as f64 * self.steps_per_scan as f64 + step as f64) * self.h
    }

    /// Advances the object to `time`; the readings there.
    fn step(&mut self, drives: &[Drive], time: f64) -> Channels {
        let mut total = 0.0;
        self.next_forces.fill(0.0);
        for drive in drives {
            let force = drive.tap.force(time);
            if force > 0.0 {
                total += force;
                for (f, p) in self.next_forces.iter_mut().zip(&drive.participation) {
                    *f += force * p;
                }
            }
        }
        self.oscillators.advance(&self.forces, &self.next_forces);
        std::mem::swap(&mut self.forces, &mut self.next_forces);
        let mut reading = self.at_rest;
        reading[0] = total * self.hammer_gain;
        let motion = self.oscillators.motion(&self.forces);
        for (([q, _, a], per_q), per_a) in
            motion.zip(&self.per_displacement).zip(&self.per_acceleration)
        {
            for k in 1..CHANNELS {
                reading[k] += per_a[k] * a + per_q[k] * q;
            }
        }
        reading
    }
}

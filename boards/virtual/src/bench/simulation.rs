//! Computes the codes of each scan of a tap, for one layout with one test's errors.

use massline_shared::layout::{HostLayout, Sensor};
use massline_shared::signal::{CHANNELS, RESPONSES, Scan};
use nalgebra::{Matrix3, Rotation3, Vector3};
use rand_chacha::ChaCha8Rng;

use super::chain::{Chain, ChainState, Channels};
use super::dynamics::{Oscillators, PointShape, check_node, point_shapes};
use super::errors::{SensorErrors, TestErrors};
use super::faults::{self, Mounting};
use super::free_response::{FreeResponse, Scanned};
use super::suspension::{RigidMode, rigid_modes};
use super::taps::Tap;
use super::{Bench, BenchError};

/// The object with its sensors and their chains, and the state of all of them.
#[derive(Clone, Debug)]
pub(super) struct Simulation {
    rigid: [RigidMode; 6],
    oscillators: Oscillators,
    chain: Chain,
    /// Reading of every channel per unit of each mode's acceleration.
    per_acceleration: Vec<Channels>,
    /// Reading of every channel per unit of each mode's displacement: from rotation in the gravity field.
    per_displacement: Vec<Channels>,
    at_rest: Channels,
    hammer_gain: f64,
    /// Interval of the grid, s.
    h: f64,
    steps_per_scan: usize,
    /// True from the first contact on.
    moving: bool,
    /// Scans since the last reset.
    scans: u64,
    forces: Vec<f64>,
    next_forces: Vec<f64>,
    /// The factors that compute a whole scan of free motion at once.
    free_response: Option<FreeResponse>,
}

/// A tap and its excitation of every mode.
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
            free_response: None,
        };
        for (i, (sensor, error)) in layout.sensors.iter().zip(&errors.sensors).enumerate() {
            simulation.attach(bench, &faults::mounting(bench, i), sensor, error)?;
        }
        simulation.free_response = Some(simulation.free_motion());
        Ok(simulation)
    }

    /// Puts a sensor on the object and connects it.
    ///
    /// The reading is `Rᵀ (a − [g]× θ)` in addition to the constant `−Rᵀ g` (theory, section 2).
    fn attach(
        &mut self,
        bench: &Bench,
        mounting: &Mounting,
        sensor: &Sensor<f64>,
        error: &SensorErrors,
    ) -> Result<(), BenchError> {
        let nominal = Matrix3::from_fn(|row, column| sensor.axes[row][column]);
        let axes = Rotation3::new(-error.rotation).matrix() * mounting.turn * nominal;
        let reads = mounting.wires * error.sensitivity * axes;
        let channel = 1 + 3 * mounting.plug;
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

    /// Prepares a tap that acts on the object at a node.
    pub(super) fn drive(&self, bench: &Bench, node: u16, tap: Tap) -> Result<Drive, BenchError> {
        let along = |s: &PointShape| s.translation.dot(&tap.direction);
        let shapes = point_shapes(bench, &self.rigid, node, &tap.point)?;
        let participation = shapes.iter().map(along).collect();
        Ok(Drive { tap, participation })
    }

    /// Brings the object to rest and sets the time to zero.
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

    /// The codes of the next scan. `drives` are the taps that are not over; nothing moves before the
    /// first.
    pub(super) fn scan(&mut self, drives: &[Drive], rng: &mut ChaCha8Rng) -> Scan {
        let sampled = self.scan_inputs(drives);
        self.chain.convert(&sampled, rng)
    }

    /// The outputs of the low-passes at the next scan, N and m/s², without noise and conversion.
    pub(super) fn scan_inputs(&mut self, drives: &[Drive]) -> Channels {
        let end = self.grid_time(self.steps_per_scan);
        self.moving |= drives.iter().any(|d| d.tap.start() < end);
        let mut sampled = self.chain.at_rest();
        let free = drives.iter().all(|d| d.tap.start() >= end || d.tap.end() < self.time())
            && self.forces.iter().all(|f| *f == 0.0);
        let mut held = self.chain.held();
        let certain = free && FreeResponse::admits(&held, self.chain.range());
        if let Some(free_response) = self.free_response.as_ref().filter(|_| self.moving && certain)
        {
            sampled = free_response.scan(self.oscillators.states_mut(), &mut held);
            self.chain.hold(&held);
        } else if self.moving {
            for step in 0..self.steps_per_scan {
                let input = self.step(drives, self.grid_time(step + 1));
                self.chain.advance(step, &input, &mut sampled);
            }
        }
        self.scans += 1;
        sampled
    }

    /// The factors of a scan of free motion.
    fn free_motion(&self) -> FreeResponse {
        let unlimited = Self { chain: self.chain.without_limits(), ..self.clone() };
        let still = vec![[0.0; 2]; self.oscillators.states().len()];
        // At rest the input is the sensors' reading of gravity.
        let rest = unlimited.clone().free_scan(&still, [0.0; CHANNELS]);
        let bare = Self { at_rest: [0.0; CHANNELS], ..unlimited };
        FreeResponse::of(still.len(), &rest, |states, output| {
            bare.clone().free_scan(states, output)
        })
    }

    /// One scan without a force, computed step by step from a state and the outputs of the low-passes.
    fn free_scan(mut self, states: &[[f64; 2]], output: Channels) -> Scanned {
        self.oscillators.states_mut().copy_from_slice(states);
        self.forces.fill(0.0);
        self.chain.hold(&ChainState { input: self.reading(0.0), output });
        let mut sampled = [0.0; CHANNELS];
        for step in 0..self.steps_per_scan {
            let input = self.step(&[], self.grid_time(step + 1));
            self.chain.advance(step, &input, &mut sampled);
        }
        let states = self.oscillators.states().to_vec();
        Scanned { sampled, held: self.chain.held(), states }
    }

    fn grid_time(&self, step: usize) -> f64 {
        (self.scans as f64 * self.steps_per_scan as f64 + step as f64) * self.h
    }

    /// Advances the object to `time` and returns the readings there.
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
        self.reading(total)
    }

    /// The readings of hammer and sensors for a force, N, and the present motion.
    fn reading(&self, force: f64) -> Channels {
        let mut reading = self.at_rest;
        reading[0] = force * self.hammer_gain;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::taps::{Contact, TapKind};
    use crate::bench::tests::test_one;
    use nalgebra::Vector3;
    use rand::SeedableRng;

    #[test]
    fn the_free_response_in_closed_form_is_that_of_the_steps() {
        let bench = Bench::named("default").unwrap();
        let layout = test_one();
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let errors = TestErrors::draw(&bench, 3, &mut rng);
        let mut free_response = Simulation::new(&bench, &layout, &errors).unwrap();
        free_response.reset(&mut rng);
        let mut stepping = Simulation { free_response: None, ..free_response.clone() };
        let contact = Contact { start: 0.01, duration: 0.003, peak: 25.0 };
        let tap = Tap {
            dof: 0,
            kind: TapKind::Good,
            point: Vector3::zeros(),
            direction: Vector3::y(),
            contacts: vec![contact],
        };
        let drives = [free_response.drive(&bench, 1, tap).unwrap()];
        let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
        for _ in 0..2048 {
            let (a, b) = (free_response.scan_inputs(&drives), stepping.scan_inputs(&drives));
            for (a, b) in a.iter().zip(b) {
                worst = worst.max((a - b).abs());
                largest = largest.max(b.abs());
            }
        }
        // Rounding over 2048 scans.
        assert!(largest > 20.0 && worst < 1e-10 * largest, "{worst} of {largest}");
    }
}

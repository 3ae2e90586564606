//! Computes the codes of each scan of a tap, for one layout with one test's errors.

use massline_shared::layout::{HostLayout, Sensor};
use massline_shared::signal::{CHANNELS, RESPONSES, Scan};
use nalgebra::{Matrix3, Rotation3, Vector3};
use rand_chacha::ChaCha8Rng;

use super::chain::{Chain, ChainState};
use super::channels::{Channels, Sampled, UNLIMITED};
use super::dynamics::{Oscillators, PointShape, check_node, point_shapes};
use super::errors::{SensorErrors, TestErrors};
use super::faults::{self, Mounting};
use super::free_response::{FreeResponse, Scanned};
use super::loads::loaded_modes;
use super::suspension::RigidMode;
use super::taps::{Tap, TapKind};
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
    /// A response channel that ends at this distance from its value at rest, m/s², from the first
    /// contact until another tap follows.
    flat: Option<(usize, f64)>,
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
        let rigid = loaded_modes(bench, layout, errors)?;
        let h = (bench.adc.rate_hz * f64::from(bench.adc.oversampling)).recip()
            * bench.adc.clock_stretch();
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
            hammer_gain: (1.0 + errors.hammer_gain) * faults::hammer_scale(bench),
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
        simulation.free_response = Some(simulation.free_motion(bench.adc.jitter_s > 0.0));
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
        let force = tap.direction + tap.tip.lateral;
        let along = |s: &PointShape| s.translation.dot(&force) + s.rotation.dot(&tap.tip.moment_m);
        let shapes = point_shapes(bench, &self.rigid, node, &tap.point)?;
        let participation: Vec<f64> = shapes.iter().map(along).collect();
        let flat = (tap.kind == TapKind::Flat).then(|| {
            let (channel, accelerance) = self.strongest(&participation);
            (channel, bench.operator.flat_level * accelerance * tap.peak())
        });
        Ok(Drive { tap, participation, flat })
    }

    /// The response channel of the largest rigid-body accelerance to a tap, and its magnitude,
    /// (m/s²)/N.
    fn strongest(&self, participation: &[f64]) -> (usize, f64) {
        let accelerance = |k: usize| {
            let modes = self.per_acceleration.iter().zip(participation).take(self.rigid.len());
            modes.map(|(per_acceleration, p)| per_acceleration[k] * p).sum::<f64>().abs()
        };
        (1..CHANNELS)
            .map(|k| (k, accelerance(k)))
            .fold((1, 0.0), |best, next| if next.1 > best.1 { next } else { best })
    }

    /// Brings the object to rest and sets the time to zero; see [`Chain::settle`].
    pub(super) fn reset(&mut self, noise: &mut ChaCha8Rng, disturbances: ChaCha8Rng) {
        self.oscillators.stop();
        self.forces.fill(0.0);
        self.chain.settle(&self.at_rest, noise, disturbances);
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
        self.chain.convert(&sampled, &self.limits(drives), rng)
    }

    /// How far each channel moves from its value at rest during taps that have begun.
    fn limits(&self, drives: &[Drive]) -> Channels {
        let mut limits = UNLIMITED;
        for drive in drives.iter().filter(|drive| drive.tap.start() < self.time()) {
            if let Some((channel, limit)) = drive.flat {
                limits[channel] = limits[channel].min(limit);
            }
        }
        limits
    }

    /// The outputs of the low-passes at the next scan, without noise and conversion.
    pub(super) fn scan_inputs(&mut self, drives: &[Drive]) -> Sampled {
        let end = self.grid_time(self.steps_per_scan);
        self.moving |= drives.iter().any(|d| d.tap.start() < end);
        let mut sampled = self.chain.at_rest();
        let free = drives.iter().all(|d| d.tap.start() >= end || d.tap.end() < self.time())
            && self.forces.iter().all(|f| *f == 0.0);
        let mut held = self.chain.held();
        let certain = free && FreeResponse::admits(&held, &self.chain.linear_range());
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
    fn free_motion(&self, with_slopes: bool) -> FreeResponse {
        let unlimited = Self { chain: self.chain.without_limits(), ..self.clone() };
        let still = vec![[0.0; 2]; self.oscillators.states().len()];
        // At rest the input is the sensors' reading of gravity.
        let rest = unlimited.clone().free_scan(&still, [0.0; CHANNELS]);
        let bare = Self { at_rest: [0.0; CHANNELS], ..unlimited };
        FreeResponse::of(still.len(), with_slopes, &rest, |states, output| {
            bare.clone().free_scan(states, output)
        })
    }

    /// One scan without a force, computed step by step from a state and the outputs of the low-passes.
    fn free_scan(mut self, states: &[[f64; 2]], output: Channels) -> Scanned {
        self.oscillators.states_mut().copy_from_slice(states);
        self.forces.fill(0.0);
        self.chain.hold(&ChainState { input: self.reading(0.0), output });
        let mut sampled = self.chain.at_rest();
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
    use crate::bench::habit::Tip;
    use crate::bench::taps::Contact;
    use crate::bench::tests::test_one;
    use nalgebra::Vector3;
    use rand::SeedableRng;

    #[test]
    fn the_free_response_in_closed_form_is_that_of_the_steps() {
        let mut bench = Bench::named("default").unwrap();
        // Jitter asks for the slopes as well.
        bench.adc.jitter_s = 1e-6;
        let layout = test_one();
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let errors = TestErrors::draw(&bench, 3, &mut rng);
        let mut free_response = Simulation::new(&bench, &layout, &errors).unwrap();
        free_response.reset(&mut rng, ChaCha8Rng::seed_from_u64(6));
        let mut stepping = Simulation { free_response: None, ..free_response.clone() };
        let contact = Contact { start: 0.01, duration: 0.003, peak: 25.0 };
        let tap = Tap {
            dof: 0,
            kind: TapKind::Good,
            point: Vector3::zeros(),
            direction: Vector3::y(),
            tip: Tip::default(),
            contacts: vec![contact],
        };
        let drives = [free_response.drive(&bench, 1, tap).unwrap()];
        let [mut values, mut slopes] = [[0.0_f64; 2]; 2];
        let compare = |[worst, largest]: &mut [f64; 2], a: &Channels, b: &Channels| {
            for (a, b) in a.iter().zip(b) {
                *worst = worst.max((a - b).abs());
                *largest = largest.max(b.abs());
            }
        };
        for _ in 0..2048 {
            let (a, b) = (free_response.scan_inputs(&drives), stepping.scan_inputs(&drives));
            compare(&mut values, &a.value, &b.value);
            compare(&mut slopes, &a.slope, &b.slope);
        }
        // Rounding over 2048 scans.
        let within = |[worst, largest]: [f64; 2]| worst < 1e-10 * largest;
        assert!(values[1] > 20.0 && within(values), "{values:?}");
        // 20 m/s² within a pulse of 3 ms.
        assert!(slopes[1] > 20.0 / 0.003 && within(slopes), "{slopes:?}");
    }
}

//! Computes the codes of each scan of a tap, for one layout with one test's errors.

use std::f64::consts::TAU;

use massline_shared::layout::{HostLayout, Sensor};
use massline_shared::signal::{CHANNELS, RESPONSES, Scan};
use nalgebra::{Matrix3, Rotation3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::chain::{Chain, ChainState};
use super::channels::{Channels, SampledOutputs, UNLIMITED};
use super::dynamics::{Oscillators, PointShape, Step, check_node, point_shapes};
use super::environment::{Environment, Load};
use super::errors::{SensorErrors, TestErrors};
use super::faults::{self, Mounting};
use super::free_response::{ActingForces, FreeResponse, FreeScan, Start};
use super::loads::loaded_modes;
use super::streams::{Branch, branch};
use super::suspension::RigidMode;
use super::taps::{Tap, TapKind};
use crate::bench::{Bench, BenchError};

/// Number of modes in which the object swings on its suspension, the lowest ones.
const ON_SUSPENSION: usize = 6;

/// Scans for which an object is calm once it is: a draught that doubles its motion within this time is a storm.
const CALM_SCANS: u64 = 256;

/// The object with its sensors and their chains, and the state of all of them.
#[derive(Clone, Debug)]
pub(super) struct Simulation {
    /// Modes on the suspension, and those against it of a part on springs of its own.
    rigid: Vec<RigidMode>,
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
    /// True from the first contact on, or from the beginning when something else moves the object.
    moving: bool,
    /// Scans since the last reset.
    scans: u64,
    /// Modal forces at the last point of the grid, and at the next.
    forces: Vec<f64>,
    next_forces: Vec<f64>,
    /// Force of the hammer at the last point of the grid, N, as its gain there has it.
    tapped: f64,
    environment: Option<Environment>,
    /// What it does to the object at the last scan.
    load: Load,
    /// Before this scan no reading comes near the end of its range without a tap.
    calm_until: u64,
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
        let omega_and_zeta = rigid.iter().map(|m| (m.omega, m.damping_ratio)).chain(elastic);
        let modes = rigid.len() + bench.elastic.len();
        let steps_per_scan = usize::from(bench.adc.oversampling);
        let scan = h * steps_per_scan as f64;
        let steps =
            omega_and_zeta.clone().map(|(omega, zeta)| Step::new(omega, zeta, scan)).collect();
        let oscillators = Oscillators::new(omega_and_zeta, h);
        let environment = Environment::new(bench, &rigid, scan);
        let mut simulation = Self {
            rigid,
            oscillators,
            chain: Chain::new(bench, errors),
            per_acceleration: vec![[0.0; CHANNELS]; modes],
            per_displacement: vec![[0.0; CHANNELS]; modes],
            at_rest: [0.0; CHANNELS],
            hammer_gain: (1.0 + errors.hammer_gain) * faults::hammer_scale(bench),
            h,
            steps_per_scan,
            moving: false,
            scans: 0,
            forces: vec![0.0; modes],
            next_forces: vec![0.0; modes],
            tapped: 0.0,
            environment,
            load: Load::zeros(),
            calm_until: 0,
            free_response: None,
        };
        for (i, (sensor, error)) in layout.sensors.iter().zip(&errors.sensors).enumerate() {
            simulation.attach(bench, &faults::mounting(bench, i), sensor, error)?;
        }
        simulation.free_response = Some(simulation.free_motion(steps, bench.adc.jitter_s > 0.0));
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
        let chip = nominal.row(2).transpose() * faults::chip_height(bench);
        let mark = Vector3::from(sensor.position) + faults::misplaced(bench, sensor.node);
        let point = mark + chip + error.position;
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

    /// Sets the gain of each channel, which is one at first; it holds from the next reset on.
    pub(super) fn set_gains(&mut self, gains: &Channels) {
        self.chain.set_gains(gains);
    }

    /// Brings the object to rest, but for what the environment does, and sets the time to zero; see
    /// [`Chain::settle`].
    pub(super) fn reset(&mut self, noise: &mut ChaCha8Rng, disturbances: ChaCha8Rng) {
        self.oscillators.stop();
        self.load = Load::zeros();
        self.tapped = 0.0;
        self.calm_until = 0;
        self.moving = self.environment.is_some();
        self.scans = 0;
        let of_environment = branch(&disturbances, Branch::Environment);
        self.chain.settle(&self.at_rest, noise, disturbances);
        if let Some(environment) = &mut self.environment {
            environment.settle(self.oscillators.states_mut(), of_environment);
            self.load = environment.load();
        }
        load_modes(&mut self.forces, &self.rigid, &self.load);
        if self.moving {
            self.chain.follow(&self.reading(0.0));
        }
    }

    /// Lets the object swing as some time after a tap: in each of the six modes on the suspension with this share of
    /// the amplitude that the tap excites, at a random phase.
    pub(super) fn swing(&mut self, after: &Drive, share: f64, rng: &mut ChaCha8Rng) {
        let impulse = share * after.tap.impulse();
        let modes = self.rigid.iter().zip(&after.participation).take(ON_SUSPENSION);
        for (state, (mode, participation)) in self.oscillators.states_mut().iter_mut().zip(modes) {
            let (sine, cosine) = (TAU * rng.random::<f64>()).sin_cos();
            let velocity = participation * impulse;
            state[0] += velocity / mode.omega * sine;
            state[1] += velocity * cosine;
        }
        self.moving = true;
        self.chain.follow(&self.reading(0.0));
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
    pub(super) fn scan_inputs(&mut self, drives: &[Drive]) -> SampledOutputs {
        let end = self.grid_time(self.steps_per_scan);
        self.moving |= drives.iter().any(|d| d.tap.start() < end);
        let next = self.environment.as_mut().map_or(self.load, Environment::advance);
        let loads = [std::mem::replace(&mut self.load, next), next];
        let free = drives.iter().all(|d| d.tap.start() >= end || d.tap.end() < self.time())
            && self.tapped == 0.0
            && (self.scans < self.calm_until
                || FreeResponse::admits(&self.chain.held().input, &self.chain.linear_range()));
        let sampled = if self.moving && free {
            self.free_scan(&loads)
        } else if self.moving {
            self.end_calm();
            self.stepped_scan(drives, &loads)
        } else {
            self.chain.at_rest()
        };
        self.scans += 1;
        sampled
    }

    /// One scan without a tap, in closed form where that is known.
    fn free_scan(&mut self, loads: &[Load; 2]) -> SampledOutputs {
        let Some(free_response) = &self.free_response else {
            return self.stepped_scan(&[], loads);
        };
        if self.environment.is_some() {
            load_modes(&mut self.next_forces, &self.rigid, &loads[1]);
        } else {
            self.next_forces.fill(0.0);
        }
        let forces = [&self.forces[..], &self.next_forces[..]];
        let mut held = self.chain.held();
        let acting = ActingForces { loads, forces };
        let calm = self.scans + 1 < self.calm_until;
        let states = self.oscillators.states_mut();
        let sampled = free_response.scan(states, &mut held, &acting, !calm);
        self.chain.hold(&held);
        std::mem::swap(&mut self.forces, &mut self.next_forces);
        if !calm && self.scans.is_multiple_of(CALM_SCANS) && self.is_calm() {
            self.calm_until = self.scans + 1 + CALM_SCANS;
        }
        sampled
    }

    /// True when no reading will come near the end of its range unless something acts on the object.
    fn is_calm(&self) -> bool {
        let mut largest = self.at_rest.map(f64::abs);
        let factors = self.per_displacement.iter().zip(&self.per_acceleration);
        for ([q, a], (per_q, per_a)) in self.oscillators.bounds().zip(factors) {
            for k in 1..CHANNELS {
                largest[k] += per_a[k].abs() * a + per_q[k].abs() * q;
            }
        }
        FreeResponse::admits(&largest, &self.chain.linear_range())
    }

    /// Restores the input of the chain, which is not computed in calm.
    fn end_calm(&mut self) {
        if self.scans < self.calm_until {
            let held = ChainState { input: self.reading(0.0), ..self.chain.held() };
            self.chain.hold(&held);
            self.calm_until = 0;
        }
    }

    /// One scan step by step.
    fn stepped_scan(&mut self, drives: &[Drive], loads: &[Load; 2]) -> SampledOutputs {
        let mut sampled = self.chain.at_rest();
        for step in 0..self.steps_per_scan {
            let share = (step + 1) as f64 / self.steps_per_scan as f64;
            let load = loads[0] + (loads[1] - loads[0]) * share;
            let input = self.step(drives, &load, self.grid_time(step + 1));
            self.chain.advance(step, &input, &mut sampled);
        }
        sampled
    }

    /// The factors of a scan of free motion.
    fn free_motion(&self, steps: Vec<Step>, with_slopes: bool) -> FreeResponse {
        let unlimited = Self { chain: self.chain.without_limits(), ..self.clone() };
        let still = Start {
            states: vec![[0.0; 2]; steps.len()],
            output: [0.0; CHANNELS],
            loads: [Load::zeros(); 2],
        };
        // At rest the input is the sensors' reading of gravity.
        let rest = unlimited.clone().scanned(&still);
        let bare = Self { at_rest: [0.0; CHANNELS], ..unlimited };
        FreeResponse::of(steps, [with_slopes, self.environment.is_some()], &rest, |start| {
            bare.clone().scanned(start)
        })
    }

    /// One scan without a tap, computed step by step.
    fn scanned(mut self, start: &Start) -> FreeScan {
        self.oscillators.states_mut().copy_from_slice(&start.states);
        load_modes(&mut self.forces, &self.rigid, &start.loads[0]);
        self.chain.hold(&ChainState { input: self.reading(0.0), output: start.output });
        let sampled = self.stepped_scan(&[], &start.loads);
        FreeScan { sampled, held: self.chain.held() }
    }

    fn grid_time(&self, step: usize) -> f64 {
        (self.scans as f64 * self.steps_per_scan as f64 + step as f64) * self.h
    }

    /// Advances the object to `time`, under this load there, and returns the readings.
    fn step(&mut self, drives: &[Drive], load: &Load, time: f64) -> Channels {
        let mut total = 0.0;
        load_modes(&mut self.next_forces, &self.rigid, load);
        for drive in drives {
            let force = drive.tap.force(time);
            if force > 0.0 {
                total += force * (1.0 + drive.tap.gain_error);
                for (f, p) in self.next_forces.iter_mut().zip(&drive.participation) {
                    *f += force * p;
                }
            }
        }
        self.oscillators.advance(&self.forces, &self.next_forces);
        std::mem::swap(&mut self.forces, &mut self.next_forces);
        self.tapped = total;
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

/// The modal forces of a load, which does not excite elastic modes.
fn load_modes(forces: &mut [f64], rigid: &[RigidMode], load: &Load) {
    forces.fill(0.0);
    if *load != Load::zeros() {
        for (force, mode) in forces.iter_mut().zip(rigid) {
            *force = mode.shape.dot(load);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error_sizes::ErrorSizes;
    use crate::habit::Tip;
    use crate::taps::Contact;
    use crate::tests::test_one;
    use nalgebra::Vector3;
    use rand::SeedableRng;

    /// Compares two seconds with two taps, computed in closed form and step by step: largest difference and largest
    /// magnitude of the values and of their rates of change.
    fn compared(mut bench: Bench, contacts: [Contact; 2]) -> [[f64; 2]; 2] {
        // Jitter asks for the slopes as well.
        bench.adc.jitter_s = 1e-6;
        bench.environment.draught_n = 0.1;
        bench.environment.draught_n_m = 0.01;
        bench.environment.creak_rate_per_s = 50.0;
        bench.environment.creak_n_s = 1e-3;
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let errors = TestErrors::draw(&bench, &ErrorSizes::of_bench(&bench, 3, 0), &mut rng);
        let mut free_response = Simulation::new(&bench, &test_one(), &errors).unwrap();
        free_response.reset(&mut rng, ChaCha8Rng::seed_from_u64(6));
        let mut stepping = Simulation { free_response: None, ..free_response.clone() };
        let tap = |contact| Tap {
            dof: 0,
            kind: TapKind::Good,
            point: Vector3::zeros(),
            direction: Vector3::y(),
            tip: Tip::default(),
            gain_error: 0.0,
            contacts: vec![contact],
        };
        let drives = contacts.map(|contact| free_response.drive(&bench, 1, tap(contact)).unwrap());
        let compare = |[worst, largest]: &mut [f64; 2], a: &Channels, b: &Channels| {
            for (a, b) in a.iter().zip(b) {
                *worst = worst.max((a - b).abs());
                *largest = largest.max(b.abs());
            }
        };
        let [mut values, mut slopes] = [[0.0_f64; 2]; 2];
        for _ in 0..8000 {
            let (a, b) = (free_response.scan_inputs(&drives), stepping.scan_inputs(&drives));
            compare(&mut values, &a.value, &b.value);
            compare(&mut slopes, &a.slope, &b.slope);
        }
        [values, slopes]
    }

    #[test]
    fn the_free_response_in_closed_form_is_that_of_the_steps() {
        let tap = |start, duration, peak| Contact { start, duration, peak };
        let hard = [tap(0.01, 0.003, 25.0), tap(1.2, 0.003, 25.0)];
        let soft = [tap(0.01, 0.02, 100.0), tap(1.2, 0.02, 100.0)];
        for (name, contacts, least) in [
            // 20 m/s² within a pulse of 3 ms, and 5 m/s² within one of 20 ms.
            ("default", hard, [20.0, 20.0 / 0.003]),
            ("wheel-with-tyre", soft, [5.0, 5.0 / 0.02]),
        ] {
            let compared = compared(Bench::named(name).unwrap(), contacts);
            for ([worst, largest], least) in compared.into_iter().zip(least) {
                // Rounding over 8000 scans.
                assert!(worst < 1e-10 * largest && largest > least, "{name}: {worst} {largest}");
            }
        }
    }
}

//! The sensors of a bench held still in the six positions of a tumble test.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use massline_shared::calibration::tumble::Position;
use massline_shared::signal::{AdcProperties, CHANNELS, RESPONSES, Scan};
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;

use super::chain::Chain;
use super::channels::{Channels, UNLIMITED};
use super::error_sizes::ErrorSizes;
use super::errors::{TestErrors, normal};
use super::operator::TEST;
use super::streams::stream;
use crate::bench::{Bench, BenchError};
use crate::source::ScanSource;

/// Makes scans of the sensors of a bench while they lie still, all side by side on one square block that
/// is turned from position to position.
///
/// The sensors are those of [`super::BenchSource`] with the same seed. Each position is tilted slightly,
/// always in the same way for one seed.
#[derive(Debug)]
pub struct TumbleSource {
    bench: Bench,
    sensors: usize,
    seed: u64,
    errors: TestErrors,
    chain: Chain,
    noise: ChaCha8Rng,
    handle: TumbleHandle,
    /// Index of the position for which the chain is in steady state.
    settled: Option<usize>,
}

/// Turns the block, from any thread.
#[derive(Clone, Debug, Default)]
pub struct TumbleHandle(Arc<AtomicUsize>);

impl TumbleHandle {
    /// From the next scan on the block lies in this position.
    pub fn turn_to(&self, position: Position) {
        let index = Position::ALL.iter().position(|&p| p == position).unwrap_or(0);
        self.0.store(index, Ordering::Relaxed);
    }
}

/// Streams of the tilts; no arming has these numbers.
const TILTS: u64 = TEST - 0x1000;
/// Streams of mains and jitter, one for each position.
const DISTURBANCES: u64 = TEST - 0x2000;

impl TumbleSource {
    /// The first `sensors` sensors of a bench, in the first of [`Position::ALL`].
    ///
    /// # Errors
    /// When a rig does not have enough channels for them.
    pub fn new(bench: &Bench, sensors: usize, seed: u64) -> Result<Self, BenchError> {
        if sensors * 3 > RESPONSES {
            return Err(BenchError::TooManySensors(sensors));
        }
        let errors = TestErrors::draw(
            bench,
            &ErrorSizes::of_bench(bench, sensors, 0),
            &mut stream(seed, TEST),
        );
        Ok(Self {
            bench: bench.clone(),
            sensors,
            seed,
            chain: Chain::new(bench, &errors),
            errors,
            noise: stream(seed, TEST - 1),
            handle: TumbleHandle::default(),
            settled: None,
        })
    }

    /// A handle that turns the block.
    pub fn handle(&self) -> TumbleHandle {
        self.handle.clone()
    }

    /// The constant errors of the sensors.
    pub fn errors(&self) -> &TestErrors {
        &self.errors
    }

    /// The inputs of the channels in a position, m/s².
    fn input(&self, index: usize) -> Channels {
        let position = Position::ALL[index];
        let mut rng = stream(self.seed, TILTS + index as u64);
        let mut up = position.up::<f64>();
        for across in 1..3 {
            let axis = (position.axis.index() + across) % 3;
            up[axis] = normal(&mut rng) * self.bench.operator.tilt_sigma_rad;
        }
        let specific_force: Vector3<f64> = up.normalize() * self.bench.gravity.norm();
        let mut input = [0.0; CHANNELS];
        for (channels, sensor) in input[1..].chunks_exact_mut(3).zip(&self.errors.sensors) {
            channels.copy_from_slice((sensor.sensitivity * specific_force).as_slice());
        }
        input
    }
}

impl ScanSource for TumbleSource {
    fn adc(&self) -> AdcProperties {
        self.bench.converter(self.sensors)
    }

    fn started(&mut self) {}

    fn armed(&mut self, _: u32, _: usize) {}

    fn next_scan(&mut self) -> Option<Scan> {
        let index = self.handle.0.load(Ordering::Relaxed);
        if self.settled != Some(index) {
            let input = self.input(index);
            let disturbances = stream(self.seed, DISTURBANCES + index as u64);
            self.chain.settle(&input, &mut self.noise, disturbances);
            self.settled = Some(index);
        }
        let output = self.chain.at_rest();
        Some(self.chain.convert(&output, &UNLIMITED, &mut self.noise))
    }
}

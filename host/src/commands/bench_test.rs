//! One test on a simulated bench: starts a rig, configures it over its link, taps, and reads the result.

use std::path::Path;

use massline_protocol::object::MeasurementResult;
use massline_shared::STANDARD_GRAVITY;
use massline_shared::calibration::CalibrationRecord;
use massline_shared::layout::HostLayout;
use massline_shared::signal::{Calibration, ChannelCalibration};
use massline_shared::units::{Hertz, Volts};
use massline_virtual::bench::{Bench, BenchError, BenchSource, Bundled, Fault};
use massline_virtual::source::ScanSource;

use super::number::seed;
use super::simulated::{SimulatedCampaign, narrow};
use crate::error::{Error, Result};
use crate::output::Output;
use crate::rig::{RigKind, SimulatedRig};

/// The bench of a test.
#[derive(Clone, Debug, clap::Args)]
pub struct BenchArgs {
    /// Name of a bundled bench, or a TOML file.
    #[arg(long, value_name = "NAME|FILE", default_value = "default", help = bench_help())]
    pub bench: String,
    /// Seed of all random numbers on the bench.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = seed)]
    pub seed: u64,
    /// A mistake on the bench: `flip:2y` (axis of sensor 2), `swap:1,2` (cables), `swap:2x,2z` (wires),
    /// `rotate:3:z90` (sensor glued turned), `hit:2:4` (second DOF hit at node 4), `reverse:2` (hit from
    /// the other side), `scale:1.1` (all sensors). May be repeated.
    #[arg(long, value_name = "FAULT")]
    pub fault: Vec<Fault>,
}

/// The help of `--bench`, with every bundled bench.
pub fn bench_help() -> String {
    let about = |bundled: &Bundled| format!("`{}` ({})", bundled.name, bundled.about);
    let all: Vec<String> = Bench::BUNDLED.iter().map(about).collect();
    format!("Bench: {}, or a TOML file", all.join(", "))
}

impl BenchArgs {
    /// The bench.
    ///
    /// # Errors
    /// When there is no bench of this name, or the file is bad.
    pub fn open(&self) -> Result<Bench> {
        let mut bench = Bench::open(&self.bench)?;
        bench.faults.extend(&self.fault);
        Ok(bench)
    }
}

impl From<BenchError> for Error {
    fn from(error: BenchError) -> Self {
        let code = match &error {
            BenchError::Unreadable { .. } => "cannot_read",
            BenchError::UnknownName(_) => "unknown_bench",
            BenchError::File(_) => "malformed_bench",
            _ => "bench_does_not_fit",
        };
        Self::input(code, error.to_string())
    }
}

/// One test.
#[derive(Clone, Copy, Debug)]
pub struct BenchTest<'a> {
    /// Name of the test, for people.
    pub label: &'a str,
    /// Where the sensors sit and the hammer lands.
    pub layout: &'a HostLayout,
    /// The simulated object and measuring chain.
    pub bench: &'a Bench,
    /// Seed of all random numbers on the bench.
    pub seed: u64,
    /// Which rig.
    pub rig: RigKind,
    /// The firmware image of the rig.
    pub firmware: Option<&'a Path>,
}

impl BenchTest<'_> {
    /// Runs the test; `wrap` may insert something between bench and rig, for example a tape recorder.
    ///
    /// # Errors
    /// When the bench does not fit the layout, the rig does not start, refuses or gets stuck, or
    /// there is no answer.
    pub fn run(
        &self,
        output: &mut Output,
        wrap: impl FnOnce(Box<dyn ScanSource>) -> Box<dyn ScanSource>,
    ) -> Result<MeasurementResult> {
        self.run_with(&nominal_calibration(self.bench).into(), output, wrap)
    }

    /// Runs the test with a given calibration.
    ///
    /// # Errors
    /// As [`BenchTest::run`].
    pub fn run_with(
        &self,
        calibration: &CalibrationRecord,
        output: &mut Output,
        wrap: impl FnOnce(Box<dyn ScanSource>) -> Box<dyn ScanSource>,
    ) -> Result<MeasurementResult> {
        let source = BenchSource::new(self.bench, self.layout, self.seed)?;
        let mut rig = SimulatedRig::start(self.rig, self.firmware, wrap(Box::new(source)))?;
        let layout = narrow(self.layout)?;
        let campaign = SimulatedCampaign { label: self.label, layout: &layout, calibration };
        campaign.run(&mut rig, output, &mut |_, _, _| Ok(None))
    }

    /// The ten properties of the object: [m, cx, cy, cz, Jxx, Jyy, Jzz, Jxy, Jxz, Jyz].
    pub fn truth(&self) -> [f64; 10] {
        self.bench.truth().theta().into()
    }
}

/// The calibration that the data sheets of the bench's parts state.
pub fn nominal_calibration(bench: &Bench) -> Calibration {
    let (sensor, hammer) = (&bench.sensor, &bench.hammer);
    let accelerometer = ChannelCalibration {
        zero: Volts(sensor.zero_v as f32),
        sensitivity: (sensor.sensitivity_v_per_g / STANDARD_GRAVITY) as f32,
        cutoff: Hertz(sensor.rc_cutoff_hz as f32),
    };
    let mut calibration = Calibration::default();
    calibration.channels.fill(accelerometer);
    calibration.channels[0] = ChannelCalibration {
        zero: Volts(hammer.zero_v as f32),
        sensitivity: hammer.sensitivity_v_per_n as f32,
        cutoff: Hertz(hammer.rc_cutoff_hz as f32),
    };
    calibration.sensor_range = (sensor.range_g * STANDARD_GRAVITY) as f32;
    calibration
}

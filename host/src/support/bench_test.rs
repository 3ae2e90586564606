//! One test on a simulated bench: starts a rig, configures it over its link, taps, and reads the result.

use std::f64::consts::FRAC_2_PI;
use std::path::Path;

use clap::ValueEnum;
use massline_physics::source::ScanSource;
use massline_physics::{Bench, BenchError, BenchSource, BundledBench, ErrorsFrom, Fault};
use massline_shared::STANDARD_GRAVITY;
use massline_shared::calibration::CalibrationRecord;
use massline_shared::layout::{HostLayout, TestProfile};
use massline_shared::signal::{Calibration, ChannelCalibration};
use massline_shared::units::{Hertz, Volts};

use super::number::seed;
use super::simulated::{SimulatedCampaign, SimulatedMeasurement, narrow};
use crate::Result;
use crate::output::Output;
use crate::rig::{RigKind, SimulatedRig};
use massline_analysis::bench_error::bench_error;
use massline_files::archive::{Archive, ArchivedLayout};
use massline_files::layout_file::LayoutFile;
use massline_files::toml_file;

/// The bench of commands that are given none.
const DEFAULT_BENCH: &str = "default";

/// The bench of a test.
#[derive(Clone, Debug, clap::Args)]
pub struct BenchArgs {
    /// Name of a bundled bench, or a TOML file; `None` for that of the command.
    #[arg(long, value_name = "NAME|FILE", help = bench_help())]
    pub bench: Option<String>,
    /// Seed of all random numbers on the bench.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = seed)]
    pub seed: u64,
    /// A mistake or a faulty part on the bench, such as `flip:2y`; may be repeated. `--help` lists them.
    ///
    /// Sensors and hits are counted from 1. Sensors: `flip:2y` (axis of sensor 2), `swap:1,2` (cables), `swap:2x,2z`
    /// (wires), `rotate:3:z90` (glued turned), `scale:1.1` (all of them read 10 % too much), `boards:0.005` (5 g on
    /// each that are not declared), `compress:2y` (softly), `rail:2y:50` (its buffer ends at 50 m/s²). Hits: `hit:2:4`
    /// (the second DOF at node 4), `beside:2:0.005` (5 mm beside the mark), `reverse:2` (from the other side),
    /// `hammer:0.97` (it reads 3 % too little), `rail:hammer:20` (its buffer ends at 20 N), `lean:2:0.08` (80 mrad),
    /// `turn:0.05` (all hits, 50 mrad), `pad:0.01` (10 g on the mark that is hit). Around: `node:4z:0.01` (node 4 lies
    /// 10 mm further along z), `height:0.004` (chips 4 mm above their marks), `drift:hammer:0.05` and `drift:2y:0.05`
    /// (gains that rise by 5 % over the test), `cable:2:400` (400 N/m at node 2), `hum:0.005` (5 mV of the mains in
    /// every channel). A bench file has more: boards/virtual/README.md.
    #[arg(long, value_name = "FAULT")]
    pub fault: Vec<Fault>,
    /// What says how large the errors of sensors, marks, hits, hammer and gravity are; default: what the bench file
    /// says.
    #[arg(long, value_enum, value_name = "WHOSE")]
    errors: Option<Errors>,
}

/// What says how large errors are, as an argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Errors {
    /// The keys of the bench file.
    Bench,
    /// The error budget of the layout: its table `uncertainty`, and the defaults.
    Layout,
}

/// The help of `--bench`, with every bundled bench.
pub fn bench_help() -> String {
    let about = |bundled: &BundledBench| format!("`{}` ({})", bundled.name, bundled.about);
    let benches: Vec<String> = Bench::BUNDLED.iter().map(about).collect();
    format!(
        "Bench: {}, or a TOML file [default: {DEFAULT_BENCH}; for `simulate`, the object of the layout's [reference]]",
        benches.join(", ")
    )
}

impl BenchArgs {
    /// The bench; without a name the default one.
    ///
    /// # Errors
    /// When there is no bench of this name, or the file is bad.
    pub fn open(&self) -> Result<Bench> {
        let bench = open_bench(self.bench.as_deref().unwrap_or(DEFAULT_BENCH))?;
        Ok(self.with_faults(bench))
    }

    /// The bench, with the faults and errors of the arguments.
    pub fn with_faults(&self, mut bench: Bench) -> Bench {
        bench.faults.extend(&self.fault);
        bench.errors = match self.errors {
            None => bench.errors,
            Some(Errors::Bench) => ErrorsFrom::Bench,
            Some(Errors::Layout) => ErrorsFrom::Layout,
        };
        bench
    }
}

/// The bundled bench of this name, or else the bench in the file at this path.
///
/// # Errors
/// When there is no bench of this name, or the file is bad.
pub fn open_bench(name_or_path: &str) -> Result<Bench> {
    let path = Path::new(name_or_path);
    let bundled = Bench::BUNDLED.iter().any(|bundled| bundled.name == name_or_path);
    if bundled || !path.exists() && path.extension().is_none() {
        return Bench::named(name_or_path).map_err(bench_error);
    }
    Bench::parse(&toml_file::read(path, "cannot_read")?, name_or_path).map_err(bench_error)
}

/// The scans of a test with this layout on a bench.
///
/// # Errors
/// When the bench does not fit the layout; where it is that of another object, with what to do.
pub fn source_on(bench: &Bench, layout: &HostLayout, seed: u64) -> Result<BenchSource> {
    BenchSource::new(bench, layout, seed).map_err(|error| {
        let is_of_another =
            matches!(error, BenchError::NodeElsewhere { .. } | BenchError::NodeWithoutShape(_));
        let error = bench_error(error);
        if is_of_another { error.advising(fitting_benches(layout)) } else { error }
    })
}

/// Which benches may be those of the object of a layout.
fn fitting_benches(layout: &HostLayout) -> String {
    let own = "--bench FILE with a bench file of its object (boards/virtual/README.md)";
    if layout.test.profile != TestProfile::Suspension {
        return format!("give {own}");
    }
    // Those whose mallet makes the modes swing as the layout asks for, and that have no nodes of their own.
    let swings = |bench: Bench| {
        // The impulse of half a period of a sine.
        let impulse = bench.tap.force_n[1] * bench.tap.duration_s[1] * FRAC_2_PI;
        impulse > layout.test.impulse_ns[0] && BenchSource::new(&bench, layout, 1).is_ok()
    };
    let hangs = |bundled: &&BundledBench| Bench::named(bundled.name).is_ok_and(swings);
    let names =
        Bench::BUNDLED.iter().filter(hangs).map(|bundled| format!("--bench {}", bundled.name));
    let ways: Vec<_> = names.chain([own.to_owned()]).collect();
    format!("this layout is one of the suspension profile: give {}", ways.join(" or "))
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
    ) -> Result<SimulatedMeasurement> {
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
    ) -> Result<SimulatedMeasurement> {
        self.on_rig(calibration, wrap, |campaign, rig| {
            campaign.run(rig, output, &mut |_, _, _| Ok(None))
        })
    }

    /// Runs the test to its archive; `file` is what the layout was read from. A file without a reference gets the truth
    /// for one.
    ///
    /// # Errors
    /// As [`BenchTest::run`].
    pub fn archived(
        &self,
        file: &LayoutFile,
        calibration: &CalibrationRecord,
        output: &mut Output,
        wrap: impl FnOnce(Box<dyn ScanSource>) -> Box<dyn ScanSource>,
    ) -> Result<Archive> {
        let archived = ArchivedLayout {
            resolved: self.layout.clone(),
            ..ArchivedLayout::of_file(&file.with_reference(&self.bench.truth()))
        };
        self.on_rig(calibration, wrap, |campaign, rig| {
            campaign.archived(rig, archived, output, &mut |_, _, _| Ok(None))
        })
    }

    /// Starts the rig on the bench, and runs the campaign on it.
    fn on_rig<T>(
        &self,
        calibration: &CalibrationRecord,
        wrap: impl FnOnce(Box<dyn ScanSource>) -> Box<dyn ScanSource>,
        run: impl FnOnce(&SimulatedCampaign<'_>, &mut SimulatedRig) -> Result<T>,
    ) -> Result<T> {
        let source = source_on(self.bench, self.layout, self.seed)?;
        let mut rig = SimulatedRig::start(self.rig, self.firmware, wrap(Box::new(source)))?;
        let layout = narrow(self.layout)?;
        run(&SimulatedCampaign { label: self.label, layout: &layout, calibration }, &mut rig)
    }

    /// The ten properties of the object: [m, c_x, c_y, c_z, J_xx, J_yy, J_zz, J_xy, J_xz, J_yz].
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

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use clap::CommandFactory;

    use super::*;

    #[derive(clap::Parser)]
    struct Options {
        #[command(flatten)]
        _bench: BenchArgs,
    }

    /// The kinds of the faults among the words of a text.
    fn kinds(text: &str) -> BTreeSet<String> {
        let words = text.split([' ', '`']).map(|word| word.trim_end_matches(','));
        let faults = words.filter(|word| word.parse::<Fault>().is_ok());
        faults.filter_map(|word| Some(word.split_once(':')?.0.to_owned())).collect()
    }

    #[test]
    fn the_help_lists_every_fault_that_an_error_lists() {
        let options = Options::command();
        let fault = options.get_arguments().find(|argument| argument.get_id() == "fault").unwrap();
        let help = fault.get_long_help().unwrap().to_string();
        let error = "nothing".parse::<Fault>().unwrap_err().to_string();
        assert_eq!(kinds(&help), kinds(&error));
        assert_eq!(kinds(&help).len(), 19, "{help}");
    }
}

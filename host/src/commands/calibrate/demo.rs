//! `massline calibrate demo`: both tests on the simulated bench, and a measurement before and after.

use massline_physics::{Bench, TumbleSource};
use massline_shared::calibration::CalibrationRecord;
use massline_shared::calibration::block::BlockMass;
use massline_shared::calibration::tumble::TumbleLimits;
use massline_shared::signal::HAMMER;

use super::block::{BlockTest, LAYOUT};
use super::helper::Lines;
use super::rig::{BlockRig, TumbleRig};
use super::{store, tumble};
use crate::commands::demo::LAYOUTS;
use crate::commands::measure::ScreenArgs;
use crate::output::{self, Output, Tone};
use crate::rig::RigKind;
use crate::rig_solution::solve_test;
use crate::support::bench_test::{BenchTest, nominal_calibration};
use crate::support::compare::Comparison;
use crate::support::simulated::narrow;
use crate::{Error, Result};
use massline_analysis::bench_error::bench_error;
use massline_analysis::identification::Selection;
use massline_analysis::single_fault::NominalTest;
use massline_files::layout_file::LayoutFile;
use massline_files::tumble_file::TumbleFile;
use massline_report::calibration as report;
use massline_report::document::{
    BeforeAndAfter, CalibratedTest, CalibrationDemo, CalibrationErrors,
};

/// Arguments of `massline calibrate demo`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Uncalibrated sensors and hammer, off from their data sheets by 5 % and 2 % (1 σ): a tumble test, a
block of 2 kg, and the four tests of `massline demo` with the data sheets and with the calibration.

Examples:
  massline calibrate demo
  massline calibrate demo --seed 7 --json")]
pub struct Args {
    /// Seed of all random numbers on the bench.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
}

/// Runs the command.
///
/// # Errors
/// When the rig does not start or gets stuck.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    let record = calibrate(args.seed, output)?;
    let bench = Bench::named("uncalibrated").map_err(bench_error)?;
    let errors = sensitivity_errors(&bench, args.seed, &record)?;
    let [gain, cross_axis, hammer] = errors.largest_percent();
    let before = nominal_calibration(&bench).into();
    let mut rows = Vec::new();
    for (name, text) in LAYOUTS {
        let [before, after] = [&before, &record].map(|calibration| {
            error_of_scale(&bench, (name, text), args.seed, calibration, output)
        });
        rows.push((name, before?, after?));
    }
    let test = |&(name, data_sheet, calibrated): &(&'static str, f64, f64)| CalibratedTest {
        name: name.into(),
        rms_error_percent_of_scale: BeforeAndAfter { data_sheet, calibrated },
    };
    let value = CalibrationDemo {
        calibration: report::record_json(&record),
        largest_error_percent: CalibrationErrors { gain, cross_axis, hammer },
        tests: rows.iter().map(test).collect(),
    };
    output.answer(&value, |output| {
        let mut table = output::table();
        table.set_header(["test", "data sheet, % of scale rms", "calibrated"]);
        for (name, before, after) in &rows {
            table.add_row([(*name).to_owned(), format!("{before:.3}"), format!("{after:.3}")]);
        }
        format!(
            "{}\n{}\nlargest error of the calibration: gain {gain:.3} %, cross-axis {cross_axis:.3} %, hammer \
             {hammer:.3} %\n\n{}\n{table}",
            output.toned("calibration", Tone::Strong),
            report::record_text(&record),
            output.toned("before and after", Tone::Strong),
        )
    })
}

/// Runs both tests on the bundled block, with virtual rigs.
///
/// # Errors
/// When a rig does not start, refuses or gets stuck, or a test does not determine a calibration.
pub fn calibrate(seed: u64, output: &mut Output) -> Result<CalibrationRecord> {
    let bench = Bench::named("block").map_err(bench_error)?;
    let file = LayoutFile::parse(LAYOUT, "block.toml")?;
    let limits = TumbleLimits::default();
    let directory = tempfile::tempdir()
        .map_err(|e| Error::internal("no_temporary_file", format!("no temporary folder: {e}")))?;
    let flash = directory.path().join("flash.bin");
    let mut record = {
        let mut rig = TumbleRig::on_bench(&bench, file.layout.sensors.len(), seed, Some(&flash))?;
        let mut readings = TumbleFile::new(&directory.path().join("tumble.toml"));
        tumble::take(&mut rig, &mut readings, &limits, &mut Lines::new(output))?;
        let mut record = CalibrationRecord::from(nominal_calibration(&bench));
        let tumble = readings.solve(&limits)?;
        tumble::judge_level(&tumble, &limits)?;
        record.take_tumble(&tumble.sensors, tumble.hammer_zero);
        store(&mut rig.client, &record)?;
        record
    };
    let mut rig = BlockRig::on_bench(&bench, &file.layout, seed, Some(&flash))?;
    let mass = BlockMass { mass: bench.truth().mass, sigma: 0.001 };
    let layout = narrow(&file.layout)?;
    let screen = ScreenArgs::default();
    let test = BlockTest { file, layout, mass, restart: false, screen };
    // The calibration that the rig has stored across its restart.
    let kept = rig.client.calibration()?;
    test.run(&mut rig, &kept, output)?.write(&mut record);
    store(&mut rig.client, &record)?;
    Ok(record)
}

/// Errors of a calibration against the truth of a bench, relative to the sensitivity of their channel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SensitivityErrors {
    /// Of the sensitivities of all axes.
    pub gain: Vec<f64>,
    /// Of the cross-axis sensitivities.
    pub cross_axis: Vec<f64>,
    /// Of the hammer's sensitivity.
    pub hammer: f64,
}

impl SensitivityErrors {
    /// The largest magnitudes of the errors of gain, cross-axis sensitivity and hammer, %.
    pub fn largest_percent(&self) -> [f64; 3] {
        let largest = |errors: &[f64]| {
            errors.iter().fold(0.0, |largest: f64, e| largest.max(100.0 * e.abs()))
        };
        [largest(&self.gain), largest(&self.cross_axis), largest(&[self.hammer])]
    }
}

/// The errors of `record` for the sensors and the hammer that the bench has with this seed.
///
/// # Errors
/// When the bench does not have as many sensors.
pub fn sensitivity_errors(
    bench: &Bench,
    seed: u64,
    record: &CalibrationRecord,
) -> Result<SensitivityErrors> {
    let source = TumbleSource::new(bench, record.sensors.len(), seed).map_err(bench_error)?;
    let truth = source.errors();
    let nominal = nominal_calibration(bench);
    let mut errors = SensitivityErrors::default();
    for (k, sensor) in truth.sensors.iter().enumerate() {
        let sensitivity = record.calibration.sensor_sensitivity(k);
        let true_one = nominal.sensor_sensitivity(k) * sensor.sensitivity;
        for row in 0..3 {
            for column in 0..3 {
                let off = (sensitivity - true_one)[(row, column)] / true_one[(row, row)];
                if row == column { &mut errors.gain } else { &mut errors.cross_axis }.push(off);
            }
        }
    }
    let hammer = |calibration: &massline_shared::signal::Calibration| {
        f64::from(calibration.channels[HAMMER].sensitivity)
    };
    let true_hammer = hammer(&nominal) * (1.0 + truth.hammer_gain);
    errors.hammer = hammer(&record.calibration) / true_hammer - 1.0;
    Ok(errors)
}

/// Root mean square over the inertial parameters of the errors of a test on the bench, % of scale.
///
/// # Errors
/// When the rig gets stuck or there is no answer.
pub fn error_of_scale(
    bench: &Bench,
    (name, text): (&str, &str),
    seed: u64,
    calibration: &CalibrationRecord,
    output: &mut Output,
) -> Result<f64> {
    let layout = LayoutFile::parse(text, name)?.layout;
    let test = BenchTest {
        label: name,
        layout: &layout,
        bench,
        seed,
        rig: RigKind::Virtual,
        firmware: None,
    };
    let measured = test.run_with(calibration, output, |source| source)?;
    let nominal = NominalTest::of_layout(layout.clone());
    let result = solve_test(measured.test(), &nominal, Selection::All).result();
    let length = layout.characteristic_length();
    let comparison = Comparison::new(name, seed, test.truth(), length, result);
    let errors = comparison.errors_percent()?;
    Ok((errors.iter().map(|e| e * e).sum::<f64>() / 10.0).sqrt())
}

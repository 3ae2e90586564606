//! The path of a user who states nothing at all: no `[uncertainty]`, parts out of the box.
//!
//! `MASSLINE_LONG=1 cargo test --release -p massline-tests --test system -- nothing_stated:: --nocapture` prints the
//! figures of tests/README.md.

use std::io;

use massline::commands::calibrate::demo::{calibrate, sensitivity_errors};
use massline::output::Output;
use massline::support::bench_test::nominal_calibration;
use massline_analysis::monte_carlo::measurement::TestLayout;
use massline_analysis::monte_carlo::statistics::MethodStatistics;
use massline_analysis::monte_carlo::{MonteCarlo, Run, apply_bench_budget, seed_of_run};
use massline_physics::Bench;
use massline_shared::calibration::{CalibrationRecord, CalibrationSigma, without_calibration};
use massline_shared::identify::Method;
use massline_shared::signal::Calibration;
use massline_tests::campaign::{THREE_BAR_TESTS, layout_file, steady_hand};
use massline_tests::long;
use massline_tests::pooled::{PooledStatistics, pooled, solved_again};

/// Chosen before the first run.
const SEED: u64 = 20_261_124;

/// Runs of each of the four tests.
fn runs() -> u64 {
    if long() { 200 } else { 3 }
}

/// A test as its file has it, with what a calibration contributes.
fn layout_of(test: &str, calibrated: Option<CalibrationSigma>) -> TestLayout {
    let mut layout: TestLayout = layout_file(test).layout.cast().expect("fits the rig");
    match calibrated {
        Some(sigma) => {
            sigma.apply_to(&mut layout);
            // From here on stated: the simulated rig would take them from the calibration in its flash.
            layout.calibrated_hammer = false;
            layout.sensors.iter_mut().for_each(|sensor| sensor.calibrated = Default::default());
        }
        None => without_calibration(&mut layout),
    }
    layout
}

/// One run of a test with its own seed.
fn run(bench: &Bench, layout: &TestLayout, calibration: &Calibration, seed: u64) -> Run {
    let study = MonteCarlo { bench, layout, calibration, seed, runs: 1, threads: None };
    study.runs(&|| false, |_| ()).expect("the bench takes the layout").remove(0)
}

/// The statistics with the true errors stated, which are those of `bench`, and with what the runs have learned.
fn compare(bench: &Bench, of_tests: &[(TestLayout, Vec<Run>)]) -> [PooledStatistics; 2] {
    let calibration = nominal_calibration(bench);
    let mut lists = [const { Vec::new() }; 2];
    for (layout, runs) in of_tests {
        let mut exact = layout.clone();
        apply_bench_budget(&mut exact, bench);
        let count = runs.len() as u64;
        let study = MonteCarlo {
            bench,
            layout,
            calibration: &calibration,
            seed: SEED,
            runs: count,
            threads: None,
        };
        let learned = study.study(runs).methods.swap_remove(0);
        // Missing answers would be the worst ones.
        assert_eq!((learned.method, learned.unanswered), (Some(Method::MaximumLikelihood), 0));
        let bound: Vec<f64> =
            learned.properties.iter().map(|p| p.bound.expect("has one")).collect();
        let bound = bound.try_into().expect("ten properties");
        let answers = solved_again(runs, &exact);
        let truth = bench.truth().theta().into();
        lists[0].push(MethodStatistics::of(learned.method, &answers, &truth, Some(&bound)));
        lists[1].push(learned);
    }
    lists.map(|list| pooled(&list))
}

fn show(name: &str, [exact, learned]: [PooledStatistics; 2]) {
    let text = |p: PooledStatistics| {
        format!("{:.1} %, {:.2}, {:.2}", 100.0 * p.coverage, p.error, p.width)
    };
    println!("| {name} | {} | {} |", text(exact), text(learned));
}

/// Allowance for the coverage of few runs, whose ten intervals may all hold the truth or all miss it: exceeded once in
/// a hundred times.
fn allowance(of_tests: &[(TestLayout, Vec<Run>)]) -> f64 {
    let runs: usize = of_tests.iter().map(|(_, runs)| runs.len()).sum();
    if long() { 0.0 } else { 2.3 * (0.95 * 0.05 / runs as f64).sqrt() }
}

/// Sensors that are 5 % off and a hammer that is 2 % off, tumbled and held against a block of known mass; then each of
/// the four tests.
#[test]
fn after_the_two_calibrations_the_intervals_hold() {
    let bench = steady_hand("uncalibrated");
    let mut of_tests = THREE_BAR_TESTS.map(|test| (layout_of(test, None), Vec::new()));
    let [mut gain, mut cross_axis, mut hammer] = [const { Vec::new() }; 3];
    for number in 0..runs() {
        let master = SEED + number;
        let mut silent = Output::to(false, io::sink(), io::sink());
        let parts = seed_of_run(master, 0);
        let record: CalibrationRecord =
            calibrate(parts, &mut silent).expect("both calibrations succeed");
        let left =
            sensitivity_errors(&bench, parts, &record).expect("has the sensors of the bench");
        gain.extend(left.gain);
        cross_axis.extend(left.cross_axis);
        hammer.push(left.hammer);
        for (test, (_, runs)) in THREE_BAR_TESTS.iter().zip(&mut of_tests) {
            let layout = layout_of(test, record.budget());
            runs.push(run(&bench, &layout, &record.calibration, master));
        }
    }
    // What the calibrations leave in truth, whatever they state.
    let rms =
        |errors: &[f64]| (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    let mut calibrated = bench.clone();
    calibrated.sensor.gain_sigma = rms(&gain);
    calibrated.sensor.cross_axis_sigma = rms(&cross_axis);
    calibrated.hammer.gain_sigma = rms(&hammer);
    let [exact, learned] = compare(&calibrated, &of_tests);
    show("nothing stated, calibrated", [exact, learned]);
    let few = allowance(&of_tests);
    assert!((0.92 - few..=0.98 + few).contains(&learned.coverage), "{learned:?}");
    // The rms of twelve runs scatters by a fifth.
    assert!(learned.error <= if long() { 1.10 } else { 1.6 }, "{learned:?}");
    assert!(learned.width <= 1.3 * exact.width, "{learned:?} {exact:?}");
}

/// A hammer out of the box, whose error is drawn from its 2 %.
#[test]
fn with_an_uncalibrated_hammer_the_intervals_hold() {
    let mut bench = steady_hand("default");
    bench.hammer.gain_sigma = 0.02;
    let calibration = nominal_calibration(&bench);
    let of_tests = THREE_BAR_TESTS.map(|test| {
        let layout = layout_of(test, None);
        let runs = (0..runs()).map(|n| run(&bench, &layout, &calibration, SEED + n)).collect();
        (layout, runs)
    });
    let [exact, learned] = compare(&bench, &of_tests);
    show("nothing stated, not calibrated, hammer off by 2 %", [exact, learned]);
    let few = allowance(&of_tests);
    assert!((0.93 - few..=0.98 + few).contains(&learned.coverage), "{learned:?}");
    assert!(learned.width <= 1.2 * exact.width, "{learned:?} {exact:?}");
}

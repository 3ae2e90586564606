//! Each disturbance of a real bench alone: how far it shifts the answer, whether the intervals still hold, and
//! whether the result says so.
//!
//! `MASSLINE_LONG=1 cargo test --release -p massline-tests --test system -- disturbances:: --nocapture` prints a table.

mod row;
mod table;

use massline::support::bench_test::nominal_calibration;
use massline_analysis::monte_carlo::measurement::TestLayout;
use massline_analysis::monte_carlo::{MonteCarlo, Run, seed_of_run};
use massline_physics::{Bench, BenchSource};
use massline_report::words::cannot_see;
use massline_tests::campaign::{THREE_BAR_TESTS, layout_file, steady_hand, with_calibrated_hammer};
use massline_tests::long;

use crate::disturbances::row::Row;
use crate::disturbances::table::{ALL, CANNOT_BE_SEEN, Disturbance, boards};

/// Chosen before the first run.
const SEED: u64 = 20_261_123;

/// Runs of each of two tests.
fn runs() -> u64 {
    if long() { 400 } else { 6 }
}

/// Tests 1 and 4.
const TESTS: [&str; 2] = [THREE_BAR_TESTS[0], THREE_BAR_TESTS[3]];

fn measured(bench: &Bench, layout: &TestLayout) -> Vec<Run> {
    let calibration = nominal_calibration(bench);
    let study = MonteCarlo {
        bench,
        layout,
        calibration: &calibration,
        seed: SEED,
        runs: runs(),
        threads: None,
    };
    study.runs(&|| false, |_| ()).expect("the bench takes the layout")
}

/// The runs under a disturbance, each beside the undisturbed one of the same seed.
fn row_of(disturbance: &Disturbance, undisturbed: &[Vec<Run>; 2]) -> Row {
    let mut bench = steady_hand("default");
    (disturbance.change)(&mut bench);
    let truth: [f64; 10] = bench.truth().theta().into();
    let mut row = Row::default();
    for (test, text) in TESTS.iter().enumerate() {
        let mut layout = with_calibrated_hammer(text);
        let host = layout_file(text).layout;
        if disturbance.declared_kg > 0.0 {
            let declared = boards(&layout.sensors, disturbance.declared_kg);
            layout.attached.push(declared).expect("a layout has room for an attached body");
        }
        let runs = measured(&bench, &layout);
        for ((number, run), before) in (0..).zip(&runs).zip(&undisturbed[test]) {
            if let (Ok(run), Ok(before)) = (run, before) {
                row.add(test, run, before, &truth);
                let source = BenchSource::new(&bench, &host, seed_of_run(SEED, number));
                row.hits.add(run, &mut source.expect("the bench takes the layout"));
            }
        }
    }
    row
}

#[test]
fn a_result_lists_what_it_cannot_see() {
    let mut layout = layout_file(TESTS[0]).layout;
    (layout.apparatus.hammer_gain, layout.calibrated_hammer) = (0.0, false);
    let listed = cannot_see(&layout, None, true);
    for (name, source) in CANNOT_BE_SEEN {
        assert!(ALL.iter().any(|disturbance| disturbance.name == name), "{name}");
        assert!(listed.iter().any(|unseen| unseen.source == source), "{name}: {source}");
    }
}

#[test]
fn each_disturbance_alone() {
    let healthy = steady_hand("default");
    let undisturbed = TESTS.map(|test| measured(&healthy, &with_calibrated_hammer(test)));
    println!(
        "| disturbance | shift, sd | z rms | coverage, % | warned, % | silent, % | hits rejected rightly | wrongly | \
         bad taps accepted | why |"
    );
    let mut silent = None;
    for disturbance in ALL {
        let row = row_of(disturbance, &undisturbed);
        println!("| {} | {row}", disturbance.name);
        // A test without an answer is in none of the shares.
        if disturbance.answers {
            assert_eq!(row.runs, 2 * runs(), "{}: each test has an answer", disturbance.name);
        }
        row.judge(disturbance, *silent.get_or_insert(row.silent()));
    }
}

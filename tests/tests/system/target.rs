//! Campaigns that stop at the `[target]` of their layout, over the whole chain from ADC codes to the ten
//! properties: stopping when the intervals are narrow enough must not make them promise too much.
//!
//! `MASSLINE_LONG=1 cargo test --release -p massline-tests --test system -- target:: --nocapture` prints the table of
//! tests/README.md.

use massline::support::bench_test::nominal_calibration;
use massline_analysis::monte_carlo::measurement::TestLayout;
use massline_analysis::monte_carlo::statistics::StoppingStatistics;
use massline_analysis::monte_carlo::{MonteCarlo, Study};
use massline_shared::layout::Target;
use massline_tests::campaign::{
    THREE_BAR_TESTS, steady_hand, with_calibrated_hammer, with_every_dof,
};
use massline_tests::long;

/// Chosen before the first run.
const SEED: u64 = 20_261_123;

/// The target of the template.
const TEMPLATE: Target<f64> = Target { mass: Some(0.01), center: Some(0.001), inertia: Some(0.02) };

/// Campaigns of each of the four tests.
fn runs() -> u64 {
    if long() { 100 } else { 3 }
}

/// The campaigns of one test with this target.
fn campaigns(layout: &TestLayout, target: Target<f64>) -> StoppingStatistics {
    study(layout, target).stopping.expect("the layout has a target")
}

fn study(layout: &TestLayout, target: Target<f64>) -> Study {
    let bench = steady_hand("default");
    let calibration = nominal_calibration(&bench);
    let layout = TestLayout { target, ..layout.clone() };
    let monte_carlo = MonteCarlo {
        bench: &bench,
        layout: &layout,
        calibration: &calibration,
        seed: SEED,
        runs: runs(),
        threads: None,
    };
    monte_carlo.run(&|| false, |_| ()).expect("the bench takes the layout")
}

fn pooled(of_tests: &[StoppingStatistics]) -> StoppingStatistics {
    of_tests.iter().fold(StoppingStatistics::default(), |mut sum, test| {
        sum.hits = test.hits;
        sum.runs += test.runs;
        sum.reached += test.reached;
        sum.hits_saved += test.hits_saved;
        for k in 0..2 {
            sum.at_target[k] += test.at_target[k];
            sum.missed[k] += test.missed[k];
        }
        sum
    })
}

fn row(name: &str, statistics: &StoppingStatistics) {
    let percent = |share: Option<f64>| share.map_or("-".into(), |s| format!("{:.1} %", 100.0 * s));
    println!(
        "| {name} | {} of {} | {:.1} of {} | {} | {} |",
        statistics.reached,
        statistics.runs,
        statistics.mean_hits_saved(),
        statistics.hits,
        percent(statistics.coverage95()),
        percent(statistics.coverage95_at_target()),
    );
}

/// Allowance for the coverage of few runs, absolute; none with `MASSLINE_LONG`. The intervals of a run may all
/// hold the truth or all miss it; 2.6 deviations are exceeded once in a hundred times.
fn allowance(runs: u64) -> f64 {
    if long() { 0.0 } else { 2.6 * (0.95 * 0.05 / runs as f64).sqrt() }
}

#[test]
fn intervals_at_the_stop_hold_the_truth_as_often_as_stated() {
    let targets = [
        ("the template's", TEMPLATE),
        ("twice as wide", Target { mass: Some(0.02), center: Some(0.002), inertia: Some(0.04) }),
        ("mass 1.5 % alone", Target { mass: Some(0.015), ..Target::default() }),
    ];
    println!(
        "| target | test | reached | hits saved | coverage at the stop | of those at the target |"
    );
    println!("| --- | --- | --- | --- | --- | --- |");
    for (name, target) in targets {
        let tests: Vec<_> = (1..)
            .zip(THREE_BAR_TESTS)
            .map(|(number, test)| {
                let of_test = campaigns(&with_every_dof(with_calibrated_hammer(test)), target);
                row(&format!("{name} | {number}"), &of_test);
                of_test
            })
            .collect();
        let total = pooled(&tests);
        row(&format!("{name} | all"), &total);
        assert_eq!(total.runs, 4 * runs(), "every campaign has mass lines");
        let coverage = total.coverage95().expect("has answers");
        let allowed = 0.92 - allowance(total.runs)..=0.98 + allowance(total.runs);
        assert!(allowed.contains(&coverage), "{name}: {total:?}");
        assert!(total.reached > 0 && total.hits_saved > 0, "{name}: {total:?}");
        // Those that reached their target, and so might have stopped because they were wrong.
        let coverage = total.coverage95_at_target().expect("some have reached it");
        let allowed = 0.92 - allowance(total.reached)..=0.98 + allowance(total.reached);
        assert!(allowed.contains(&coverage), "{name}: {total:?}");
    }
}

/// The same campaigns without a target, to compare with.
#[test]
fn intervals_of_all_dofs_hold_the_truth_as_often_as_stated() {
    let tests = THREE_BAR_TESTS.map(|test| {
        let study = study(&with_every_dof(with_calibrated_hammer(test)), Target::default());
        assert_eq!(study.stopping, None);
        study.methods[0].pooled_coverage95().expect("has answers")
    });
    let coverage = tests.iter().sum::<f64>() / 4.0;
    println!("without a target, all twelve DOFs: {:.1} %", 100.0 * coverage);
    let allowed = 0.92 - allowance(4 * runs())..=0.98 + allowance(4 * runs());
    assert!(allowed.contains(&coverage), "{tests:?}");
}

/// The three DOFs of the shipped layouts are the fewest that determine the ten properties: no target can
/// leave one out.
#[test]
fn a_campaign_of_three_dofs_has_nothing_to_save() {
    let layout = with_calibrated_hammer(THREE_BAR_TESTS[0]);
    let of_test = campaigns(&layout, Target { mass: Some(0.5), ..Target::default() });
    assert_eq!((of_test.reached, of_test.hits_saved), (of_test.runs, 0));
}

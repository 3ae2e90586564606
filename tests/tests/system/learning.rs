//! The error budget learned from the data, over the whole chain from ADC codes to the ten properties: benches
//! whose errors are smaller, as large and larger than the stated ones.
//!
//! `MASSLINE_LONG=1 cargo test --release -p massline-tests --test system -- learning:: --nocapture` prints the table of
//! tests/README.md.

use massline::support::bench_test::nominal_calibration;
use massline_analysis::monte_carlo::statistics::MethodStatistics;
use massline_analysis::monte_carlo::{MonteCarlo, apply_bench_budget};
use massline_physics::Bench;
use massline_shared::identify::Method;
use massline_shared::layout::{HitUncertainty, SensorUncertainty};
use massline_tests::campaign::{THREE_BAR_TESTS, steady_hand, with_calibrated_hammer};
use massline_tests::long;
use massline_tests::pooled::{PooledStatistics, pooled, solved_again};

/// Chosen before the first run.
const SEED: u64 = 20_261_122;

/// Runs of each of the four tests.
fn runs() -> u64 {
    if long() { 1000 } else { 10 }
}

/// The errors of a bench, as multiples of the stated budget, which is the default one.
#[derive(Clone, Copy, Debug)]
struct Errors {
    hits: f64,
    sensors: f64,
}

/// A bench with these errors, or the default bench, whose person only hits well.
fn bench(errors: Option<Errors>) -> Bench {
    let mut bench = steady_hand("default");
    if let Some(Errors { hits, sensors }) = errors {
        let (hit, sensor) = (HitUncertainty::<f64>::default(), SensorUncertainty::<f64>::default());
        bench.tap.point_sigma_m = hit.position * hits;
        bench.tap.direction_sigma_rad = hit.direction * hits;
        bench.tap.mark_position_sigma_m = hit.node_position * sensors;
        bench.tap.mark_direction_sigma_rad = hit.node_direction * sensors;
        bench.sensor.position_sigma_m = sensor.position * sensors;
        bench.sensor.rotation_sigma_rad = sensor.rotation * sensors;
        bench.sensor.gain_sigma = sensor.gain * sensors;
        bench.sensor.cross_axis_sigma = sensor.cross_axis * sensors;
    }
    bench
}

/// The true budget stated, the default budget stated, and the default budget as the start of learning.
fn compare(bench: &Bench) -> [PooledStatistics; 3] {
    let calibration = nominal_calibration(bench);
    let mut of_tests = [const { Vec::new() }; 3];
    for test in THREE_BAR_TESTS {
        let layout = with_calibrated_hammer(test);
        let mut exact = layout.clone();
        apply_bench_budget(&mut exact, bench);
        let study = MonteCarlo {
            bench,
            layout: &layout,
            calibration: &calibration,
            seed: SEED,
            runs: runs(),
            threads: None,
        };
        let runs = study.runs(&|| false, |_| ()).expect("the bench takes the layout");
        let mut methods = study.study(&runs).methods;
        let learned = methods.swap_remove(0);
        assert_eq!(learned.method, Some(Method::MaximumLikelihood));
        // Missing answers would be the worst ones. With errors of twice the budget one fit of several thousand does not
        // converge, and its result says so.
        let unanswered = learned.unanswered;
        assert!(500 * unanswered <= runs.len(), "{unanswered} tests have no answer");
        let bound: Vec<f64> =
            learned.properties.iter().map(|p| p.bound.expect("has one")).collect();
        let bound = bound.try_into().expect("ten properties");
        let truth = bench.truth().theta().into();
        let statistics = |layout| {
            let answers = solved_again(&runs, layout);
            MethodStatistics::of(Some(Method::MaximumLikelihood), &answers, &truth, Some(&bound))
        };
        for (list, of_test) in
            of_tests.iter_mut().zip([statistics(&exact), statistics(&layout), learned])
        {
            list.push(of_test);
        }
    }
    of_tests.map(|of_budget| pooled(&of_budget))
}

/// Allowances for the statistics of few runs; none with `MASSLINE_LONG`.
///
/// The rms of N normal errors deviates by `1/√(2N)`, relative, and the intervals of a run may all hold the
/// truth or all miss it; 2.3 deviations are exceeded once in a hundred times.
fn allowances() -> (f64, f64) {
    if long() {
        return (0.0, 0.0);
    }
    let tests = (THREE_BAR_TESTS.len() as u64 * runs()) as f64;
    (2.3 / (2.0 * tests).sqrt(), 2.3 * (0.95 * 0.05 / tests).sqrt())
}

/// One bench and what learning has to reach on it.
struct Case {
    name: &'static str,
    errors: Option<Errors>,
    coverage: [f64; 2],
    /// Largest rms error over the bound.
    error: f64,
    /// Largest width of the intervals over that with the true budget stated.
    width: Option<f64>,
}

#[test]
fn learned_intervals_hold_whatever_the_errors_of_the_bench_are() {
    let scale = |hits, sensors| Some(Errors { hits, sensors });
    let usual = [0.915, 0.975];
    let width = Some(1.25);
    let cases = [
        Case {
            name: "0.5 × stated", errors: scale(0.5, 0.5), coverage: usual, error: 1.10, width
        },
        Case { name: "1 × stated", errors: scale(1.0, 1.0), coverage: usual, error: 1.10, width },
        Case { name: "2 × stated", errors: scale(2.0, 2.0), coverage: usual, error: 1.15, width },
        Case { name: "default bench", errors: None, coverage: usual, error: 1.10, width },
        Case {
            name: "sensors 2 ×, hits 0.5 ×",
            errors: scale(0.5, 2.0),
            coverage: usual,
            error: 1.10,
            width,
        },
        // The sensors are so much better than the hits that the second-order terms of the hits remain.
        Case {
            name: "hits 2 ×, sensors 0.5 ×",
            errors: scale(2.0, 0.5),
            coverage: [0.90, 1.0],
            error: 1.25,
            width: None,
        },
    ];
    let (of_error, of_coverage) = allowances();
    println!("| errors | true budget stated | default budget stated | learned |");
    println!("| --- | --- | --- | --- |");
    for case in cases {
        let [exact, stated, learned] = compare(&bench(case.errors));
        let show = |p: PooledStatistics| {
            format!("{:.1} %, {:.2}, {:.2}", 100.0 * p.coverage, p.error, p.width)
        };
        println!("| {} | {} | {} | {} |", case.name, show(exact), show(stated), show(learned));
        let [least, most] = case.coverage;
        let allowed = least - of_coverage..=most + of_coverage;
        assert!(allowed.contains(&learned.coverage), "{}: {learned:?}", case.name);
        assert!(learned.error <= case.error * (1.0 + of_error), "{}: {learned:?}", case.name);
        let wider = learned.width / exact.width;
        // The mean width of few runs hardly scatters.
        assert!(case.width.is_none_or(|most| wider <= most), "{}: {wider}", case.name);
    }
}

/// Hits of 12 to 40 N with the true budget stated.
#[test]
fn hits_of_unequal_force_are_averaged_to_the_bound() {
    let mut bench = bench(None);
    bench.tap.force_n = [12.0, 40.0];
    let [exact, ..] = compare(&bench);
    println!("12 to 40 N: {exact:?}");
    let (of_error, of_coverage) = allowances();
    let allowed = 0.93 - of_coverage..=0.97 + of_coverage;
    assert!(allowed.contains(&exact.coverage), "{exact:?}");
    assert!(exact.error <= 1.10 * (1.0 + of_error), "{exact:?}");
}

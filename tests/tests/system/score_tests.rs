//! Score tests of small faults over many simulated tests: how often a healthy one is suspected, how often a fault that
//! the data show is named, and how often it is not while the answer is wrong.
//!
//! `MASSLINE_LONG=1 cargo test --release -p massline-tests --test system -- score_tests:: --nocapture` prints the
//! tables of tests/README.md.

use massline_analysis::parallel::each;
use massline_physics::{Bench, ErrorsFrom};
use massline_result::Verdict;
use massline_shared::identify::Estimate;
use massline_tests::campaign::{THREE_BAR_TESTS, layout_file, steady_hand};
use massline_tests::long;
use massline_tests::mistakes::{measured_tests, small};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Chosen before the first run.
const SEED: u64 = 20_261_201;
/// A fault is there for all to see beyond this deviate: 3.57 standard deviations of a size of either sign, which chance
/// makes once in three thousand tests.
const SEEN: f64 = 3.31;
/// An answer is wrong when a property is off by more than so many of its standard deviations.
const WRONG: f64 = 3.0;

/// The benches: the errors of the default bench, and errors as large as the layout states.
fn benches() -> [(&'static str, Bench); 2] {
    let default = steady_hand("default");
    let stated = Bench { errors: ErrorsFrom::Layout, ..default.clone() };
    [("default bench", default), ("errors as stated", stated)]
}

#[test]
fn a_healthy_test_shows_hardly_ever_a_small_fault() {
    let runs = if long() { 1000 } else { 10 };
    for (name, bench) in benches() {
        let (mut alarms, mut untested, mut total) = (0, 0, 0_usize);
        for text in THREE_BAR_TESTS {
            let measured = measured_tests(&bench, text, runs, SEED);
            for tests in each(&measured, || (), |(), test| test.score_tests()) {
                let Some((_, tests)) = tests else { continue };
                // An answer that was held to a physical body is no minimum, and not tested.
                untested += usize::from(tests.tests.is_empty());
                alarms += usize::from(!tests.shown().is_empty());
                total += 1;
            }
        }
        println!("{name}: {alarms} of {total} healthy tests are suspected, {untested} not tested");
        assert!(untested <= total / 100, "{name}: {untested} of {total} not tested");
        // 0.7 % with errors as stated; of few tests two may be.
        assert!(alarms <= (total / 100).max(2), "{name}: {alarms} of {total}");
    }
}

/// What becomes of the tests with one kind of fault.
#[derive(Default)]
struct Row {
    tests: usize,
    wrong: usize,
    /// Wrong and called good.
    silent: usize,
    /// The fault is seen by who knows the errors of the bench.
    seen: usize,
    /// Of these: named; named alone; wrong and called good.
    named: usize,
    named_alone: usize,
    silent_seen: usize,
}

fn is_wrong(answer: &Estimate<f64>, truth: &[f64; 10]) -> bool {
    let Some(sigma) = answer.sigma() else { return true };
    let theta = answer.theta();
    (0..10).any(|k| (theta[k] - truth[k]).abs() > WRONG * sigma[k])
}

/// Tests with this kind of fault, each on a bench of its own.
fn row(bench: &Bench, kind: &small::Kind, runs: usize, random: &mut ChaCha8Rng) -> Row {
    let truth: [f64; 10] = bench.truth().theta().into();
    let mut row = Row::default();
    for text in THREE_BAR_TESTS {
        let layout = layout_file(text).layout;
        let mut draws = Vec::new();
        for _ in 0..runs {
            let mut wrong = bench.clone();
            let fault = (kind.make)(&mut wrong, &layout, random);
            // A layout may have no room for it.
            if fault.is_some() || !kind.is_tested {
                draws.push((wrong, fault, random.random()));
            }
        }
        let judged = each(
            &draws,
            || (),
            |(), (bench, fault, seed)| {
                let test = measured_tests(bench, text, 1, *seed).into_iter().next()?;
                let (answer, tests) = test.score_tests()?;
                let shown = tests.shown();
                let wrong = is_wrong(&answer, &truth);
                // What shows is a reason of the verdict.
                let is_good =
                    || test.judge().1.is_some_and(|judgement| judgement.verdict() == Verdict::Good);
                let silent = wrong && shown.is_empty() && is_good();
                let seen = fault.and_then(|fault| test.seen_with_true_budget(fault, bench));
                let named = shown.iter().any(|test| Some(test.fault) == *fault);
                Some((
                    wrong,
                    silent,
                    seen.is_some_and(|z| z > SEEN),
                    named,
                    named && shown.len() == 1,
                ))
            },
        );
        for (wrong, silent, seen, named, alone) in judged.into_iter().flatten() {
            row.tests += 1;
            row.wrong += usize::from(wrong);
            row.silent += usize::from(silent);
            row.seen += usize::from(seen);
            row.named += usize::from(seen && named);
            row.named_alone += usize::from(seen && alone);
            row.silent_seen += usize::from(seen && silent);
        }
    }
    row
}

#[test]
fn a_small_fault_that_is_seen_is_named() {
    let runs = if long() { 200 } else { 2 };
    println!(
        "| fault | bench | tests | wrong | silent | seen | named | alone | silent though seen |"
    );
    // Where the errors are as stated the program knows as much as who sees the fault. On the default bench they are
    // smaller, which it has to learn from a handful of readings.
    for ((name, bench), [least_named, most_silent]) in
        benches().into_iter().zip([[0.5, 0.1], [0.9, 0.02]])
    {
        let mut sum = Row::default();
        for kind in small::ALL {
            let mut random = ChaCha8Rng::seed_from_u64(SEED);
            let row = row(&bench, kind, runs, &mut random);
            let Row { tests, wrong, silent, seen, named, named_alone, silent_seen } = row;
            println!(
                "| {} | {name} | {tests} | {wrong} | {silent} | {seen} | {named} | {named_alone} | {silent_seen} |",
                kind.name
            );
            sum.seen += seen;
            sum.named += named;
            sum.silent_seen += silent_seen;
        }
        assert!(sum.seen > 0, "{name}: no fault was large enough to be seen");
        // Of few tests, chance decides how many more or fewer.
        let few = if long() { 0.0 } else { 0.4 };
        let share = |count: usize| count as f64 / sum.seen as f64;
        assert!(
            share(sum.named) >= least_named - few,
            "{name}: named {} of {}",
            sum.named,
            sum.seen
        );
        assert!(share(sum.silent_seen) <= most_silent + few, "{name}: silent {}", sum.silent_seen);
    }
}

//! The search for a single mistake over many simulated tests: how often a healthy one is suspected, and how often the
//! culprit is named, for mistakes of each kind with sizes drawn at random.
//!
//! `MASSLINE_LONG=1 cargo test --release -p massline-tests --test system -- single_mistakes:: --nocapture` draws more
//! of them and prints the counts.

use std::collections::BTreeMap;

use massline_analysis::single_fault::{Examination, Outcome};
use massline_physics::Bench;
use massline_tests::campaign::{FIVE_HITS, THREE_BAR_TESTS, half_as_well, steady_hand};
use massline_tests::long;
use massline_tests::mistakes::{Culprit, MeasuredTest, measured_tests, written};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Chosen before the first run.
const SEED: u64 = 20_261_127;

/// Healthy tests on a bench, `runs` of each layout.
fn healthy(bench: &Bench, layouts: &[&str], runs: u64, seed: u64) -> Vec<MeasuredTest> {
    layouts.iter().flat_map(|text| measured_tests(bench, text, runs, seed)).collect()
}

/// What the search says, in one word.
fn outcome(examination: &Examination) -> &'static str {
    match examination.outcome {
        Outcome::NothingSuspicious => "nothing",
        Outcome::Suspected(_) => "suspected",
        Outcome::LargerErrors(_) => "larger errors",
        Outcome::Unexplained => "unexplained",
    }
}

#[test]
fn a_healthy_test_is_hardly_ever_suspected() {
    let runs = if long() { 500 } else { 6 };
    let usual = steady_hand("default");
    let sloppy = half_as_well(usual.clone());
    for (name, bench) in [("default bench", usual), ("a person who hits half as well", sloppy)] {
        let mut layouts = THREE_BAR_TESTS.to_vec();
        layouts.push(FIVE_HITS);
        let tests = healthy(&bench, &layouts, runs, SEED);
        let mut counts = BTreeMap::new();
        let mut suspected = Vec::new();
        for test in &tests {
            let examination = test.examine();
            *counts.entry(outcome(&examination)).or_insert(0) += 1;
            if let [first, ..] = examination.suspects() {
                suspected.push(first.mistake);
            }
        }
        println!("{name}: {} tests: {counts:?}", tests.len());
        // One in a hundred is allowed; of few tests none is likely.
        assert!(suspected.len() <= tests.len() / 100, "{name}: {suspected:?}");
    }
}

#[test]
fn the_culprit_is_named() {
    let runs = if long() { 40 } else { 2 };
    let mistakes = if long() { 200 } else { 2 };
    let bench = steady_hand("default");
    for (name, layouts, least) in
        [("tests 1 to 4", &THREE_BAR_TESTS[..], 0.8), ("five hits", &[FIVE_HITS][..], 0.8)]
    {
        let tests = healthy(&bench, layouts, runs, SEED + 1);
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        let (mut all_named, mut all_noticed) = (0, 0);
        for kind in written::NAMED {
            let mut counts = BTreeMap::new();
            let (mut named, mut noticed, mut first, mut total) = (0, 0, 0, 0);
            while total < mistakes {
                let mut test = tests[random.random_range(0..tests.len())].clone();
                let Some(Culprit::Suspect(is_culprit)) = (kind.make)(&mut test, &mut random) else {
                    continue;
                };
                total += 1;
                let examination = test.examine();
                *counts.entry(outcome(&examination)).or_insert(0) += 1;
                noticed += usize::from(examination.outcome != Outcome::NothingSuspicious);
                let suspects = examination.suspects();
                named += usize::from(suspects.iter().any(|suspect| is_culprit(&suspect.mistake)));
                first += usize::from(suspects.first().is_some_and(|s| is_culprit(&s.mistake)));
            }
            println!(
                "{name}: {}: of {total} noticed {noticed}, named {named}, first {first}; {counts:?}",
                kind.name
            );
            all_named += named;
            all_noticed += noticed;
        }
        // Nine of ten are named; of few draws the seed, chosen before, decides how many more or fewer.
        let share = all_named as f64 / all_noticed as f64;
        println!("{name}: named {share:.3} of those that are noticed");
        assert!(share > least, "{name}: {share}");
    }
}

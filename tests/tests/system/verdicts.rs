//! The verdict over many simulated tests: how often a healthy one is not called good, and by which concern; and what
//! becomes of tests with a mistake.
//!
//! `MASSLINE_LONG=1 cargo test --release -p massline-tests --test system -- verdicts:: --nocapture` prints the tables
//! of tests/README.md.

use std::collections::BTreeMap;

use massline_physics::{Bench, ErrorsFrom};
use massline_result::Verdict;
use massline_shared::identify::Estimate;
use massline_tests::campaign::{THREE_BAR_TESTS, steady_hand};
use massline_tests::long;
use massline_tests::mistakes::{Culprit, MeasuredTest, measured_tests, set_up, written};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Chosen before the first run.
const SEED: u64 = 20_261_128;

#[test]
fn healthy_tests_are_good() {
    let runs = if long() { 1000 } else { 4 };
    let default = Bench::named("default").expect("is bundled");
    // As rough as the layout states, which the default bench is not.
    let stated = Bench { errors: ErrorsFrom::Layout, ..default.clone() };
    for (name, bench) in [("default bench", default), ("errors as stated", stated)] {
        let (mut verdicts, mut codes, mut total) = (BTreeMap::new(), BTreeMap::new(), 0_usize);
        for test in THREE_BAR_TESTS.iter().flat_map(|text| measured_tests(&bench, text, runs, SEED))
        {
            let judgement = test.judge().1.expect("healthy tests have an answer");
            *verdicts.entry(judgement.verdict()).or_insert(0_usize) += 1;
            let mut seen: Vec<_> = judgement.concerns.iter().map(|c| c.code()).collect();
            seen.dedup();
            seen.into_iter()
                .for_each(|code| *codes.entry(code.to_string()).or_insert(0_usize) += 1);
            total += 1;
        }
        println!("{name}: {total} tests: {verdicts:?}; by code {codes:?}");
        assert_eq!(total, 4 * runs as usize, "{name}: each healthy test has mass lines");
        // Four of ten thousand; of few tests none.
        let unusable = verdicts.get(&Verdict::DoNotUse).copied().unwrap_or(0);
        assert!(unusable <= total / 2500, "{name}: {unusable} of {total} are not to be used");
        for (code, count) in codes {
            // 3 %; of few tests two may have the same warning by chance.
            assert!(count <= (total * 3 / 100).max(2), "{name}: {count} of {total} have {code}");
        }
    }
}

/// An answer is wrong when a property is off by more than so many of its standard deviations, which of ten properties
/// chance makes once in two hundred thousand.
const WRONG: f64 = 5.0;

/// What becomes of the tests with one kind of mistake.
#[derive(Default)]
struct Row {
    tests: usize,
    /// Without an answer.
    refused: usize,
    verdicts: BTreeMap<Verdict, usize>,
    named: usize,
    /// Wrong answers, and how many of them are exported and called good.
    wrong: [usize; 3],
}

impl Row {
    fn add(&mut self, measured: &MeasuredTest, culprit: &Culprit, truth: &[f64; 10]) {
        self.tests += 1;
        let (identification, judgement) = measured.judge();
        let (Some(answer), Some(judgement)) = (identification.estimates.first(), judgement) else {
            self.refused += 1;
            return;
        };
        let verdict = judgement.verdict();
        *self.verdicts.entry(verdict).or_default() += 1;
        self.named += usize::from(culprit.is_named_in(&judgement));
        let is_wrong = is_wrong(answer, truth);
        let exported = verdict != Verdict::DoNotUse;
        let among = [true, exported, verdict == Verdict::Good];
        for (count, is_among) in self.wrong.iter_mut().zip(among) {
            *count += usize::from(is_wrong && is_among);
        }
    }

    fn count(&self, verdict: Verdict) -> usize {
        self.verdicts.get(&verdict).copied().unwrap_or(0)
    }

    fn print(&self, name: &str, is_listed: bool) {
        let named = if is_listed { self.named.to_string() } else { String::new() };
        let [good, care, not] =
            [Verdict::Good, Verdict::UseWithCare, Verdict::DoNotUse].map(|v| self.count(v));
        let [wrong, exported, called_good] = self.wrong;
        println!(
            "| {name} | {} | {} | {good} | {care} | {not} | {named} | {wrong} | {exported} | {called_good} |",
            self.tests, self.refused
        );
    }
}

fn is_wrong(answer: &Estimate<f64>, truth: &[f64; 10]) -> bool {
    let Some(sigma) = answer.sigma() else { return true };
    let theta = answer.theta();
    (0..10).any(|k| (theta[k] - truth[k]).abs() > WRONG * sigma[k])
}

#[test]
fn a_wrong_answer_does_not_look_clean() {
    let (runs, draws) = if long() { (25, 100) } else { (1, 2) };
    let bench = steady_hand("default");
    let truth: [f64; 10] = bench.truth().theta().into();
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    println!(
        "| mistake | tests | no answer | good | use with care | do not use | named | wrong | and exported | and called \
         good |"
    );
    let mut rows = Vec::new();
    let healthy: Vec<_> = THREE_BAR_TESTS
        .iter()
        .flat_map(|text| measured_tests(&bench, text, runs, SEED + 1))
        .collect();
    for kind in written::NAMED.iter().chain(written::ON_NO_LIST) {
        let mut row = Row::default();
        let mut is_listed = false;
        while row.tests < draws {
            let mut test = healthy[random.random_range(0..healthy.len())].clone();
            if let Some(culprit) = (kind.make)(&mut test, &mut random) {
                is_listed = !matches!(culprit, Culprit::OnNoList);
                row.add(&test, &culprit, &truth);
            }
        }
        row.print(kind.name, is_listed);
        rows.push(row);
    }
    for kind in set_up::ALL {
        let mut row = Row::default();
        let mut is_listed = false;
        for draw in 0..draws {
            let mut wrong = bench.clone();
            let culprit = (kind.make)(&mut wrong, &mut random);
            is_listed = !matches!(culprit, Culprit::OnNoList);
            let text = THREE_BAR_TESTS[draw % THREE_BAR_TESTS.len()];
            let tests = measured_tests(&wrong, text, 1, random.random());
            // A test without a hit that passes has no answer.
            row.refused += usize::from(tests.is_empty());
            row.tests += usize::from(tests.is_empty());
            tests.iter().for_each(|test| row.add(test, &culprit, &truth));
        }
        row.print(kind.name, is_listed);
        rows.push(row);
    }
    let sum = |count: fn(&Row) -> usize| rows.iter().map(count).sum::<usize>();
    let [wrong, exported, called_good] =
        [sum(|row| row.wrong[0]), sum(|row| row.wrong[1]), sum(|row| row.wrong[2])];
    println!("of {wrong} wrong answers {exported} are exported and {called_good} called good");
    // Measured: one of a hundred is exported, and fewer are called good; of few tests three may be.
    assert!(
        wrong > rows.len() * draws.min(3) / 3,
        "{wrong} wrong answers: the mistakes are too small"
    );
    assert!(exported <= (wrong / 50).max(3), "{exported} of {wrong}");
    assert!(called_good <= (wrong / 100).max(2), "{called_good} of {wrong}");
}

//! The verdict over many simulated tests: how often a healthy one is not called good, and by which concern.
//!
//! `MASSLINE_LONG=1 cargo test --release -p massline-tests --test verdicts -- --nocapture` prints the tables of
//! tests/README.md.

use std::collections::BTreeMap;

use massline::commands::bench_test::nominal_calibration;
use massline::identification::{Selection, identify};
use massline::interrupt::Interrupt;
use massline::judgement::{Evidence, Judgement};
use massline::monte_carlo::MonteCarlo;
use massline::monte_carlo::measurement::{SimulatedTest, TestLayout};
use massline::single_fault::examine;
use massline::suspension::{MassLineAnswers, compare, reciprocity_of_mass_lines};
use massline::verdict::Verdict;
use massline_shared::identify::{DofMassLines, IdentifySettings, Observations};
use massline_shared::layout::{HOST_SENSORS, HostLayout};
use massline_tests::campaign::{THREE_BAR_TESTS, layout_file};
use massline_tests::long;
use massline_virtual::bench::{Bench, ErrorsFrom};

/// Chosen before the first run.
const SEED: u64 = 20_261_128;

/// The verdict as the program comes to it from the mass lines of a test.
fn judge(test: &SimulatedTest, layout: &HostLayout, nodes: &[(u16, [f64; 3])]) -> Judgement {
    let lines: Vec<DofMassLines<f64, HOST_SENSORS>> =
        test.dofs.iter().map(|(index, lines)| (*index, lines.resized())).collect();
    let observed = Observations::of_mass_lines(layout, &lines);
    let settings = IdentifySettings::default();
    let found = identify(&observed, Selection::All, &settings);
    let examination = examine(layout, nodes, &lines);
    let answers = MassLineAnswers {
        budget: layout.clone(),
        lines: &lines,
        settings: settings.inertia_restraint,
        estimates: &found.estimates,
    };
    let comparison = compare(&answers, |_, _| ());
    let reciprocity = reciprocity_of_mass_lines(layout, &lines).to_vec();
    let evidence = Evidence {
        examination: Some(&examination),
        comparison: Some(&comparison),
        refusals: found.refusals(),
        diagnostics: [found.priors.as_slice(), &reciprocity, &test.diagnostics].concat(),
        ..Evidence::of(found.estimates.first().expect("healthy tests have an answer"))
    };
    evidence.judge()
}

#[test]
fn healthy_tests_are_good() {
    let runs = if long() { 1000 } else { 10 };
    let default = Bench::named("default").expect("is bundled");
    // As rough as the layout states, which the default bench is not.
    let stated = Bench { errors: ErrorsFrom::Layout, ..default.clone() };
    for (name, bench) in [("default bench", default), ("errors as stated", stated)] {
        let calibration = nominal_calibration(&bench);
        let (mut verdicts, mut codes, mut total) = (BTreeMap::new(), BTreeMap::new(), 0_usize);
        for text in THREE_BAR_TESTS {
            let file = layout_file(text);
            let layout: TestLayout = file.layout.cast().expect("fits the rig");
            let nodes: Vec<_> = file.nodes.iter().map(|node| (node.id, node.position)).collect();
            let study = MonteCarlo {
                bench: &bench,
                layout: &layout,
                calibration: &calibration,
                seed: SEED,
                runs,
                threads: None,
            };
            for run in study.runs(&Interrupt::new(), |_| ()).expect("the bench takes the layout") {
                let judgement = judge(&run.expect("has mass lines"), &file.layout, &nodes);
                *verdicts.entry(judgement.verdict()).or_insert(0_usize) += 1;
                let mut seen: Vec<_> = judgement.concerns.iter().map(|c| c.code()).collect();
                seen.dedup();
                seen.into_iter().for_each(|code| *codes.entry(code).or_insert(0_usize) += 1);
                total += 1;
            }
        }
        println!("{name}: {total} tests: {verdicts:?}; by code {codes:?}");
        // Four of ten thousand; of few tests none.
        let unusable = verdicts.get(&Verdict::DoNotUse).copied().unwrap_or(0);
        assert!(unusable <= total / 2500, "{name}: {unusable} of {total} are not to be used");
        for (code, count) in codes {
            // 3 %; of few tests two may have the same warning by chance.
            assert!(count <= (total * 3 / 100).max(2), "{name}: {count} of {total} have {code}");
        }
    }
}

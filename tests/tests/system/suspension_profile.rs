//! A campaign of the suspension profile from scans to answers: the rig stores the lines, and the program solves them.

use std::collections::BTreeMap;

use massline::support::bench_test::nominal_calibration;
use massline_analysis::monte_carlo::MonteCarlo;
use massline_analysis::monte_carlo::measurement::{
    MeasureError, SimulatedTest, TestLayout, measure,
};
use massline_analysis::suspension::{DofLines, TestLines};
use massline_files::layout_file::LayoutFile;
use massline_physics::source::ScanSource;
use massline_physics::{Bench, BenchSource, ErrorsFrom};
use massline_report::words::monte_carlo as report;
use massline_shared::diagnosis::Code;
use massline_shared::identify::Method;
use massline_shared::layout::{CALIBRATED_HAMMER_GAIN, RigLayout};
use massline_shared::measurement::campaign::Start;
use massline_shared::measurement::{Measurement, Memory, NextAction};
use massline_shared::nalgebra::Complex;
use massline_shared::signal::{
    COMPACT_RESPONSE, CompactLines, SPECTRUM_BINS, expand_response, ringing_s,
};
use massline_shared::units::ScanIndex;
use massline_tests::long;

/// Hits at each DOF: fewer than usual, so that the poles of noise stand beside the modes.
const HITS: u8 = 2;

/// The wheel's layout under the profile.
fn layout() -> RigLayout {
    let text = include_str!("../../../host/examples/wheel.toml");
    let file = LayoutFile::parse(text, "wheel.toml").expect("a layout");
    let mut layout: RigLayout = file.layout.cast().expect("it fits a rig");
    layout.test.hits_per_dof = HITS;
    layout
}

/// The bytes of every response that has been stored, by DOF and response.
type Flash = BTreeMap<(usize, usize), [u8; COMPACT_RESPONSE]>;

/// The lines of a DOF as bytes.
fn store(rig: &Measurement<'_, f32>, dof: usize, flash: &mut Flash) {
    let responses = rig.adc_in_use().responses();
    let lines = CompactLines::new(responses, |response, line| rig.line(response, line));
    let lines = lines.expect("finite lines");
    for response in 0..responses {
        let mut bytes = [0; COMPACT_RESPONSE];
        lines.read(response * COMPACT_RESPONSE, &mut bytes);
        flash.insert((dof, response), bytes);
    }
}

/// A campaign on the wheel: the stored lines, and the length of the records, s.
fn campaign(layout: &RigLayout, seed: u64) -> (Flash, f64) {
    let bench = Bench::named("wheel").expect("bundled");
    let mut source = BenchSource::new(&bench, &layout.cast().unwrap(), seed).unwrap();
    let mut memory = Box::new(Memory::<f32>::new());
    let mut rig = Measurement::new(source.adc(), &mut memory);
    rig.set_layout(layout.clone());
    rig.set_calibration(nominal_calibration(&bench), None);
    rig.start(Start::DEFAULT, false, true).unwrap();
    let mut flash = Flash::new();
    loop {
        match rig.next_action() {
            NextAction::Sample => {
                rig.sampling_started();
                source.armed(rig.armings(), rig.campaign().unwrap().dof());
                for index in 0.. {
                    rig.feed(ScanIndex(index), &[source.next_scan().unwrap()]);
                    if rig.next_action() != NextAction::Sample {
                        break;
                    }
                }
            }
            NextAction::Compute => rig.work(),
            NextAction::StoreLines { dof } => {
                store(&rig, dof, &mut flash);
                rig.lines_stored();
            }
            NextAction::Store => break,
            NextAction::Wait => panic!("the campaign was interrupted: {:?}", rig.diagnostics()),
        }
    }
    assert!(rig.result().estimates.is_empty(), "the program solves it");
    (flash, ringing_s(rig.adc()))
}

#[test]
fn the_program_solves_the_lines_that_a_rig_has_stored() {
    // In the fourth, a search for the poles after an error of the layout takes one of noise for a mode.
    let seeds = if long() { 1..=20 } else { 4..=5 };
    for seed in seeds {
        solve(&layout(), seed);
    }
}

fn solve(layout: &RigLayout, seed: u64) {
    let (flash, record_s) = campaign(layout, seed);
    let lines: Vec<DofLines> = (0..layout.hits.len())
        .map(|dof| {
            let expand = |response| {
                let lines: [Complex<f64>; SPECTRUM_BINS] =
                    expand_response(&flash[&(dof, response)]).expect("stored lines");
                lines
            };
            DofLines { dof, lines: (0..9).flat_map(expand).collect() }
        })
        .collect();
    let bench = Bench::named("wheel").expect("bundled");
    let source = BenchSource::new(&bench, &layout.cast().unwrap(), seed).unwrap();
    let measured = TestLines::new(&layout.cast().unwrap(), &source.adc(), &lines);
    let wanted: Vec<Method> = Method::of_modes().collect();
    let host = measured.solve(record_s, &wanted, |_, _| ()).expect("the host has answers");
    let frequencies = host.modes.rows.iter().map(|mode| mode.frequency_hz[0]);
    // The wheel's modes; 0.5 % of a frequency is a third of the width of the peak.
    for (frequency, expected) in frequencies.zip([2.82, 3.22, 3.56, 6.14, 7.16, 7.66]) {
        assert!((frequency / expected - 1.0).abs() < 0.005, "{frequency} Hz, {expected} Hz");
    }
    assert_eq!(host.modes.rows.len(), 6);
    let truth = bench.truth().theta();
    for estimate in &host.estimates {
        let sigma = estimate.sigma().expect("the answers have intervals");
        for k in 0..10 {
            let error = estimate.theta()[k] - truth[k];
            // Twenty campaigns of fifty numbers each: chance exceeds five standard deviations once in 1700 such runs.
            assert!(
                error.abs() < 5.0 * sigma[k],
                "seed {seed}, {:?} {k}: {error} of {}",
                estimate.method,
                sigma[k]
            );
        }
    }
}

/// A test of the wheel after this change of its bench.
fn changed(change: impl FnOnce(&mut Bench)) -> Result<SimulatedTest, MeasureError> {
    let mut bench = Bench::named("wheel").expect("bundled");
    change(&mut bench);
    let layout: TestLayout = layout().cast().expect("as precise");
    let mut source = BenchSource::new(&bench, &layout.cast().unwrap(), 3).unwrap();
    measure(&mut source, &layout, &nominal_calibration(&bench))
}

#[test]
fn a_push_that_the_hammer_clips_is_not_averaged() {
    let too_hard = changed(|bench| bench.operator.too_hard_rate = 0.3).expect("lines");
    // The hammer's converter ends at 129 N, and taps as they should be stay below 110 N.
    let at_end = too_hard.hits.iter().filter(|(_, hit)| hit.peak_force > 120.0);
    assert!(at_end.clone().count() > 0);
    for (_, hit) in at_end {
        let overloaded = hit.findings.iter().any(|finding| finding.code == Code::Overload);
        assert!(!hit.good && overloaded, "{hit:?}");
    }
    // An amplifier may end before the converter does.
    let cut = changed(|bench| bench.faults.push("rail:hammer:70".parse().expect("a fault")));
    assert!(matches!(cut, Err(MeasureError::AlwaysRejected { dof: 0, .. })), "{cut:?}");
}

/// Campaigns whose errors are drawn from the default error budget, with a calibrated hammer: as in the study of the
/// guide, whose seed was chosen before its first run.
#[test]
fn errors_within_the_budget_are_not_refused_and_the_intervals_hold_the_truth() {
    let bench = Bench { errors: ErrorsFrom::Layout, ..Bench::named("wheel").expect("bundled") };
    let file = LayoutFile::parse(include_str!("../../../host/examples/wheel.toml"), "wheel.toml");
    let mut layout = file.expect("a layout").layout.cast().expect("it fits a rig");
    (layout.apparatus.hammer_gain, layout.calibrated_hammer) = (CALIBRATED_HAMMER_GAIN, false);
    let calibration = nominal_calibration(&bench);
    let (layout, calibration) = (&layout, &calibration);
    let runs = if long() { 100 } else { 3 };
    let study = MonteCarlo { bench: &bench, layout, calibration, seed: 2026, runs, threads: None }
        .run(&|| false, |_| ())
        .expect("the bench takes the layout");
    println!("{}", report::to_text(&study, layout));
    let combined = study.methods.last().expect("a combined answer");
    // Each of the checks has a false alarm in at most one of a hundred tests.
    let refused = if long() { 3 } else { 0 };
    assert!(combined.method.is_none() && combined.unanswered <= refused, "{combined:?}");
    // The ten intervals of a run may all contain the truth or all miss it; 2.3 standard deviations for few runs.
    let allowed = if long() { 0.0 } else { 2.3 * (0.95 * 0.05 / runs as f64).sqrt() };
    let coverage = combined.pooled_coverage95().expect("intervals");
    assert!((0.92 - allowed..=0.97 + allowed).contains(&coverage), "{coverage}");
}

//! A campaign of the suspension profile from scans to answers: what the rig finds in single precision, against the host in double
//! precision on the same stored lines.

use std::collections::BTreeMap;

use massline::commands::bench_test::nominal_calibration;
use massline::interrupt::Interrupt;
use massline::layout_file::LayoutFile;
use massline::monte_carlo::{MonteCarlo, report};
use massline::suspension::{DofLines, TestLines};
use massline_shared::identify::{Estimate, Method};
use massline_shared::layout::{CALIBRATED_HAMMER_GAIN, RigLayout};
use massline_shared::measurement::campaign::Start;
use massline_shared::measurement::{Measurement, Memory, NextAction};
use massline_shared::nalgebra::Complex;
use massline_shared::signal::{
    COMPACT_RESPONSE, CompactLines, SPECTRUM_BINS, expand_response, ringing_s,
};
use massline_shared::units::ScanIndex;
use massline_tests::long;
use massline_virtual::bench::{Bench, BenchSource, ErrorsFrom};
use massline_virtual::source::ScanSource;

/// Hits at each DOF: fewer than usual, so that the poles of noise stand beside the modes.
const HITS: u8 = 2;

/// The wheel's layout under the profile.
fn layout() -> RigLayout {
    let text = include_str!("../../host/examples/wheel.toml");
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

/// A campaign on the wheel: the stored lines, and the rig's answers.
fn campaign(layout: &RigLayout, seed: u64) -> (Flash, Vec<Estimate<f32>>, [f32; 6], f64) {
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
            NextAction::FetchLines { dof, response } => {
                let lines = expand_response(&flash[&(dof, response)]).expect("stored lines");
                rig.take_lines(&lines);
            }
            NextAction::Store => break,
            NextAction::Wait => panic!("the campaign was interrupted: {:?}", rig.diagnostics()),
        }
    }
    let solver = rig.solver().expect("the rig has solved");
    assert!(!solver.has_failed(), "{:?}", rig.diagnostics());
    let frequencies = solver.modes().iter().map(|mode| mode.frequency_hz).collect::<Vec<_>>();
    let frequencies = frequencies.try_into().expect("six modes");
    (flash, rig.modal_estimates().collect(), frequencies, ringing_s(rig.adc()))
}

#[test]
fn rig_and_host_answer_the_same_lines_alike() {
    // In the fourth, a search for the poles after an error of the layout takes one of noise for a mode.
    let seeds = if long() { 1..=20 } else { 4..=5 };
    for seed in seeds {
        compare(&layout(), seed);
    }
}

fn compare(layout: &RigLayout, seed: u64) {
    let (flash, estimates, frequencies, record_s) = campaign(layout, seed);
    // The wheel's modes; 0.5 % of a frequency is a third of the width of the peak.
    for (found, expected) in frequencies.iter().zip([2.82, 3.22, 3.56, 6.14, 7.16, 7.66_f32]) {
        assert!((found / expected - 1.0).abs() < 0.005, "{found} Hz, {expected} Hz");
    }
    let lines: Vec<DofLines> = (0..layout.hits.len())
        .map(|dof| {
            let of = |response| {
                let lines: [Complex<f64>; SPECTRUM_BINS] =
                    expand_response(&flash[&(dof, response)]).expect("stored lines");
                lines
            };
            DofLines { dof, lines: (0..9).flat_map(of).collect() }
        })
        .collect();
    let bench = Bench::named("wheel").expect("bundled");
    let source = BenchSource::new(&bench, &layout.cast().unwrap(), seed).unwrap();
    let measured = TestLines::new(&layout.cast().unwrap(), &source.adc(), &lines);
    let wanted: Vec<Method> = Method::of_modes().collect();
    let host = measured.solve(record_s, &wanted, |_, _| ()).expect("the host has answers");
    let mut compared = 0;
    for estimate in &estimates {
        let Some(other) = host.estimates.iter().find(|of| of.method == estimate.method) else {
            continue;
        };
        compared += 1;
        let sigma = other.sigma().expect("the answers have intervals");
        let of_rig = estimate.sigma().expect("the answers have intervals");
        for k in 0..10 {
            let ratio = f64::from(of_rig[k]) / sigma[k];
            let allowed = spread_of_draws(estimate.method);
            let what = format!("seed {seed}, {:?} {k}: {ratio}", estimate.method);
            assert!((ratio - 1.0).abs() < allowed, "{what}");
            let difference = f64::from(estimate.theta()[k]) - other.theta()[k];
            // The part of a standard deviation by which rig and host may differ.
            assert!(
                difference.abs() < 0.05 * sigma[k],
                "seed {seed}, {:?} {k}: {difference} of {}",
                estimate.method,
                sigma[k]
            );
        }
    }
    assert!(compared >= 3, "{estimates:?}");
}

/// By how much the standard deviations of rig and host may differ, relative. The host has 200 draws of noise and the rig 100:
/// what noise alone makes of a standard deviation differs by 9 % (1 sd). Most of the variance is that of the layout's errors,
/// of which both have the same; where noise makes an eighth of it, 3.5 sd are 4 %. The modal constant has only the few lines
/// beyond the highest mode; if noise makes half of its variance, 3.5 sd are 15 %.
fn spread_of_draws(method: Method) -> f64 {
    if method == Method::ModalConstant { 0.15 } else { 0.05 }
}

/// Campaigns whose errors are drawn from the default error budget, with a calibrated hammer: as in the study of the guide, whose
/// seed was chosen before its first run.
#[test]
fn errors_within_the_budget_are_not_refused_and_the_intervals_hold_the_truth() {
    let bench = Bench { errors: ErrorsFrom::Layout, ..Bench::named("wheel").expect("bundled") };
    let file = LayoutFile::parse(include_str!("../../host/examples/wheel.toml"), "wheel.toml");
    let mut layout = file.expect("a layout").layout.cast().expect("it fits a rig");
    (layout.hammer_gain, layout.calibrated_hammer) = (CALIBRATED_HAMMER_GAIN, false);
    let calibration = nominal_calibration(&bench);
    let (layout, calibration) = (&layout, &calibration);
    let runs = if long() { 100 } else { 3 };
    let study = MonteCarlo { bench: &bench, layout, calibration, seed: 2026, runs, threads: None }
        .run(&Interrupt::new(), |_| ())
        .expect("the bench takes the layout");
    println!("{}", report::to_text(&study));
    let combined = study.methods.last().expect("a combined answer");
    // Each of the checks has a false alarm in at most one of a hundred tests.
    let refused = if long() { 3 } else { 0 };
    assert!(combined.method.is_none() && combined.unanswered <= refused, "{combined:?}");
    // The ten intervals of a run may all contain the truth or all miss it; 2.3 standard deviations for few runs.
    let allowed = if long() { 0.0 } else { 2.3 * (0.95 * 0.05 / runs as f64).sqrt() };
    let coverage = combined.pooled_coverage95().expect("intervals");
    assert!((0.92 - allowed..=0.97 + allowed).contains(&coverage), "{coverage}");
}

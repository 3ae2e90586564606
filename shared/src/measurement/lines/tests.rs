use super::*;
use crate::layout::tests::bar_layout;
use crate::layout::{TestProfile, TestSettings};
use crate::measurement::campaign::{Command, Phase, Start};
use crate::measurement::{Measurement, Memory};
use crate::signal::tests::{ADC, hammer_code};
use crate::signal::{Calibration, SPECTRUM_BINS, Scan};
use crate::units::ScanIndex;
use nalgebra::Complex;
use std::boxed::Box;
use std::vec::Vec;

const INTERVAL: f64 = 1.0 / 4000.0;
/// Duration of the push, scans, and the peak of its force, a half sine of 1 N s, N.
const PUSH: (u64, f64) = (80, 25.0 * std::f64::consts::PI);
/// The mode: decay and angular frequency, 1/s.
const POLE: Complex<f64> = Complex::new(-0.25, 21.0);

/// A rig with two hits at each of the first two DOFs of the bar.
fn rig(memory: &mut Memory<f64>) -> Measurement<'_, f64> {
    let mut calibration = Calibration::default();
    calibration.channels.iter_mut().for_each(|channel| channel.cutoff.0 = 0.0);
    let adc = crate::signal::AdcProperties { channel_delay: crate::units::Seconds(0.0), ..ADC };
    let mut rig = Measurement::new(adc, memory);
    rig.set_calibration(calibration, None);
    let bar = bar_layout();
    let test =
        TestSettings { hits_per_dof: 2, ..TestSettings::of_profile(TestProfile::Suspension) };
    let mut layout: crate::measurement::TestLayout<f64> = bar.cast().unwrap();
    layout.hits.truncate(2);
    layout.test = test;
    rig.set_layout(layout);
    rig
}

/// Residue of the accelerance of a response, 1/kg.
fn residue(response: usize) -> f64 {
    0.4 - 0.1 * response as f64
}

/// The force of the push this many scans after its start, N.
fn force(since: u64) -> f64 {
    let phase = std::f64::consts::PI * since as f64 / PUSH.0 as f64;
    if since < PUSH.0 { PUSH.1 * phase.sin() } else { 0.0 }
}

/// The response of unit residue to the push, m/s², this many scans after its start.
fn response(since: u64) -> f64 {
    let rate = std::f64::consts::PI / (PUSH.0 as f64 * INTERVAL);
    let pushed = since.min(PUSH.0) as f64 * INTERVAL;
    let (sin, cos) = (rate * pushed).sin_cos();
    let integral = rate - (-POLE * pushed).exp() * (POLE * sin + rate * cos);
    let response = (POLE * (since as f64 * INTERVAL)).exp() * integral;
    PUSH.1 * (response / (POLE * POLE + rate * rate)).re
}

/// Feeds the rig until it wants no more scans: a push of `gain` times the residues after 2.5 s, from scan `first` on.
fn push(rig: &mut Measurement<'_, f64>, first: u64, gain: f64) {
    assert!(matches!(rig.next_action(), NextAction::Sample), "{:?}", rig.next_action());
    rig.sampling_started();
    let mut state = first as u32;
    let scans = (0..200_000).map(|n| -> Scan {
        let since = u64::checked_sub(n, 10_000);
        let ringing = since.map_or(0.0, response) * gain;
        core::array::from_fn(|channel| {
            if channel == 0 {
                return hammer_code(since.map_or(0.0, force) as f32);
            }
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            // Noise of up to one code either way, so that rounding is not the same in every period.
            let noise = f64::from(state >> 8) / f64::from(1 << 23) - 1.0;
            let per_code = f64::from(Calibration::default().per_code(&ADC, channel));
            (2048.0 + noise + ringing * residue(channel - 1) / per_code).round() as u16
        })
    });
    for (scan, n) in scans.zip(first..) {
        rig.feed(ScanIndex(n), &[scan]);
        if rig.next_action() != NextAction::Sample {
            break;
        }
    }
    while rig.next_action() == NextAction::Compute {
        rig.work();
    }
}

fn good(rig: &mut Measurement<'_, f64>) -> Vec<Code> {
    let mut codes = Vec::new();
    while let Some(hit) = rig.next_hit() {
        codes = hit.findings.iter().map(|finding| finding.code).collect();
    }
    codes
}

#[test]
fn the_lines_of_a_dof_are_handed_to_the_driver() {
    let mut memory = Box::new(Memory::<f64>::new());
    let mut rig = rig(&mut memory);
    rig.start(Start::DEFAULT, false, true).unwrap();
    push(&mut rig, 0, 1.0);
    assert_eq!(good(&mut rig), []);
    let hit = rig.last_hit().unwrap();
    // A code of the hammer is 0.03 N.
    assert!((hit.swing.unwrap().impulse - 1.0).abs() < 0.01, "{hit:?}");
    push(&mut rig, 777_777, 1.0);
    assert_eq!(rig.next_action(), NextAction::StoreLines { dof: 0 });
    for response in [0, 5, 8] {
        for line in 6..SPECTRUM_BINS {
            let s = Complex::new(0.1, std::f64::consts::TAU * 50.0 / 512.0 * line as f64);
            let shifted = s - POLE.re;
            let expected = shifted / (shifted * shifted + POLE.im * POLE.im) * residue(response);
            let value = rig.line(response, line);
            // Noise and rounding of 0.65 codes of 0.13 m/s² in two hits of 1 N s: 2.4e-3; four times that.
            assert!((value - expected).norm() < 0.01, "{response} {line}: {value} {expected}");
        }
    }
    let stored = rig.result().lines[0];
    assert_eq!((stored.dof, stored.hits), (0, 2));
    // Noise alone scatters: 3.3e-3 in each of 1100 lines of both hits, 0.012 in all.
    assert!((0.006..0.02).contains(&stored.scatter.scatter_squared), "{stored:?}");
    rig.lines_stored();
    assert!(rig.has_data(0) && !rig.has_data(1));
    rig.work();
    assert_eq!(rig.next_action(), NextAction::Sample);
    assert_eq!(rig.campaign().unwrap().dof(), 1);
}

#[test]
fn lines_that_cannot_be_stored_interrupt_the_campaign_until_resume() {
    let mut memory = Box::new(Memory::<f64>::new());
    let mut rig = rig(&mut memory);
    rig.start(Start::DEFAULT, false, true).unwrap();
    push(&mut rig, 0, 1.0);
    push(&mut rig, 300_000, 1.0);
    rig.lines_not_stored();
    assert_eq!((rig.next_action(), rig.phase()), (NextAction::Wait, Phase::Paused));
    assert!(rig.diagnostics().iter().any(|diagnostic| diagnostic.code == Code::LinesNotStored));
    // The DOF does not count as finished, so a power cut loses it, and says so.
    assert!(!rig.progress().unwrap().dofs[0].is_finished());
    rig.command(Command::Resume).unwrap();
    assert_eq!(rig.next_action(), NextAction::StoreLines { dof: 0 });
    assert!(rig.diagnostics().iter().all(|diagnostic| diagnostic.code != Code::LinesNotStored));
    rig.lines_stored();
    assert!(rig.progress().unwrap().dofs[0].is_finished());
}

#[test]
fn a_hit_that_moves_the_body_otherwise_is_inconsistent_and_the_last_one_can_be_undone() {
    let mut memory = Box::new(Memory::<f64>::new());
    let mut rig = rig(&mut memory);
    rig.start(Start::DEFAULT, false, true).unwrap();
    push(&mut rig, 0, 1.0);
    push(&mut rig, 300_000, -1.0);
    assert_eq!(good(&mut rig), [Code::HitsInDoubt]);
    rig.lines_stored();
    rig.work();
    // The DOF is open again, with the first hit; the second one is taken out of the averages.
    rig.command(Command::Undo).unwrap();
    while rig.next_action() == NextAction::Compute {
        rig.work();
    }
    assert!(!rig.has_data(0));
    assert_eq!((rig.campaign().unwrap().dof(), rig.campaign().unwrap().accepted()), (0, 1));
    push(&mut rig, 600_000, 1.0);
    assert_eq!(good(&mut rig), []);
    assert_eq!(rig.next_action(), NextAction::StoreLines { dof: 0 });
    let shifted = Complex::new(0.1 - POLE.re, std::f64::consts::TAU * 50.0 / 512.0 * 34.0);
    let expected = shifted / (shifted * shifted + POLE.im * POLE.im) * residue(0);
    assert!((rig.line(0, 34) - expected).norm() < 0.01);
}

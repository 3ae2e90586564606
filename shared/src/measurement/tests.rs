use std::boxed::Box;

use super::campaign::{
    CampaignProgress, Command, CommandError, DofProgress, Object, Outcome, Phase, Start,
};
use super::*;
use crate::diagnosis::Code;
use crate::identify::MassLines;
use crate::layout::tests::{bar_body, bar_layout};
use crate::signal::tests::{ADC, code};
use crate::signal::{RECORD_SCANS, Scan};

fn memory() -> Box<Memory<f64>> {
    Box::new(Memory::<f64>::new())
}

fn measurement(memory: &mut Memory<f64>) -> Measurement<'_, f64> {
    let mut measurement = Measurement::new(ADC, memory);
    let mut layout: TestLayout<f64> = bar_layout().cast().unwrap();
    layout.test.hits_per_dof = 2;
    measurement.set_layout(layout);
    measurement
}

/// `count` scans from `first` on, with hits of about 20 N every 4000 scans that move every response a little.
/// No two hits are equal.
fn scans(first: usize, count: usize) -> std::vec::Vec<Scan> {
    let scan = |n: usize| -> Scan {
        let (number, n) = (n / 4000, n % 4000);
        let force = if (200..216).contains(&n) {
            (20.0 + 0.2 * number as f32) * ((n - 200) as f32 / 16.0 * core::f32::consts::PI).sin()
        } else {
            0.0
        };
        core::array::from_fn(|channel| match channel {
            0 => code(0, force),
            k => code(k, force * (0.3 + 0.1 * k as f32)),
        })
    };
    (first..first + count).map(scan).collect()
}

/// Runs the measurement until it rests or has a result to store.
fn drive(measurement: &mut Measurement<'_, f64>) -> NextAction {
    let mut next = 0;
    loop {
        match measurement.next_action() {
            NextAction::Sample => {
                measurement.sampling_started();
                while measurement.next_action() == NextAction::Sample {
                    let block = scans(next, 20);
                    measurement.feed(ScanIndex(next as u64), &block);
                    next += 20;
                    assert!(next < 400_000, "no result: {:?}", measurement.last_hit());
                }
                // Skips to the next hit.
                next = next.div_ceil(4000) * 4000;
            }
            NextAction::Compute => measurement.work(),
            action => return action,
        }
    }
}

#[test]
fn nothing_else_begins_while_something_is_measured() {
    let mut memory = memory();
    let mut rig = measurement(&mut memory);
    rig.set_stream(true).unwrap();
    assert_eq!(rig.start(Start::DEFAULT, false, true), Err(StartError::WrongPhase));
    assert_eq!(rig.take_reading(), Err(CommandError::WrongPhase));
    assert_eq!(rig.begin_change(), Err(StartError::WrongPhase));
    rig.set_stream(false).unwrap();
    rig.begin_change().unwrap();
    assert_eq!(rig.start(Start::DEFAULT, false, true), Err(StartError::Busy));
    assert_eq!(rig.set_stream(true), Err(CommandError::WrongPhase));
    rig.end_change();
    assert_eq!(rig.start(Start::DEFAULT, false, false), Err(StartError::NoRoom));
    rig.start(Start::DEFAULT, false, true).unwrap();
    assert_eq!(rig.take_reading(), Err(CommandError::WrongPhase));
    assert_eq!(rig.set_stream(true), Err(CommandError::WrongPhase));
    assert_eq!(rig.start(Start::DEFAULT, false, true), Err(StartError::WrongPhase));
    rig.command(Command::Abort).unwrap();
    assert_eq!((rig.phase(), rig.next_action()), (Phase::Idle, NextAction::Wait));
    rig.take_reading().unwrap();
    assert_eq!(rig.next_action(), NextAction::Sample);
}

#[test]
fn a_reading_fills_the_record_and_a_converter_that_stops_ends_it() {
    let mut memory = memory();
    let mut rig = measurement(&mut memory);
    rig.take_reading().unwrap();
    rig.sampling_started();
    rig.feed(ScanIndex(0), &scans(0, 1000));
    rig.lost(5);
    rig.feed(ScanIndex(1005), &scans(0, RECORD_SCANS));
    assert_eq!((rig.recorded(), rig.next_action()), (RecordContent::Reading, NextAction::Wait));
    rig.take_reading().unwrap();
    rig.sampling_started();
    for _ in 0..LOSSES_TO_STOP {
        rig.lost(1);
    }
    assert_eq!(
        (rig.recorded(), rig.next_action()),
        (RecordContent::ReadingFailed, NextAction::Wait)
    );
}

#[test]
fn a_campaign_goes_from_scans_to_a_result_to_be_kept() {
    let mut memory = memory();
    let mut rig = measurement(&mut memory);
    rig.start(Start::DEFAULT, false, true).unwrap();
    assert_eq!(drive(&mut rig), NextAction::Store);
    // Two hits at each of three DOFs, none of them rejected.
    assert_eq!((rig.hits(), rig.counts().triggers, rig.campaign().unwrap().rejected()), (6, 6, 0));
    assert_eq!(rig.result().dofs.len(), 3);
    rig.not_stored();
    assert_eq!((rig.phase(), rig.next_action()), (Phase::Paused, NextAction::Wait));
    rig.command(Command::Resume).unwrap();
    assert_eq!(drive(&mut rig), NextAction::Store);
    rig.stored(7);
    assert_eq!((rig.phase(), rig.campaign().unwrap().result()), (Phase::Done, 7));
    assert!(rig.is_idle());
}

#[test]
fn scans_lost_after_the_trigger_reject_the_hit_and_before_it_only_arm_again() {
    let mut memory = memory();
    let mut rig = measurement(&mut memory);
    rig.start(Start::DEFAULT, false, true).unwrap();
    rig.sampling_started();
    rig.feed(ScanIndex(0), &scans(0, 100));
    rig.lost(3);
    assert_eq!(
        (rig.next_action(), rig.hits(), rig.campaign().unwrap().rejected()),
        (NextAction::Sample, 0, 0)
    );
    rig.sampling_started();
    rig.feed(ScanIndex(103), &scans(100, 300));
    rig.lost(3);
    assert_eq!((rig.hits(), rig.campaign().unwrap().rejected(), rig.armings()), (1, 1, 2));
    let hit = rig.next_hit().unwrap();
    assert_eq!((hit.good, hit.findings[0].code), (false, Code::ScansLost));
    assert_eq!(rig.counts().hits_aborted, 1);
}

#[test]
fn a_gap_that_nobody_reports_aborts_the_hit_and_the_next_one_counts() {
    let mut memory = memory();
    let mut rig = measurement(&mut memory);
    rig.start(Start::DEFAULT, false, true).unwrap();
    rig.sampling_started();
    rig.feed(ScanIndex(0), &scans(0, 300));
    rig.feed(ScanIndex(340), &scans(340, 20));
    assert_eq!(
        (rig.hits(), rig.counts().hits_aborted, rig.next_action()),
        (1, 1, NextAction::Sample)
    );
    // The sampler continues without a restart.
    rig.feed(ScanIndex(360), &scans(360, 8000));
    assert_eq!((rig.next_action(), rig.counts().triggers), (NextAction::Compute, 2));
}

#[test]
fn a_sampler_that_starts_after_the_campaign_was_interrupted_wakes_nothing() {
    let mut memory = memory();
    let mut rig = measurement(&mut memory);
    rig.start(Start::DEFAULT, false, true).unwrap();
    rig.command(Command::Pause).unwrap();
    rig.sampling_started();
    assert_eq!(
        (rig.phase(), rig.next_action(), rig.armings()),
        (Phase::Paused, NextAction::Wait, 0)
    );
    // Reports that were not requested have no effect.
    rig.command(Command::Abort).unwrap();
    rig.set_stream(true).unwrap();
    rig.work();
    rig.stored(3);
    assert!(rig.streamed().is_some());
}

/// Regression test: the checkpoint of a block test stores the mass of the block, not only a flag.
#[test]
fn a_block_test_resumed_after_a_power_cut_knows_its_mass() {
    let start = Start { object: Object::Block { mass: 2.0 }, ..Start::DEFAULT };
    let mut before = memory();
    let mut rig = measurement(&mut before);
    rig.start(start, false, true).unwrap();
    rig.command(Command::Skip).unwrap();
    let progress = rig.progress().unwrap();
    assert_eq!(progress.dofs[0].outcome, Outcome::Skipped);
    let mut after = memory();
    let mut rig = measurement(&mut after);
    rig.resume(progress, [], |_| false, Diagnostics::new()).unwrap();
    assert_eq!(rig.phase(), Phase::Paused);
    assert_eq!(rig.campaign().unwrap().started(), start);
    rig.command(Command::Resume).unwrap();
    assert_eq!(drive(&mut rig), NextAction::Store);
    assert!(rig.result().block.is_some(), "the block is weighed");
    assert_eq!(rig.result().estimates, []);
}

#[test]
fn a_finished_dof_whose_mass_lines_are_lost_is_measured_again() {
    let mut memory = memory();
    let mut rig = measurement(&mut memory);
    let done = DofProgress { accepted: 2, outcome: Outcome::Complete };
    let dofs = [done, done, DofProgress::OPEN].into_iter().collect();
    let progress = CampaignProgress { start: Start::DEFAULT, dofs, wanted: 2, rejected: 0 };
    let layout = bar_layout();
    let measured_dof = |index: usize| {
        let accelerance = layout.accelerance(&bar_body(), index).unwrap();
        let details =
            MeasuredDof { dof: layout.hits[index].dof, band_hz: [10.0, 120.0], coherence: None };
        (details, (index, MassLines::without_scatter(accelerance)))
    };
    // The mass lines of the second are lost; those of the third do not belong to a finished DOF.
    let dofs = [measured_dof(0), measured_dof(2)]
        .map(|(details, lines)| (details, DofData::MassLines(lines)));
    rig.resume(progress, dofs, |index| index < 2, Diagnostics::new()).unwrap();
    assert_eq!(rig.result().mass_lines.len(), 1);
    assert_eq!(rig.campaign().unwrap().dofs(), [done, DofProgress::OPEN, DofProgress::OPEN]);
    assert_eq!(rig.campaign().unwrap().dof(), 1);
}

/// Hits the present DOF once; the peak of the force in N, and a factor on all accelerances.
fn hit(rig: &mut Measurement<'_, f64>, (peak, accelerance): (f32, f32)) {
    rig.sampling_started();
    let scan = |n: usize| -> Scan {
        let pulse = if (200..216).contains(&n) { (n - 200) as f32 / 16.0 } else { 0.0 };
        let force = peak * (pulse * core::f32::consts::PI).sin();
        core::array::from_fn(|channel| match channel {
            0 => code(0, force),
            k => code(k, force * accelerance * (0.3 + 0.1 * k as f32)),
        })
    };
    for n in 0..4000 {
        if rig.next_action() == NextAction::Sample {
            rig.feed(ScanIndex(n as u64), &[scan(n)]);
        }
    }
    while rig.next_action() == NextAction::Compute {
        rig.work();
    }
}

/// A gentle hit and a hard one at the same DOF, whose accelerances differ by a tenth, as where they land differs.
#[test]
fn hits_of_unequal_force_count_the_same_where_noise_is_small() {
    let mut memory = memory();
    let mut rig = measurement(&mut memory);
    rig.start(Start::DEFAULT, false, true).unwrap();
    for each in [(12.0, 1.0), (40.0, 1.1)] {
        hit(&mut rig, each);
    }
    let measured = &rig.result().mass_lines[0].1.accelerance;
    for k in 1..=9 {
        let ratio = measured[k - 1] / (1.05 * (0.3 + 0.1 * k as f64));
        // A code is 0.6 % of the smallest peak; with squared forces as weights the ratio would be 1.04.
        assert!((ratio - 1.0).abs() < 5e-3, "response {k}: {ratio}");
    }
}

/// Codes of hits that differ from each other.
const OF_REPEATS: [Code; 4] =
    [Code::HitInconsistent, Code::HitElsewhere, Code::HitsInDoubt, Code::HitsDisagree];

/// Whether a hit counts, and the code of the finding about it.
type JudgedHit = (bool, Option<Code>);

/// What became of hits with these factors on their accelerances, three of which a DOF needs: each hit, the codes of the
/// campaign, and the mean factor that the averages have.
fn repeat_hits(factors: &[f32]) -> (std::vec::Vec<JudgedHit>, std::vec::Vec<Code>, f64) {
    let mut memory = memory();
    let mut rig = measurement(&mut memory);
    let mut layout: TestLayout<f64> = bar_layout().cast().unwrap();
    layout.test.hits_per_dof = 3;
    rig.set_layout(layout);
    rig.start(Start::DEFAULT, false, true).unwrap();
    let each = factors.iter().zip(0_u8..).map(|(&factor, number)| {
        // No two records are equal.
        hit(&mut rig, (20.0 + 0.3 * f32::from(number), factor));
        let graded = rig.last_hit().unwrap();
        let mut codes = graded.findings.iter().map(|finding| finding.code);
        (graded.good, codes.find(|code| OF_REPEATS.contains(code)))
    });
    let each = each.collect();
    let codes = rig.diagnostics().iter().map(|diagnostic| diagnostic.code);
    let codes = codes.filter(|code| OF_REPEATS.contains(code)).collect();
    let lines = &rig.result().mass_lines;
    assert_eq!(lines.len(), 1, "{factors:?}: the DOF is complete");
    (each, codes, lines[0].1.accelerance[8] / (0.3 + 0.9))
}

/// A hit that moves the body 180 % otherwise, as beside its node on the other side of the center of mass.
#[test]
fn a_hit_beside_its_node_does_not_count_whether_it_is_the_first_the_second_or_a_later_one() {
    use Code::{HitElsewhere, HitsDisagree, HitsInDoubt};
    let good = (true, None);
    // The mean of the three that count; a code is 0.4 % of the smallest peak.
    let near =
        |mean: f64, expected: f64| assert!((mean - expected).abs() < 0.01, "{mean} {expected}");

    let (hits, codes, mean) = repeat_hits(&[1.0, 1.02, -0.8, 0.98]);
    assert_eq!(hits, [good, good, (false, Some(HitElsewhere)), good]);
    assert_eq!(codes, []);
    near(mean, 1.0);

    // Of two nothing shows which is wrong; the third replaces both.
    for first_two in [[-0.8, 1.0], [1.0, -0.8]] {
        let (hits, codes, mean) = repeat_hits(&[first_two[0], first_two[1], 1.02, 0.98, 1.0]);
        let (doubt, replaced) = ((true, Some(HitsInDoubt)), (true, Some(HitsDisagree)));
        assert_eq!(hits, [good, doubt, replaced, good, good]);
        assert_eq!(codes, [], "the doubt is gone with the hits");
        near(mean, 1.0);
    }
    // Two bad ones are no majority against the hits that follow.
    let (hits, _, mean) = repeat_hits(&[-0.8, 1.0, -0.8, 1.02, 0.98, 1.0, 1.01]);
    assert_eq!(hits.iter().filter(|hit| hit.0).count(), 7);
    near(mean, 1.0);
}

#[test]
fn hits_that_differ_by_a_fifth_are_averaged_and_one_that_differs_by_two_fifths_is_not() {
    let (hits, _, mean) = repeat_hits(&[1.0, 1.0, 1.2]);
    assert!(hits.iter().all(|hit| hit.0));
    assert!((mean - 3.2 / 3.0).abs() < 0.01, "{mean}");
    // Steady hits before show that the person hits well: 0.1 to begin with, and then the mean square of what is seen.
    let (hits, _, _) = repeat_hits(&[1.0, 1.0, 1.45, 1.0]);
    assert_eq!(hits[2], (false, Some(Code::HitElsewhere)));
}

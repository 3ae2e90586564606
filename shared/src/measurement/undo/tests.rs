use std::boxed::Box;
use std::vec::Vec;

use super::*;
use crate::capacity::Rig;
use crate::identify::MassLines;
use crate::layout::HitTreatment;
use crate::layout::tests::bar_layout;
use crate::measurement::averaging::DofSpectra;
use crate::measurement::campaign::{Command, Outcome, Phase, Start};
use crate::measurement::{Memory, NextAction, TestLayout};
use crate::signal::tests::{ADC, code};
use crate::signal::{PRE_TRIGGER_SCANS, RECORD_SCANS, RESPONSES, SPECTRUM_BINS, Scan};
use crate::units::ScanIndex;

type Repeats<R> = MassLines<R, Rig>;

/// Hits at each DOF.
const WANTED: u8 = 3;

fn rig<R: RealFft>(memory: &mut Memory<R>) -> Measurement<'_, R> {
    let mut rig = Measurement::new(ADC, memory);
    let mut layout: TestLayout<R> = bar_layout().cast().unwrap();
    layout.test.hits_per_dof = WANTED;
    rig.set_layout(layout);
    rig.start(Start::DEFAULT, false, true).unwrap();
    rig
}

/// A scan of a record with hum of 50 Hz; the hit of this number begins after `quiet` scans. No two hits are equal.
fn scan(number: usize, quiet: usize, n: usize) -> Scan {
    let pulse = n.checked_sub(quiet).filter(|&n| n < 16).map_or(0.0, |n| n as f32 / 16.0);
    let force = (20.0 + number as f32) * (pulse * core::f32::consts::PI).sin();
    let turn = core::f32::consts::TAU * 50.0 * n as f32 / 4000.0 + number as f32;
    core::array::from_fn(|channel| {
        let hum = (3.0 * (turn + channel as f32).sin()).round();
        let gain = if channel == 0 {
            1.0
        } else {
            0.3 + 0.1 * channel as f32 + 0.01 * ((number * channel) % 3) as f32
        };
        (f32::from(code(channel, force * gain)) + hum) as u16
    })
}

/// Feeds `count` scans of an arming.
fn feed<R: RealFft>(rig: &mut Measurement<'_, R>, count: usize, scan: impl Fn(usize) -> Scan) {
    assert_eq!(rig.next_action(), NextAction::Sample);
    rig.sampling_started();
    let scans: Vec<Scan> = (0..count).map(scan).collect();
    rig.feed(ScanIndex(0), &scans);
}

fn work<R: RealFft>(rig: &mut Measurement<'_, R>) {
    while rig.next_action() == NextAction::Compute {
        rig.work();
    }
}

/// Takes the hit of this number to its end.
fn hit<R: RealFft>(rig: &mut Measurement<'_, R>, number: usize) {
    let quiet = 200 + 37 * number;
    feed(rig, quiet + RECORD_SCANS, |n| scan(number, quiet, n));
    work(rig);
}

/// Waits this long for a hit.
fn wait<R: RealFft>(rig: &mut Measurement<'_, R>, scans: usize) {
    feed(rig, scans, |n| scan(99, usize::MAX, n));
    assert_eq!(rig.next_action(), NextAction::Sample, "nothing has triggered");
}

fn undo<R: RealFft>(rig: &mut Measurement<'_, R>) -> Result<(), CommandError> {
    rig.command(Command::Undo)?;
    work(rig);
    Ok(())
}

fn accepted<R: RealFft>(rig: &Measurement<'_, R>) -> [u8; 3] {
    core::array::from_fn(|dof| rig.campaign().unwrap().dofs()[dof].accepted)
}

/// The codes of the diagnostics; those that were there before the hit may have its value.
fn codes<R: RealFft>(rig: &Measurement<'_, R>) -> Vec<Code> {
    rig.diagnostics().iter().map(|diagnostic| diagnostic.code).collect()
}

/// Compares the averages after an undo with those in which the hit has never been. Adding and subtracting the same
/// number rounds twice, each time by half of `ε` of at most the sum of absolute values; dividing by the number of hits
/// rounds both once more.
fn agree<R: RealFft>(undone: &DofSpectra<R>, never: &DofSpectra<R>, with: &DofSpectra<R>) {
    assert_eq!((undone.hits(), with.hits()), (never.hits(), never.hits() + 1));
    let [hits, hits_with] = [never, with].map(|spectra| f64::from(spectra.hits().max(1)));
    let tolerance =
        |all_of_it: f64| 2.0 * R::default_epsilon().to_f64() * all_of_it * hits_with / hits;
    let near = |one: R, other: R, scale: f64| {
        let off = (one - other).to_f64().abs();
        assert!(off <= tolerance(scale), "{off:e} of {scale:e}");
    };
    let mut changed = 0;
    for bin in 0..SPECTRUM_BINS {
        let force = with.force_auto(bin).to_f64();
        near(undone.force_auto(bin), never.force_auto(bin), force);
        for response in 0..RESPONSES {
            let auto = with.response_auto(response, bin).to_f64();
            near(undone.response_auto(response, bin), never.response_auto(response, bin), auto);
            let [one, other] = [undone, never].map(|spectra| spectra.cross(response, bin));
            near(one.re, other.re, (force * auto).sqrt());
            near(one.im, other.im, (force * auto).sqrt());
            changed += usize::from(with.cross(response, bin) != never.cross(response, bin));
        }
    }
    assert!(changed > SPECTRUM_BINS, "the hit is in the sums");
}

/// Compares what the repeat hits show: scatter and trend. Their sums are of products of deviations of two numbers, each
/// of which is off by a few roundings of these numbers.
fn near_repeats<R: RealFft>(one: &Repeats<R>, other: &Repeats<R>) {
    let few = R::default_epsilon() * R::of(16.0);
    let (largest, force) = (other.accelerance.largest(), other.trend.mean);
    let pairs = one.scatter.as_slice().iter().zip(other.scatter.as_slice());
    pairs.for_each(|(&a, &b)| assert!((a - b).abs() <= few * largest * largest, "{a} {b}"));
    assert_eq!(one.hits, other.hits);
    assert!(force > R::zero() && (one.trend.mean - force).abs() <= few * force);
    assert!((one.trend.squares - other.trend.squares).abs() <= few * force * force);
    let products = (&one.trend.products - &other.trend.products).largest();
    assert!(products <= few * force * largest, "{products}");
}

/// Undoes the third hit of `WANTED + 1`, and compares with a campaign without it.
fn as_if_never_made<R: RealFft>(
    [mut one, mut other, mut third]: [Box<Memory<R>>; 3],
    before_undo: impl Fn(&mut Measurement<'_, R>),
) {
    let (mut rig, mut never, mut with) =
        (rig(&mut one), self::rig(&mut other), self::rig(&mut third));
    for rig in [&mut rig, &mut never, &mut with] {
        rig.layout.as_mut().unwrap().test.hits_per_dof = WANTED + 1;
        rig.start_again();
        hit(rig, 0);
        hit(rig, 1);
    }
    hit(&mut with, 2);
    hit(&mut rig, 2);
    before_undo(&mut rig);
    assert_eq!(accepted(&rig), [3, 0, 0]);
    undo(&mut rig).unwrap();
    assert_eq!(accepted(&rig), [2, 0, 0]);
    assert_eq!(rig.campaign().unwrap().rejected(), 0);
    agree(&rig.memory.spectra, &never.memory.spectra, &with.memory.spectra);
    let [one, other] = [&rig, &never].map(|rig| rig.memory.single_hits.as_ref().unwrap());
    near_repeats(&one.mass_lines(), &other.mass_lines());
    assert_eq!(codes(&rig), codes(&never));
    assert_eq!(rig.precision(), never.precision());
    assert!(rig.diagnostics().iter().any(|diagnostic| diagnostic.code == Code::HumOf50Hz));
    // The hit is reported again, as one that does not count.
    let undone = rig.last_hit().unwrap();
    assert_eq!((undone.number, undone.dof, undone.good), (3, 0, false));
    assert_eq!(undone.findings.last().unwrap().code, Code::HitUndone);
    if rig.phase() == Phase::Paused {
        rig.command(Command::Resume).unwrap();
    }
    for rig in [&mut rig, &mut never] {
        hit(rig, 3);
        hit(rig, 4);
    }
    assert_eq!((accepted(&rig), rig.phase()), (accepted(&never), never.phase()));
    assert_eq!(accepted(&rig), [4, 0, 0]);
    let [(_, one), (_, other)] = [&rig, &never].map(|rig| &rig.result().mass_lines[0]);
    near_repeats(one, other);
    // A fit over a hundred bins, each within a few roundings.
    let off = (&one.accelerance - &other.accelerance).norm() / other.accelerance.norm();
    assert!(off < R::default_epsilon() * R::of(10.0), "{off}");
}

impl<R: RealFft> Measurement<'_, R> {
    /// Starts the campaign anew, with the present layout.
    fn start_again(&mut self) {
        self.command(Command::Abort).unwrap();
        self.start(Start::DEFAULT, false, true).unwrap();
    }
}

/// Runs a test in the precision of the rig and in that of the host.
macro_rules! in_both_precisions {
    ($test:ident($($argument:expr),*)) => {{
        $test(core::array::from_fn(|_| Box::new(Memory::<f32>::new())), $($argument),*);
        $test(core::array::from_fn(|_| Box::new(Memory::<f64>::new())), $($argument),*);
    }};
}

#[test]
fn an_undone_hit_leaves_the_averages_as_if_it_had_never_been_made() {
    // Before the rig samples again.
    in_both_precisions!(as_if_never_made(|_| ()));
}

#[test]
fn a_hit_can_be_undone_however_long_the_rig_has_waited_for_the_next_one() {
    for scans in [1, PRE_TRIGGER_SCANS - 1, PRE_TRIGGER_SCANS + 1, 3 * RECORD_SCANS] {
        in_both_precisions!(as_if_never_made(|rig| wait(rig, scans)));
    }
}

#[test]
fn a_hit_can_be_undone_in_a_pause_and_after_scans_were_lost() {
    in_both_precisions!(as_if_never_made(|rig| {
        wait(rig, 3000);
        rig.lost(5);
        wait(rig, 500);
        rig.command(Command::Pause).unwrap();
    }));
}

#[test]
fn a_hit_can_be_undone_after_its_dof_was_finished_early() {
    // What is computed then needs the memory in which the start of the record was kept.
    in_both_precisions!(as_if_never_made(|rig| {
        wait(rig, 3000);
        rig.command(Command::Finish).unwrap();
        work(rig);
        wait(rig, 3000);
    }));
}

#[test]
fn an_undo_tells_of_an_interruption_that_came_after_the_hit() {
    let mut memory = Box::new(Memory::<f32>::new());
    let mut rig = rig(&mut memory);
    hit(&mut rig, 0);
    rig.stopped();
    undo(&mut rig).unwrap();
    assert_eq!((rig.phase(), accepted(&rig)), (Phase::Paused, [0; 3]));
    assert!(rig.diagnostics().iter().any(|diagnostic| diagnostic.code == Code::SamplerStopped));
    // The first hit after it starts the DOF.
    rig.command(Command::Resume).unwrap();
    hit(&mut rig, 1);
    assert_eq!((accepted(&rig), rig.spectra().unwrap().1.hits()), ([1, 0, 0], 1));
}

#[test]
fn a_dof_whose_last_hit_is_undone_is_open_again() {
    let [mut one, mut other] = core::array::from_fn(|_| Box::new(Memory::<f32>::new()));
    let (mut rig, mut never) = (rig(&mut one), self::rig(&mut other));
    for rig in [&mut rig, &mut never] {
        (0..usize::from(WANTED)).for_each(|number| hit(rig, number));
        let finished = rig.campaign().unwrap().dofs()[0];
        assert_eq!((finished.outcome, rig.campaign().unwrap().dof()), (Outcome::Complete, 1));
        hit(rig, 3);
        hit(rig, 4);
    }
    hit(&mut rig, 5);
    assert_eq!(rig.result().mass_lines.len(), 2);
    wait(&mut rig, 3000);
    undo(&mut rig).unwrap();
    assert_eq!(
        (rig.campaign().unwrap().dofs(), rig.campaign().unwrap().dof()),
        (never.campaign().unwrap().dofs(), 1)
    );
    assert_eq!(rig.precision(), never.precision());
    assert_eq!(codes(&rig), codes(&never));
    assert_eq!(rig.progress(), never.progress());
    assert_eq!(rig.result().mass_lines, never.result().mass_lines);
    hit(&mut rig, 6);
    hit(&mut never, 6);
    let [one, other] = [&rig, &never].map(|rig| &rig.result().mass_lines[1].1.accelerance);
    assert!((one - other).norm() / other.norm() < 1e-6, "as in the tests above");
}

#[test]
fn without_a_hit_to_undo_the_reason_is_named_and_nothing_changes() {
    let mut memory = Box::new(Memory::<f32>::new());
    let mut rig = rig(&mut memory);
    let nothing = Err(CommandError::NothingToUndo);
    assert_eq!(undo(&mut rig), nothing, "no hit yet");
    hit(&mut rig, 0);
    undo(&mut rig).unwrap();
    assert_eq!(undo(&mut rig), nothing, "the second in a row");
    hit(&mut rig, 1);
    rig.command(Command::Redo).unwrap();
    assert_eq!(undo(&mut rig), nothing, "the DOF is measured again");
    hit(&mut rig, 2);
    rig.command(Command::Skip).unwrap();
    assert_eq!(undo(&mut rig), nothing, "the DOF is skipped");
    hit(&mut rig, 3);
    rig.start_again();
    assert_eq!(undo(&mut rig), nothing, "another campaign");
    rig.command(Command::Abort).unwrap();
    assert_eq!(undo(&mut rig), Err(CommandError::WrongPhase));
}

#[test]
fn a_hit_whose_record_is_gone_can_not_be_undone() {
    let mut memory = Box::new(Memory::<f32>::new());
    let mut rig = rig(&mut memory);
    hit(&mut rig, 0);
    // The same record once more is rejected as a duplicate.
    hit(&mut rig, 0);
    assert_eq!((accepted(&rig), rig.campaign().unwrap().rejected()), ([1, 0, 0], 1));
    assert_eq!(undo(&mut rig), Err(CommandError::HitOverwritten));
    // While the next record is being taken.
    hit(&mut rig, 1);
    feed(&mut rig, 400, |n| scan(2, 300, n));
    assert_eq!(undo(&mut rig), Err(CommandError::HitOverwritten));
    assert_eq!(accepted(&rig), [2, 0, 0]);
}

/// In the last hit a response is reversed; its policy keeps it.
#[test]
fn what_was_found_in_discarded_hits_goes_with_them() {
    for command in [Command::Redo, Command::Skip] {
        let mut memory = Box::new(Memory::<f32>::new());
        let mut rig = rig(&mut memory);
        let mut layout = rig.layout().unwrap().clone();
        let policy = layout.test.policy.with(Code::HitInconsistent, HitTreatment::Warn);
        layout.test.policy = policy.with(Code::HitElsewhere, HitTreatment::Warn);
        rig.command(Command::Abort).unwrap();
        rig.set_layout(layout);
        rig.start(Start::DEFAULT, false, true).unwrap();
        (0..4).for_each(|number| hit(&mut rig, number));
        let before = rig.diagnostics().clone();
        assert!(
            codes(&rig).contains(&Code::HumOf50Hz),
            "it was in the hits of the first DOF: {before:?}"
        );
        let wrong = |n: usize| scan(9, 200, n).map(|code| 4095 - code);
        feed(&mut rig, 200 + RECORD_SCANS, |n| {
            let (right, wrong) = (scan(9, 200, n), wrong(n));
            core::array::from_fn(
                |channel| if channel == 3 { wrong[channel] } else { right[channel] },
            )
        });
        work(&mut rig);
        // The second hit of its DOF: nothing shows which of the two is wrong.
        assert!(codes(&rig).contains(&Code::HitsInDoubt), "{:?}", rig.diagnostics());
        rig.command(command).unwrap();
        assert_eq!(*rig.diagnostics(), before);
    }
}

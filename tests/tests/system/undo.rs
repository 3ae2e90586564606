//! The last accepted hit is undone on the whole rig: over the wire, at the end of a DOF, and while the power is cut.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use massline_client::campaign::{CampaignOutcome, Observer, explain_refusal, follow};
use massline_client::interrupt::Interrupt;
use massline_client::{Client, Event};
use massline_physics::BenchSource;
use massline_physics::source::ScanSource;
use massline_protocol::message::{Reason, Status};
use massline_protocol::object::{DofResult, MeasurementResult};
use massline_shared::diagnosis::Code;
use massline_shared::measurement::campaign::{Command, Phase};
use massline_shared::signal::{AdcProperties, RECORD_SCANS, Scan};
use massline_tests::campaign::{
    LATE, phase, scans, start, steady_hand, three_bar_with_hits, wait_for,
};
use massline_virtual::flash::{Cut, FlashBacking, FlashMemory};
use massline_virtual::{VirtualRig, VirtualRigOptions};

/// DOFs of the layout, and hits at each.
const DOFS: usize = 3;
const WANTED: u8 = 3;
/// Scans between an arming and the stop.
const STOP_AFTER: usize = 500;
/// The hammer's code changes by thousands in a strike.
const STRIKE: u16 = 300;

/// Scans of a bench, hit by hit: after each arming they stop until the test decides to hit, and after the record of
/// that hit. Which hit it is depends on its number only.
struct NumberedHits {
    bench: BenchSource,
    /// Numbers of the hits at each DOF that have not been made.
    left: [VecDeque<u32>; DOFS],
    arming: u32,
    dof: usize,
    played: usize,
    /// The hammer at rest, and the scans since the strike.
    strike: Option<(u16, usize)>,
    /// True when the hit is made.
    hit_made: bool,
    /// The arming at which the test hits.
    hits: Arc<AtomicU32>,
}

impl NumberedHits {
    /// A steady hand that hits each DOF with these numbers.
    fn of(numbers: [&[u32]; DOFS]) -> (Self, Arc<AtomicU32>) {
        let bench = *scans(&steady_hand("default"), &three_bar_with_hits(WANTED), 1);
        let left = numbers.map(|numbers| numbers.iter().copied().collect());
        let hits = Arc::new(AtomicU32::new(0));
        let hit = hits.clone();
        let (arming, dof, played, strike, hit_made) = (0, 0, 0, None, false);
        (Self { bench, left, arming, dof, played, strike, hit_made, hits: hit }, hits)
    }
}

impl ScanSource for NumberedHits {
    fn adc(&self) -> AdcProperties {
        self.bench.adc()
    }

    fn armed(&mut self, arming: u32, dof: usize) {
        if std::mem::take(&mut self.hit_made) {
            self.left[self.dof].pop_front();
        }
        (self.arming, self.dof, self.played, self.strike) = (arming, dof, 0, None);
        if let Some(&number) = self.left[dof].front() {
            self.bench.armed(1 + number, dof);
        }
    }

    fn next_scan(&mut self) -> Option<Scan> {
        let over = self.strike.is_some_and(|(_, since)| since > RECORD_SCANS);
        let now = self.hits.load(Ordering::Acquire) == self.arming;
        let waits = self.played >= STOP_AFTER && !now && !self.hit_made;
        if over || waits || self.left[self.dof].is_empty() {
            return None;
        }
        self.hit_made |= self.played >= STOP_AFTER;
        self.played += 1;
        let scan = self.bench.next_scan()?;
        let (rest, since) = self.strike.unwrap_or((scan[0], 0));
        let strikes = since > 0 || scan[0].abs_diff(rest) > STRIKE;
        self.strike = Some((rest, since + usize::from(strikes)));
        Some(scan)
    }
}

/// A rig that is hit on request, and its host.
struct Operator {
    rig: VirtualRig,
    client: Client,
    hits: Arc<AtomicU32>,
    armings: u32,
}

impl Operator {
    /// Switches the rig on.
    fn new(flash: &FlashBacking, numbers: [&[u32]; DOFS]) -> Self {
        let (source, hits) = NumberedHits::of(numbers);
        let options =
            VirtualRigOptions { flash: flash.clone(), ..VirtualRigOptions::new(Box::new(source)) };
        let (rig, client) = start(options);
        Self { rig, client, hits, armings: 0 }
    }

    /// Starts a campaign on a rig that has been switched on.
    fn starting(flash: &FlashBacking, numbers: [&[u32]; DOFS]) -> Self {
        let mut operator = Self::new(flash, numbers);
        let layout = three_bar_with_hits(WANTED).rig_layout().unwrap();
        operator.client.put_layout(&layout).unwrap();
        operator.client.start(false, false).unwrap();
        operator
    }

    /// Waits until the rig waits for the next hit.
    fn armed(&mut self) -> Status {
        let before = self.armings;
        let status = wait_for(&mut self.client, |status| {
            phase(status) == Some(Phase::Armed) && status.armings > before
        });
        self.armings = status.armings;
        status
    }

    /// Waits until the rig waits for a hit, and hits; as often as `times`.
    fn hit(&mut self, times: usize) {
        for _ in 0..times {
            self.armed();
            self.strike();
        }
    }

    /// Hits; the rig is waiting.
    fn strike(&mut self) {
        self.hits.store(self.armings, Ordering::Release);
        self.rig.poke();
    }

    /// Waits until the rig waits for a hit, and undoes the last one instead; returns the status when it is done.
    fn undo(&mut self) -> Status {
        self.armed();
        self.client.command(Command::Undo).unwrap();
        let status = self.armed();
        // The next look is at the same arming.
        self.armings -= 1;
        status
    }

    fn refusal(&mut self) -> Option<Reason> {
        self.client.command(Command::Undo).unwrap_err().refusal()
    }

    fn result(&mut self) -> MeasurementResult {
        let done = wait_for(&mut self.client, |status| phase(status) == Some(Phase::Done));
        self.client.result(done.result).unwrap()
    }
}

fn bits(dof: &DofResult) -> Vec<u8> {
    postcard::to_stdvec(dof).unwrap()
}

#[test]
fn a_campaign_with_undone_hits_has_the_estimate_of_one_in_which_they_were_never_made() {
    let mut undoing = Operator::starting(
        &FlashBacking::default(),
        [&[0, 1, 2, 3], &[0, 1, 2, 3], &[0, 1, 2, 3, 4]],
    );
    // The second of three at the first DOF.
    undoing.hit(2);
    assert_eq!(undoing.undo().accepted, [1, 0, 0]);
    undoing.hit(2);
    // The last of three at the second DOF, which was finished.
    undoing.hit(3);
    let armed = undoing.undo();
    assert_eq!((armed.dof, &armed.accepted[..], armed.rejected), (1, &[3, 2, 0][..], 0));
    undoing.hit(1);
    // The first and, in a pause, the next at the third DOF.
    undoing.hit(1);
    assert_eq!(undoing.undo().accepted, [3, 3, 0]);
    undoing.hit(1);
    undoing.armed();
    undoing.client.command(Command::Pause).unwrap();
    undoing.client.command(Command::Undo).unwrap();
    let undone = |status: &Status| status.accepted[2] == 0;
    assert_eq!(phase(&wait_for(&mut undoing.client, undone)), Some(Phase::Paused));
    undoing.client.command(Command::Resume).unwrap();
    undoing.hit(3);
    let result = undoing.result();
    undoing.rig.stop().unwrap();

    let mut never =
        Operator::starting(&FlashBacking::default(), [&[0, 2, 3], &[0, 1, 3], &[2, 3, 4]]);
    never.hit(9);
    let expected = never.result();
    never.rig.stop().unwrap();

    assert_eq!(result.dofs.len(), expected.dofs.len());
    for (one, other) in result.dofs.iter().zip(&expected.dofs) {
        assert_eq!((one.dof, one.hits), (other.dof, other.hits));
        let (trend, expected) = (&one.trend, &other.trend);
        assert!((trend.mean / expected.mean - 1.0).abs() < 1e-6, "{trend:?} {expected:?}");
        // As the scatter below.
        assert!((trend.squares / expected.squares - 1.0).abs() < 1e-4, "{trend:?} {expected:?}");
        // A few roundings of the mean times the deviation, which is a hundredth of the mean at least.
        let most = other.scatter.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
        for (one, other) in one.scatter.iter().zip(&other.scatter) {
            assert!((one - other).abs() <= 1e-4 * most, "{one} {other}");
        }
        // The sums differ by rounding, which a fit over a hundred bins averages.
        let largest = other.accelerance.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
        for (one, other) in one.accelerance.iter().zip(&other.accelerance) {
            assert!((one - other).abs() <= 4.0 * f32::EPSILON * largest, "{one} {other}");
        }
    }
    assert_eq!(result.diagnostics, expected.diagnostics);
    for (one, other) in result.estimates.iter().zip(&expected.estimates) {
        assert_eq!(one.method, other.method);
        let sigma = |place: usize| other.covariance[place * (place + 3) / 2].sqrt();
        for (place, (one, other)) in one.properties.iter().zip(&other.properties).enumerate() {
            // A thousandth of the standard deviation is far below what anyone can see.
            assert!((one - other).abs() < 1e-3 * sigma(place), "{place}: {one} {other}");
        }
    }
}

#[test]
fn the_host_hears_which_hit_was_undone() {
    let mut operator = Operator::starting(&FlashBacking::default(), [&[0, 1], &[], &[]]);
    operator.hit(2);
    operator.undo();
    let mut heard = Vec::new();
    while let Some(event) = operator.client.next_event(Duration::ZERO).unwrap() {
        if let Event::Hit(hit) = event {
            let undone = hit.findings.iter().any(|finding| finding.code == Code::HitUndone);
            heard.push((hit.number, hit.dof, hit.good, undone));
        }
    }
    assert_eq!(heard, [(1, 0, true, false), (2, 0, true, false), (2, 0, false, true)]);
    operator.rig.stop().unwrap();
}

#[test]
fn the_rig_says_why_there_is_nothing_to_undo() {
    let flash = FlashBacking::default();
    let mut operator = Operator::starting(&flash, [&[0, 1, 1, 2, 3], &[0], &[0]]);
    operator.armed();
    assert_eq!(operator.refusal(), Some(Reason::NothingToUndo));
    operator.strike();
    operator.undo();
    operator.armed();
    assert_eq!(operator.refusal(), Some(Reason::NothingToUndo), "the second in a row");
    operator.strike();
    // The same record once more is rejected, and has overwritten the one before.
    operator.hit(1);
    let status = operator.armed();
    assert_eq!((status.accepted[0], status.rejected), (1, 1));
    assert_eq!(operator.refusal(), Some(Reason::HitOverwritten));
    operator.client.command(Command::Redo).unwrap();
    operator.armed();
    assert_eq!(operator.refusal(), Some(Reason::NothingToUndo), "the DOF is measured again");
    operator.rig.stop().unwrap();
}

#[test]
fn after_power_on_there_is_nothing_to_undo() {
    let flash = FlashBacking::default();
    let mut operator = Operator::starting(&flash, [&[0, 1, 2], &[], &[]]);
    operator.hit(3);
    operator.armed();
    operator.rig.stop().unwrap();
    let mut operator = Operator::new(&flash, [&[], &[0, 1], &[]]);
    assert_eq!(operator.refusal(), Some(Reason::NothingToUndo));
    operator.client.command(Command::Resume).unwrap();
    let status = operator.armed();
    assert_eq!((status.dof, &status.accepted[..]), (1, &[3, 0, 0][..]));
    assert_eq!(operator.refusal(), Some(Reason::NothingToUndo));
    operator.rig.stop().unwrap();
}

/// Undoes once, and ends the campaign when that is refused.
#[derive(Default)]
struct UndoObserver {
    refused: Option<String>,
}

impl Observer for UndoObserver {
    fn steer(&mut self, _: &mut Client, status: &Status) -> massline::Result<Option<Command>> {
        let command = match self.refused {
            Some(_) => Command::Abort,
            None => Command::Undo,
        };
        let armed = phase(status) == Some(Phase::Armed);
        Ok(armed.then_some(command))
    }

    fn refused(&mut self, command: Command, reason: Reason) {
        self.refused = Some(explain_refusal(command, reason));
    }
}

#[test]
fn a_refused_undo_is_explained_and_the_campaign_goes_on() {
    let mut operator = Operator::starting(&FlashBacking::default(), [&[0], &[], &[]]);
    let mut undoing = UndoObserver::default();
    let ending = follow(&mut operator.client, &Interrupt::new(), Some(LATE), &mut undoing);
    assert_eq!(ending.unwrap(), CampaignOutcome::Aborted);
    let refusal = undoing.refused.unwrap();
    assert!(refusal.contains("there is no hit to undo"), "{refusal}");
    operator.rig.stop().unwrap();
}

/// What is stored of the first DOF: `None` when it is open.
fn first_dof(flash: &FlashBacking) -> Option<Vec<u8>> {
    let mut operator = Operator::new(flash, [&[], &[], &[]]);
    let status = operator.client.status().unwrap();
    assert_eq!(operator.client.stats().unwrap().store_failures, 0);
    let lines = operator.client.mass_lines(0).unwrap();
    assert_eq!(status.accepted.first().copied().unwrap_or(0), lines.as_ref().map_or(0, |_| WANTED));
    operator.rig.stop().unwrap();
    lines.as_ref().map(bits)
}

#[test]
fn an_undo_that_could_not_be_stored_is_stored_after_the_next_hit() {
    let memory = FlashMemory::default();
    let flash = FlashBacking::Memory(memory.clone());
    // The same record once more is rejected, so that the DOF stays open.
    let mut operator = Operator::starting(&flash, [&[0, 1, 2, 2], &[], &[]]);
    operator.hit(usize::from(WANTED));
    operator.armed();
    memory.refuse_changes(true);
    operator.armings -= 1;
    assert_eq!(operator.undo().accepted, [2, 0, 0]);
    memory.refuse_changes(false);
    operator.hit(1);
    let status = operator.armed();
    assert_eq!((&status.accepted[..], status.rejected), (&[2, 0, 0][..], 1));
    operator.rig.stop().unwrap();
    assert_eq!(first_dof(&flash), None);
}

/// Runs a campaign in which the last hit of the first DOF is undone and made again; the power is cut at this step of
/// the writes from the undo on. Returns what is stored then, and how many steps the undo took, and all.
fn cut_after(steps: Option<u64>) -> (Option<Vec<u8>>, [u64; 2]) {
    let memory = FlashMemory::default();
    let flash = FlashBacking::Memory(memory.clone());
    let mut operator = Operator::starting(&flash, [&[0, 1, 2, 3], &[0], &[0]]);
    operator.hit(usize::from(WANTED));
    operator.armed();
    let start = memory.steps();
    if let Some(after) = steps {
        memory.cut_power(Cut { after, seed: after });
    }
    operator.client.command(Command::Undo).unwrap();
    // Without power the rig of this test goes on; it only cannot write.
    operator.hit(1);
    let undone = memory.steps();
    operator.armed();
    let taken = [undone - start, memory.steps() - start];
    operator.rig.stop().unwrap();
    (first_dof(&flash), taken)
}

#[test]
fn wherever_the_power_is_cut_an_undone_hit_does_not_come_back() {
    let memory = FlashMemory::default();
    let flash = FlashBacking::Memory(memory.clone());
    let mut operator = Operator::starting(&flash, [&[0, 1, 2], &[], &[]]);
    operator.hit(usize::from(WANTED));
    operator.armed();
    operator.rig.stop().unwrap();
    let with_the_hit = first_dof(&flash);
    let (with_the_other, [undo, steps]) = cut_after(None);
    assert!(with_the_hit.is_some() && with_the_other.is_some() && with_the_hit != with_the_other);
    let mut seen = [0; 3];
    for step in 0..steps {
        let (stored, _) = cut_after(Some(step));
        // Each state is whole: before the undo, after it, and with the DOF measured again.
        let state = match &stored {
            None => 1,
            _ if stored == with_the_hit => 0,
            _ if stored == with_the_other => 2,
            other => panic!("step {step}: {other:?}"),
        };
        assert!(state > 0 || step < undo, "step {step} of {undo}: the hit has come back");
        seen[state] += 1;
    }
    println!("{steps} steps, {undo} of them of the undo: {seen:?} before, after, measured again");
    assert!(seen[0] > 0 && seen[1] > 0, "{seen:?}");
}

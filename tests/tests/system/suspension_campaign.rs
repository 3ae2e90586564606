//! A campaign of the suspension profile that is interrupted at every DOF, or whose power is cut at every word that it
//! writes: the whole rig, with hits that are the same to the last bit each time.

use std::ops::Range;
use std::sync::LazyLock;
use std::thread;

use embassy_futures::block_on;
use massline::support::bench_test::nominal_calibration;
use massline_client::Client;
use massline_client::campaign::{CampaignOutcome, StartOptions, StartOutcome, begin, follow};
use massline_client::interrupt::Interrupt;
use massline_firmware::panel::{Button, PanelModel};
use massline_firmware::store::Store;
use massline_physics::source::ScanSource;
use massline_protocol::lines::{CURRENT_CAMPAIGN, LinesId};
use massline_protocol::message::Reason;
use massline_protocol::object::{ObjectId, ObjectKind};
use massline_shared::calibration::CalibrationRecord;
use massline_shared::layout::RigLayout;
use massline_shared::measurement::campaign::{Command, Phase};
use massline_shared::signal::AdcProperties;
use massline_tests::campaign::{LATE, layout_file, phase, start, steady_hand, wait_for};
use massline_tests::held_scans::HeldScans;
use massline_tests::taped_hits::{Hits, TapedHits, take_hits};
use massline_virtual::flash::{Cut, Flash, FlashBacking, FlashError, FlashMemory, FlashStep};
use massline_virtual::{VirtualRig, VirtualRigOptions};

/// Hits that show all six modes of the wheel.
const DOFS: usize = 3;
/// Hits at each DOF: the second is averaged with the first.
const HITS: u8 = 2;

/// A campaign that nothing interrupts.
struct WholeCampaign {
    adc: AdcProperties,
    hits: Hits,
    /// The flash before it.
    before: FlashMemory,
    /// What it writes.
    steps: Vec<FlashStep>,
    /// Its result, and the lines of its DOFs.
    result: StoredResult,
}

/// What is stored of a campaign.
#[derive(Debug, PartialEq)]
struct StoredResult {
    number: u32,
    bytes: Vec<u8>,
    dofs: Vec<Vec<u8>>,
}

impl StoredResult {
    fn read(client: &mut Client, number: u32) -> Self {
        let object = ObjectId { kind: ObjectKind::Result as u8, number };
        let bytes = client.download(object, |_, _| ()).unwrap();
        let dofs = (0..DOFS as u8).map(|dof| lines(client, number, dof).unwrap());
        Self { number, bytes, dofs: dofs.collect() }
    }
}

/// The lines of a DOF of this result, or why there are none.
fn lines(client: &mut Client, result: u32, dof: u8) -> Result<Vec<u8>, Reason> {
    let object = LinesId { result, dof }.object().unwrap();
    client.download(object, |_, _| ()).map_err(|error| error.refusal().unwrap())
}

static WHOLE: LazyLock<WholeCampaign> = LazyLock::new(|| {
    let bench = steady_hand("wheel");
    let layout = layout();
    let (adc, hits) = take_hits(&bench, &layout, 1);
    let calibration = nominal_calibration(&bench).into();
    let before = used_flash(&layout, &calibration);
    let memory = before.copied();
    let (rig, mut client) = power_on(&memory, TapedHits::new(adc, &hits));
    memory.note_steps();
    let (begun, result) = finish(&mut client);
    assert_eq!(begun, StartOutcome::Started);
    rig.stop().unwrap();
    WholeCampaign { adc, hits, before, steps: memory.noted_steps(), result }
});

impl WholeCampaign {
    fn source(&self) -> TapedHits {
        TapedHits::new(self.adc, &self.hits)
    }
}

/// The wheel with a few hits.
fn layout() -> RigLayout {
    let file = layout_file(include_str!("../../../host/examples/wheel.toml"));
    let mut layout = file.rig_layout().expect("it fits a rig");
    layout.test.hits_per_dof = HITS;
    let hits = [0, 1, 3].map(|hit| layout.hits[hit]);
    layout.hits = hits.into_iter().collect();
    layout
}

/// Flash in which every page has been in use: the campaign opens pages, and moves what is stored in them.
fn used_flash(layout: &RigLayout, calibration: &CalibrationRecord) -> FlashMemory {
    let memory = FlashMemory::default();
    let mut store =
        Store::new(Flash::open(&FlashBacking::Memory(memory.clone())).unwrap(), || false);
    let calibration = postcard::to_stdvec(calibration).unwrap();
    block_on(async {
        store.open().await;
        store.put_layout(&postcard::to_stdvec(layout).unwrap()).await.unwrap();
        for _ in 0..2 {
            store.put_result(&[7; 2000][..], 0, None).await.unwrap();
        }
        while memory.erases().contains(&0) {
            store.put_calibration(&calibration).await.unwrap();
        }
    });
    memory
}

/// A rig on this flash.
fn power_on(memory: &FlashMemory, source: impl ScanSource + 'static) -> (VirtualRig, Client) {
    let flash = FlashBacking::Memory(memory.clone());
    start(VirtualRigOptions { flash, ..VirtualRigOptions::new(Box::new(source)) })
}

/// Begins a campaign, or goes on with one, and runs it to its result.
fn finish(client: &mut Client) -> (StartOutcome, StoredResult) {
    let begun = begin(client, StartOptions::default()).unwrap();
    let ending = follow(client, &Interrupt::new(), Some(LATE), &mut ()).unwrap();
    let CampaignOutcome::Done(number) = ending else { panic!("{ending:?}") };
    (begun, StoredResult::read(client, number))
}

/// What a rig has of a campaign when it is switched on after a power cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum RecoveredState {
    /// So many finished DOFs.
    Dofs(usize),
    Result,
}

impl RecoveredState {
    /// Everything that may be there, in the order of writing.
    fn all() -> impl Iterator<Item = Self> {
        (0..=DOFS).map(Self::Dofs).chain([Self::Result])
    }
}

/// Switches a rig on after a power cut; compares what it has to the last bit, and lets it go on.
fn look(whole: &WholeCampaign, memory: &FlashMemory, label: &str) -> RecoveredState {
    // The rig waits for the hit at which it goes on.
    let (held, _) = HeldScans::at(whole.source(), vec![0]);
    let (rig, mut client) = power_on(memory, held);
    let status = client.status().unwrap();
    assert_eq!(client.stats().unwrap().store_failures, 0, "{label}: something is torn");
    let results = client.results().unwrap();
    let state = if results.iter().any(|kept| kept.number == whole.result.number) {
        assert_eq!(phase(&status), Some(Phase::Idle), "{label}");
        assert_eq!(StoredResult::read(&mut client, whole.result.number), whole.result, "{label}");
        RecoveredState::Result
    } else {
        let finished = status.accepted.iter().take_while(|&&accepted| accepted == HITS).count();
        // The hits of the DOF in hand are lost, and nothing is behind it.
        assert!(status.accepted.iter().skip(finished).all(|&accepted| accepted == 0), "{label}");
        for (dof, bytes) in (0..finished as u8).zip(&whole.result.dofs) {
            let stored = lines(&mut client, CURRENT_CAMPAIGN, dof);
            assert!(stored.as_ref() == Ok(bytes), "{label}: DOF {dof}");
        }
        goes_on(&mut client, finished, phase(&status), label);
        RecoveredState::Dofs(finished)
    };
    rig.stop().unwrap();
    state
}

/// The campaign goes on at the DOF in hand; without a finished DOF it begins anew.
fn goes_on(client: &mut Client, finished: usize, phase_at_start: Option<Phase>, label: &str) {
    if finished == 0 {
        assert_eq!(phase_at_start, Some(Phase::Idle), "{label}");
        client.start(false, false).unwrap();
    } else {
        assert_eq!(phase_at_start, Some(Phase::Paused), "{label}");
        if finished == DOFS {
            // Nothing is left to be hit; what is solved then is compared by `finish`.
            return;
        }
        client.command(Command::Resume).unwrap();
    }
    let status = wait_for(client, |status| phase(status) == Some(Phase::Armed));
    assert_eq!(usize::from(status.dof), finished, "{label}");
}

/// The flash after a power cut in the step of this number.
fn cut_at(whole: &WholeCampaign, before: &FlashMemory, step: usize) -> FlashMemory {
    let memory = before.copied();
    memory.cut_power(Cut { after: 0, seed: step as u64 });
    assert_eq!(memory.repeat(&whole.steps[step]), Err(FlashError::PowerCut));
    memory
}

/// What is found after a cut in each of these steps.
fn look_after_cuts(whole: &WholeCampaign, steps: Range<usize>) -> Vec<RecoveredState> {
    let memory = whole.before.copied();
    whole.steps[..steps.start].iter().for_each(|step| memory.repeat(step).unwrap());
    let look_at = |step: usize| {
        let state = look(whole, &cut_at(whole, &memory, step), &format!("step {step}"));
        memory.repeat(&whole.steps[step]).unwrap();
        state
    };
    steps.map(look_at).collect()
}

/// Does this for each range of the steps of a campaign on a thread of its own.
fn on_all_cores<T: Send>(steps: usize, part: impl Fn(Range<usize>) -> Vec<T> + Sync) -> Vec<T> {
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let end = |core: usize| steps * core / cores;
    thread::scope(|scope| {
        let part = &part;
        let threads = (0..cores).map(|core| scope.spawn(move || part(end(core)..end(core + 1))));
        let threads: Vec<_> = threads.collect();
        threads.into_iter().flat_map(|part| part.join().expect("no part fails")).collect()
    })
}

#[test]
fn the_power_is_cut_at_every_word_of_a_campaign() {
    let whole = &*WHOLE;
    let states = on_all_cores(whole.steps.len(), |steps| look_after_cuts(whole, steps));
    // What was found after an earlier cut is found after a later one.
    assert!(states.is_sorted(), "{states:?}");
    let mut ends = Vec::new();
    for kind in RecoveredState::all() {
        let of_kind = states.partition_point(|&state| state < kind)
            ..states.partition_point(|&state| state <= kind);
        println!("{kind:?}: {} of {} cuts", of_kind.len(), states.len());
        // A result is there from its last word on.
        if kind != RecoveredState::Result {
            assert!(!of_kind.is_empty(), "{kind:?} was never found");
            ends.extend([of_kind.start, of_kind.start.midpoint(of_kind.end), of_kind.end - 1]);
        }
    }
    let memory = whole.before.copied();
    whole.steps.iter().for_each(|step| memory.repeat(step).unwrap());
    assert_eq!(look(whole, &memory, "the last word is written"), RecoveredState::Result);
    // From what a rig finds follows what it does: the campaign is finished after some cuts with each finding.
    let finish_after = |range: Range<usize>| {
        let finished = ends[range].iter().map(|&step| {
            let memory = whole.before.copied();
            whole.steps[..step].iter().for_each(|step| memory.repeat(step).unwrap());
            let (rig, mut client) = power_on(&cut_at(whole, &memory, step), whole.source());
            let (begun, result) = finish(&mut client);
            let anew = states[step] == RecoveredState::Dofs(0);
            let expected = if anew { StartOutcome::Started } else { StartOutcome::Resumed };
            assert_eq!(begun, expected, "step {step}");
            assert!(result == whole.result, "step {step}: {result:?}");
            rig.stop().unwrap();
        });
        finished.collect()
    };
    assert_eq!(on_all_cores(ends.len(), finish_after).len(), 3 * (DOFS + 1));
}

/// Scans after an arming at which the rig waits for the hit, and at which it records the ringing.
const STOPS: [usize; 2] = [1_000, 60_000];

#[test]
fn a_campaign_that_is_interrupted_at_every_dof_has_the_same_result() {
    let whole = &*WHOLE;
    let memory = whole.before.copied();
    let (held, looked) = HeldScans::at(whole.source(), STOPS.to_vec());
    let (rig, mut client) = power_on(&memory, held);
    client.start(false, false).unwrap();
    let mut arming = 0;
    for dof in 0..DOFS as u8 {
        for hit in 0..HITS {
            // The panel follows a little later than the status.
            let at = |client: &mut Client, wanted: Phase, arming: u32| {
                wait_for(client, |status| {
                    let accepted = status.accepted[usize::from(dof)];
                    (phase(status), status.armings) == (Some(wanted), arming)
                        && (status.dof, accepted) == (dof, hit)
                });
                let shown = |model: &PanelModel| (model.phase, model.armings) == (wanted, arming);
                rig.wait_for(LATE, shown).expect("the panel shows it");
            };
            arming += 1;
            at(&mut client, Phase::Armed, arming);
            // Before the hit and while it rings, by the host and by the button.
            for (ringing, by_host) in [(false, true), (true, false), (true, true), (false, false)] {
                if ringing {
                    looked.go_on(&rig);
                    at(&mut client, Phase::Busy, arming);
                }
                if by_host {
                    client.command(Command::Pause).unwrap();
                    at(&mut client, Phase::Paused, arming);
                    client.command(Command::Resume).unwrap();
                } else {
                    // "Pause", and "Go on".
                    rig.press(Button::Next);
                    at(&mut client, Phase::Paused, arming);
                    rig.press(Button::Ok);
                }
                arming += 1;
                at(&mut client, Phase::Armed, arming);
            }
            looked.go_on(&rig);
            at(&mut client, Phase::Busy, arming);
            looked.go_on(&rig);
        }
    }
    let status = wait_for(&mut client, |status| phase(status) == Some(Phase::Done));
    assert_eq!((status.rejected, status.armings), (0, arming));
    assert!(StoredResult::read(&mut client, status.result) == whole.result);
    rig.stop().unwrap();
}

#[test]
fn a_campaign_that_is_ended_at_a_dof_leaves_nothing_behind() {
    let whole = &*WHOLE;
    for dof in 0..DOFS as u8 {
        let memory = whole.before.copied();
        let (rig, mut client) = power_on(&memory, whole.source());
        client.start(false, false).unwrap();
        wait_for(&mut client, |status| phase(status) == Some(Phase::Busy) && status.dof == dof);
        client.command(Command::Abort).unwrap();
        // The rig answers before it writes.
        wait_for(&mut client, |status| phase(status) == Some(Phase::Idle));
        for earlier in 0..dof {
            while lines(&mut client, CURRENT_CAMPAIGN, earlier) != Err(Reason::NotFound) {}
        }
        rig.stop().unwrap();
        assert_eq!(look(whole, &memory, "ended"), RecoveredState::Dofs(0));
        let (rig, mut client) = power_on(&memory, whole.source());
        let (begun, result) = finish(&mut client);
        assert!(begun == StartOutcome::Started && result == whole.result, "ended at DOF {dof}");
        rig.stop().unwrap();
    }
}

//! A campaign continues after a power cut: the whole rig on a bench, with its flash in a file or cut at
//! any word.

use massline_client::Client;
use massline_client::campaign::{
    CampaignOutcome, Observer, StartOptions, StartOutcome, begin, follow,
};
use massline_client::interrupt::Interrupt;
use massline_files::layout_file::LayoutFile;
use massline_physics::Bench;
use massline_protocol::LayoutHash;
use massline_protocol::message::Status;
use massline_protocol::object::{DofResult, MeasurementResult, ObjectId, ObjectKind};
use massline_shared::diagnosis::{Code, Subject};
use massline_shared::layout::RigLayout;
use massline_shared::measurement::campaign::{Command, Phase};
use massline_tests::campaign::{LATE, phase, scans, start, three_bar_with_hits, wait_for};
use massline_virtual::flash::{Cut, FlashBacking, FlashMemory};
use massline_virtual::{VirtualRig, VirtualRigOptions};

fn layout_file() -> LayoutFile {
    // Two hits are enough for a scatter.
    three_bar_with_hits(2)
}

fn layout() -> RigLayout {
    layout_file().rig_layout().unwrap()
}

/// A rig on a bench with noise; its results are the same bits every time.
fn power_on(flash: &FlashBacking) -> (VirtualRig, Client) {
    let bench = Bench::named("default").unwrap();
    let source = scans(&bench, &layout_file(), 1);
    let options = VirtualRigOptions { flash: flash.clone(), ..VirtualRigOptions::new(source) };
    start(options)
}

/// Waits until the rig is in a phase at this DOF or a later one.
fn wait_at(client: &mut Client, wanted: Phase, dof: u8) -> Status {
    wait_for(client, |status| phase(status) == Some(wanted) && status.dof >= dof)
}

/// Accepts the hit that waits for confirmation at this DOF or a later one.
fn accept(client: &mut Client, dof: u8) {
    wait_at(client, Phase::Confirming, dof);
    client.command(Command::Accept).unwrap();
}

/// Accepts every hit. The rig waits for the confirmation, so the outcome does not depend on timing.
struct AcceptingObserver;

impl Observer for AcceptingObserver {
    fn steer(&mut self, _: &mut Client, status: &Status) -> massline::Result<Option<Command>> {
        let waits = phase(status) == Some(Phase::Confirming);
        Ok(waits.then_some(Command::Accept))
    }
}

/// Resumes a campaign, or begins one, and runs it to its result.
fn finish(client: &mut Client) -> (StartOutcome, MeasurementResult) {
    let begun = begin(client, StartOptions { confirm: true, ..StartOptions::default() }).unwrap();
    let ending = follow(client, &Interrupt::new(), Some(LATE), &mut AcceptingObserver).unwrap();
    let CampaignOutcome::Done(number) = ending else { panic!("{ending:?}") };
    (begun, read_result(client, number))
}

fn read_result(client: &mut Client, number: u32) -> MeasurementResult {
    let object = ObjectId { kind: ObjectKind::Result as u8, number };
    postcard::from_bytes(&client.download(object, |_, _| ()).unwrap()).unwrap()
}

/// The result of a campaign without a power cut.
fn undisturbed(flash: &FlashBacking) -> MeasurementResult {
    let (rig, mut client) = power_on(flash);
    client.put_layout(&layout()).unwrap();
    let (begun, result) = finish(&mut client);
    assert_eq!((begun, result.dofs.len()), (StartOutcome::Started, 3));
    rig.stop().unwrap();
    result
}

fn same_bits(one: &DofResult, other: &DofResult) -> bool {
    postcard::to_stdvec(one).unwrap() == postcard::to_stdvec(other).unwrap()
}

#[test]
fn a_rig_that_is_switched_off_goes_on_at_the_next_dof() {
    let whole = undisturbed(&FlashBacking::default());
    let folder = tempfile::tempdir().unwrap();
    let flash = FlashBacking::File(folder.path().join("flash.bin"));
    let (rig, mut client) = power_on(&flash);
    client.put_layout(&layout()).unwrap();
    client.start(true, false).unwrap();
    for _ in 0..3 {
        accept(&mut client, 0);
    }
    wait_at(&mut client, Phase::Confirming, 1);
    rig.stop().unwrap();
    // Switched on and off again without any request.
    power_on(&flash).0.stop().unwrap();
    let (rig, mut client) = power_on(&flash);
    let status = client.status().unwrap();
    assert_eq!((phase(&status), status.layout_hash), (Some(Phase::Paused), layout().hash()));
    // One of two hits of the second DOF had been accepted: this DOF begins again.
    assert_eq!((status.dof, &status.accepted[..], status.hits_per_dof), (1, &[2, 0, 0][..], 2));
    let (begun, result) = finish(&mut client);
    assert_eq!(begun, StartOutcome::Resumed);
    assert_eq!((result.dofs.len(), result.head.number), (3, 1));
    assert!(same_bits(&result.dofs[0], &whole.dofs[0]));
    assert_eq!(result.estimates.len(), whole.estimates.len());
    rig.stop().unwrap();
    // The campaign has ended, so there is nothing to resume.
    let (rig, mut client) = power_on(&flash);
    assert_eq!(phase(&client.status().unwrap()), Some(Phase::Idle));
    assert_eq!(read_result(&mut client, 1), result);
    rig.stop().unwrap();
}

#[test]
fn a_campaign_that_was_ended_or_begun_anew_does_not_come_back() {
    for is_ended in [true, false] {
        let memory = FlashMemory::default();
        let flash = FlashBacking::Memory(memory.clone());
        let (rig, mut client) = power_on(&flash);
        client.put_layout(&layout()).unwrap();
        client.start(true, false).unwrap();
        for _ in 0..2 {
            accept(&mut client, 0);
        }
        wait_at(&mut client, Phase::Confirming, 1);
        client.command(Command::Pause).unwrap();
        let steps = memory.steps();
        if is_ended {
            client.command(Command::Abort).unwrap();
        } else {
            client.start(true, false).unwrap();
        }
        // The rig answers before it writes; stopping it does not tear the write.
        let asked = std::time::Instant::now();
        while memory.steps() == steps {
            client.status().unwrap();
            assert!(asked.elapsed() < LATE, "ended {is_ended}: nothing is written");
        }
        rig.stop().unwrap();
        let (rig, mut client) = power_on(&flash);
        let status = client.status().unwrap();
        assert_eq!(phase(&status), Some(Phase::Idle), "ended {is_ended}: {status:?}");
        rig.stop().unwrap();
    }
}

#[test]
fn a_dof_that_was_skipped_stays_skipped_and_hits_still_wait_for_a_confirmation() {
    let flash = FlashBacking::default();
    let (rig, mut client) = power_on(&flash);
    client.put_layout(&layout()).unwrap();
    client.start(true, false).unwrap();
    wait_at(&mut client, Phase::Confirming, 0);
    client.command(Command::Skip).unwrap();
    wait_at(&mut client, Phase::Confirming, 1);
    rig.stop().unwrap();
    let (rig, mut client) = power_on(&flash);
    let status = client.status().unwrap();
    assert_eq!((phase(&status), status.dof), (Some(Phase::Paused), 1), "{status:?}");
    client.command(Command::Resume).unwrap();
    for hit in 0..4 {
        accept(&mut client, 1 + hit / 2);
    }
    let number = wait_at(&mut client, Phase::Done, 0).result;
    let result = read_result(&mut client, number);
    assert_eq!(result.dofs.iter().map(|dof| dof.index).collect::<Vec<_>>(), [1, 2]);
    let skipped = |d: &massline_shared::diagnosis::Diagnostic| {
        d.code == Code::DofSkipped && d.subject == Subject::Hit(0)
    };
    assert!(result.diagnostics.iter().any(skipped), "{:?}", result.diagnostics);
    rig.stop().unwrap();
}

/// Number of power cuts in the test of the whole rig.
const CUTS: u64 = 36;

#[test]
fn wherever_the_power_is_cut_the_campaign_ends_with_the_dofs_that_were_finished() {
    let fresh = FlashMemory::default();
    let (rig, mut client) = power_on(&FlashBacking::Memory(fresh.clone()));
    client.put_layout(&layout()).unwrap();
    rig.stop().unwrap();
    let memory = fresh.copied();
    let whole = undisturbed(&FlashBacking::Memory(memory.clone()));
    let steps = memory.steps() - fresh.steps();
    let (mut restored, mut stored) = ([0; 4], 0);
    for i in 0..CUTS {
        let memory = fresh.copied();
        let flash = FlashBacking::Memory(memory.clone());
        let (rig, mut client) = power_on(&flash);
        memory.cut_power(Cut { after: steps * i / CUTS, seed: i });
        client.start(true, false).unwrap();
        // When a hit waits for confirmation while there is power, all earlier DOFs are stored.
        let mut safe = 0;
        loop {
            let status = client.status().unwrap();
            if !memory.has_power() {
                break;
            }
            assert_ne!(phase(&status), Some(Phase::Done), "the cut comes before the end");
            if phase(&status) == Some(Phase::Confirming) {
                safe = safe.max(status.dof);
                client.command(Command::Accept).unwrap();
            }
        }
        rig.stop().unwrap();

        let (rig, mut client) = power_on(&flash);
        let status = client.status().unwrap();
        assert_eq!(client.stats().unwrap().store_failures, 0, "cut {i}");
        if let Some(kept) = client.results().unwrap().first() {
            // There is a result only when its last word was written completely despite the cut.
            assert_eq!(read_result(&mut client, kept.number), whole, "cut {i}");
            stored += 1;
            continue;
        }
        let finished = status.accepted.iter().filter(|&&accepted| accepted == 2).count();
        assert!(finished >= usize::from(safe), "cut {i}: {status:?}, {safe} were safe");
        let wanted = if finished == 0 { Phase::Idle } else { Phase::Paused };
        assert_eq!(phase(&status), Some(wanted), "cut {i}");
        restored[finished] += 1;
        let (begun, result) = finish(&mut client);
        assert_eq!(
            begun,
            if finished == 0 { StartOutcome::Started } else { StartOutcome::Resumed }
        );
        assert_eq!((result.head.number, result.dofs.len()), (1, 3), "cut {i}");
        for dof in 0..finished {
            assert!(same_bits(&result.dofs[dof], &whole.dofs[dof]), "cut {i}, DOF {dof}");
        }
        rig.stop().unwrap();
    }
    println!(
        "{CUTS} cuts of a campaign of {steps} words: went on with {restored:?} finished DOFs, \
         {stored} results were whole"
    );
    assert!(restored.iter().all(|&count| count > 0), "{restored:?}");
}

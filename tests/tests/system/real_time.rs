//! The converter loses scans: a hit whose record they belong to is aborted with a named reason and
//! requested again, and the campaign ends like an undisturbed one.

use massline::rig::PipeTransport;
use massline_client::{Client, Event};
use massline_firmware::board::SampleError;
use massline_firmware::panel::PanelModel;
use massline_firmware::scan_ring::FAULTS_TO_STOP;
use massline_physics::source::ScanSource;
use massline_protocol::event::HitEvent;
use massline_protocol::message::{Reason, Stats, Status};
use massline_shared::diagnosis::Code;
use massline_shared::measurement::campaign::{Command, Phase};
use massline_shared::signal::Scan;
use massline_tests::campaign::{LATE, scans, steady_hand, three_bar};
use massline_tests::faulty_sampler::{Strikes, rig_that_loses};
use massline_tests::held_scans::HeldScans;
use massline_virtual::{VirtualRig, VirtualRigOptions};

/// Number of scans lost at a time.
const LOST: u32 = 3;

/// A rig on the ideal bench with a steady hand; its converter loses scans in the blocks for which `loses`
/// is true.
fn rig_whose_converter(loses: impl FnMut(&[Scan]) -> bool + Send + 'static) -> VirtualRig {
    rig_on(scans(&steady_hand("ideal"), &three_bar(), 1), loses)
}

/// The same with the scans of `source`.
fn rig_on(
    source: Box<dyn ScanSource>,
    mut loses: impl FnMut(&[Scan]) -> bool + Send + 'static,
) -> VirtualRig {
    let fault = move |block: &[Scan]| loses(block).then_some(SampleError::Overrun { lost: LOST });
    rig_that_loses(VirtualRigOptions::new(source), fault).unwrap()
}

/// Loses scans once, `blocks` blocks after the hammer's strike number `strike`.
fn after(strike: u32, blocks: u32) -> impl FnMut(&[Scan]) -> bool + Send {
    let mut strikes = Strikes::above(500);
    move |block| strikes.see(block) == Some((strike, blocks))
}

struct Outcome {
    hits: Vec<HitEvent>,
    status: Status,
    stats: Stats,
    /// Number of methods with an answer.
    methods: usize,
}

fn measure(rig: VirtualRig) -> Outcome {
    let mut client = Client::new(PipeTransport::new(rig.link()));
    client.identify().unwrap();
    client.put_layout(&three_bar().rig_layout().unwrap()).unwrap();
    client.start(false, false).unwrap();
    let (mut hits, mut done) = (Vec::new(), None);
    while done.is_none() {
        match client.next_event(LATE).unwrap().expect("the campaign goes on") {
            Event::Hit(hit) => hits.push(hit),
            Event::Status(status) if status.phase == u8::from(Phase::Done) => done = Some(status),
            _ => {}
        }
    }
    let status = done.unwrap();
    let methods = client.result(status.result).unwrap().estimates.len();
    let stats = client.stats().unwrap();
    rig.stop().unwrap();
    Outcome { hits, status, stats, methods }
}

#[test]
fn a_hit_whose_record_misses_scans_is_aborted_by_name_and_asked_for_again() {
    // In the middle of the record of the sixth hit.
    let measured = measure(rig_whose_converter(after(6, 50)));
    let rejected: Vec<_> = measured.hits.iter().filter(|hit| !hit.good).collect();
    let [aborted] = rejected[..] else { panic!("one hit is aborted: {rejected:?}") };
    assert_eq!(aborted.number, 6);
    let [finding] = &aborted.findings[..] else { panic!("for one reason: {aborted:?}") };
    assert_eq!((finding.code, finding.value), (Code::ScansLost, LOST as f32));
    let Outcome { status, stats, .. } = measured;
    assert_eq!((&status.accepted[..], status.rejected), (&[5, 5, 5][..], 1));
    assert_eq!((stats.scans_lost, stats.overruns, stats.hits_aborted), (LOST.into(), 1, 1));
    assert_eq!((measured.hits.len(), measured.methods), (16, 2));
}

#[test]
fn scans_that_are_lost_between_the_hits_cost_no_hit() {
    let mut blocks = 0;
    let measured = measure(rig_whose_converter(move |_| {
        blocks += 1;
        blocks == 2
    }));
    assert_eq!(measured.status.rejected, 0);
    assert!(measured.hits.iter().all(|hit| hit.good) && measured.hits.len() == 15);
    let Outcome { stats, .. } = measured;
    assert_eq!((stats.scans_lost, stats.overruns, stats.hits_aborted), (LOST.into(), 1, 0));
}

#[test]
fn the_panel_says_which_hit_was_aborted_and_why() {
    let (held, looked) = HeldScans::of(*scans(&steady_hand("ideal"), &three_bar(), 1));
    let rig = rig_on(Box::new(held), after(1, 20));
    let mut client = Client::new(PipeTransport::new(rig.link()));
    client.put_layout(&three_bar().rig_layout().unwrap()).unwrap();
    client.start(false, false).unwrap();
    let moves = |model: &PanelModel| {
        model.phase == Phase::Armed && model.levels.iter().any(|&level| level > 0)
    };
    rig.wait_for(LATE, moves).expect("the rig is armed");
    looked.go_on(&rig);
    let why = |model: &PanelModel| {
        let reason = model.verdict.and_then(|verdict| verdict.reason);
        reason.is_some_and(|reason| reason.code == Code::ScansLost)
    };
    let model = rig.wait_for(LATE, why).expect("the verdict is shown");
    assert_eq!((model.rejected, model.accepted), (1, 0));
    rig.stop().unwrap();
}

#[test]
fn a_converter_that_only_loses_scans_interrupts_the_campaign_by_name() {
    let rig = rig_whose_converter(|_| true);
    let mut client = Client::new(PipeTransport::new(rig.link()));
    client.identify().unwrap();
    client.put_layout(&three_bar().rig_layout().unwrap()).unwrap();
    client.start(false, false).unwrap();
    let paused = |status: &Status| status.phase == u8::from(Phase::Paused);
    let mut status = client.status().unwrap();
    while !paused(&status) {
        if let Event::Status(changed) = client.next_event(LATE).unwrap().expect("it is given up") {
            status = changed;
        }
    }
    let [why] = &status.diagnostics[..] else { panic!("for one reason: {status:?}") };
    assert_eq!(why.code, Code::SamplerStopped);
    assert_eq!(client.stats().unwrap().overruns, u32::from(FAULTS_TO_STOP));
    // A measurement of the rest values also fails, with the same reason.
    client.command(Command::Abort).unwrap();
    let refused = client.rest_statistics().unwrap_err();
    assert_eq!(refused.refusal(), Some(Reason::SamplerStopped), "{refused}");
    rig.stop().unwrap();
}

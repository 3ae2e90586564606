//! Wrong use of a rig by a host or a person, which the rig must survive.

use std::time::Duration;

use massline::rig::PipeTransport;
use massline_client::campaign::{CampaignOutcome, StartOptions, StartOutcome, begin, follow};
use massline_client::interrupt::Interrupt;
use massline_client::{Client, Event};
use massline_firmware::board::SampleError;
use massline_physics::source::ScanSource;
use massline_physics::{Bench, TumbleSource};
use massline_protocol::message::{Reason, Status};
use massline_shared::diagnosis::Code;
use massline_shared::layout::RigLayout;
use massline_shared::measurement::campaign::{Command, Phase};
use massline_shared::signal::RECORD_SCANS;
use massline_tests::campaign::{LATE, phase, scans, start, three_bar, wait_for};
use massline_tests::faulty_sampler::rig_that_loses;
use massline_virtual::flash::FlashBacking;
use massline_virtual::rig::{VirtualRig, VirtualRigOptions};

fn rig(flash: &FlashBacking) -> (VirtualRig, Client, RigLayout) {
    let file = three_bar();
    let bench = Bench::named("ideal").unwrap();
    let source = scans(&bench, &file, 1);
    let options = VirtualRigOptions { flash: flash.clone(), ..VirtualRigOptions::new(source) };
    let (rig, mut client) = start(options);
    client.identify().unwrap();
    let layout = file.rig_layout().unwrap();
    (rig, client, layout)
}

fn wait_in(client: &mut Client, wanted: Phase) -> Status {
    wait_for(client, |status| phase(status) == Some(wanted))
}

#[test]
fn settings_that_no_rig_can_work_with_are_refused_even_by_force() {
    let (rig, mut client, good) = rig(&FlashBacking::default());
    for change in [
        |l: &mut RigLayout| l.test.trigger_n = f32::NAN,
        |l: &mut RigLayout| l.test.band_hz = Some([10.0, 1e30]),
        |l: &mut RigLayout| l.test.exponential_decay = f32::INFINITY,
        |l: &mut RigLayout| l.test.hits_per_dof = 0,
        |l: &mut RigLayout| l.sensors[1].position[2] = f32::NAN,
        |l: &mut RigLayout| l.sensors[0].axes[1] = [0.0; 3],
    ] {
        let mut layout = good.clone();
        change(&mut layout);
        let answer = client.put_layout(&layout).unwrap();
        assert!(answer.diagnostics.iter().any(|d| d.is_error()), "{layout:?}");
        let refusal = client.start(false, true).unwrap_err().refusal();
        assert_eq!(refusal, Some(Reason::LayoutRefused));
        assert_eq!(phase(&client.status().unwrap()), Some(Phase::Idle));
    }
    // The rig still measures afterwards.
    client.put_layout(&good).unwrap();
    client.start(false, false).unwrap();
    assert_eq!(wait_in(&mut client, Phase::Done).result, 1);
    rig.stop().unwrap();
}

#[test]
fn a_layout_that_leaves_no_method_is_refused_with_its_code() {
    let (rig, mut client, good) = rig(&FlashBacking::default());
    type Spoil = fn(&mut RigLayout);
    let cases: [(Spoil, Code); 4] = [
        (|l| l.sensors.truncate(1), Code::TenParametersNotIdentifiable),
        (|l| l.hits.truncate(2), Code::FewerThanThreeHits),
        (|l| l.hits.iter_mut().for_each(|h| h.direction = [0.0, 0.0, 1.0]), Code::HitsAllParallel),
        (|l| l.hits.iter_mut().for_each(|h| h.position = [0.2, 0.0, 0.0]), Code::HitsConcurrent),
    ];
    for (spoil, code) in cases {
        let mut layout = good.clone();
        spoil(&mut layout);
        let answer = client.put_layout(&layout).unwrap();
        let named = |d: &massline_shared::diagnosis::Diagnostic| d.is_error() && d.code == code;
        assert!(answer.diagnostics.iter().any(named), "{answer:?}");
        let refusal = client.start(false, false).unwrap_err().refusal();
        assert_eq!(refusal, Some(Reason::LayoutRefused));
        assert_eq!(phase(&client.status().unwrap()), Some(Phase::Idle));
    }
    rig.stop().unwrap();
}

#[test]
fn concurrent_hits_can_be_forced_and_give_a_reason_instead_of_numbers() {
    let (rig, mut client, mut layout) = rig(&FlashBacking::default());
    let position = layout.hits[0].position;
    layout.hits.iter_mut().for_each(|hit| hit.position = position);
    client.put_layout(&layout).unwrap();
    let refusal = client.start(false, false).unwrap_err().refusal();
    assert_eq!(refusal, Some(Reason::LayoutRefused));
    client.start(false, true).unwrap();
    let status = wait_in(&mut client, Phase::Done);
    let result = client.result(status.result).unwrap();
    assert!(result.estimates.is_empty());
    assert_eq!(result.dofs.len(), 3);
    assert!(result.diagnostics.iter().any(|d| d.code == Code::HitsConcurrent));
    rig.stop().unwrap();
}

#[test]
fn a_campaign_in_which_everything_was_skipped_has_no_mass() {
    let flash = FlashBacking::default();
    let (rig, mut client, layout) = rig(&flash);
    client.put_layout(&layout).unwrap();
    client.start(true, false).unwrap();
    for _ in 0..layout.hits.len() {
        wait_in(&mut client, Phase::Confirming);
        client.command(Command::Skip).unwrap();
    }
    let status = wait_in(&mut client, Phase::Done);
    let result = client.result(status.result).unwrap();
    assert!(result.estimates.is_empty() && result.dofs.is_empty());
    let skipped = result.diagnostics.iter().filter(|d| d.code == Code::DofSkipped);
    assert_eq!(skipped.count(), 3);
    assert_eq!(rig.panel().mass, None);
    rig.stop().unwrap();
    let (rig, _client, _) = self::rig(&flash);
    assert!(rig.wait_for(LATE, |model| model.mass.is_none()).is_some());
    rig.stop().unwrap();
}

#[test]
fn a_stream_that_is_started_again_has_no_old_scans() {
    let (rig, mut client, layout) = rig(&FlashBacking::default());
    client.put_layout(&layout).unwrap();
    client.start(false, false).unwrap();
    wait_in(&mut client, Phase::Done);
    for _ in 0..3 {
        while client.next_event(Duration::ZERO).unwrap().is_some() {}
        client.set_stream(true).unwrap();
        let mut next = None;
        let mut blocks = 0;
        while blocks < 60 {
            let Some(event) = client.next_event(LATE).unwrap() else { panic!("no scans") };
            if let Event::Scans(block) = event {
                let scans = block.codes.len() as u64 / 20;
                assert!(next.is_none_or(|next| next == block.first), "a gap without a loss");
                next = Some(block.first + scans);
                blocks += 1;
            }
        }
        client.set_stream(false).unwrap();
    }
    rig.stop().unwrap();
}

#[test]
fn a_new_layout_leaves_nothing_of_the_last_campaign() {
    let (rig, mut client, mut layout) = rig(&FlashBacking::default());
    client.put_layout(&layout).unwrap();
    client.start(false, false).unwrap();
    wait_in(&mut client, Phase::Done);
    layout.hits.pop();
    client.put_layout(&layout).unwrap();
    let status = client.status().unwrap();
    assert_eq!(phase(&status), Some(Phase::Idle));
    assert!(status.accepted.is_empty() && status.result == 0 && status.diagnostics.is_empty());
    rig.stop().unwrap();
}

#[test]
fn redo_measures_the_dof_again_and_a_pause_keeps_the_others() {
    let (rig, mut client, layout) = rig(&FlashBacking::default());
    client.put_layout(&layout).unwrap();
    client.start(true, false).unwrap();
    for _ in 0..2 {
        wait_in(&mut client, Phase::Confirming);
        client.command(Command::Accept).unwrap();
    }
    wait_in(&mut client, Phase::Confirming);
    client.command(Command::Redo).unwrap();
    let status = wait_in(&mut client, Phase::Confirming);
    assert_eq!(status.accepted[0], 0);
    client.command(Command::Pause).unwrap();
    assert_eq!(phase(&client.status().unwrap()), Some(Phase::Paused));
    let refusal = client.start(true, false).map(|status| status.accepted[0]);
    assert_eq!(refusal.unwrap(), 0, "a start over a pause starts anew");
    rig.stop().unwrap();
}

/// A rig whose converter fails once, after this many blocks.
fn rig_that_fails(
    source: Box<dyn ScanSource>,
    mut left: u32,
    fault: SampleError,
) -> (Client, VirtualRig) {
    let fails = move |_: &[_]| {
        left = left.wrapping_sub(1);
        (left == u32::MAX).then_some(fault)
    };
    let rig = rig_that_loses(VirtualRigOptions::new(source), fails).unwrap();
    (Client::new(PipeTransport::new(rig.link())), rig)
}

#[test]
fn a_converter_that_stops_is_not_taken_for_ctrl_c_and_the_campaign_can_be_resumed() {
    let file = three_bar();
    let bench = Bench::named("ideal").unwrap();
    let source = scans(&bench, &file, 1);
    // A hit takes about 160 blocks of 20 scans, so this is in the sixth hit.
    let left = 900;
    let fault = SampleError::Stopped;
    let (mut client, rig) = rig_that_fails(source, left, fault);
    client.put_layout(&file.rig_layout().unwrap()).unwrap();
    let mut follow_one = |wanted: StartOutcome| {
        assert_eq!(begin(&mut client, StartOptions::default()).unwrap(), wanted);
        follow(&mut client, &Interrupt::new(), Some(LATE), &mut ()).unwrap()
    };
    let CampaignOutcome::Stopped(status) = follow_one(StartOutcome::Started) else {
        panic!("it has stopped")
    };
    assert!(status.diagnostics.iter().any(|d| d.code == Code::SamplerStopped));
    let kept: u8 = status.accepted.iter().sum();
    assert!(kept >= 3, "{status:?}");
    let CampaignOutcome::Done(number) = follow_one(StartOutcome::Resumed) else {
        panic!("it goes on")
    };
    let result = client.result(number).unwrap();
    assert_eq!(result.estimates.len(), 2);
    assert!(!result.diagnostics.iter().any(|d| d.interrupts()));
    rig.stop().unwrap();
}

#[test]
fn a_reading_outlives_lost_scans_and_says_when_the_converter_has_stopped() {
    let faults = [SampleError::Overrun { lost: 3 }, SampleError::Stopped];
    let [whole, broken] = faults.map(|fault| {
        let source = Box::new(TumbleSource::new(&Bench::named("ideal").unwrap(), 3, 1).unwrap());
        // In the middle of a measurement of 103 blocks.
        let (mut client, rig) = rig_that_fails(source, 50, fault);
        let reading = client.rest_statistics();
        let lost = client.stats().unwrap().scans_lost;
        rig.stop().unwrap();
        (reading, lost)
    });
    assert_eq!((whole.0.unwrap().scans, whole.1), (RECORD_SCANS as u32, 3));
    assert_eq!(broken.0.unwrap_err().refusal(), Some(Reason::SamplerStopped));
}

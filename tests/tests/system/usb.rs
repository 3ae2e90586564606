//! Disturbances by a USB host: nobody reads, the plug is pulled in mid-frame, the host sleeps, noise
//! arrives. The measurement continues and completes with the result of an undisturbed rig, the session
//! recovers by itself, and the counters report what happened.

use std::io::{Read, Write};
use std::sync::LazyLock;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Duration;

use massline_client::{Client, Event};
use massline_physics::BenchSource;
use massline_physics::source::ScanSource;
use massline_protocol::event::{SCAN_BLOCK_BYTES, ScanBlock};
use massline_protocol::message::{Identity, ResultEntry};
use massline_protocol::object::{ObjectId, ObjectKind};
use massline_protocol::{MAX_FRAME, encode_frame};
use massline_shared::layout::RigLayout;
use massline_shared::measurement::campaign::Phase;
use massline_shared::signal::{AdcProperties, Record, Scan};
use massline_tests::campaign::{LATE, connect, scans, steady_hand, three_bar};
use massline_tests::garbage::{garbage, question};
use massline_virtual::pipe::HostEnd;
use massline_virtual::{VirtualRig, VirtualRigOptions};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Hits of a campaign: three DOFs with five each; with a steady hand none is rejected.
const HITS: usize = 15;

fn layout() -> RigLayout {
    three_bar().rig_layout().unwrap()
}

fn bench() -> Box<BenchSource> {
    scans(&steady_hand("ideal"), &three_bar(), 1)
}

/// A rig whose link has this capacity in each direction; bench and seed are always the same.
fn start(link_capacity: usize) -> VirtualRig {
    let options = VirtualRigOptions { link_capacity, ..VirtualRigOptions::new(bench()) };
    VirtualRig::start(options).unwrap()
}

/// Sends the layout and starts a campaign.
fn begin(client: &mut Client) {
    client.put_layout(&layout()).unwrap();
    client.start(false, false).unwrap();
}

/// The state of a rig after its campaign.
#[derive(Debug, PartialEq)]
struct Outcome {
    results: Vec<ResultEntry>,
    result: Vec<u8>,
    accepted: Vec<u8>,
    rejected: u16,
}

fn outcome(client: &mut Client) -> Outcome {
    let (results, status) = (client.results().unwrap(), client.status().unwrap());
    let object = ObjectId { kind: ObjectKind::Result as u8, number: status.result };
    let result = client.download(object, |_, _| ()).unwrap();
    Outcome { results, result, accepted: status.accepted.to_vec(), rejected: status.rejected }
}

/// The outcome on an undisturbed rig.
static UNDISTURBED: LazyLock<Outcome> = LazyLock::new(|| {
    let rig = start(1 << 16);
    let mut client = connect(&rig);
    begin(&mut client);
    finish(&rig);
    let outcome = outcome(&mut client);
    assert_eq!((&outcome.accepted[..], outcome.rejected), (&[5, 5, 5][..], 0));
    let stats = client.stats().unwrap();
    assert_eq!((stats.frames_broken, stats.frames_unsent), (0, 0));
    assert_eq!((stats.bytes_dropped, stats.reconnects), (0, 0));
    rig.stop().unwrap();
    outcome
});

/// Waits for the end of the campaign by looking only at the panel.
fn finish(rig: &VirtualRig) {
    assert!(rig.wait_for(LATE, |model| model.phase == Phase::Done).is_some(), "{rig:?}");
}

#[test]
fn nobody_reads_for_a_whole_campaign() {
    // The link holds less than one status, so that there is no room even for the first event.
    let rig = start(32);
    let mut client = connect(&rig);
    begin(&mut client);
    drop(client);
    finish(&rig);
    // After the rest of a cut_frames frame, a new client gets the true outcome.
    let mut client = connect(&rig);
    assert_eq!(outcome(&mut client), *UNDISTURBED);
    let stats = client.stats().unwrap();
    assert!(stats.frames_unsent >= 1, "{stats:?}");
    // The rig queues the last four hits for the next client; one more may be in the cut_frames frame.
    assert!((HITS - 5..=HITS - 4).contains(&(stats.events_dropped as usize)), "{stats:?}");
    rig.stop().unwrap();
}

#[test]
fn a_program_that_asks_and_never_reads_holds_nothing_up() {
    let rig = start(32);
    let mut client = connect(&rig);
    begin(&mut client);
    let mut link = rig.link();
    link.set_timeout(LATE);
    let mut asked = 0;
    while rig.panel().phase != Phase::Done {
        // Waits while the rig has not read the last request because it is blocked in writing an answer.
        link.write_all(&question(asked)).unwrap();
        asked += 1;
    }
    let mut client = connect(&rig);
    assert_eq!(outcome(&mut client), *UNDISTURBED);
    let stats = client.stats().unwrap();
    assert!(stats.frames_in >= u32::from(asked) && stats.frames_unsent > 1, "{stats:?}");
    rig.stop().unwrap();
}

#[test]
fn the_plug_is_pulled_in_the_middle_of_a_question_at_every_byte() {
    let rig = start(1 << 16);
    let mut client = connect(&rig);
    begin(&mut client);
    let before = client.stats().unwrap();
    let mut link = rig.link();
    link.set_timeout(LATE);
    let whole = question(0xABCD);
    let mut cut_frames = 0;
    // Everything but the last byte, the zero, is a complete frame, which the next zero would also end.
    let pulled = whole.len() - 2;
    for cut in 1..=pulled {
        link.write_all(&whole[..cut]).unwrap();
        assert!(link.drained(), "the rig listens");
        link.unplug();
        link.plug();
        cut_frames += cut;
        // The next request begins with a zero, which ends the cut_frames one.
        cut_frames += 1;
        connect(&rig).identify().unwrap();
    }
    let mut client = connect(&rig);
    let after = client.stats().unwrap();
    assert_eq!(after.frames_broken - before.frames_broken, pulled as u32);
    assert_eq!(after.bytes_dropped - before.bytes_dropped, cut_frames as u32);
    assert_eq!(after.reconnects - before.reconnects, pulled as u32);
    finish(&rig);
    assert_eq!(outcome(&mut client), *UNDISTURBED);
    rig.stop().unwrap();
}

#[test]
fn the_plug_is_pulled_in_the_middle_of_an_answer_at_every_byte() {
    // The link holds a request but not an answer: the rig is writing when the plug is pulled.
    let rig = start(32);
    let mut client = connect(&rig);
    let identity = client.identify().unwrap();
    begin(&mut client);
    let answer = encode_frame(1, 1, &identity, &mut [0; MAX_FRAME]).unwrap();
    let mut link = rig.link();
    link.set_timeout(LATE);
    let (mut pulled, mut measuring) = (0, 0);
    for cut in (1..answer).cycle() {
        pull_after(&mut link, cut);
        assert_eq!(identify(&rig), identity, "after {cut} bytes");
        pulled += 1;
        if rig.panel().phase != Phase::Done {
            measuring += 1;
        } else if pulled >= answer {
            break;
        }
    }
    println!("the plug was pulled {pulled} times, {measuring} of them in the campaign");
    assert!(measuring > 0);
    let mut client = connect(&rig);
    let stats = client.stats().unwrap();
    assert_eq!(stats.reconnects as usize, pulled);
    // An answer was cut when it was longer than the bytes read plus the capacity of the link.
    assert!(stats.frames_unsent > 0, "{stats:?}");
    finish(&rig);
    assert_eq!(outcome(&mut client), *UNDISTURBED);
    rig.stop().unwrap();
}

/// Sends a request and pulls the plug when this many bytes have arrived.
fn pull_after(link: &mut HostEnd, bytes: usize) {
    link.write_all(&question(0x1234)).unwrap();
    link.read_exact(&mut vec![0; bytes]).unwrap();
    link.unplug();
    link.plug();
}

fn identify(rig: &VirtualRig) -> Identity {
    connect(rig).identify().unwrap()
}

#[test]
fn noise_torn_frames_and_giants_come_in_while_the_rig_measures() {
    let rig = start(1 << 16);
    let mut client = connect(&rig);
    begin(&mut client);
    let before = client.stats().unwrap();
    let mut link = rig.link();
    link.set_timeout(LATE);
    let (mut broken, mut bytes) = (0, 0);
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut rounds = 0;
    while rig.panel().phase != Phase::Done || rounds < 100 {
        for noise in garbage(&mut random) {
            link.write_all(&noise).unwrap();
            broken += 1;
            bytes += noise.len();
        }
        // This also reads what the rig has sent in the meantime.
        client.identify().unwrap();
        while client.next_event(Duration::ZERO).unwrap().is_some() {}
        rounds += 1;
    }
    let after = client.stats().unwrap();
    assert_eq!(after.frames_broken - before.frames_broken, broken);
    assert_eq!((after.bytes_dropped - before.bytes_dropped) as usize, bytes);
    assert_eq!(after.requests_refused, before.requests_refused);
    assert_eq!(outcome(&mut client), *UNDISTURBED);
    println!("{broken} pieces of garbage, {bytes} bytes, in one campaign");
    rig.stop().unwrap();
}

/// Sends a message for every second of scans that the rig has taken.
struct CountingSource {
    bench: BenchSource,
    scans: u32,
    seconds: SyncSender<()>,
}

impl CountingSource {
    fn new() -> (Self, Receiver<()>) {
        let (seconds, receiver) = sync_channel(1 << 16);
        (Self { bench: *bench(), scans: 0, seconds }, receiver)
    }
}

impl ScanSource for CountingSource {
    fn adc(&self) -> AdcProperties {
        self.bench.adc()
    }

    fn started(&mut self) {
        self.bench.started();
    }

    fn armed(&mut self, arming: u32, dof: usize) {
        self.bench.armed(arming, dof);
    }

    fn next_scan(&mut self) -> Option<Scan> {
        self.scans += 1;
        if self.scans as f32 >= self.bench.adc().rate.0 {
            self.scans = 0;
            // The receiver is gone once the test is over.
            let _ = self.seconds.try_send(());
        }
        self.bench.next_scan()
    }
}

/// The next block of the stream; other events are skipped.
fn next_block(client: &mut Client) -> ScanBlock {
    loop {
        if let Event::Scans(block) = client.next_event(LATE).unwrap().expect("the stream goes on") {
            return *block;
        }
    }
}

#[test]
fn a_host_that_sleeps_for_a_minute_of_a_stream_wakes_up_to_a_gap_and_a_working_rig() {
    let scans = (SCAN_BLOCK_BYTES / Record::SCAN_BYTES) as u64;
    let (source, seconds) = CountingSource::new();
    let options =
        VirtualRigOptions { link_capacity: 2000, ..VirtualRigOptions::new(Box::new(source)) };
    let rig = VirtualRig::start(options).unwrap();
    let mut client = connect(&rig);
    client.set_stream(true).unwrap();
    let mut next = next_block(&mut client).first + scans;
    while seconds.try_recv().is_ok() {}
    // The host does not read for a minute of the rig's time.
    (0..60).for_each(|_| seconds.recv_timeout(LATE).expect("the rig samples on"));
    // The host is back: its next request makes the rig send again.
    let asleep = client.stats().unwrap();
    assert!(asleep.frames_unsent >= 1, "{asleep:?}");
    let (mut gap, mut gaps) = (0, 0);
    // Read until there has been a gap and the stream has continued without another one.
    let mut since = 0;
    while since < 20 {
        let block = next_block(&mut client);
        assert!(block.first >= next, "no scan comes twice");
        since = if block.first > next { 0 } else { since + u32::from(gaps > 0) };
        gaps += u32::from(block.first > next);
        gap += block.first - next;
        next = block.first + scans;
    }
    client.set_stream(false).unwrap();
    let stats = client.stats().unwrap();
    // A block that was abandoned half-way is missing as well.
    let unsent = scans * u64::from(stats.frames_unsent);
    let dropped = u64::from(stats.stream_scans_dropped);
    assert!(gap > 100_000 && (dropped..=dropped + unsent).contains(&gap), "{gap}: {stats:?}");
    assert_eq!(stats.scans_lost, 0);
    // The rig measures normally.
    begin(&mut client);
    finish(&rig);
    let now = outcome(&mut client);
    assert_eq!((now.accepted, now.rejected), (vec![5; 3], 0));
    rig.stop().unwrap();
}

#[test]
fn a_host_that_sleeps_through_a_campaign_finds_its_result_when_it_wakes_up() {
    let rig = start(400);
    let mut client = connect(&rig);
    begin(&mut client);
    // The host has seen the first hit when it falls asleep, with bytes from the rig in transit.
    while !matches!(client.next_event(LATE).unwrap(), Some(Event::Hit(_))) {}
    finish(&rig);
    // The same program continues where it was.
    assert_eq!(outcome(&mut client), *UNDISTURBED);
    let stats = client.stats().unwrap();
    assert!(stats.frames_unsent >= 1 && stats.events_dropped >= 1, "{stats:?}");
    // The plug was never pulled.
    assert_eq!((stats.reconnects, stats.frames_broken), (0, 0));
    rig.stop().unwrap();
}

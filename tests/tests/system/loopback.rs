//! The real client against the real application of the rig, over a pipe in memory that has the faults of
//! a bad cable. No fault may stop the rig, and none may let a wrong value through.

use std::cell::RefCell;
use std::io::{self, Write};
use std::thread;
use std::time::Duration;

use massline::rig::PipeTransport;
use massline_client::{Client, Event, Timing, Transport};
use massline_files::layout_file::LayoutFile;
use massline_physics::Bench;
use massline_protocol::LayoutHash;
use massline_protocol::message::{ENDPOINTS, Identity, ResultEntry, Status};
use massline_protocol::object::{ObjectId, ObjectKind};
use massline_protocol::{MAX_FRAME, PROTOCOL_MAJOR, encode_frame};
use massline_shared::layout::RigLayout;
use massline_shared::measurement::campaign::{Command, Phase};
use massline_tests::campaign::{self, LATE, scans, three_bar_with_hits};
use massline_virtual::flash::{FlashBacking, FlashMemory};
use massline_virtual::pipe::faults::{FaultRates, FaultyPipe};
use massline_virtual::pipe::{Direction, Filter, HostEnd};
use massline_virtual::{VirtualRig, VirtualRigOptions};
use proptest::prelude::*;

/// Link faults in the long test.
const FAULTS: u64 = 10_000;
/// Number of rigs that share these faults and run in parallel, because a fault mostly costs waiting.
const RIGS: u64 = 4;

/// A fault costs the wait for an answer, and there are thousands of faults.
const IMPATIENT: Timing = Timing { answer: Duration::from_millis(6), ..campaign::IMPATIENT };

fn layout_file() -> LayoutFile {
    // The smallest number of hits that gives a covariance.
    three_bar_with_hits(3)
}

fn rig_layout() -> RigLayout {
    layout_file().rig_layout().unwrap()
}

/// A rig on the ideal bench; seed and layout are always the same.
fn start(flash: &FlashMemory) -> VirtualRig {
    let source = scans(&Bench::named("ideal").unwrap(), &layout_file(), 1);
    let flash = FlashBacking::Memory(flash.clone());
    let options = VirtualRigOptions { flash, ..VirtualRigOptions::new(source) };
    VirtualRig::start(options).unwrap()
}

fn connect(rig: &VirtualRig) -> Client {
    Client::with_timing(PipeTransport::new(rig.link()), IMPATIENT)
}

/// Everything that a host can request from a rig after its campaign.
#[derive(Debug, PartialEq)]
struct Content {
    identity: Identity,
    layout: RigLayout,
    status: Status,
    results: Vec<ResultEntry>,
    result: Vec<u8>,
    record: Option<Vec<u8>>,
    spectra: Option<Vec<u8>>,
}

impl Content {
    /// Requests all of it. What is not stored in flash is available until the rig is restarted.
    fn ask(client: &mut Client, since_start: bool) -> Self {
        let results = client.results().unwrap();
        let status = client.status().unwrap();
        let mut object = |kind: ObjectKind, number| {
            client.download(ObjectId { kind: kind as u8, number }, |_, _| ()).unwrap()
        };
        let result = object(ObjectKind::Result, results.last().unwrap().number);
        let record = since_start.then(|| object(ObjectKind::Record, status.last_hit));
        let spectra = since_start.then(|| object(ObjectKind::Spectra, 2));
        Self {
            identity: client.identify().unwrap(),
            layout: client.layout().unwrap(),
            status,
            results,
            result,
            record,
            spectra,
        }
    }
}

/// Runs a campaign to its result; checks every event that arrives on the way.
fn run_campaign(client: &mut Client) {
    let layout = rig_layout();
    let answer = client.put_layout(&layout).unwrap();
    assert_eq!(answer.hash, layout.hash());
    client.start(false, false).unwrap();
    loop {
        match client.next_event(Duration::from_millis(50)).unwrap() {
            Some(Event::Hit(hit)) => {
                assert!(usize::from(hit.dof) < layout.hits.len() && hit.good, "{hit:?}");
            }
            Some(Event::Status(status)) => assert_eq!(status.layout_hash, layout.hash()),
            Some(Event::Scans(_)) => panic!("nobody asked for scans"),
            None => {}
        }
        if Phase::try_from(client.status().unwrap().phase).ok() == Some(Phase::Done) {
            return;
        }
    }
}

/// Splits every write in two at `at`.
fn cut_at(at: usize) -> Filter {
    Box::new(move |bytes| {
        let (head, tail) = bytes.split_at(at.min(bytes.len()));
        vec![head.to_vec(), tail.to_vec()]
    })
}

/// Applies `harm` to byte `at` of the first write that is long enough, and to nothing afterwards.
fn harm_once(at: usize, harm: fn(u8) -> Vec<u8>) -> Filter {
    let mut done = false;
    Box::new(move |bytes| {
        let mut out = bytes.to_vec();
        if !done && at < out.len() {
            done = true;
            out.splice(at..=at, harm(bytes[at]));
        }
        vec![out]
    })
}

#[test]
fn the_rig_says_who_it_is_over_frames_cut_at_every_byte() {
    let rig = start(&FlashMemory::default());
    let (mut client, link) = (connect(&rig), rig.link());
    let identity = client.identify().unwrap();
    assert_eq!((identity.protocol_major, identity.board.as_str()), (PROTOCOL_MAJOR, "virtual"));
    let longest = encode_frame(1, 1, &identity, &mut [0; MAX_FRAME]).unwrap();
    for at in 0..=longest {
        link.set_filter(Direction::ToRig, Some(cut_at(at)));
        link.set_filter(Direction::ToHost, Some(cut_at(at)));
        assert_eq!(client.identify().unwrap(), identity, "cut after {at} bytes");
    }
    FaultyPipe::on(&link, 0, FaultRates { cut: 1.0, ..FaultRates::NONE });
    assert_eq!(client.identify().unwrap(), identity);
    let stats = client.stats().unwrap();
    assert_eq!((stats.frames_broken, client.broken_frames()), (0, 0));
    rig.stop().unwrap();
}

#[test]
fn any_byte_may_be_lost_doubled_or_changed() {
    let harms: [fn(u8) -> Vec<u8>; 4] =
        [|_| vec![], |b| vec![b, b], |b| vec![b ^ 0x10], |_| vec![0]];
    let rig = start(&FlashMemory::default());
    let (mut client, link) = (connect(&rig), rig.link());
    let identity = client.identify().unwrap();
    let longest = encode_frame(1, 1, &identity, &mut [0; MAX_FRAME]).unwrap();
    for at in 0..longest {
        for harm in harms {
            for direction in [Direction::ToRig, Direction::ToHost] {
                link.set_filter(direction, Some(harm_once(at, harm)));
                assert_eq!(client.identify().unwrap(), identity, "byte {at}, {direction:?}");
                link.set_filter(direction, None);
            }
        }
    }
    assert!(client.broken_frames() > 0);
    assert!(client.stats().unwrap().frames_broken > 0);
    rig.stop().unwrap();
}

#[test]
fn what_changes_the_rig_is_done_once_however_often_it_arrives() {
    let rig = start(&FlashMemory::default());
    let mut client = connect(&rig);
    client.put_layout(&rig_layout()).unwrap();
    let twice = FaultRates { double_write: 1.0, ..FaultRates::NONE };
    rig.link().set_filter(Direction::ToRig, Some(FaultyPipe::default().filter(0, twice)));
    client.start(true, false).unwrap();
    // If start were executed twice, the second would be refused, because a campaign is already running.
    client.command(Command::Abort).unwrap();
    let stats = client.stats().unwrap();
    assert_eq!((stats.requests_repeated, stats.requests_refused), (2, 0));
    rig.stop().unwrap();
}

#[test]
fn ten_thousand_faults_let_every_download_complete_and_no_wrong_value_through() {
    let flash = FlashMemory::default();
    let rig = start(&flash);
    let mut client = connect(&rig);
    run_campaign(&mut client);
    let clean = Content::ask(&mut client, true);
    let stored = {
        let again = start(&flash.copied());
        let content = Content::ask(&mut connect(&again), false);
        assert_eq!(content.result, clean.result);
        again.stop().unwrap();
        content
    };
    let downloads = thread::scope(|scope| {
        let mut workers = Vec::new();
        let (clean, stored) = (&clean, &stored);
        workers.push(scope.spawn(move || endure(rig, 0, clean)));
        for seed in 1..RIGS {
            let rig = start(&flash.copied());
            workers.push(scope.spawn(move || endure(rig, seed, stored)));
        }
        workers.into_iter().map(|worker| worker.join().unwrap()).sum::<u32>()
    });
    println!("{downloads} complete and right under {FAULTS} faults");
    assert!(downloads >= RIGS as u32);
}

/// Requests everything repeatedly until this rig has had its share of faults; returns the number of
/// rounds.
fn endure(rig: VirtualRig, seed: u64, expected: &Content) -> u32 {
    let mut client = connect(&rig);
    let faulty = FaultyPipe::on(&rig.link(), seed, FaultRates::one_in(600.0, 5.0));
    let mut downloads = 0;
    while faulty.faults() < FAULTS / RIGS {
        assert_eq!(&Content::ask(&mut client, expected.record.is_some()), expected);
        downloads += 1;
    }
    FaultyPipe::repair(&rig.link());
    let stats = client.stats().unwrap();
    assert!(stats.frames_broken > 0 && client.broken_frames() > 0, "{stats:?}");
    rig.stop().unwrap();
    downloads
}

#[test]
fn a_campaign_over_a_bad_link_ends_with_the_result_of_a_good_one() {
    let contents = [FaultRates::NONE, FaultRates::one_in(300.0, 4.0)].map(|rates| {
        let rig = start(&FlashMemory::default());
        let mut client = connect(&rig);
        let faulty = FaultyPipe::on(&rig.link(), 7, rates);
        run_campaign(&mut client);
        let content = Content::ask(&mut client, true);
        assert_eq!(faulty.faults() > 0, rates != FaultRates::NONE);
        rig.stop().unwrap();
        content
    });
    assert_eq!(contents[0], contents[1]);
}

/// A port that is available again when it is reopened.
struct RepluggedTransport(PipeTransport, HostEnd);

impl Transport for RepluggedTransport {
    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        self.0.read(buffer, timeout)
    }

    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0.write_all(bytes)
    }

    fn reconnect(&mut self) -> io::Result<()> {
        self.1.plug();
        self.0.reconnect()
    }

    fn name(&self) -> &str {
        self.0.name()
    }
}

#[test]
fn a_download_goes_on_where_the_plug_was_pulled() {
    let rig = start(&FlashMemory::default());
    let mut client = connect(&rig);
    run_campaign(&mut client);
    let number = client.status().unwrap().last_hit;
    let record = ObjectId { kind: ObjectKind::Record as u8, number };
    let clean = client.download(record, |_, _| ()).unwrap();

    let link = rig.link();
    let transport = RepluggedTransport(PipeTransport::new(rig.link()), rig.link());
    let mut client = Client::with_timing(transport, IMPATIENT);
    let mut had = Vec::new();
    let bytes = client
        .download(record, |have, _| {
            had.push(have);
            if have % 4096 == 0 {
                link.unplug();
            }
        })
        .unwrap();
    assert!(bytes == clean);
    assert!(client.reconnects() >= 10, "{}", client.reconnects());
    assert!(had.is_sorted(), "nothing is read twice: {had:?}");
    rig.stop().unwrap();
}

#[test]
fn a_stop_in_the_middle_of_a_campaign_is_clean_and_loses_no_layout() {
    let flash = FlashMemory::default();
    let rig = start(&flash);
    let mut client = connect(&rig);
    client.put_layout(&rig_layout()).unwrap();
    client.start(false, false).unwrap();
    assert!(rig.wait_for(LATE, |model| model.accepted > 0).is_some());
    rig.stop().unwrap();
    assert!(client.status().is_err());
    let rig = start(&flash);
    let mut client = connect(&rig);
    assert_eq!(client.layout().unwrap(), rig_layout());
    assert_eq!(client.results().unwrap(), []);
    run_campaign(&mut client);
    rig.stop().unwrap();
}

#[test]
fn whatever_the_host_writes_the_rig_answers_the_next_question() {
    let rig = start(&FlashMemory::default());
    let client = RefCell::new(connect(&rig));
    let identity = client.borrow_mut().identify().unwrap();
    let noise = proptest::collection::vec(any::<u8>(), 0..3000);
    proptest!(cases(64), |(bytes in noise)| {
        rig.link().write_all(&bytes).unwrap();
        prop_assert_eq!(&client.borrow_mut().identify().unwrap(), &identity);
    });
    rig.stop().unwrap();
}

#[test]
fn well_framed_nonsense_harms_nothing() {
    let rig = start(&FlashMemory::default());
    let client = RefCell::new(connect(&rig));
    let identity = client.borrow_mut().identify().unwrap();
    let kinds = 0..ENDPOINTS.len() as u16 + 3;
    let body =
        proptest::collection::vec(prop_oneof![Just(0), Just(1), Just(0xFF), any::<u8>()], 0..60);
    let requests = proptest::collection::vec((kinds, any::<u16>(), body), 1..30);
    proptest!(cases(48), |(requests in requests)| {
        let mut link = rig.link();
        for (kind, sequence, body) in requests {
            link.write_all(&framed(kind, sequence, &body)).unwrap();
        }
        // The refusal of a random request may happen to have the sequence number of the first question,
        // but not that of the next.
        let mut client = client.borrow_mut();
        let answer = client.identify().or_else(|_| client.identify());
        prop_assert_eq!(&answer.unwrap(), &identity);
    });
    rig.stop().unwrap();
}

/// Failing cases are not stored in a file: they also depend on the rig's state.
fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

/// A frame with exactly these bytes as its body.
fn framed(kind: u16, sequence: u16, body: &[u8]) -> Vec<u8> {
    /// Serialises as its bytes without a length.
    struct RawBytes<'a>(&'a [u8]);
    impl serde::Serialize for RawBytes<'_> {
        fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            use serde::ser::SerializeTuple;
            let mut tuple = serializer.serialize_tuple(self.0.len())?;
            self.0.iter().try_for_each(|byte| tuple.serialize_element(byte))?;
            tuple.end()
        }
    }
    let mut frame = [0; MAX_FRAME];
    let length = encode_frame(kind, sequence, &RawBytes(body), &mut frame).unwrap();
    frame[..length].to_vec()
}

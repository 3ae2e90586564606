//! The client against a minimal fake rig that misbehaves on purpose.

use std::collections::VecDeque;
use std::io;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use massline_protocol::event::STATUS_CHANGED;
use massline_protocol::message::{
    ANSWER, DeleteResult, GetIdentity, GetObjectInfo, GetStatus, Identity, ListRequest,
    ListResults, REFUSED, ReadObject, Reason, Refusal, ResultEntry, ResultPage, Status,
    SteerCampaign,
};
use massline_protocol::object::{Chunk, ChunkRequest, ObjectId, ObjectInfo};
use massline_protocol::{
    Deframer, Endpoint, Frame, MAX_FRAME, PROTOCOL_MAJOR, crc32, encode_frame,
};
use massline_shared::measurement::campaign::Command;
use massline_shared::signal::AdcProperties;
use massline_shared::units::{Hertz, Seconds, Volts};

use super::*;

const TIMING: Timing = Timing {
    answer: Duration::from_millis(30),
    attempts: 3,
    reconnect: Duration::from_millis(200),
    pause: Duration::from_millis(1),
};

/// The frames that the fake rig sends in answer to a frame; an error breaks the link instead.
type Handler = Box<dyn FnMut(Frame<'_>) -> io::Result<Vec<Vec<u8>>> + Send>;

struct FakeRig {
    handler: Handler,
    deframer: Deframer,
    to_host: VecDeque<u8>,
    plugged: bool,
    comes_back: bool,
}

impl FakeRig {
    fn new(handler: impl FnMut(Frame<'_>) -> io::Result<Vec<Vec<u8>>> + Send + 'static) -> Self {
        Self {
            handler: Box::new(handler),
            deframer: Deframer::new(),
            to_host: VecDeque::new(),
            plugged: true,
            comes_back: true,
        }
    }

    fn client(self) -> Client {
        Client::with_timing(self, TIMING)
    }
}

fn unplugged() -> io::Error {
    io::Error::new(io::ErrorKind::BrokenPipe, "unplugged")
}

impl Transport for FakeRig {
    fn read(&mut self, buffer: &mut [u8], _: Duration) -> io::Result<usize> {
        if !self.plugged {
            return Err(unplugged());
        }
        let n = buffer.len().min(self.to_host.len());
        for byte in &mut buffer[..n] {
            *byte = self.to_host.pop_front().unwrap();
        }
        Ok(n)
    }

    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        let mut rest = bytes;
        while self.plugged && !rest.is_empty() {
            let (taken, frame) = self.deframer.push(rest);
            rest = &rest[taken..];
            match frame.map(|frame| (self.handler)(frame.unwrap())) {
                Some(Ok(answers)) => self.to_host.extend(answers.concat()),
                Some(Err(_)) => {
                    self.plugged = false;
                    self.to_host.clear();
                }
                None => {}
            }
        }
        if self.plugged { Ok(()) } else { Err(unplugged()) }
    }

    fn reconnect(&mut self) -> io::Result<()> {
        self.plugged = self.comes_back;
        if self.plugged { Ok(()) } else { Err(unplugged()) }
    }

    fn name(&self) -> &str {
        "fake"
    }
}

fn frame<T: serde::Serialize>(kind: u16, sequence: u16, body: &T) -> Vec<u8> {
    let mut out = [0; MAX_FRAME];
    let n = encode_frame(kind, sequence, body, &mut out).unwrap();
    out[..n].to_vec()
}

fn answer<E: Endpoint>(to: Frame<'_>, response: &E::Response) -> Vec<u8> {
    frame(E::KIND | ANSWER, to.sequence, response)
}

fn status(phase: u8) -> Status {
    Status {
        phase,
        dof: 0,
        armings: 1,
        accepted: heapless::Vec::new(),
        hits_per_dof: 5,
        rejected: 0,
        last_hit: 0,
        layout_hash: 0,
        result: 0,
        started_unix_s: 0,
        diagnostics: heapless::Vec::new(),
    }
}

fn identity(protocol_major: u8) -> Identity {
    Identity {
        protocol_major,
        protocol_minor: 0,
        firmware: "0.1.0".try_into().unwrap(),
        git_hash: "0".try_into().unwrap(),
        git_dirty: false,
        board: "fake".try_into().unwrap(),
        adc: AdcProperties {
            rate: Hertz(4000.0),
            channels: 10,
            bits: 12,
            reference: Volts(3.0),
            channel_delay: Seconds(0.0),
        },
        record_scans: 2048,
        pre_trigger_scans: 80,
        max_sensors: 3,
        max_hits: 12,
        streams: false,
        boot_reason: 1,
        last_panic: heapless::String::new(),
    }
}

#[test]
fn a_request_that_is_lost_is_sent_again_with_the_same_sequence() {
    let heard = Arc::new(Mutex::new(Vec::new()));
    let log = heard.clone();
    let mut client = FakeRig::new(move |f| {
        log.lock().unwrap().push(f.sequence);
        let lost = log.lock().unwrap().len() < 3;
        Ok(if lost { vec![] } else { vec![answer::<SteerCampaign>(f, &status(4))] })
    })
    .client();
    assert_eq!(client.command(Command::Pause).unwrap().phase, 4);
    let heard = heard.lock().unwrap();
    assert_eq!(heard.len(), 3);
    assert!(heard.iter().all(|s| *s == heard[0]));
}

#[test]
fn the_next_request_has_another_sequence() {
    let heard = Arc::new(Mutex::new(Vec::new()));
    let log = heard.clone();
    let mut client = FakeRig::new(move |f| {
        log.lock().unwrap().push(f.sequence);
        Ok(vec![answer::<GetStatus>(f, &status(0))])
    })
    .client();
    client.status().unwrap();
    client.status().unwrap();
    let heard = heard.lock().unwrap();
    assert_ne!(heard[0], heard[1]);
}

#[test]
fn nobody_who_answers_is_named_with_attempts() {
    let mut client = FakeRig::new(|_| Ok(vec![])).client();
    let error = client.status().unwrap_err();
    assert_eq!(error.code(), "no_answer");
    assert!(error.to_string().contains("3 attempts"), "{error}");
}

#[test]
fn an_answer_to_another_request_or_of_another_kind_is_not_taken() {
    let mut client = FakeRig::new(|f| {
        Ok(vec![
            frame(GetStatus::KIND | ANSWER, f.sequence.wrapping_sub(1), &status(1)),
            frame(GetIdentity::KIND | ANSWER, f.sequence, &identity(1)),
            answer::<GetStatus>(f, &status(2)),
        ])
    })
    .client();
    assert_eq!(client.status().unwrap().phase, 2);
}

#[test]
fn events_between_request_and_answer_wait_in_the_queue() {
    let mut client = FakeRig::new(|f| {
        Ok(vec![
            frame(STATUS_CHANGED, 9, &status(1)),
            frame(0x4FFF, 10, &7_u8),
            answer::<GetStatus>(f, &status(2)),
        ])
    })
    .client();
    assert_eq!(client.status().unwrap().phase, 2);
    assert_eq!(client.next_event(Duration::ZERO).unwrap(), Some(Event::Status(status(1))));
    assert_eq!(client.next_event(Duration::ZERO).unwrap(), None);
}

#[test]
fn a_broken_answer_is_counted_and_asked_for_again() {
    let mut times = 0;
    let mut client = FakeRig::new(move |f| {
        times += 1;
        let mut bytes = answer::<GetStatus>(f, &status(3));
        if times == 1 {
            // Another byte that is not zero, which would end the frame and count twice.
            bytes[3] = if bytes[3] == 1 { 2 } else { 1 };
        }
        Ok(vec![bytes])
    })
    .client();
    assert_eq!(client.status().unwrap().phase, 3);
    assert_eq!(client.broken_frames(), 1);
}

#[test]
fn a_refusal_is_an_error_with_its_reason() {
    let mut client =
        FakeRig::new(|f| Ok(vec![frame(REFUSED, f.sequence, &Refusal::from(Reason::NotFound))]))
            .client();
    let error = client.ask::<DeleteResult>(&7).unwrap_err();
    assert_eq!(error.refusal(), Some(Reason::NotFound));
}

#[test]
fn another_protocol_major_is_named_with_both_versions() {
    let mut client =
        FakeRig::new(|f| Ok(vec![answer::<GetIdentity>(f, &identity(PROTOCOL_MAJOR + 1))]))
            .client();
    let error = massline_result::Error::from(client.identify().unwrap_err());
    assert_eq!(error.exit_code(), 4);
    assert_eq!(error.code(), "protocol_major_differs");
    let text = error.to_string();
    assert!(text.contains(&format!("{}.0", PROTOCOL_MAJOR + 1)), "{text}");
    assert!(text.contains(&format!("this program {PROTOCOL_MAJOR}.")), "{text}");
}

#[test]
fn the_list_of_results_is_read_page_by_page() {
    let entry = |number| ResultEntry { number, layout_hash: 1, mass: None, length: 9 };
    let mut client = FakeRig::new(move |f| {
        let ListRequest { after } = postcard::from_bytes(f.body).unwrap();
        let entries = [entry(after + 1), entry(after + 2)].into_iter().collect();
        Ok(vec![answer::<ListResults>(f, &ResultPage { entries, more: after < 4 })])
    })
    .client();
    let numbers: Vec<_> = client.results().unwrap().iter().map(|e| e.number).collect();
    assert_eq!(numbers, [1, 2, 3, 4, 5, 6]);
}

const OBJECT: ObjectId = ObjectId { kind: 1, number: 3 };

fn object_bytes() -> Vec<u8> {
    (0..5000_u32).map(|i| (i % 251) as u8).collect()
}

/// Serves [`object_bytes`]; `spoil` may change the answer to the n-th request for a chunk or break the link.
fn object_server(
    mut spoil: impl FnMut(u32, &mut Chunk) -> io::Result<()> + Send + 'static,
) -> FakeRig {
    let mut asked = 0;
    FakeRig::new(move |f| {
        let bytes = object_bytes();
        if f.kind == GetObjectInfo::KIND {
            let info = ObjectInfo { length: bytes.len() as u32, crc: crc32(&bytes) };
            return Ok(vec![answer::<GetObjectInfo>(f, &info)]);
        }
        let request: ChunkRequest = postcard::from_bytes(f.body).unwrap();
        let start = request.offset as usize;
        let end = start + usize::from(request.length);
        let mut chunk = Chunk {
            object: request.object,
            offset: request.offset,
            bytes: heapless::Vec::from_slice(&bytes[start..end]).unwrap(),
        };
        asked += 1;
        spoil(asked, &mut chunk)?;
        Ok(vec![answer::<ReadObject>(f, &chunk)])
    })
}

#[test]
fn an_object_arrives_whole() {
    let mut client = object_server(|_, _| Ok(())).client();
    let mut last = (0, 0);
    assert_eq!(client.download(OBJECT, |n, total| last = (n, total)).unwrap(), object_bytes());
    assert_eq!(last, (5000, 5000));
}

#[test]
fn a_download_goes_on_where_the_link_was_lost() {
    let offsets = Arc::new(Mutex::new(Vec::new()));
    let log = offsets.clone();
    let mut client = object_server(move |n, chunk| {
        log.lock().unwrap().push(chunk.offset);
        if n == 3 { Err(unplugged()) } else { Ok(()) }
    })
    .client();
    assert_eq!(client.download(OBJECT, |_, _| ()).unwrap(), object_bytes());
    assert_eq!(client.reconnects(), 1);
    assert_eq!(*offsets.lock().unwrap(), [0, 1024, 2048, 2048, 3072, 4096]);
}

#[test]
fn a_link_that_does_not_come_back_is_a_named_error() {
    let mut rig = object_server(|n, _| if n == 3 { Err(unplugged()) } else { Ok(()) });
    rig.comes_back = false;
    let error = rig.client().download(OBJECT, |_, _| ()).unwrap_err();
    assert_eq!(error.code(), "link_lost");
}

/// What a client tells its listener.
fn record_notices(client: Client) -> (Client, Arc<Mutex<Vec<String>>>) {
    let notices = Arc::new(Mutex::new(Vec::new()));
    let listener = notices.clone();
    (client.telling(move |text| listener.lock().unwrap().push(text.to_owned())), notices)
}

#[test]
fn a_rig_that_is_unplugged_or_silent_is_named_while_it_is_waited_for() {
    let mut rig = FakeRig::new(|_| Err(unplugged()));
    rig.comes_back = false;
    let (mut client, notices) = record_notices(rig.client());
    client.status().unwrap_err();
    let notices = notices.lock().unwrap().clone();
    assert_eq!(
        notices,
        ["fake is gone (unplugged): connect the rig again; waiting up to 0.2 s for it"]
    );
    let (mut client, notices) = record_notices(FakeRig::new(|_| Ok(Vec::new())).client());
    client.status().unwrap_err();
    let notices = notices.lock().unwrap().clone();
    assert_eq!(notices.len(), 2);
    assert!(notices[1].starts_with("no answer from fake for "), "{notices:?}");
    assert!(notices[1].ends_with("asking again (3 of 3)"), "{notices:?}");
}

/// Whoever follows a campaign hears of a silent rig after the attempts of one request.
#[test]
fn a_rig_that_falls_silent_during_a_campaign_is_asked_no_further_requests() {
    let asked = Arc::new(Mutex::new(0));
    let count = asked.clone();
    let mut client = FakeRig::new(move |_| {
        *count.lock().unwrap() += 1;
        Ok(Vec::new())
    })
    .client();
    let interrupt = crate::interrupt::Interrupt::new();
    let ended = crate::campaign::follow(&mut client, &interrupt, None, &mut ()).unwrap_err();
    assert_eq!(ended.code(), "no_answer");
    assert_eq!(*asked.lock().unwrap(), TIMING.attempts);
}

/// The error of a request to this rig after Ctrl-C, and how often the rig got it.
fn interrupted(mut rig: FakeRig) -> (massline_result::Error, u32) {
    let asked = Arc::new(Mutex::new(0));
    let count = asked.clone();
    let mut handler = rig.handler;
    rig.handler = Box::new(move |frame| {
        *count.lock().unwrap() += 1;
        handler(frame)
    });
    let interrupt = crate::interrupt::Interrupt::new();
    interrupt.press();
    let mut client = rig.client().interrupted_by(interrupt);
    let error = client.status().unwrap_err().into();
    let asked = *asked.lock().unwrap();
    (error, asked)
}

#[test]
fn an_interrupt_ends_the_wait_for_a_silent_rig_after_one_attempt() {
    let (error, asked) = interrupted(FakeRig::new(|_| Ok(Vec::new())));
    assert_eq!((error.code(), error.exit_code(), asked), ("interrupted", 130, 1));
    assert_eq!(error.to_string(), "interrupted while fake did not answer");
}

#[test]
fn an_interrupt_ends_the_wait_for_a_lost_link() {
    let mut rig = FakeRig::new(|_| Err(unplugged()));
    rig.comes_back = false;
    let began = std::time::Instant::now();
    let (error, _) = interrupted(rig);
    assert!(began.elapsed() < TIMING.reconnect, "{:?}", began.elapsed());
    assert_eq!(error.to_string(), "interrupted while fake was gone (unplugged)");
}

#[test]
fn an_object_that_changed_on_the_way_is_read_again() {
    let mut client = object_server(|n, chunk| {
        if n == 2 {
            chunk.bytes[0] ^= 1;
        }
        Ok(())
    })
    .client();
    assert_eq!(client.download(OBJECT, |_, _| ()).unwrap(), object_bytes());
}

#[test]
fn an_object_that_is_always_wrong_is_not_accepted() {
    let mut client = object_server(|_, chunk| {
        chunk.bytes[0] ^= 1;
        Ok(())
    })
    .client();
    assert_eq!(client.download(OBJECT, |_, _| ()).unwrap_err().code(), "checksum_differs");
}

#[test]
fn chunks_of_another_object_or_place_are_not_accepted() {
    for wrong in [
        |chunk: &mut Chunk| chunk.object.number += 1,
        |chunk: &mut Chunk| chunk.offset += 1,
        |chunk: &mut Chunk| chunk.bytes.clear(),
    ] {
        let mut client = object_server(move |_, chunk| {
            wrong(chunk);
            Ok(())
        })
        .client();
        assert_eq!(client.download(OBJECT, |_, _| ()).unwrap_err().code(), "checksum_differs");
    }
}

#[test]
fn a_length_beyond_reason_is_not_believed() {
    let mut client = FakeRig::new(|f| {
        Ok(vec![answer::<GetObjectInfo>(f, &ObjectInfo { length: u32::MAX, crc: 0 })])
    })
    .client();
    assert_eq!(client.download(OBJECT, |_, _| ()).unwrap_err().code(), "checksum_differs");
}

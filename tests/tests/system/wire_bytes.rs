//! The bytes of every message, as committed in `tests/golden/wire.txt`.
//!
//! They change only on purpose: `MASSLINE_BLESS=1 cargo test -p massline-tests --test system -- wire_bytes::`
//! rewrites them.

use std::fmt::Write as _;
use std::path::Path;

use heapless::{String, Vec};
use massline_protocol::event::{HIT, HitEvent, SCAN_BLOCK_BYTES, SCANS, STATUS_CHANGED, ScanBlock};
use massline_protocol::lines::LinesId;
use massline_protocol::message::*;
use massline_protocol::object::*;
use massline_protocol::{Deframer, Endpoint, MAX_FRAME, MAX_LAYOUT, encode_frame};
use massline_shared::calibration::{CalibrationMethod, CalibrationRecord, CalibrationSigma};
use massline_shared::diagnosis::{Code, Diagnostic, Diagnostics, Setting, Severity, Subject};
use massline_shared::identify::Consistency;
use massline_shared::identify::Method;
use massline_shared::layout::{
    AttachedBody, Axis, Dof, FrfEstimator, Hit, MAX_ATTACHED, Prior, RIG_HITS, RIG_SENSORS,
    RigLayout, Sensor, Sign, Target,
};
use massline_shared::mass_line::Terms;
use massline_shared::measurement::campaign::{Command, Object, Phase, Start};
use massline_shared::signal::{AdcProperties, CHANNELS, RESPONSES, RestStatistics};
use massline_shared::units::{Hertz, Seconds, Volts};
use serde::Serialize;

fn text<const N: usize>(s: &str) -> String<N> {
    s.try_into().unwrap()
}

fn diagnostics(n: usize) -> Diagnostics {
    let subjects = [
        (Code::Overload, Subject::Channel(4)),
        (Code::NoPlateau, Subject::Response { hit: 1, response: 5 }),
        (Code::LargeSensorPull, Subject::Sensor(2)),
        (Code::DofSkipped, Subject::Hit(3)),
        (Code::PriorInconsistentWithData, Subject::Property(9)),
        (Code::SettingOutOfRange, Subject::Setting(Setting::BandUpper)),
        (Code::GravityNotGiven, Subject::Whole),
    ];
    let about = |(code, subject)| Diagnostic::about(code, Severity::Warning, subject, 1.5);
    subjects.into_iter().map(about).cycle().take(n).collect()
}

fn dof(node: u16) -> Dof {
    Dof { node, sign: Sign::Minus, axis: Axis::Z }
}

fn layout(sensors: usize, hits: usize) -> RigLayout {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let sensor = |i: usize| Sensor::new(i as u16 + 1, [0.1, -0.2, i as f32], axes);
    let hit = |i: usize| Hit::new(dof(i as u16), [0.0; 3], [0.0, 0.0, -1.0]);
    RigLayout {
        target: Target { mass: Some(0.01), center: Some(0.001), inertia: Some(0.02) },
        title: text("three-bar frame, with a title of forty-eight byt"),
        gravity: Some([0.0, 0.0, -9.80665]),
        sensors: (0..sensors).map(sensor).collect(),
        hits: (0..hits).map(hit).collect(),
        priors: (0..10).map(|property| Prior { property, value: 1.5, sigma: 0.25 }).collect(),
        attached: (0..MAX_ATTACHED)
            .map(|_| AttachedBody::point(0.5, 0.125, [1.0, 2.0, -1.0]))
            .collect(),
        ..RigLayout::default()
    }
}

fn calibration() -> CalibrationRecord {
    let mut record = CalibrationRecord {
        method: CalibrationMethod::TumbleAndBlock,
        date: text("2026-03-14"),
        hammer: text("hammer 12345"),
        sensors: [text("A17"), text(""), text("sensor 12345")],
        temperature: Some(21.5),
        ..CalibrationRecord::default()
    };
    record.calibration.cross_axis[1].yz = -0.015625;
    record
}

fn reading() -> RestStatistics {
    RestStatistics { scans: 2048, mean: [2047.75; CHANNELS], deviation: [0.625; CHANNELS] }
}

fn identity() -> Identity {
    Identity {
        protocol_major: 1,
        protocol_minor: 0,
        firmware: text("0.1.0"),
        git_hash: text("0123456789ab"),
        git_dirty: false,
        board: text("virtual"),
        adc: AdcProperties {
            rate: Hertz(4000.0),
            channels: 10,
            bits: 12,
            reference: Volts(3.0),
            channel_delay: Seconds(10e-6),
        },
        record_scans: 2048,
        pre_trigger_scans: 80,
        max_sensors: 3,
        max_hits: 12,
        streams: true,
        boot_reason: 1,
        last_panic: text(""),
    }
}

fn hardware() -> Hardware {
    Hardware { clock: 2, brown_out_mv: Some(2700), supply_is_low: true, converter: 4, wrong_tag: 7 }
}

fn battery() -> Battery {
    Battery { millivolts: 3840, percent: 64 }
}

fn status(dofs: usize) -> Status {
    Status {
        phase: u8::from(Phase::Armed),
        dof: 2,
        armings: 17,
        accepted: (0..dofs).map(|i| i as u8).collect(),
        hits_per_dof: 5,
        rejected: 1,
        last_hit: 16,
        layout_hash: 0xDEAD_BEEF,
        result: 0,
        started_unix_s: 1_795_000_000,
        diagnostics: diagnostics(1),
    }
}

fn entry(number: u32) -> ResultEntry {
    let mass = EstimatedMass { value: 1.23, sigma: Some(0.005) };
    ResultEntry { number, layout_hash: 7, mass: (number % 2 == 1).then_some(mass), length: 1234 }
}

fn result(dofs: usize) -> MeasurementResult {
    let one = |i: usize| DofResult {
        dof: dof(i as u16),
        index: i as u8,
        hits: 5,
        band_hz: [10.0, 120.0],
        accelerance: [0.5; RESPONSES],
        noise: [0.001; RESPONSES],
        scatter: (0..SCATTER).map(|_| 1e-6).collect(),
        coherence: Some([0.999; RESPONSES]),
        trend: StoredTrend { mean: 400.0, squares: 1e5, products: [0.1; RESPONSES] },
        band_shift: [1e-4; RESPONSES],
    };
    let estimate = StoredEstimate {
        method: Method::InertiaRestraint.number(),
        properties: [1.0; 10],
        covariance: (0..COVARIANCE).map(|_| 1e-9).collect(),
        condition: 20.0,
        consistency: Some(Consistency { chi_squared: 21.5, degrees_of_freedom: 17 }),
        learned: None,
        diagnostics: diagnostics(1),
    };
    MeasurementResult {
        head: ResultHead {
            number: 3,
            layout_hash: 7,
            title: text("frame"),
            started_unix_s: 1_795_000_000,
            calibration: 8,
            gains: None,
            firmware: text("0.1.0"),
            frf_estimator: FrfEstimator::H1,
            terms: Terms::Abc,
            band_automatic: false,
        },
        dofs: (0..dofs).map(one).collect(),
        lines: Default::default(),
        estimates: Vec::from_slice(&[estimate]).unwrap(),
        diagnostics: diagnostics(1),
    }
}

fn object() -> ObjectId {
    ObjectId { kind: ObjectKind::Result as u8, number: 3 }
}

fn stored_layout() -> ObjectId {
    ObjectId { kind: ObjectKind::Layout as u8, number: 0x7500_bcfb }
}

fn lines() -> ObjectId {
    LinesId { result: 3, dof: 11 }.object().unwrap()
}

fn frame<T: Serialize>(kind: u16, message: &T) -> std::vec::Vec<u8> {
    let mut out = [0; MAX_FRAME];
    let length = encode_frame(kind, 0x0102, message, &mut out).expect("fits a frame");
    out[..length].to_vec()
}

fn request<E: Endpoint>(message: E::Request) -> std::vec::Vec<u8> {
    frame(E::KIND, &message)
}

fn answer<E: Endpoint>(message: E::Response) -> std::vec::Vec<u8> {
    frame(E::KIND | ANSWER, &message)
}

fn messages() -> std::vec::Vec<(&'static str, std::vec::Vec<u8>)> {
    let start = Start {
        object: Object::Block { mass: 2.5 },
        confirm: true,
        calibration_age_days: 300,
        started_unix_s: 1_795_000_000,
    };
    let chunk_request = ChunkRequest { object: object(), offset: 1024, length: 512 };
    let chunk =
        Chunk { object: object(), offset: 1024, bytes: Vec::from_slice(&[1, 2, 0, 3]).unwrap() };
    let page = ResultPage { entries: Vec::from_slice(&[entry(3)]).unwrap(), more: false };
    let hit = HitEvent {
        number: 16,
        dof: 2,
        good: false,
        scan: 123_456_789_012,
        peak_force: 21.5,
        peak_acceleration: 99.0,
        swing: None,
        findings: diagnostics(7),
    };
    let scans = ScanBlock { first: 77, codes: Vec::from_slice(&[1, 2]).unwrap() };
    let accepted = LayoutAnswer { hash: 9, diagnostics: diagnostics(2) };
    vec![
        ("GetIdentity request", request::<GetIdentity>(())),
        ("GetIdentity answer", answer::<GetIdentity>(identity())),
        ("GetStatus request", request::<GetStatus>(())),
        ("GetStatus answer", answer::<GetStatus>(status(3))),
        ("GetStats request", request::<GetStats>(())),
        ("GetStats answer", answer::<GetStats>(Stats { scans: 5, ..Stats::default() })),
        ("PutLayout request", request::<PutLayout>(layout(3, 3))),
        ("PutLayout answer", answer::<PutLayout>(accepted)),
        ("GetLayout request", request::<GetLayout>(())),
        ("GetLayout answer", answer::<GetLayout>(layout(1, 1))),
        ("PutCalibration request", request::<PutCalibration>(calibration())),
        ("PutCalibration answer", answer::<PutCalibration>(())),
        ("GetCalibration request", request::<GetCalibration>(())),
        ("GetCalibration answer", answer::<GetCalibration>(calibration())),
        ("StartCampaign request", request::<StartCampaign>(StartRequest { start, force: false })),
        ("StartCampaign answer", answer::<StartCampaign>(status(1))),
        ("SteerCampaign request", request::<SteerCampaign>(Command::Undo)),
        ("SteerCampaign answer", answer::<SteerCampaign>(status(1))),
        ("GetObjectInfo request", request::<GetObjectInfo>(object())),
        ("GetObjectInfo request, layout", request::<GetObjectInfo>(stored_layout())),
        ("GetObjectInfo answer", answer::<GetObjectInfo>(ObjectInfo { length: 4000, crc: 1 })),
        ("ReadObject request", request::<ReadObject>(chunk_request)),
        ("ReadObject answer", answer::<ReadObject>(chunk)),
        ("ListResults request", request::<ListResults>(ListRequest { after: 2 })),
        ("ListResults answer", answer::<ListResults>(page)),
        ("DeleteResult request", request::<DeleteResult>(3)),
        ("DeleteResult answer", answer::<DeleteResult>(())),
        ("SetStream request", request::<SetStream>(true)),
        ("SetStream answer", answer::<SetStream>(())),
        ("TakeReading request", request::<TakeReading>(())),
        ("TakeReading answer", answer::<TakeReading>(())),
        ("EraseStore request", request::<EraseStore>(())),
        ("EraseStore answer", answer::<EraseStore>(())),
        ("GetBattery request", request::<GetBattery>(())),
        ("GetBattery answer", answer::<GetBattery>(Some(battery()))),
        ("GetBattery answer without one", answer::<GetBattery>(None)),
        ("GetHardware request", request::<GetHardware>(())),
        ("GetHardware answer", answer::<GetHardware>(hardware())),
        ("SetBrownOut request", request::<SetBrownOut>(())),
        ("SetBrownOut answer", answer::<SetBrownOut>(())),
        ("GetRestStatistics request", request::<GetRestStatistics>(())),
        ("GetRestStatistics answer", answer::<GetRestStatistics>(reading())),
        ("GetLevels request", request::<GetLevels>(())),
        ("GetLevels answer", answer::<GetLevels>([0, 1, 2, 3, 4, 5, 6, 7, 8, 16])),
        ("GetMassLines request", request::<GetMassLines>(2)),
        ("GetMassLines answer", answer::<GetMassLines>(result(1).dofs[0].clone())),
        ("GetObjectInfo request, lines", request::<GetObjectInfo>(lines())),
        (
            "ReadObject request, lines",
            request::<ReadObject>(ChunkRequest { object: lines(), offset: 4096, length: 1024 }),
        ),
        ("refusal of an undo", frame(REFUSED, &Refusal::from(Reason::HitOverwritten))),
        ("refusal", frame(REFUSED, &Refusal::from(Reason::WrongPhase))),
        ("event: status changed", frame(STATUS_CHANGED, &status(2))),
        ("event: hit", frame(HIT, &hit)),
        ("event: scans", frame(SCANS, &scans)),
    ]
}

#[test]
fn every_message_has_the_committed_bytes() {
    let mut now = std::string::String::new();
    for (name, bytes) in messages() {
        write!(now, "{name}:").unwrap();
        for byte in bytes {
            write!(now, " {byte:02x}").unwrap();
        }
        now.push('\n');
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("golden/wire.txt");
    if std::env::var_os("MASSLINE_BLESS").is_some() {
        std::fs::write(&path, &now).unwrap();
    }
    let committed = std::fs::read_to_string(&path).expect("golden/wire.txt is committed");
    for (now, committed) in now.lines().zip(committed.lines()) {
        assert_eq!(now, committed, "a message has changed on the wire");
    }
    assert_eq!(now.lines().count(), committed.lines().count());
}

#[test]
fn every_endpoint_is_among_the_committed_bytes() {
    let messages = messages();
    for (_, name, _) in ENDPOINTS {
        for part in ["request", "answer"] {
            let wanted = format!("{name} {part}");
            assert!(messages.iter().any(|(name, _)| *name == wanted), "{wanted}");
        }
    }
}

#[test]
fn kinds_are_unique_and_leave_the_answer_bit_free() {
    for (i, (kind, ..)) in ENDPOINTS.iter().enumerate() {
        assert_eq!(kind & ANSWER, 0);
        assert!(ENDPOINTS[i + 1..].iter().all(|(other, ..)| other != kind));
        assert!(![HIT, SCANS, STATUS_CHANGED].contains(kind));
    }
}

#[test]
fn the_largest_of_each_growing_message_fits_a_frame() {
    let largest = layout(RIG_SENSORS, RIG_HITS);
    let encoded = postcard::to_stdvec(&largest).unwrap();
    assert!(encoded.len() <= MAX_LAYOUT, "{}", encoded.len());
    request::<PutLayout>(largest);
    let mut identity = identity();
    identity.last_panic = text(&"p".repeat(96));
    answer::<GetIdentity>(identity);
    answer::<GetStatus>(full_status());
    answer::<GetMassLines>(result(1).dofs[0].clone());
    let bytes: Vec<u8, MAX_CHUNK> = (0..MAX_CHUNK).map(|_| 0xFF).collect();
    let (object, offset) = (ObjectId { kind: u8::MAX, number: u32::MAX }, u32::MAX);
    let chunk = ChunkRef { object, offset, bytes: &bytes };
    let sent = frame(ReadObject::KIND | ANSWER, &chunk);
    assert_eq!(sent, answer::<ReadObject>(Chunk { object, offset, bytes }));
    let entries = (0..16).map(|i| entry(u32::MAX - i)).collect();
    answer::<ListResults>(ResultPage { entries, more: true });
    let codes = (0..SCAN_BLOCK_BYTES).map(|_| 0xFF).collect();
    frame(SCANS, &ScanBlock { first: u64::MAX, codes });
}

/// As many as fit, each with the largest numbers that a rig can pass on.
fn longest_diagnostics() -> Diagnostics {
    let longest = Diagnostic {
        code: Code::Unknown(u16::MAX),
        severity: Severity::Error,
        subject: Subject::response(usize::MAX, usize::MAX),
        value: 1.0,
    };
    (0..16).map(|_| longest).collect()
}

fn full_status() -> Status {
    Status {
        armings: u32::MAX,
        accepted: Vec::from_slice(&[u8::MAX; RIG_HITS]).unwrap(),
        rejected: u16::MAX,
        last_hit: u32::MAX,
        layout_hash: u32::MAX,
        result: u32::MAX,
        started_unix_s: u32::MAX,
        diagnostics: longest_diagnostics(),
        ..status(0)
    }
}

#[test]
fn the_largest_answer_to_a_change_is_kept_for_a_repetition() {
    let Status { diagnostics, .. } = full_status();
    let largest = [
        answer::<StartCampaign>(full_status()),
        answer::<SteerCampaign>(full_status()),
        answer::<PutLayout>(LayoutAnswer { hash: u32::MAX, diagnostics }),
        answer::<PutCalibration>(()),
        answer::<DeleteResult>(()),
        answer::<SetStream>(()),
        answer::<TakeReading>(()),
        answer::<EraseStore>(()),
        answer::<SetBrownOut>(()),
        frame(REFUSED, &Refusal { reason: u16::MAX, results_to_delete: u8::MAX }),
    ];
    let longest = largest.iter().map(|bytes| bytes.len()).max();
    assert!(longest <= Some(MAX_CHANGE_ANSWER), "{longest:?}");
    let changing = ENDPOINTS.iter().filter(|(.., changes)| *changes).count();
    assert_eq!(largest.len(), changing + 1, "every request that changes the rig, and a refusal");
}

#[test]
fn the_largest_result_of_every_number_of_dofs_fits_the_store() {
    use massline_firmware::store::{MAX_DOF, MAX_ESTIMATE, MAX_RESULT};
    use massline_shared::identify::MASS_LINE_METHODS;
    for dofs in 0..=RIG_HITS {
        let mut largest = result(dofs);
        for dof in &mut largest.dofs {
            dof.dof.node = u16::MAX;
        }
        largest.head.number = u32::MAX;
        largest.head.layout_hash = u32::MAX;
        largest.head.calibration = u32::MAX;
        largest.head.firmware = text(&"9".repeat(16));
        // The rig produces these diagnostics itself, so their codes are known ones.
        largest.diagnostics = diagnostics(16);
        largest.estimates[0].diagnostics = diagnostics(16);
        let answer = largest.estimates[0].clone();
        let answers = core::iter::repeat_n(answer.clone(), MASS_LINE_METHODS);
        largest.estimates = answers.collect();
        assert!(postcard::to_stdvec(&answer).unwrap().len() <= MAX_ESTIMATE);
        let bytes = postcard::to_stdvec(&largest).unwrap();
        let room = MAX_RESULT - (RIG_HITS - dofs) * MAX_DOF;
        assert!(bytes.len() <= room, "{dofs} DOFs: {} of {room} bytes", bytes.len());
        let longest = largest.dofs.iter().map(|dof| postcard::to_stdvec(dof).unwrap().len()).max();
        assert!(longest.is_none_or(|longest| longest <= MAX_DOF), "{longest:?}");
    }
}

#[test]
fn the_largest_result_of_the_suspension_profile_fits_the_store() {
    use massline_firmware::store::{MAX_LINES_HEAD, MAX_RESULT_HEAD};
    use massline_protocol::lines_head::LinesHead;
    let dof = LinesHead {
        dof: "65535:-Z".parse().unwrap(),
        index: 11,
        hits: u16::MAX,
        band_hz: [0.5, 12.4],
        coherence: Some([0.999; RESPONSES]),
        mean_squared: 1.0,
        scatter_squared: 1.0,
    };
    let plain = result(0);
    let mut largest = MeasurementResult {
        head: ResultHead {
            number: u32::MAX,
            layout_hash: u32::MAX,
            calibration: u32::MAX,
            title: text(&"9".repeat(48)),
            gains: Some(CalibrationSigma { gain: 0.01, cross_axis: 0.01, hammer_gain: 0.01 }),
            started_unix_s: u32::MAX,
            firmware: text(&"9".repeat(16)),
            ..plain.head.clone()
        },
        lines: core::iter::repeat_n(dof, RIG_HITS).collect(),
        estimates: heapless::Vec::new(),
        diagnostics: diagnostics(16),
        ..plain
    };
    let bytes = postcard::to_stdvec(&largest).unwrap();
    assert_eq!(postcard::from_bytes::<MeasurementResult>(&bytes).unwrap(), largest);
    for dofs in 0..=RIG_HITS {
        largest.lines.truncate(RIG_HITS - dofs);
        let bytes = postcard::to_stdvec(&largest).unwrap();
        let room = MAX_RESULT_HEAD + largest.lines.len() * MAX_LINES_HEAD;
        assert!(bytes.len() <= room, "{dofs} fewer DOFs: {} of {room} bytes", bytes.len());
    }
}

#[test]
fn what_was_encoded_is_decoded_to_the_same() {
    let bytes = answer::<GetStatus>(status(3));
    let mut deframer = Deframer::new();
    let (_, frame) = deframer.push(&bytes);
    let body = frame.expect("a frame").expect("a whole one").body;
    assert_eq!(postcard::from_bytes::<Status>(body).unwrap(), status(3));
    let bytes = postcard::to_stdvec(&result(2)).unwrap();
    assert_eq!(postcard::from_bytes::<MeasurementResult>(&bytes).unwrap(), result(2));
}

use std::fs;

use massline_protocol::LayoutHash;
use massline_shared::layout::RigLayout;
use massline_shared::signal::{RECORD_SCANS, Scan};
use massline_shared::units::{Hertz, Seconds, Volts};

use super::*;
use crate::file::ExistingFile;
use crate::layout_file::LayoutFile;

fn layout() -> RigLayout {
    let text = include_str!("../../../examples/three-bar-test-1.toml");
    LayoutFile::parse(text, "l").unwrap().rig_layout().unwrap()
}

fn sidecar(segments: &[(u64, &str)]) -> Sidecar {
    let segments =
        segments.iter().map(|&(start, dof)| Segment { start, dof: dof.parse().unwrap() }).collect();
    Sidecar {
        adc: AdcProperties {
            rate: Hertz(4000.0),
            channels: 10,
            bits: 16,
            reference: Volts(3.3),
            channel_delay: Seconds(25e-6),
        },
        calibration: Calibration::default(),
        pre_trigger_scans: 80,
        layout_hash: layout().hash(),
        segments,
    }
}

/// Every channel of scan `k` holds `k` plus the number of the channel.
fn scans(count: u16) -> Vec<Scan> {
    (0..count).map(|k| std::array::from_fn(|channel| k + channel as u16)).collect()
}

fn npy(dictionary: &str, version: u8, data: &[u8]) -> Vec<u8> {
    let mut bytes = b"\x93NUMPY".to_vec();
    bytes.extend([version, 0]);
    match version {
        1 => bytes.extend((dictionary.len() as u16).to_le_bytes()),
        _ => bytes.extend((dictionary.len() as u32).to_le_bytes()),
    }
    bytes.extend(dictionary.as_bytes());
    bytes.extend(data);
    bytes
}

const GOOD: &str = "{'descr': '<u2', 'fortran_order': False, 'shape': (2, 10), }   \n";

#[test]
fn a_tape_reads_back_what_was_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tape.npy");
    let sidecar = sidecar(&[(0, "1:+Y"), (300, "2:+Z")]);
    let mut writer = TapeWriter::create(&path, sidecar.clone(), ExistingFile::Kept).unwrap();
    writer.push(&scans(400)[..150]).unwrap();
    writer.push(&scans(400)[150..]).unwrap();
    writer.segment(Segment { start: 350, dof: "4:+X".parse().unwrap() }).unwrap();
    assert_eq!(writer.finish().unwrap(), 400);
    let mut tape = Tape::read(&path).unwrap();
    assert_eq!(tape.scans.to_vec().unwrap(), scans(400));
    assert_eq!(tape.sidecar.segments[..2], sidecar.segments[..]);
    assert_eq!(tape.sidecar.segments[2].start, 350);
    assert_eq!(Sidecar { segments: sidecar.segments.clone(), ..tape.sidecar }, sidecar);
}

#[test]
fn the_header_is_as_numpy_writes_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tape.npy");
    let mut writer = TapeWriter::create(&path, sidecar(&[]), ExistingFile::Kept).unwrap();
    writer.push(&scans(2)).unwrap();
    writer.finish().unwrap();
    let bytes = fs::read(&path).unwrap();
    // The header that numpy.save writes for numpy.zeros((2, 10), '<u2'): 118 = 0x76 bytes of text, padded to 128 in
    // total.
    assert!(bytes.starts_with(
        b"\x93NUMPY\x01\x00\x76\x00{'descr': '<u2', 'fortran_order': False, 'shape': (2, 10), }  "
    ));
    assert_eq!(bytes[127], b'\n');
    assert_eq!(bytes.len(), 128 + 40);
}

/// The scans of a segment that holds a record.
const WHOLE: u16 = (LEAD_IN_SCANS + RECORD_SCANS) as u16;

fn files(folder: &tempfile::TempDir) -> Vec<String> {
    let names = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name());
    let mut names: Vec<String> = names.map(|name| name.into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_recording_that_fails_keeps_whole_hits_and_leaves_nothing_without_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tape.npy");
    let last = u64::from(WHOLE);
    let written = |segments: &[(u64, &str)]| {
        let mut writer = TapeWriter::create(&path, sidecar(segments), ExistingFile::Kept).unwrap();
        assert_eq!(files(&folder), ["tape.partial.npy", "tape.partial.toml"]);
        writer.push(&scans(WHOLE + 7)).unwrap();
        writer
    };
    assert_eq!(written(&[(8, "1:+Y")]).keep().unwrap(), None);
    drop(written(&[(8, "1:+Y")]));
    written(&[(0, "1:+Y")]).discard();
    assert!(files(&folder).is_empty());
    assert_eq!(written(&[(7, "1:+Y"), (last, "2:+Z")]).keep().unwrap(), Some(last + 7));
    assert_eq!(files(&folder), ["tape.npy", "tape.toml"]);
    let tape = Tape::read(&path).unwrap();
    assert_eq!((tape.cut_short, tape.scans.count()), (false, last + 7));
    assert_eq!(tape.sidecar.segments.len(), 1);
    for file in [&path, &sidecar_path(&path)] {
        fs::remove_file(file).unwrap();
    }
    drop(written(&[(7, "1:+Y")]));
    assert_eq!(Tape::read(&path).unwrap().sidecar.segments.len(), 1);
}

#[test]
fn a_tape_to_be_replaced_stays_until_the_new_one_is_complete() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tape.npy");
    let create = |existing| TapeWriter::create(&path, sidecar(&[]), existing);
    let mut writer = create(ExistingFile::Kept).unwrap();
    writer.push(&scans(3)).unwrap();
    writer.finish().unwrap();
    let old = || Tape::read(&path).unwrap().scans.count();
    // A folder of that name cannot become a file.
    let obstacle = folder.path().join("tape.partial.npy");
    fs::create_dir(&obstacle).unwrap();
    assert_eq!(create(ExistingFile::Replaced).unwrap_err().code(), "cannot_write");
    assert_eq!(old(), 3);
    fs::remove_dir(obstacle).unwrap();
    let mut writer = create(ExistingFile::Replaced).unwrap();
    writer.push(&scans(5)).unwrap();
    assert_eq!(old(), 3);
    writer.finish().unwrap();
    assert_eq!((old(), files(&folder)), (5, vec!["tape.npy".into(), "tape.toml".into()]));
}

#[test]
fn both_header_versions_are_read() {
    let data: Vec<u8> = scans(2).as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect();
    for version in [1, 2, 3] {
        assert_eq!(scans_of_npy(npy(GOOD, version, &data)).unwrap().to_vec().unwrap(), scans(2));
    }
    assert_eq!(scans_of_npy(npy(GOOD, 4, &data)).unwrap_err().code(), "tape_malformed");
}

#[test]
fn other_types_shapes_and_orders_are_named() {
    let data = [0; 40];
    let error = |from: &str, to: &str| {
        assert!(GOOD.contains(from));
        scans_of_npy(npy(&GOOD.replacen(from, to, 1), 1, &data)).unwrap_err()
    };
    for (from, to, code, word) in [
        ("<u2", ">u2", "tape_wrong_type", ">u2"),
        ("<u2", "<f8", "tape_wrong_type", "<f8"),
        ("'<u2'", "[('a', '<u2'), ('b', '<u2')]", "tape_wrong_type", "'b'"),
        ("(2, 10)", "(20,)", "tape_wrong_shape", "(20,)"),
        ("(2, 10)", "(4, 5)", "tape_wrong_shape", "(4, 5)"),
        ("(2, 10)", "(1, 2, 10)", "tape_wrong_shape", "(1, 2, 10)"),
        ("(2, 10)", "(-2, 10)", "tape_malformed", "shape"),
        ("False", "True", "tape_wrong_shape", "Fortran"),
        ("(2, 10)", "(3, 10)", "tape_truncated", "60 bytes"),
        ("(2, 10)", "(18446744073709551, 10)", "tape_truncated", "40 are there"),
        ("(2, 10)", "(1844674407370955161, 10)", "tape_truncated", "40 are there"),
        ("(2, 10)", "(1844674407370955162, 10)", "tape_malformed", "shape"),
        ("'descr'", "'type'", "tape_malformed", "the key \"type\""),
    ] {
        let error = error(from, to);
        assert_eq!(error.code(), code, "{to}: {error}");
        assert!(error.to_string().contains(word), "{to}: {error}");
        assert_eq!(error.exit_code(), 2);
    }
    for length in 0..70 {
        assert!(scans_of_npy(npy(GOOD, 1, &data)[..length].to_vec()).is_err());
    }
}

#[test]
fn a_segment_past_the_end_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tape.npy");
    let mut writer =
        TapeWriter::create(&path, sidecar(&[(7, "1:+Y")]), ExistingFile::Kept).unwrap();
    writer.push(&scans(7)).unwrap();
    writer.finish().unwrap();
    let error = Tape::read(&path).unwrap_err().to_string();
    assert!(error.contains("tape.toml") && error.contains("scan 7"), "{error}");
    fs::remove_file(sidecar_path(&path)).unwrap();
    assert_eq!(Tape::read(&path).unwrap_err().code(), "sidecar_not_readable");
}

#[test]
fn a_bad_sidecar_is_named() {
    let good = sidecar(&[(0, "1:+Y")]).to_toml();
    let error = |from: &str, to: &str| {
        assert!(good.contains(from), "{good}");
        Sidecar::parse(&good.replacen(from, to, 1), "s.toml").unwrap_err().to_string()
    };
    let channels = error("channels = 10", "channels = 9");
    assert!(channels.starts_with("s.toml:2: channels: 9 is not valid"), "{channels}");
    assert!(error("adc_bits = 16", "adc_bits = 24").starts_with("s.toml:3: adc_bits: 24 is"));
    assert!(error("1:+Y", "1:up").contains("segment.dof: \"1:up\""), "{}", error("1:+Y", "1:up"));
    let rate = error("scan_rate_hz = 4000.0", "scan_rate_hz = nan");
    assert!(rate.starts_with("s.toml:1: scan_rate_hz: NaN is not valid"), "{rate}");
    assert!(error("pre_trigger_scans", "pretrigger").starts_with("s.toml:6: "));
}

#[test]
fn a_tape_replaces_an_earlier_tape_when_it_may_and_never_another_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("frame.npy");
    let layout = folder.path().join("frame.toml");
    fs::write(&layout, "title = \"a layout\"\n").unwrap();
    assert!(TapeWriter::create(&path, sidecar(&[]), ExistingFile::Replaced).is_err());
    assert_eq!(fs::read_to_string(&layout).unwrap(), "title = \"a layout\"\n");
    assert!(!path.exists());
    fs::remove_file(&layout).unwrap();
    TapeWriter::create(&path, sidecar(&[]), ExistingFile::Kept).unwrap().finish().unwrap();
    let error = TapeWriter::create(&path, sidecar(&[]), ExistingFile::Kept).unwrap_err();
    assert_eq!(error.code(), "file_exists");
    TapeWriter::create(&path, sidecar(&[]), ExistingFile::Replaced).unwrap().finish().unwrap();
    let nowhere = folder.path().join("none").join("frame.npy");
    assert!(TapeWriter::check(&nowhere, ExistingFile::Kept).is_err());
    assert!(TapeWriter::check(&folder.path().join("frame"), ExistingFile::Kept).is_err());
}

#[test]
fn a_tape_whose_writer_was_killed_has_its_whole_scans_and_the_segments_with_a_whole_record() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tape.npy");
    let partial = folder.path().join("tape.partial.npy");
    let whole = u64::from(WHOLE);
    let mut writer = TapeWriter::create(&path, sidecar(&[]), ExistingFile::Kept).unwrap();
    assert_eq!(Tape::read(&partial).unwrap_err().code(), "tape_empty");
    writer.push(&scans(2 * WHOLE)).unwrap();
    for start in [0, whole, whole + 1] {
        writer.segment(Segment { start, dof: "1:+Y".parse().unwrap() }).unwrap();
    }
    // A killed process runs no destructor.
    std::mem::forget(writer);
    // Half of a scan more, as far as the system came.
    let mut bytes = fs::read(&partial).unwrap();
    bytes.extend([0; 9]);
    fs::write(&partial, bytes).unwrap();
    assert_eq!(files(&folder), ["tape.partial.npy", "tape.partial.toml"]);
    let mut tape = Tape::read(&partial).unwrap();
    assert!(tape.cut_short);
    assert_eq!(tape.scans.to_vec().unwrap(), scans(2 * WHOLE));
    let starts: Vec<u64> = tape.sidecar.segments.iter().map(|s| s.start).collect();
    assert_eq!(starts, [0, whole]);
    // The hits are not lost to the next recording; a partial tape without hits is not in its way.
    let again = |existing| TapeWriter::create(&path, sidecar(&[]), existing);
    let refused = again(ExistingFile::Kept).unwrap_err();
    assert!(refused.to_string().contains("tape.partial.npy holds the hits"), "{refused}");
    std::mem::forget(again(ExistingFile::Replaced).unwrap());
    again(ExistingFile::Kept).unwrap().finish().unwrap();
}

#[test]
fn scans_are_read_in_any_order() {
    let mut reader = Scans::from(scans(10_000));
    for index in [9_999, 0, 4_096, 4_095, 5_000] {
        assert_eq!(reader.get(index).unwrap().unwrap()[0], index as u16);
    }
    assert_eq!(reader.get(10_000).unwrap(), None);
}

use massline_physics::source::ScanSource;
use massline_protocol::LayoutHash;
use massline_shared::layout::RigLayout;
use massline_shared::signal::{RECORD_SCANS, Scan};
use massline_shared::units::{Hertz, Seconds, Volts};

use massline_files::layout_file::LayoutFile;
use massline_files::tape::Sidecar;
use massline_shared::signal::Calibration;

use super::*;

fn layout() -> RigLayout {
    let text = include_str!("../../../../examples/three-bar-test-1.toml");
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

/// Plays until no more scans come.
fn play(source: &mut TapeSource) -> Vec<u16> {
    std::iter::from_fn(|| source.next_scan()).map(|scan| scan[0]).collect()
}

fn source(count: u16, segments: &[(u64, &str)]) -> TapeSource {
    let tape = Tape { sidecar: sidecar(segments), scans: scans(count).into(), cut_short: false };
    TapeSource::new(tape, &layout()).unwrap().0
}

#[test]
fn each_arming_plays_the_next_segment_of_its_dof() {
    let mut source =
        source(20_000, &[(0, "1:+Y"), (4000, "2:+Z"), (8000, "1:+Y"), (12_000, "4:+X")]);
    let progress = source.progress();
    assert_eq!(source.next_scan(), None);
    source.armed(1, 0);
    // Played to the start of the next segment.
    assert_eq!(play(&mut source), (0..4000).collect::<Vec<_>>());
    assert!(progress.played_out() && progress.exhausted().is_none());
    // A repeated arming number is not a new arming.
    source.armed(1, 0);
    assert_eq!(source.next_scan(), None);
    source.armed(2, 0);
    assert!(!progress.played_out());
    assert_eq!(source.next_scan().unwrap()[0], 8000);
    source.armed(3, 0);
    assert_eq!(progress.exhausted(), Some(0));
    assert_eq!(source.next_scan(), None);
    source.armed(4, 2);
    assert_eq!(progress.exhausted(), None);
    // A record that the end of the tape cuts is completed.
    let played = play(&mut source);
    assert_eq!(played[..8000], (12_000..20_000).collect::<Vec<_>>());
    assert_eq!(played[8000..], [19_999; RECORD_SCANS]);
}

#[test]
fn a_short_segment_goes_on_into_the_following_scans_and_the_last_is_repeated() {
    let mut source = source(1000, &[(0, "1:+Y"), (500, "2:+Z"), (900, "4:+X")]);
    source.armed(1, 0);
    let played = play(&mut source);
    assert!(played.len() > RECORD_SCANS);
    assert_eq!(played[..1000], (0..1000).collect::<Vec<_>>());
    assert!(played[1000..].iter().all(|&code| code == 999));
}

#[test]
fn a_segment_without_a_hit_can_be_passed_over() {
    let mut source = source(20_000, &[(0, "1:+Y"), (4000, "1:+Y"), (8000, "2:+Z"), (9000, "4:+X")]);
    let progress = source.progress();
    source.armed(1, 0);
    play(&mut source);
    progress.play_next();
    assert_eq!(source.next_scan().unwrap()[0], 4000);
    play(&mut source);
    progress.play_next();
    assert_eq!(source.next_scan(), None);
    assert_eq!(progress.exhausted(), Some(0));
}

#[test]
fn the_layout_must_be_that_of_the_tape() {
    let segments = [(0, "1:+Y"), (10, "2:+Z"), (20, "4:+X")];
    let new = |segments: &[(u64, &str)], change: fn(&mut Sidecar)| {
        let mut sidecar = sidecar(segments);
        change(&mut sidecar);
        let tape = Tape { sidecar, scans: scans(100).into(), cut_short: false };
        TapeSource::new(tape, &layout()).map(|(_, warning)| warning)
    };
    assert_eq!(new(&segments, |_| ()).unwrap(), None);
    // The tape of an interrupted campaign still belongs to this layout.
    assert_eq!(new(&segments[..1], |_| ()).unwrap(), None);
    let warning = new(&segments, |s| s.layout_hash ^= 1).unwrap().unwrap();
    assert!(warning.contains("another layout"));
    let error = new(&segments[..2], |s| s.layout_hash ^= 1).unwrap_err().to_string();
    assert!(error.contains("hits at 4:+X"), "{error}");
    let error = new(&[(0, "3:+Y")], |_| ()).unwrap_err().to_string();
    assert!(error.contains("hits at 3:+Y"), "{error}");
    let error = new(&segments, |s| s.adc.channels = 7).unwrap_err().to_string();
    assert!(error.contains("3 sensors and the tape 2"), "{error}");
}

#[test]
fn a_code_beyond_the_bits_of_the_converter_ends_the_tape_with_its_place() {
    let mut sidecar = sidecar(&[(0, "1:+Y"), (10, "2:+Z"), (20, "4:+X")]);
    sidecar.adc.bits = 6;
    let tape = Tape { sidecar, scans: scans(100).into(), cut_short: false };
    let mut source = TapeSource::new(tape, &layout()).unwrap().0;
    source.armed(1, 0);
    // Channel 9 of scan k has the code k + 9.
    assert_eq!(play(&mut source).len(), 55);
    let failed = source.progress().failed().unwrap().to_owned();
    assert!(failed.contains("scan 55 has the code 64 in channel 9"), "{failed}");
}

//! Replays with segments that the rig rejects, and with too few segments for a DOF.

use std::path::PathBuf;

use massline_files::file::ExistingFile;
use massline_files::tape::{Segment, Sidecar, Tape, TapeWriter};
use serde_json::Value;
use tempfile::TempDir;

use crate::program::{layout_with_hits, run_json, success};

struct Recording {
    folder: TempDir,
    layout: String,
    tape: Tape,
}

impl Recording {
    /// A recording of three good hits at each DOF of the demo's first layout.
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let layout = layout_with_hits(folder.path(), 3);
        let path = |name: &str| folder.path().join(name).display().to_string();
        let (tape, bench) = (path("all.npy"), path("bench.toml"));
        std::fs::write(&bench, "[operator]\ntoo_weak_rate = 0.0\ntoo_hard_rate = 0.0\n").unwrap();
        success(&["simulate", &layout, "--bench", &bench, "--tape", &tape]);
        let tape = Tape::read(&PathBuf::from(&tape)).unwrap();
        assert_eq!(tape.sidecar.segments.len(), 9);
        Self { folder, layout, tape }
    }

    /// Replays the tape with other segments: exit code, JSON, text.
    fn replay(&mut self, segments: Vec<Segment>) -> (i32, Value, String) {
        let path = self.folder.path().join("some.npy");
        let sidecar = Sidecar { segments, ..self.tape.sidecar.clone() };
        let mut writer = TapeWriter::create(&path, sidecar, ExistingFile::Replaced).unwrap();
        writer.push(&self.tape.scans.to_vec().unwrap()).unwrap();
        writer.finish().unwrap();
        let path = path.display().to_string();
        let (run, value) = run_json(&["replay", &path, "--layout", &self.layout]);
        let text = format!("{}{}", run.stderr, value["error"]["message"]);
        (run.exit, value, text)
    }

    fn segments(&self) -> Vec<Segment> {
        self.tape.sidecar.segments.clone()
    }
}

fn hits(value: &Value) -> Vec<u64> {
    let lines = value["mass_lines"].as_array().unwrap();
    lines.iter().map(|line| line["hits"].as_u64().unwrap()).collect()
}

#[test]
fn a_whole_tape_gives_every_hit() {
    let mut recording = Recording::new();
    let (exit, value, text) = recording.replay(recording.segments());
    assert_eq!((exit, hits(&value)), (0, vec![3, 3, 3]), "{text}");
    assert!(!text.contains("warning"), "{text}");
}

#[test]
fn a_dof_with_fewer_hits_goes_on_with_a_warning() {
    let mut recording = Recording::new();
    let mut segments = recording.segments();
    segments.remove(4);
    let (exit, value, text) = recording.replay(segments);
    assert_eq!((exit, hits(&value)), (0, vec![3, 2, 3]), "{text}");
    assert!(text.contains("warning: 2:+Z is finished with 2 of 3 hits"), "{text}");
    let codes: Vec<_> = value["diagnostics"].as_array().unwrap().iter().collect();
    assert!(codes.iter().any(|d| d["code"] == "dof_finished_early"), "{value}");
}

#[test]
fn a_segment_without_a_hit_counts_as_used_up() {
    let mut recording = Recording::new();
    let mut segments = recording.segments();
    // The last segment contains only the ring-down after its tap, without a contact of the hammer.
    segments[8].start = recording.tape.scans.count() - 500;
    let (exit, value, text) = recording.replay(segments);
    assert_eq!((exit, hits(&value)), (0, vec![3, 3, 2]), "{text}");
    assert!(text.contains("a segment of 4:+X holds no hit"), "{text}");
}

#[test]
fn a_dof_without_any_hit_cannot_determine_the_answer() {
    let mut recording = Recording::new();
    let mut segments = recording.segments();
    segments.truncate(6);
    let (exit, value, text) = recording.replay(segments);
    assert_eq!((exit, &value["error"]["code"]), (3, &"dof_without_hits".into()), "{text}");
    assert!(text.contains("4:+X"), "{text}");
}

#[test]
fn every_rejected_hit_is_listed_before_a_replay_ends() {
    let recording = Recording::new();
    let text = std::fs::read_to_string(&recording.layout).unwrap();
    let strict = recording.folder.path().join("strict.toml").display().to_string();
    // No tap of the bench is so hard.
    let changed = text.replace("[test]", "[test]\nmin_peak_force_n = 90.0");
    assert_ne!(changed, text);
    std::fs::write(&strict, changed).unwrap();
    let tape = recording.folder.path().join("all.npy").display().to_string();
    let (run, value) = run_json(&["replay", &tape, "--layout", &strict]);
    assert_eq!((run.exit, &value["error"]["code"]), (3, &"dof_without_hits".into()));
    let rejected = |line: &&str| line.starts_with("hit ") && line.contains("rejected");
    assert_eq!(run.stderr.lines().filter(rejected).count(), 3, "{}", run.stderr);
}

//! Tapes of recordings that are killed, and on a disk that is full.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

use massline_files::tape::Tape;
use serde_json::Value;
use tempfile::TempDir;

use crate::program::{layout_with_hits, run, run_json, run_limited, success};
use crate::virtual_process::VirtualProcess;

fn names(folder: &TempDir) -> Vec<String> {
    let names = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name());
    let mut names: Vec<String> = names.map(|name| name.into_string().unwrap()).collect();
    names.sort();
    names
}

/// The documents that a run printed with `--json`.
fn documents(stdout: &str) -> Vec<Value> {
    stdout.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// A replay of a cut tape of one DOF grades all its hits, and then lacks those of the other DOFs.
#[track_caller]
fn replays_its_hits(tape: &Path, layout: &str) {
    let cut = Tape::read(tape).unwrap();
    assert!(cut.cut_short);
    let (run, value) = run_json(&["replay", tape.to_str().unwrap(), "--layout", layout]);
    assert!(run.says("the recording was cut short"), "{}", run.stderr);
    assert_eq!((run.exit, &value["error"]["code"]), (3, &"dof_without_hits".into()));
    let hits = run.stderr.lines().filter(|line| line.starts_with("hit ")).count();
    assert_eq!(hits, cut.sidecar.segments.len(), "{}", run.stderr);
}

#[test]
fn a_recording_that_is_killed_replays_up_to_its_last_whole_scan() {
    let rig = VirtualProcess::start(&["--fast"]);
    let folder = tempfile::tempdir().unwrap();
    // Far more hits than there are before the end of the recording.
    let layout = layout_with_hits(folder.path(), 50);
    let path = folder.path().join("cut.npy");
    let mut record = Command::new(env!("CARGO_BIN_EXE_massline"))
        .args(["record", &layout, "--triggered", "--port", &rig.port, "-o"])
        .arg(&path)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(record.stderr.take().unwrap()).lines();
    let good = lines.map_while(Result::ok).filter(|line| line.ends_with("good")).take(4).count();
    assert_eq!(good, 4);
    record.kill().unwrap();
    record.wait().unwrap();
    assert_eq!(names(&folder), ["cut.partial.npy", "cut.partial.toml", "layout-50.toml"]);
    let partial = path.with_extension("partial.npy");
    // The record of the hit that was graded last may not have been read yet.
    assert!(Tape::read(&partial).unwrap().sidecar.segments.len() >= 3);
    replays_its_hits(&partial, &layout);
}

/// The stream is written in blocks, so that a killed process leaves a part of a scan.
#[test]
fn a_simulation_that_is_killed_leaves_a_tape_of_its_whole_hits() {
    let folder = tempfile::tempdir().unwrap();
    let layout = layout_with_hits(folder.path(), 50);
    let path = folder.path().join("cut.npy");
    let partial = path.with_extension("partial.npy");
    let mut recording = Command::new(env!("CARGO_BIN_EXE_massline"))
        .args(["simulate", &layout, "--tape", path.to_str().unwrap()])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    // More than the first hits of the first DOF, far less than all 150.
    let written = || std::fs::metadata(&partial).map_or(0, |metadata| metadata.len());
    while written() < 2_000_000 {
        assert!(recording.try_wait().unwrap().is_none(), "it ended at {} bytes", written());
        std::thread::yield_now();
    }
    recording.kill().unwrap();
    recording.wait().unwrap();
    assert!(!path.exists());
    let cut = Tape::read(&partial).unwrap();
    assert!(cut.scans.count() >= 90_000 && cut.sidecar.segments.len() > 2, "{cut:?}");
    replays_its_hits(&partial, &layout);
}

/// 512 kB are half of the tape.
const FULL_AT: &str = "-f 1000";

#[test]
fn a_simulation_whose_tape_fills_the_disk_prints_its_result_and_leaves_no_tape() {
    let folder = tempfile::tempdir().unwrap();
    let layout = layout_with_hits(folder.path(), 5);
    let path = folder.path().join("tape.npy").display().to_string();
    let simulate = ["--json", "simulate", &layout, "--tape", &path];
    let full = run_limited(FULL_AT, &simulate);
    let documents = documents(&full.stdout);
    assert_eq!((full.exit, documents.len()), (2, 2), "{}", full.stderr);
    assert!(documents[0]["results"][0]["mass_kg"]["value"].is_number());
    assert!(documents[0]["tape"].is_null());
    assert_eq!(documents[1]["error"]["code"], "cannot_write");
    assert_eq!(names(&folder), ["layout-5.toml"]);
    // Nothing is in the way of the next attempt, and the next failure leaves its tape alone.
    success(&simulate[1..]);
    let whole = std::fs::read(&path).unwrap();
    let forced = run_limited(FULL_AT, &[&simulate[..], &["--force"]].concat());
    assert_eq!(forced.exit, 2);
    assert!(std::fs::read(&path).unwrap() == whole, "the old tape is as it was");
    assert_eq!(names(&folder), ["layout-5.toml", "tape.npy", "tape.toml"]);
}

#[test]
fn a_recording_that_fills_the_disk_keeps_the_hits_that_it_has() {
    let rig = VirtualProcess::start(&["--fast"]);
    let folder = tempfile::tempdir().unwrap();
    let layout = layout_with_hits(folder.path(), 5);
    let path = folder.path().join("tape.npy");
    let record = ["record", &layout, "--triggered", "--port", &rig.port, "-o"];
    let record = [&record[..], &[path.to_str().unwrap()]].concat();
    // A record with its lead-in has 2088 scans of 20 bytes: three of them, and a part of the fourth.
    let full = run_limited("-f 300", &record);
    assert_eq!(full.exit, 2, "{}", full.stderr);
    assert!(full.says("tape.npy has the 7673 scans before this"), "{}", full.stderr);
    let tape = Tape::read(&path).unwrap();
    assert_eq!((tape.scans.count(), tape.sidecar.segments.len()), (7673, 3));
    for file in ["tape.npy", "tape.toml"] {
        std::fs::remove_file(folder.path().join(file)).unwrap();
    }
    // Less than one record: nothing is left.
    let full = run_limited("-f 40", &record);
    assert_eq!(full.exit, 2, "{}", full.stderr);
    assert!(full.says("is not written, because it would have no hit"), "{}", full.stderr);
    assert_eq!(names(&folder), ["layout-5.toml"]);
}

#[test]
fn a_layout_that_the_rig_refuses_leaves_no_tape() {
    let rig = VirtualProcess::start(&["--fast"]);
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(crate::program::LAYOUT).unwrap();
    let layout = folder.path().join("parallel.toml").display().to_string();
    let parallel = text.replace("\"2:+Z\", \"4:+X\"", "\"2:+Y\", \"4:+Y\"");
    assert_ne!(parallel, text);
    std::fs::write(&layout, parallel).unwrap();
    let tape = folder.path().join("tape.npy").display().to_string();
    let refused = run(&["record", &layout, "-o", &tape, "--triggered", "--port", &rig.port]);
    assert_eq!(refused.exit, 3, "{}", refused.stderr);
    assert!(refused.says("parallel"), "{}", refused.stderr);
    assert_eq!(names(&folder), ["parallel.toml"]);
}

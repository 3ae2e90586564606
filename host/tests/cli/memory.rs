//! No file, however it is made, takes more than half a gibibyte of memory.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Stdio};

use crate::program::{LAYOUT, Run, run_in_shell, run_limited};
use crate::virtual_process::VirtualProcess;

/// All that a process may allocate: 500 MiB, with which code, stacks and libraries of the C kind stay below 512.
const LIMIT: &str = "-d 512000";
/// Size of the large files, bytes.
const LARGE: usize = 60 << 20;

/// A process that is out of memory is ended by a signal, which `run` does not accept.
#[track_caller]
fn refused(arguments: &[&str], words: &str) {
    let Run { exit, stderr, .. } = run_limited(LIMIT, arguments);
    assert_eq!(exit, 2, "{arguments:?}: {stderr}");
    let message = crate::program::words(&stderr);
    assert!(message.contains(words), "{arguments:?}: {message}");
}

/// A file that repeats `part` between a head and a tail.
fn file(folder: &Path, name: &str, head: &str, part: &str, tail: &str) -> String {
    let path = folder.join(name);
    let mut to = std::io::BufWriter::new(std::fs::File::create(&path).unwrap());
    to.write_all(head.as_bytes()).unwrap();
    let block = part.repeat((1 << 16) / part.len());
    for _ in 0..LARGE / block.len() {
        to.write_all(block.as_bytes()).unwrap();
    }
    to.write_all(tail.as_bytes()).unwrap();
    to.into_inner().unwrap();
    path.display().to_string()
}

#[test]
fn recordings_of_text() {
    let folder = tempfile::tempdir().unwrap();
    let recording = |head: &str, part: &str| file(folder.path(), "r.csv", head, part, "\n");
    refused(&["hits", &recording("", "1,")], "line 1: it is longer than 1048576 bytes");
    refused(&["hits", &recording("1,2\n\"", "3,4\n")], "it is longer than 1048576 bytes");
    refused(&["hits", &recording("", "words\n")], "the format is not known");
    let wide = format!("{}\n", "1,".repeat(5000));
    refused(&["hits", &recording("", &wide)], "5000 channels; at most 1000 are read");
    let lvm = "LabVIEW Measurement\n***End_of_Header***\n";
    refused(&["hits", &recording(lvm, "\t")], "it is longer than 1048576 bytes");
    refused(
        &["hits", &recording(lvm, "Channels\t1\nSamples\t1\n***End_of_Header***\nX\tF\n0\t1\n\n")],
        "segments; at most 10000 are read",
    );
}

/// The shortest function of a universal file.
fn function() -> String {
    let empty = "\n".repeat(5);
    let axes = "         0    0    0    0\n".repeat(4);
    let head = format!(
        "    -1\n    58\n{empty}    1         0    0         0       NONE         1   1       NONE         1   3\n"
    );
    let shape = format!("{:10}{:10}{:10}{:13}{:13}{:13}\n", 2, 1, 1, 0.0, 0.1, 0.0);
    head + &shape + &axes + "1.0\n    -1\n"
}

#[test]
fn universal_files_of_tiny_functions() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(folder.path(), "tiny.uff", "", &function(), "");
    refused(&["hits", &path], "more than 100000 functions");
    refused(&["solve", LAYOUT, &path], "more than 100000 functions");
}

#[test]
fn arrays_of_tiny_segments() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tiny.npy");
    let head = "{'descr': '<i2', 'fortran_order': False, 'shape': (8000000, 1, 2), }\n";
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((head.len() as u16).to_le_bytes());
    bytes.extend(head.as_bytes());
    bytes.extend(vec![1; 32_000_000]);
    std::fs::write(&path, bytes).unwrap();
    refused(&["hits", path.to_str().unwrap()], "8000000 segments; at most 10000 are read");
}

#[test]
fn archives_of_tiny_values() {
    let folder = tempfile::tempdir().unwrap();
    let head = r#"{"format":"massline-archive","schema_version":1,"x":"#;
    let list = format!("{head}[");
    for (head, part, tail) in [
        (&*list, "[],", "0]}\n"),
        (&*list, "\"\",", "0]}\n"),
        (&*list, "[0],", "0]}\n"),
        (&*format!("{head}{{"), "\"\":0,", "\"\":0}}\n"),
    ] {
        let path = file(folder.path(), "x.massline", head, part, tail);
        refused(&["report", &path], "it needs more than 192 MiB of memory");
    }
}

#[test]
fn every_file_in_toml() {
    let folder = tempfile::tempdir().unwrap();
    let long = file(folder.path(), "long.toml", "", "a = []\n", "");
    // As much as is read: a list of the shortest values.
    let most = folder.path().join("most.toml").display().to_string();
    std::fs::write(&most, format!("sensors = [{}]\n", "1,".repeat((1 << 19) - 10))).unwrap();
    let tape = folder.path().join("tape.npy");
    let head = "{'descr': '<u2', 'fortran_order': False, 'shape': (1, 10), }\n";
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((head.len() as u16).to_le_bytes());
    bytes.extend(head.as_bytes());
    bytes.extend([0; 20]);
    std::fs::write(&tape, bytes).unwrap();
    let tape = tape.to_str().unwrap();
    for (path, words) in [(&long, "is longer than 1 MiB"), (&most, "most.toml")] {
        refused(&["layout", "check", path], words);
        refused(&["layout", "suggest", path], words);
        refused(&["simulate", LAYOUT, "--calibration", path], words);
        refused(&["simulate", LAYOUT, "--bench", path], words);
        refused(&["calibrate", "tumble", "--rig", "virtual", "--readings", path], words);
    }
    std::fs::rename(&long, folder.path().join("tape.toml")).unwrap();
    refused(&["replay", tape, "--layout", LAYOUT], "is longer than 1 MiB");
}

#[test]
fn files_without_end() {
    refused(&["simulate", LAYOUT, "--bench", "/dev/zero"], "is longer than 1 MiB");
    refused(&["simulate", LAYOUT, "--calibration", "/dev/zero"], "is longer than 1 MiB");
    refused(&["layout", "check", "/dev/zero"], "is longer than 1 MiB");
    refused(&["hits", "/dev/zero"], "is longer than 128 MiB");
    refused(&["solve", LAYOUT, "/dev/zero"], "is longer than 128 MiB");
    refused(&["replay", "/dev/zero", "--layout", LAYOUT], "/dev/zero");
    let image = ["flash", "--board", "blackpill-f411", "--dry-run", "--image", "/dev/zero"];
    refused(&image, "/dev/zero");
}

/// What a person types is read line by line; a line may not be endless either.
#[test]
fn lines_without_end() {
    let folder = tempfile::tempdir().unwrap();
    let readings = folder.path().join("readings.toml").display().to_string();
    let rig = VirtualProcess::start(&["--fast"]);
    let script = format!("ulimit {LIMIT}; exec \"$0\" \"$@\" < /dev/zero");
    let tumble = ["calibrate", "tumble", "--readings", &readings, "--port", &rig.port];
    let run = run_in_shell(&script, &tumble);
    assert_eq!(run.exit, 2, "{}", run.stderr);
    assert!(run.says("a line is longer than 4096 bytes"), "{}", run.stderr);
    // The rig goes on without its keyboard.
    let script = format!("ulimit {LIMIT}; exec \"$0\" \"$@\" < /dev/zero");
    let mut process = Command::new("sh")
        .args(["-c", &script, env!("CARGO_BIN_EXE_massline"), "virtual", "--manual"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(process.stderr.take().unwrap()).lines().map_while(Result::ok);
    let notice = lines.find(|line| line.contains("nothing taps any more"));
    process.kill().unwrap();
    process.wait().unwrap();
    assert!(notice.is_some_and(|line| line.contains("a line is longer than 4096 bytes")));
}

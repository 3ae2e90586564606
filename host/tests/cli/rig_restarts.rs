//! A rig whose supply fails during a measurement: it is killed, and started again on its flash.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use serde_json::Value;

use crate::program::{answer, layout_with_hits};
use crate::virtual_process::VirtualProcess;

/// A rig in real time at this address of this computer, with its flash in this file.
fn start(address: &str, flash: &Path) -> VirtualProcess {
    VirtualProcess::start(&["--tcp", address, "--flash", flash.to_str().unwrap()])
}

/// Measures until this many hits are good.
fn measure_until(good: usize, layout: &str, port: &str) -> Child {
    let mut measure = Command::new(env!("CARGO_BIN_EXE_massline"))
        .env("MASSLINE_CONFIG", "")
        .args(["measure", layout, "--port", port, "--json"])
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(measure.stderr.take().unwrap()).lines();
    let hits = lines.by_ref().map_while(Result::ok).filter(|line| line.ends_with("good"));
    assert_eq!(hits.take(good).count(), good);
    // The rest is read as well, so that the program never waits for a reader.
    std::thread::spawn(move || lines.for_each(drop));
    measure
}

/// The exit code and the error of a program that ends by itself.
fn error_of(mut program: Child) -> (Option<i32>, Value) {
    let mut text = String::new();
    program.stdout.take().unwrap().read_to_string(&mut text).unwrap();
    let error: Value = serde_json::from_str(&text).unwrap();
    (program.wait().unwrap().code(), error["error"].clone())
}

#[test]
fn a_rig_that_restarts_is_named_with_what_it_keeps_and_the_same_command_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let (layout, flash) = (layout_with_hits(folder.path(), 2), folder.path().join("flash.bin"));
    let mut rig = start("127.0.0.1:0", &flash);
    let port = rig.port.clone();
    let address = port.strip_prefix("tcp://").unwrap().to_owned();
    // Before the first DOF is finished, and within the second.
    for (good, kept) in [
        (1, "no DOF was finished"),
        (3, "it keeps the 2 accepted hits of the DOFs that were finished"),
    ] {
        let measure = measure_until(good, &layout, &port);
        drop(rig);
        rig = start(&address, &flash);
        let (exit, error) = error_of(measure);
        assert_eq!((exit, error["code"].as_str()), (Some(4), Some("rig_restarted")), "{error}");
        let message = error["message"].as_str().unwrap();
        assert!(message.contains(kept) && message.contains("the same command"), "{message}");
    }
    let (exit, measured) = answer(&["measure", &layout, "--port", &port]);
    assert_eq!(exit, 0, "{measured}");
    let hits: Vec<_> =
        measured["mass_lines"].as_array().unwrap().iter().map(|dof| &dof["hits"]).collect();
    assert_eq!(hits, [2, 2, 2]);
}

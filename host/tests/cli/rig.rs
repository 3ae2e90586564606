//! The program with a virtual rig on a pty, used like real hardware.

use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, Command, Stdio};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::program::{answer, layout_with_hits, run, success};
use crate::virtual_process::VirtualProcess;

/// Five DOFs of the three-bar frame, three hits each, and a target.
const LAYOUT_WITH_TARGET: &str = r#"
sensors = [1, 2, 3]
hits = ["1:+Y", "2:+Z", "4:+X", "1:+X", "3:+Z"]
node = [
    { id = 1, position_m = [0.0, 0.0, 0.0] },
    { id = 2, position_m = [0.2079, -0.1990, 0.0] },
    { id = 3, position_m = [0.2079, 0.0, 0.0] },
    { id = 4, position_m = [0.2079, -0.1990, 0.1491] },
]
[test]
hits_per_dof = 3
[target]
center_m = {center_m}
"#;

/// A virtual rig and a folder for the host's files.
pub struct Rig {
    pub process: VirtualProcess,
    pub folder: TempDir,
}

impl Rig {
    pub fn start(arguments: &[&str]) -> Self {
        let process = VirtualProcess::start(arguments);
        Self { process, folder: tempfile::tempdir().unwrap() }
    }

    /// The first layout of the demo with this number of hits at each DOF.
    pub fn layout(&self, hits: u8) -> String {
        layout_with_hits(self.folder.path(), hits)
    }

    /// Starts a command on this rig; its output is piped.
    pub fn spawn(&self, arguments: &[&str]) -> Child {
        Command::new(env!("CARGO_BIN_EXE_massline"))
            .args(arguments)
            .args(["--port", &self.process.port])
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
    }

    /// The port that it serves.
    pub fn port(&self) -> &str {
        &self.process.port
    }

    /// Runs a command on this rig with `--json`: its exit code and what it printed.
    #[track_caller]
    pub fn run(&self, arguments: &[&str]) -> (i32, Value) {
        answer(&[arguments, &["--port", &self.process.port]].concat())
    }
}

#[test]
fn a_measured_result_can_be_listed_fetched_and_deleted() {
    let rig = Rig::start(&["--fast"]);
    let layout = rig.layout(3);
    let (exit, measured) = rig.run(&["measure", &layout]);
    assert_eq!(exit, 0, "{measured}");
    // The ideal bench has no errors of placement: 1.23 kg within the scatter of three hits.
    let mass = measured["results"][0]["mass_kg"]["value"].as_f64().unwrap();
    assert!((mass / 1.23 - 1.0).abs() < 0.01, "{mass}");

    // The last DOF is included; a fast rig may have closed several between two looks.
    let [after, lines] =
        ["after_each_dof", "mass_lines"].map(|key| measured[key].as_array().unwrap());
    assert_eq!(after.last().unwrap()["dofs_measured"], lines.len());

    let (exit, list) = rig.run(&["results", "list"]);
    assert_eq!((exit, list["results"].as_array().unwrap().len()), (0, 1));
    assert_eq!(list["results"][0]["layout_hash"], measured["layout_hash"]);
    let (exit, fetched) = rig.run(&["results", "get", "1"]);
    assert_eq!(exit, 0, "{fetched}");
    // Hammer and sensors have their terms; five lines are left.
    let unseen = measured["cannot_see"].as_array().unwrap();
    let sources: Vec<_> = unseen.iter().map(|source| source["source"].as_str().unwrap()).collect();
    assert_eq!(
        sources,
        [
            "same_side_miss",
            "lateral_force_or_free_moment",
            "sensor_mass",
            "loose_parts",
            "nonlinearity"
        ]
    );
    assert!(unseen.iter().all(|source| !source["message"].as_str().unwrap().is_empty()));
    for key in ["number", "layout_hash", "calibration", "firmware", "mass_lines"] {
        // The answers are not compared: the file has more digits and nodes than the rig stores of it.
        assert_eq!(fetched[key], measured[key], "{key}");
    }

    let path = rig.folder.path().join("one.json").display().to_string();
    let (exit, written) = rig.run(&["export", "1", "--format", "json", "-o", &path]);
    assert_eq!((exit, &written["physically_consistent"]), (0, &true.into()), "{written}");
    let exported: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    let of_host = &fetched["results"][0];
    assert_eq!(exported["method"], of_host["method"]);
    assert_eq!(exported["inertia"], of_host["inertia_kg_m2"]["value"]);
    assert_eq!(exported["source"], "result 1 of the rig");
    assert_eq!(exported["title"], "three-bar frame, test 1");
    // The rig keeps positions of nodes, but not their axes.
    let at_node = ["export", "1", "--format", "urdf", "--frame", "1", "-o", "unwritten"];
    let (exit, error) = rig.run(&at_node);
    assert_eq!((exit, &error["error"]["code"]), (2, &"unknown_axes".into()), "{error}");

    let (exit, missing) = rig.run(&["results", "get", "7"]);
    assert_eq!((exit, &missing["error"]["code"]), (2, &"not_found".into()));
    let (exit, unasked) = rig.run(&["results", "delete", "1"]);
    assert_eq!((exit, &unasked["error"]["code"]), (2, &"not_confirmed".into()));
    assert_eq!(rig.run(&["results", "delete", "1", "--yes"]).1["deleted"], json!([1]));
    assert_eq!(rig.run(&["results", "get", "1"]).0, 2);
    assert_eq!(rig.run(&["results", "delete", "1-", "--yes"]).0, 2);
    assert_eq!(rig.run(&["results", "delete", "--all", "--yes"]).1["deleted"], json!([]));
}

/// Without a keyboard nobody can be asked: the campaign finishes at its target, and the answer says so.
#[test]
fn without_a_keyboard_a_campaign_finishes_at_its_target() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("target.toml").display().to_string();
    std::fs::write(&path, LAYOUT_WITH_TARGET.replace("{center_m}", "0.01")).unwrap();
    let process = VirtualProcess::start(&["--fast", "--layout", &path]);
    let (exit, measured) = answer(&["measure", &path, "--port", &process.port]);
    assert_eq!(exit, 0, "{measured}");
    // Ten millimetres are reached as soon as there is an answer, with three DOFs of five.
    let after = measured["after_each_dof"].as_array().unwrap().last().unwrap();
    assert_eq!((&after["dofs_measured"], &after["target_reached"]), (&3.into(), &true.into()));
    assert!(after["half_widths95"]["center_m"].as_f64().unwrap() <= 0.01, "{after}");
    assert_eq!(measured["mass_lines"].as_array().unwrap().len(), 3);
    let codes: Vec<_> = measured["diagnostics"].as_array().unwrap().iter().collect();
    let stopped = codes.iter().find(|d| d["code"] == "stopped_at_target").unwrap();
    // Two DOFs of three hits.
    assert!(stopped["message"].as_str().unwrap().contains("saved 6 hits"), "{stopped}");
}

#[test]
fn a_target_that_is_missed_is_a_note_with_what_to_hit_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("target.toml").display().to_string();
    std::fs::write(&path, LAYOUT_WITH_TARGET.replace("{center_m}", "1e-6")).unwrap();
    let process = VirtualProcess::start(&["--fast", "--layout", &path]);
    let (exit, measured) = answer(&["measure", &path, "--port", &process.port]);
    assert_eq!(exit, 0, "{measured}");
    assert_eq!(measured["mass_lines"].as_array().unwrap().len(), 5);
    let diagnostics = measured["diagnostics"].as_array().unwrap();
    let diagnostic = |code: &str| diagnostics.iter().find(|d| d["code"] == code);
    let missed = diagnostic("target_missed").unwrap();
    assert_eq!(missed["severity"], "note");
    assert!(missed["message"].as_str().unwrap().contains("interval of c"), "{missed}");
    let again = diagnostic("hit_again").unwrap()["message"].as_str().unwrap();
    assert!(again.contains("(") && again.contains(":+"), "the DOF has its name: {again}");
    assert!(diagnostic("stopped_at_target").is_none());
}

#[test]
fn the_rig_tells_who_it_is_and_what_it_has_counted() {
    let rig = Rig::start(&["--fast"]);
    let (exit, identity) = rig.run(&["device", "identify"]);
    assert_eq!((exit, &identity["board"]), (0, &"virtual".into()));
    assert_eq!(identity["phase"], "idle");
    assert!(identity["result"].is_null());
    let (exit, stats) = rig.run(&["device", "stats"]);
    assert_eq!((exit, &stats["scans_lost"]), (0, &0.into()));
    assert_eq!(stats["boot_reason"], "power-on");
    let erases = stats["flash_erases"].as_u64().unwrap();
    assert_eq!(rig.run(&["measure", &rig.layout(3)]).0, 0);
    // A layout and a result went into empty flash: at least its first page was erased.
    assert!(rig.run(&["device", "stats"]).1["flash_erases"].as_u64().unwrap() > erases);
}

#[test]
fn a_rig_in_safe_mode_says_so_measures_nothing_and_is_erased_when_it_is_told_to() {
    let rig = Rig::start(&["--fast", "--safe-mode"]);
    let (exit, identity) = rig.run(&["device", "identify"]);
    assert_eq!((exit, &identity["boot_reason"]), (0, &"safe mode".into()));
    assert_eq!(identity["phase"], "safe_mode");
    assert_eq!(identity["last_panic"], "nothing has failed: this is --safe-mode");
    let text = run(&["device", "identify", "--port", rig.port()]).stdout;
    assert!(text.contains("layout     not read") && text.contains("device erase"), "{text}");
    for command in [&["device", "stats"][..], &["results", "list"], &["measure", &rig.layout(3)]] {
        let (exit, error) = rig.run(command);
        assert_eq!((exit, &error["error"]["code"]), (4, &"safe_mode".into()), "{command:?}");
    }
    let (exit, error) = rig.run(&["device", "erase"]);
    assert_eq!((exit, &error["error"]["code"]), (2, &"not_confirmed".into()));
    let (exit, erased) = rig.run(&["device", "erase", "--yes"]);
    assert_eq!((exit, &erased["erased"]), (0, &true.into()));
}

#[test]
fn a_rig_that_runs_as_usual_is_not_erased_as_a_whole() {
    let rig = Rig::start(&["--fast"]);
    let (exit, error) = rig.run(&["device", "erase", "--yes"]);
    assert_eq!((exit, &error["error"]["code"]), (2, &"not_in_safe_mode".into()));
    assert_eq!(rig.run(&["device", "stats"]).0, 0);
}

#[test]
fn a_virtual_rig_names_its_port_in_json() {
    let rig = VirtualProcess::start(&["--json"]);
    let value: Value = serde_json::from_str(&rig.port).unwrap();
    crate::documents::check(&["virtual"], &value);
    assert!(std::path::Path::new(value["port"].as_str().unwrap()).exists(), "{value}");
}

#[test]
fn a_port_in_use_is_busy() {
    let rig = Rig::start(&["--fast"]);
    let port = massline_client::SerialTransport::open(rig.process.port.clone()).unwrap();
    let (exit, error) = rig.run(&["device", "identify"]);
    assert_eq!((exit, &error["error"]["code"]), (4, &"port_busy".into()));
    drop(port);
    assert_eq!(rig.run(&["device", "identify"]).0, 0);
}

#[test]
fn after_ctrl_c_the_rig_keeps_what_is_accepted_and_goes_on_with_it() {
    // In real time fifteen hits take many seconds, so the interruption comes during the campaign.
    let rig = Rig::start(&[]);
    let layout = rig.layout(5);
    let mut measure = rig.spawn(&["measure", &layout, "--json"]);
    let lines = BufReader::new(measure.stderr.take().unwrap()).lines();
    let good = lines.map_while(Result::ok).filter(|line| line.ends_with("good")).take(2).count();
    assert_eq!(good, 2);
    kill(Pid::from_raw(measure.id() as i32), Signal::SIGINT).unwrap();
    let mut text = String::new();
    measure.stdout.take().unwrap().read_to_string(&mut text).unwrap();
    assert_eq!(measure.wait().unwrap().code(), Some(130), "{text}");
    let error: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(error["error"]["code"], "interrupted");

    let (exit, identity) = rig.run(&["device", "identify"]);
    assert_eq!((exit, &identity["phase"]), (0, &"paused".into()));
    // Another layout does not replace the interrupted campaign.
    let (exit, other) = rig.run(&["measure", &rig.layout(2)]);
    assert_eq!((exit, &other["error"]["code"]), (4, &"another_campaign".into()));
    let (exit, result) = rig.run(&["measure", &layout]);
    assert_eq!(exit, 0, "{result}");
    assert!(result["mass_lines"].as_array().unwrap().iter().all(|line| line["hits"] == 5));
    // Exactly fifteen hits were averaged; a few more were rejected.
    let (_, stats) = rig.run(&["device", "stats"]);
    let triggers = stats["triggers"].as_u64().unwrap();
    assert!((15..30).contains(&triggers), "{triggers}");
}

#[test]
fn a_replay_of_recorded_hits_gives_what_the_rig_itself_had() {
    let rig = Rig::start(&["--fast"]);
    let layout = rig.layout(3);
    let tape = rig.folder.path().join("tape.npy").display().to_string();
    let (exit, recorded) = rig.run(&["record", &layout, "--output", &tape, "--triggered"]);
    assert_eq!((exit, &recorded["segments"]), (0, &9.into()));
    // The layout that the rig returns is in single precision, that of the file is not.
    let (_, own) = rig.run(&["results", "get", "1", "--layout", &layout]);
    let replayed = success(&["replay", &tape, "--layout", &layout]);
    assert_eq!(replayed["results"], own["results"]);
    // The program's answer differs from the rig's by single precision, which is a tenth of a standard deviation at
    // most.
    assert_eq!(own["rig"]["agrees"], true, "{}", own["rig"]);
    let far = own["rig"]["difference_sigma"].as_f64().unwrap();
    assert!(far != 0.0 && far.abs() < 0.1, "{far}");
}

/// A recording that is killed leaves a rig that asks for a verdict on every hit.
#[test]
fn after_a_killed_recording_a_campaign_ends_without_a_keyboard_and_can_be_aborted() {
    let rig = Rig::start(&[]);
    let layout = rig.layout(2);
    let tape = rig.folder.path().join("tape.npy").display().to_string();
    let kill_a_recording = || {
        let mut record = rig.spawn(&["record", &layout, "-o", &tape, "--force", "--triggered"]);
        let lines = BufReader::new(record.stderr.take().unwrap()).lines();
        assert!(lines.map_while(Result::ok).any(|line| line.ends_with("good")));
        record.kill().unwrap();
        record.wait().unwrap();
    };
    kill_a_recording();
    let measured = run(&["measure", &layout, "--port", &rig.process.port]);
    assert_eq!(measured.exit, 0, "{}", measured.stderr);
    assert!(!measured.stderr.contains("accept this hit?"), "{}", measured.stderr);

    kill_a_recording();
    let (exit, refused) = rig.run(&["measure", &rig.layout(1)]);
    assert_eq!((exit, &refused["error"]["code"]), (4, &"another_campaign".into()));
    let message = refused["error"]["message"].as_str().unwrap();
    assert!(message.contains("`massline device abort`"), "{message}");
    assert_eq!(rig.run(&["device", "abort"]).1["aborted"], true);
    assert_eq!(rig.run(&["device", "abort"]).1["aborted"], false);
    let (exit, identity) = rig.run(&["device", "identify"]);
    assert_eq!((exit, &identity["phase"]), (0, &"idle".into()));
}

#[test]
fn a_prompt_counts_the_hits_that_were_shown_before_it() {
    let rig = Rig::start(&["--fast"]);
    let measured = run(&["measure", &rig.layout(5), "--port", &rig.process.port]);
    assert_eq!(measured.exit, 0, "{}", measured.stderr);
    let mut prompts = 0;
    let lines: Vec<&str> = measured.stderr.lines().collect();
    for (place, line) in lines.iter().enumerate() {
        // hit 1:+Y now (1:+Y 3/5)
        let Some((dof, count)) = line.strip_prefix("hit ").and_then(|l| l.split_once(" now ("))
        else {
            continue;
        };
        let count = count.split([' ', '/']).nth(1).unwrap().parse::<usize>().unwrap();
        let shown =
            lines[..place].iter().filter(|l| l.ends_with("good") && l.contains(dof)).count();
        assert_eq!(shown, count, "{line}\n{}", measured.stderr);
        prompts += usize::from(count > 0);
    }
    assert!(prompts > 3, "{}", measured.stderr);
}

#[test]
fn the_stream_of_a_manual_rig_has_the_taps_of_enter() {
    let mut rig = Rig::start(&["--manual"]);
    let layout = rig.layout(2);
    let tape = rig.folder.path().join("tape.npy").display().to_string();
    let mut record = rig.spawn(&["record", &layout, "-o", &tape, "--json"]);
    let lines = BufReader::new(record.stderr.take().unwrap()).lines();
    let mut text = String::new();
    for line in lines.map_while(Result::ok) {
        text += &format!("{line}\n");
        let Some((dof, count)) = line.strip_prefix("hit ").and_then(|l| l.split_once(" now ("))
        else {
            continue;
        };
        // The first tap at a DOF names it.
        let keyboard = rig.process.process.stdin.as_mut().unwrap();
        writeln!(keyboard, "{}", if count.starts_with('0') { dof } else { "" }).unwrap();
    }
    let mut answer = String::new();
    record.stdout.take().unwrap().read_to_string(&mut answer).unwrap();
    assert_eq!(record.wait().unwrap().code(), Some(0), "{text}");
    let answer: Value = serde_json::from_str(&answer).unwrap();
    assert_eq!(answer["segments"], 6, "{text}");
}

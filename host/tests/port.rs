//! The complete workflow with a rig, from its identity to its result, using only the program: one script
//! for real hardware and for the virtual rig.
//!
//! ```text
//! ./tests/run --port /dev/ttyACM0 frame.toml      a real rig: you tap as prompted
//! cargo test -p massline --test port              the virtual rig on a pty, which taps by itself
//! ```
//! `MASSLINE_PORT` is the port, `MASSLINE_LAYOUT` the layout of the object on it, `MASSLINE_MASS_KG` its
//! mass if you have weighed it. Calibration and results are left as they were; the layout becomes the one
//! in use, and an interrupted campaign is discarded.
#![cfg(unix)]

#[path = "cli/virtual_process.rs"]
mod virtual_process;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use serde_json::Value;
use tempfile::TempDir;
use virtual_process::VirtualProcess;

/// A limit that is reached only when something hangs. A person who taps may take any time.
const LATE: Duration = Duration::from_secs(120);

#[test]
fn a_rig_does_all_that_its_user_needs() {
    let rig = Rig::of_environment();
    let who = rig.ask("who is it", &["device", "identify"]);
    assert_eq!(who["channels"], 10, "{who}");
    assert!(who["last_panic"] == "", "the rig has panicked before: {who}");
    let before = rig.ask("what has it counted", &["device", "stats"]);
    settings_come_back(&rig);
    let measured = measure(&rig);
    result_is_kept(&rig, &measured);
    let after = rig.ask("what has it counted now", &["device", "stats"]);
    nothing_went_wrong(&rig, [&before, &after], &measured);
    let (exit, error) = rig.run(&["results", "get", "4294967295"]);
    assert_eq!((exit, &error["error"]["code"]), (2, &"not_found".into()), "a wrong request");
    rig.print("done: all as it should be");
}

/// The calibration is written to a file and back, and is unchanged.
fn settings_come_back(rig: &Rig) {
    let shown = rig.ask("its calibration", &["calibrate", "show"]);
    let file = rig.folder.path().join("calibration.toml");
    let file = file.to_str().unwrap();
    rig.ask("its calibration into a file", &["calibrate", "pull", file]);
    rig.ask("and back", &["calibrate", "push", file]);
    assert_eq!(rig.ask("its calibration again", &["calibrate", "show"]), shown);
}

fn measure(rig: &Rig) -> Value {
    let layout = rig.layout.to_str().unwrap();
    rig.print(match rig.simulated {
        Some(_) => "a measurement: the bench taps by itself",
        None => "a measurement: YOUR TURN, tap where the lines below say",
    });
    let (exit, measured) = rig.measure(&["measure", layout, "--restart"]);
    assert_eq!(exit, 0, "{measured}");
    let mass = &measured["results"][0]["mass_kg"];
    let (value, sd) = (mass["value"].as_f64().unwrap(), mass["sigma"].as_f64().unwrap());
    rig.print(&format!("mass {value:.4} kg, standard deviation {sd:.4} kg"));
    assert!(value.is_finite() && sd > 0.0, "{mass}");
    if let Some(truth) = rig.mass_kg {
        // Four standard deviations: one correct measurement in 16 000 deviates more.
        assert!((value - truth).abs() < 4.0 * sd, "weighed: {truth} kg");
    }
    measured
}

fn result_is_kept(rig: &Rig, measured: &Value) {
    let layout = rig.layout.to_str().unwrap();
    let number = measured["number"].as_u64().unwrap().to_string();
    let list = rig.ask("its results", &["results", "list"]);
    let listed = list["results"].as_array().unwrap().iter();
    assert!(listed.clone().any(|entry| entry["number"] == measured["number"]), "{list}");
    // The layout that the rig returns is in single precision, that of the file is not.
    let kept = rig.ask("the new one", &["results", "get", &number, "--layout", layout]);
    for key in ["number", "layout_hash", "results", "mass_lines"] {
        assert_eq!(kept[key], measured[key], "{key}");
    }
    rig.ask("delete it", &["results", "delete", &number, "--yes"]);
    assert_eq!(rig.run(&["results", "get", &number]).0, 2, "it is gone");
}

fn nothing_went_wrong(rig: &Rig, stats: [&Value; 2], measured: &Value) {
    let [before, after] = stats.map(|stats| {
        move |name: &str| stats[name].as_u64().unwrap_or_else(|| panic!("{name} of {stats}"))
    });
    for name in ["scans_lost", "frames_broken", "store_failures"] {
        assert_eq!(after(name), before(name), "{name}");
    }
    if rig.simulated.is_none() {
        // On a busy computer the process occasionally has to wait.
        assert_eq!(after("deadlines_missed"), before("deadlines_missed"), "deadlines_missed");
        assert!(after("stack_high_water") < after("stack_size"), "{}", stats[1]);
    }
    // Every hit that counted has triggered; a layout has at least three DOFs.
    assert!(after("triggers") >= before("triggers") + 3, "{measured}");
    assert!(after("uptime_ms") >= before("uptime_ms"), "the rig has started anew");
}

/// A rig on a port.
struct Rig {
    port: String,
    layout: PathBuf,
    mass_kg: Option<f64>,
    folder: TempDir,
    simulated: Option<VirtualProcess>,
}

impl Rig {
    /// The rig at `MASSLINE_PORT`, or else a virtual one.
    fn of_environment() -> Self {
        let set = |name| std::env::var(name).ok().filter(|value| !value.is_empty());
        let folder = tempfile::tempdir().unwrap();
        let Some(port) = set("MASSLINE_PORT") else { return Self::simulated(folder) };
        let layout = set("MASSLINE_LAYOUT")
            .expect("MASSLINE_LAYOUT names the layout file of what hangs at the rig");
        let mass_kg = set("MASSLINE_MASS_KG")
            .map(|mass| mass.parse().expect("MASSLINE_MASS_KG is a number of kilograms"));
        Self { port, layout: layout.into(), mass_kg, folder, simulated: None }
    }

    /// The three-bar frame of 1.23 kg on the ideal bench, which taps by itself.
    fn simulated(folder: TempDir) -> Self {
        let process = VirtualProcess::start(&["--fast"]);
        let layout = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/three-bar-test-1.toml");
        Self {
            port: process.port.clone(),
            layout,
            mass_kg: Some(1.23),
            folder,
            simulated: Some(process),
        }
    }

    fn print(&self, text: &str) {
        eprintln!("{}: {text}", self.port);
    }

    /// The output of a command that must succeed.
    #[track_caller]
    fn ask(&self, step: &str, arguments: &[&str]) -> Value {
        self.print(step);
        let (exit, answer) = self.run(arguments);
        assert_eq!(exit, 0, "massline {}: {answer}", arguments.join(" "));
        answer
    }

    /// Exit code and output of a command.
    #[track_caller]
    fn run(&self, arguments: &[&str]) -> (i32, Value) {
        let mut command = assert_cmd::Command::from_std(program(arguments));
        command.args(["--json", "--port", &self.port]).timeout(LATE);
        answer(&command.output().unwrap())
    }

    /// Like [`Rig::run`], but for a person who reads the prompts and may take any time.
    fn measure(&self, arguments: &[&str]) -> (i32, Value) {
        if self.simulated.is_some() {
            return self.run(arguments);
        }
        let mut command = program(arguments);
        command.args(["--json", "--port", &self.port]).stderr(Stdio::inherit());
        answer(&command.output().unwrap())
    }
}

fn program(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_massline"));
    command.args(arguments);
    command
}

#[track_caller]
fn answer(output: &std::process::Output) -> (i32, Value) {
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let seen = format!("{text}\n{}", String::from_utf8_lossy(&output.stderr));
    (output.status.code().expect(&seen), serde_json::from_str(&text).expect(&seen))
}

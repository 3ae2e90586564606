//! The emulated rig from end to end: the real command-line program, a pty and the Cortex-M4F firmware.
//!
//! Needs QEMU and the target `thumbv7em-none-eabihf`, so it is behind a feature:
//! `cargo test -p massline --features emulated-rig --test emulated_rig`.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;
use std::thread;
use std::time::{Duration, Instant};

use massline::qemu::{EmulatedRig, Feeder, build_firmware};
use massline_client::campaign::{CampaignOutcome, Observer, StartOptions, begin, follow};
use massline_client::interrupt::Interrupt;
use massline_client::{Client, SerialTransport};
use massline_files::layout_file::LayoutFile;
use massline_physics::source::ScanSource;
use massline_physics::{Bench, BenchSource};
use massline_protocol::message::Stats;
use serde_json::Value;

/// A limit that is reached only when something hangs.
const LATE: Duration = Duration::from_secs(60);

/// Built once for all tests.
static FIRMWARE: LazyLock<PathBuf> = LazyLock::new(|| build_firmware().unwrap());

fn massline(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_massline"));
    command.args(arguments);
    command
}

/// The output of the program with `--json`.
fn json(arguments: &[&str]) -> Value {
    let output = massline(arguments).arg("--json").output().unwrap();
    let words = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "massline {arguments:?}: {}\n{words}", output.status);
    serde_json::from_slice(&output.stdout).unwrap()
}

fn firmware() -> &'static str {
    FIRMWARE.to_str().unwrap()
}

fn example(test: u32) -> String {
    format!("{}/examples/three-bar-test-{test}.toml", env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn the_demo_is_the_same_on_the_emulated_and_on_the_virtual_rig() {
    let emulated = json(&["demo", "--rig", "qemu", "--firmware", firmware(), "--seed", "3"]);
    let on_host = json(&["demo", "--rig", "virtual", "--seed", "3"]);
    assert_eq!(emulated["tests"].as_array().unwrap().len(), 4);
    // The same functions in the same precision on the same scans give the same bits.
    assert_eq!(emulated["tests"], on_host["tests"]);
}

#[test]
fn a_tape_gives_the_same_results_on_the_emulated_and_on_the_virtual_rig() {
    let directory = tempfile::tempdir().unwrap();
    for test in 1..=4 {
        let (layout, tape) = (example(test), directory.path().join(format!("test-{test}.npy")));
        let tape = tape.to_str().unwrap();
        json(&["simulate", &layout, "--tape", tape]);
        let replay = ["replay", tape, "--layout", &layout];
        let on_host = json(&replay);
        let emulated = json(&[&replay[..], &["--rig", "qemu", "--firmware", firmware()]].concat());
        assert_eq!(emulated["results"], on_host["results"], "test {test}");
        assert_eq!(emulated["results"].as_array().unwrap().len(), 2);
    }
}

/// A DOF of the wheel whose hit moves all six modes.
const OBLIQUE: &str = r#"
[[node]]
id = 110
position_m = [0.18, -0.21, -0.02]
axes = [[0.6, 0.64, 0.48], [-0.8, 0.48, 0.36]]
"#;

#[test]
fn a_dof_of_the_wheel_has_the_same_modes_and_answers_on_the_emulated_and_on_the_virtual_rig() {
    let directory = tempfile::tempdir().unwrap();
    let path = |name: &str| directory.path().join(name).display().to_string();
    let (layout, tape) = (path("wheel.toml"), path("tape.npy"));
    let text = include_str!("../examples/wheel.toml").to_owned() + OBLIQUE;
    let hits = r#"["101:+X", "102:+Z", "103:+Z", "104:+Y", "105:+X"]"#;
    let text = text.replace(hits, r#"["110:+X"]"#);
    std::fs::write(&layout, text.replace("[test]\n", "[test]\nhits_per_dof = 2\n")).unwrap();
    json(&["simulate", &layout, "--bench", "wheel", "--tape", &tape]);
    let replay = ["replay", &tape, "--layout", &layout];
    let on_host = json(&replay);
    let emulated = json(&[&replay[..], &["--rig", "qemu", "--firmware", firmware()]].concat());
    let [on_host, emulated] = [&on_host, &emulated];
    let modes = |document: &Value| document["suspension"]["modes"].as_array().unwrap().clone();
    assert_eq!(modes(emulated).len(), 6);
    // Both rigs compute the lines in single precision, but sines, hypotenuses and the like come from another library
    // there: last bits differ, as after another order of rounding, which is a hundredth of a standard deviation at
    // most.
    let alike = |one: &Value, other: &Value, quantity: &str| {
        let numbers = |value: &Value| match value {
            Value::Array(values) => values.iter().map(|v| v.as_f64().unwrap()).collect(),
            single => vec![single.as_f64().unwrap()],
        };
        let value_and_sigma = |entry: &Value| [numbers(&entry["value"]), numbers(&entry["sigma"])];
        let ([a, sigmas], [b, others]) = (value_and_sigma(one), value_and_sigma(other));
        for k in 0..a.len().max(b.len()) {
            let (difference, sigma) = (a[k] - b[k], sigmas[k]);
            assert!(difference.abs() < 0.01 * sigma, "{quantity} {k}: {difference} of {sigma}");
            assert!(
                (sigma / others[k] - 1.0).abs() < 0.01,
                "{quantity} {k}: {sigma}, {}",
                others[k]
            );
        }
    };
    for (one, other) in modes(emulated).iter().zip(&modes(on_host)) {
        alike(&one["frequency_hz"], &other["frequency_hz"], "frequency");
        alike(&one["damping_ratio"], &other["damping_ratio"], "damping");
    }
    let results = |document: &Value| document["results"].as_array().unwrap().clone();
    let methods = |document: &Value| {
        results(document).iter().map(|r| r["method"].clone()).collect::<Vec<_>>()
    };
    assert!(methods(emulated).len() >= 3, "{emulated}");
    assert_eq!(methods(on_host), methods(emulated));
    for (one, other) in results(emulated).iter().zip(&results(on_host)) {
        for key in ["mass_kg", "center_of_mass_m", "principal_moments_kg_m2"] {
            alike(&one[key], &other[key], &format!("{key} by {}", one["method"]));
        }
    }
}

/// The wheel measured from scans to answers: on the virtual rig, and with MASSLINE_LONG on the emulated one too, where
/// it takes minutes.
#[test]
fn the_whole_wheel_is_measured_and_the_truth_is_within_the_uncertainty() {
    let long = std::env::var_os("MASSLINE_LONG").is_some();
    let rigs: &[&[&str]] = &[&["virtual"], &["qemu", "--firmware", firmware()]];
    for rig in &rigs[..if long { 2 } else { 1 }] {
        let document = json(&[&["demo", "wheel", "--rig"][..], rig].concat());
        assert_eq!(document["suspension"]["modes"].as_array().unwrap().len(), 6);
        let truth = document["truth"].as_array().unwrap();
        let agreement = &document["agreement"];
        assert_eq!(agreement["outcome"], "agree", "{rig:?} {agreement}");
        let names = ["m", "c_x", "c_y", "c_z", "J_xx", "J_yy", "J_zz", "J_xy", "J_xz", "J_yz"];
        for (name, truth) in names.iter().zip(truth) {
            let number = |part: &str| agreement["combined"][part][name].as_f64().unwrap();
            let error = number("value") - truth.as_f64().unwrap();
            // The seed is fixed; chance exceeds 3.5 standard deviations for one of ten numbers in 200 campaigns.
            assert!(error.abs() < 3.5 * number("sigma"), "{rig:?} {name}: {error}");
        }
    }
}

#[test]
fn results_and_layout_survive_a_restart_of_the_rig() {
    let file = LayoutFile::read(Path::new(&example(1))).unwrap();
    let layout = file.rig_layout().unwrap();
    let bench = Bench::named("ideal").unwrap();
    let source = BenchSource::new(&bench, &file.layout, 1).unwrap();
    let mut rig = EmulatedRig::start(&FIRMWARE, &source.adc()).unwrap();
    let mut client = connect(&rig);
    client.put_layout(&layout).unwrap();
    begin(&mut client, StartOptions::default()).unwrap();
    let mut operator = Operator(rig.feed(Box::new(source)));
    let ending = follow(&mut client, &Interrupt::new(), Some(LATE), &mut operator).unwrap();
    let CampaignOutcome::Done(number) = ending else { panic!("{ending:?}") };
    let (before, stats) = (client.result(number).unwrap(), client.stats().unwrap());
    nothing_went_wrong(&stats);
    assert!(stats.triggers >= 15, "three DOFs of five hits: {stats:?}");
    drop((operator, client));

    rig.restart().unwrap();
    let mut client = connect(&rig);
    assert_eq!(client.layout().unwrap(), layout);
    assert_eq!(client.result(number).unwrap(), before);
    // The count begins at power-on.
    assert_eq!(client.stats().unwrap().triggers, 0);
    rig.check().unwrap();
}

fn connect(rig: &EmulatedRig) -> Client {
    let mut client = Client::new(SerialTransport::open(rig.port_path()).unwrap());
    assert_eq!(client.identify().unwrap().board, "mps2-an386");
    client
}

/// Passes to the simulated person at the bench what the rig waits for.
struct Operator(Feeder);

impl Observer for Operator {
    fn armed(&mut self, arming: u32, dof: usize) -> massline::Result<()> {
        self.0.armed(arming, dof);
        Ok(())
    }
}

fn nothing_went_wrong(stats: &Stats) {
    assert_eq!(stats.scans_lost, 0);
    assert_eq!(stats.frames_broken, 0);
    assert_eq!(stats.frames_unsent, 0);
    assert_eq!(stats.store_failures, 0);
    assert!(stats.stack_high_water > 0 && stats.stack_high_water < stats.stack_size);
}

/// What this firmware says before it ends the emulator.
fn last_words_of(firmware: &str) -> String {
    let elf = FIRMWARE.with_file_name(firmware);
    let bench = Bench::named("ideal").unwrap();
    let layout = LayoutFile::read(Path::new(&example(1))).unwrap().layout;
    let adc = BenchSource::new(&bench, &layout, 1).unwrap().adc();
    let mut rig = match EmulatedRig::start(&elf, &adc) {
        Ok(rig) => rig,
        // It may have ended before the host has seen it start.
        Err(error) => {
            assert_eq!(error.exit_code(), 4, "{error}");
            return error.to_string();
        }
    };
    let start = Instant::now();
    let error = loop {
        match rig.check() {
            Err(error) => break error,
            Ok(()) => assert!(start.elapsed() < LATE, "the emulator goes on"),
        }
        thread::yield_now();
    };
    assert_eq!((error.code(), error.exit_code()), ("rig_died", 4));
    error.to_string()
}

#[test]
fn a_panic_of_the_firmware_ends_the_emulator_and_its_message_is_reported() {
    let words = last_words_of("last_words");
    assert!(
        words.contains("last_words.rs") && words.contains("these are the last words"),
        "{words}"
    );
}

#[test]
fn an_overflow_of_the_stack_is_a_fault_with_a_name() {
    let words = last_words_of("stack_overflow");
    assert!(words.contains("the stack has overflowed"), "{words}");
}

#[test]
fn a_missing_emulator_is_named_with_the_command_that_installs_it() {
    let output = massline(&["demo", "--rig", "qemu", "--firmware", firmware()])
        .env("PATH", "")
        .output()
        .unwrap();
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{words}");
    assert!(words.contains("apt-get install qemu-system-arm"), "{words}");
}

//! The verdict on a result: first line, JSON, exit code and export, of a healthy test and of a contradicted one.

use serde_json::Value;
use tempfile::TempDir;

use crate::program::{LAYOUT, Run, answer, run, run_json};

/// What the commands print of a test: with a mistake in it, or without.
struct SimulatedCase {
    folder: TempDir,
    fault: Option<&'static str>,
}

impl SimulatedCase {
    fn healthy() -> Self {
        Self { folder: tempfile::tempdir().unwrap(), fault: None }
    }

    /// Sensor 2 has its y axis reversed, which moves J_xy by 43 %.
    fn contradicted() -> Self {
        Self { fault: Some("flip:2y"), ..Self::healthy() }
    }

    fn path(&self, name: &str) -> String {
        self.folder.path().join(name).display().to_string()
    }

    /// `simulate` on the bench of the demo, with further arguments.
    fn simulate<'a>(&'a self, more: &[&'a str]) -> Vec<&'a str> {
        let fault = self.fault.map_or(Vec::new(), |fault| vec!["--fault", fault]);
        [&["simulate", LAYOUT, "--bench", "default", "--seed", "1"], fault.as_slice(), more]
            .concat()
    }

    /// The first line, the exit code, and the verdict in JSON of a command.
    #[track_caller]
    fn verdict(&self, arguments: &[&str]) -> (String, i32, Value) {
        let text = run(arguments);
        let (again, value) = run_json(arguments);
        assert_eq!(text.exit, again.exit, "{arguments:?}: {}", text.stderr);
        let first = text.stdout.lines().next().unwrap_or_default().to_owned();
        (first, text.exit, value)
    }
}

#[track_caller]
fn is_good((first, exit, value): &(String, i32, Value)) {
    assert!(first.starts_with("Good: "), "{first}");
    assert_eq!((*exit, &value["verdict"]), (0, &"good".into()));
    assert_eq!(value["verdict_reasons"], serde_json::json!([]));
}

#[track_caller]
fn is_not_to_be_used((first, exit, value): &(String, i32, Value)) {
    assert!(first.starts_with("Do not use this answer"), "{first}");
    assert_eq!((*exit, &value["verdict"]), (3, &"do_not_use".into()));
    let reason = &value["verdict_reasons"][0];
    assert_eq!(reason["verdict"], "do_not_use", "{reason}");
}

#[test]
fn simulate_and_replay_state_the_verdict_first_and_end_with_it() {
    for (simulated, check) in [
        (SimulatedCase::healthy(), is_good as fn(&_)),
        (SimulatedCase::contradicted(), is_not_to_be_used),
    ] {
        check(&simulated.verdict(&simulated.simulate(&[])));
        let tape = simulated.path("tape.npy");
        run(&simulated.simulate(&["--tape", &tape]));
        check(&simulated.verdict(&["replay", &tape, "--layout", LAYOUT]));
    }
}

/// Writes the result of a simulation as URDF.
fn exported(simulated: &SimulatedCase, more: &[&str]) -> Run {
    let result = simulated.path("result.json");
    let printed = run(&[&["--json"], simulated.simulate(&[]).as_slice()].concat());
    std::fs::write(&result, printed.stdout).unwrap();
    run(&[&["export", &result, "--format", "urdf"], more].concat())
}

#[test]
fn a_good_answer_is_exported_with_its_verdict() {
    let written = exported(&SimulatedCase::healthy(), &[]);
    assert_eq!(written.exit, 0, "{}", written.stderr);
    assert!(written.stdout.contains("verdict: good"), "{}", written.stdout);
    assert!(!written.stderr.contains("verdict"), "{}", written.stderr);
}

#[test]
fn a_contradicted_answer_is_exported_only_despite_its_verdict() {
    let simulated = SimulatedCase::contradicted();
    let refused = exported(&simulated, &[]);
    assert_eq!((refused.exit, refused.stdout.as_str()), (3, ""), "{}", refused.stderr);
    assert!(refused.says("has its y axis reversed"), "{}", refused.stderr);
    assert!(refused.says("--despite-verdict"), "{}", refused.stderr);
    let forced = exported(&simulated, &["--despite-verdict"]);
    assert_eq!(forced.exit, 0, "{}", forced.stderr);
    assert!(forced.stdout.contains("verdict: DO NOT USE"), "{}", forced.stdout);
    assert!(forced.says("verdict: do not use: "), "{}", forced.stderr);
}

/// The rig measures, stores and archives it all the same; only what states an answer ends with the verdict.
#[cfg(unix)]
#[test]
fn a_contradicted_measurement_is_kept_and_every_command_says_so() {
    let rig = crate::rig::Rig::start(&["--fast", "--fault", "flip:2y"]);
    let folder = tempfile::tempdir().unwrap();
    let archive = folder.path().join("test.massline").display().to_string();
    let layout = rig.layout(3);
    let is_not_to_be_used = |(exit, value): (i32, Value), expected: i32| {
        assert_eq!((exit, &value["verdict"]), (expected, &"do_not_use".into()), "{value}");
        let reason = value["verdict_reasons"][0]["message"].as_str().unwrap();
        assert!(reason.contains("has its y axis reversed"), "{reason}");
    };
    is_not_to_be_used(rig.run(&["measure", &layout, "-o", &archive]), 3);
    is_not_to_be_used(rig.run(&["results", "get", "1"]), 0);
    is_not_to_be_used(answer(&["solve", &archive]), 3);
    assert_eq!(run(&["export", &archive, "--format", "urdf"]).exit, 3);
    let responses = run(&["export", &archive, "--format", "uff"]);
    assert_eq!(responses.exit, 0, "{}", responses.stderr);
    assert!(responses.says("verdict: do not use"), "{}", responses.stderr);
    let page = folder.path().join("test.html").display().to_string();
    assert_eq!(run(&["report", &archive, "-o", &page]).exit, 0);
    assert!(std::fs::read_to_string(&page).unwrap().contains("Do not use this answer"));
    let (exit, history) = answer(&["history", &folder.path().display().to_string()]);
    assert_eq!((exit, &history["archives"][0]["verdict"]), (0, &"do_not_use".into()));
    let (exit, list) = rig.run(&["results", "list"]);
    assert_eq!((exit, &list["results"][0]["verdict"]), (0, &"do_not_use".into()));
}

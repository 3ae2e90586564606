//! Options with impossible numbers, and text that fits a terminal.

use std::path::Path;

use crate::program::{LAYOUT, Run, run};

/// Exit code and stderr.
fn refusal(arguments: &[&str]) -> (i32, String) {
    let run = run(arguments);
    (run.exit, run.stderr)
}

fn recording() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"));
    path.join("../tests/data/pyfrf-impact/impact2_response0.lvm").display().to_string()
}

/// Command lines with a numeric option each.
fn numbers() -> Vec<(Vec<String>, &'static str)> {
    let recording = recording();
    let cases = |before: &[&str], options: &[&'static str]| {
        let before: Vec<String> = before.iter().map(|&word| word.to_owned()).collect();
        options.iter().map(|&option| (before.clone(), option)).collect::<Vec<_>>()
    };
    let hits = [
        "--rate-hz",
        "--force-range-n",
        "--response-range-m-per-s2",
        "--trigger-n",
        "--min-peak-force-n",
        "--pre-trigger-s",
        "--record-s",
        "--force-window-s",
        "--exponential-decay-per-s",
        "--keep",
    ];
    let suggest = ["--sensors", "--hits", "--hits-per-dof", "--noise", "--starts", "--seed"];
    [
        cases(&["hits", &recording], &hits),
        cases(&["layout", "suggest", LAYOUT], &suggest),
        cases(&["layout", "check", LAYOUT], &["--noise"]),
        cases(&["simulate", LAYOUT], &["--seed", "--runs"]),
        cases(&["simulate", LAYOUT, "--runs", "2"], &["--threads"]),
        cases(&["demo"], &["--seed", "--hits"]),
    ]
    .concat()
}

#[test]
fn a_number_that_cannot_be_is_refused_by_the_name_of_its_option() {
    for (before, option) in numbers() {
        for value in ["-5", "nan", "inf", "1e400", "x", ""] {
            let mut arguments: Vec<&str> = before.iter().map(String::as_str).collect();
            arguments.extend([option, value]);
            let (code, message) = refusal(&arguments);
            assert_eq!(code, 2, "{arguments:?}: {message}");
            assert!(!message.contains("unexpected argument"), "{arguments:?}: {message}");
            assert!(message.contains(&format!("for '{option} <")), "{arguments:?}: {message}");
        }
    }
}

#[test]
fn a_negative_end_of_a_band_is_refused_as_a_number() {
    let (code, message) = refusal(&["hits", &recording(), "--band-hz", "-5", "100"]);
    assert_eq!(code, 2);
    assert!(message.contains("'-5' for '--band-hz <LOW> <HIGH>'"), "{message}");
    assert!(message.contains("positive number"), "{message}");
}

#[test]
fn no_hits_to_keep_and_no_runs_are_refused_with_what_to_give() {
    let (code, message) = refusal(&["hits", &recording(), "--keep", "0"]);
    assert!(code == 2 && message.contains("at least 1; leave --keep out"), "{message}");
    let (code, message) = refusal(&["simulate", LAYOUT, "--runs", "0"]);
    assert!(code == 2 && message.contains("at least 1; use 100 or more"), "{message}");
}

#[test]
fn a_day_that_the_calendar_does_not_have_is_refused_by_the_name_of_its_option() {
    let Run { exit, stderr: message, .. } = run(&["calibrate", "tumble", "--date", "2026-02-31"]);
    assert!(exit == 2 && message.contains("'2026-02-31' for '--date <DAY>'"), "{message}");
    assert!(message.contains("yyyy-mm-dd"), "{message}");
}

#[test]
fn the_help_names_every_bundled_bench() {
    for command in ["simulate", "demo", "virtual"] {
        let help = run(&[command, "--help"]).stdout;
        for bundled in massline_physics::Bench::BUNDLED {
            assert!(help.contains(&format!("`{}`", bundled.name)), "{command}: {help}");
        }
    }
}

#[test]
fn text_is_at_most_a_hundred_columns_wide() {
    let recording = recording();
    let commands: [&[&str]; 7] = [
        &["simulate", LAYOUT, "--runs", "2"],
        &["simulate", LAYOUT, "--fault", "swap:1,2"],
        &["layout", "check", LAYOUT],
        &["layout", "check", "examples/block.toml"],
        &["layout", "show", LAYOUT],
        &["hits", &recording],
        &["hits", &recording, "--rate-hz", "1000"],
    ];
    for arguments in commands {
        let Run { stdout: out, stderr: err, .. } = run(arguments);
        assert!(!out.is_empty() || !err.is_empty());
        for line in out.lines().chain(err.lines()) {
            // A path or another long word is not broken.
            let whole = line.trim().contains(' ');
            assert!(line.chars().count() <= 100 || !whole, "{arguments:?}: {line}");
        }
    }
}

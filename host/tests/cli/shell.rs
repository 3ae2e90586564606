//! Completions and colour.

use crate::program::{LAYOUT, run, success};

#[test]
fn every_shell_completes_every_command() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = run(&["completions", shell]);
        assert_eq!(script.exit, 0, "{}", script.stderr);
        let as_json = success(&["completions", shell]);
        assert_eq!(as_json["completions"].as_str().unwrap().trim_end(), script.stdout.trim_end());
        for word in ["massline", "measure", "identify", "--method"] {
            assert!(script.stdout.contains(word.trim_start_matches("--")), "{shell}: {word}");
        }
    }
}

#[test]
fn colour_is_for_terminals_or_for_who_asks() {
    let show = |color: &[&str]| {
        let simulated = run(&[&["simulate", LAYOUT], color].concat());
        assert_eq!(simulated.exit, 0, "{}", simulated.stderr);
        simulated.stdout.contains('\x1b')
    };
    assert!(!show(&[]));
    assert!(show(&["--color", "always"]));
    assert!(!show(&["--color", "never"]));
}

#[test]
fn doctor_says_how_things_are_and_what_to_do() {
    let value = success(&["doctor"]);
    let findings = value["findings"].as_array().unwrap();
    let finding_of = |subject: &str| findings.iter().find(|finding| finding["subject"] == subject);
    let program = finding_of("massline").unwrap();
    assert_eq!(program["state"], "good");
    assert!(program["found"].as_str().unwrap().starts_with(env!("CARGO_PKG_VERSION")), "{program}");
    let emulator = finding_of("emulated rig").unwrap();
    assert_eq!(emulator["advice"].is_null(), emulator["state"] == "good", "{emulator}");
    for finding in findings.iter().filter(|finding| finding["state"] == "absent") {
        assert!(finding["advice"].is_string(), "{finding}");
    }
    let text = run(&["doctor"]);
    assert!(text.exit == 0 && text.stdout.contains("massline: "), "{}", text.stdout);
}

#[test]
fn the_ports_of_this_computer_are_listed_with_paths() {
    let value = success(&["device", "list"]);
    for port in value["ports"].as_array().unwrap() {
        assert!(!port["path"].as_str().unwrap().is_empty(), "{port}");
    }
}

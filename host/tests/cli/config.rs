//! The configuration file.

use std::path::{Path, PathBuf};

use crate::program::{LAYOUT, run, run_with_config, run_with_config_and_port};

fn config(folder: &Path, text: &str) -> PathBuf {
    let path = folder.join("config.toml");
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn options_have_the_defaults_of_the_file_and_arguments_win() {
    let folder = tempfile::tempdir().unwrap();
    let path = config(folder.path(), "color = \"always\"\nport = \"/dev/no-such-port\"\n");
    let colored = run_with_config(&path, &["demo", "--help"]);
    assert!(colored.stdout.contains("\x1b["), "{}", colored.stdout);
    let plain = run_with_config(&path, &["demo", "--help", "--color", "never"]);
    assert!(!plain.stdout.contains("\x1b["), "{}", plain.stdout);
    let asked = run_with_config(&path, &["device", "identify"]);
    assert!(asked.says("/dev/no-such-port does not exist"), "{}", asked.stderr);
    let other = run_with_config(&path, &["device", "identify", "--port", "/dev/other-port"]);
    assert!(other.says("/dev/other-port does not exist"), "{}", other.stderr);
}

/// The command line, then the environment, then the file, whether the file has the port for all commands or for one.
#[test]
fn the_environment_comes_before_the_file_and_the_command_line_before_both() {
    let folder = tempfile::tempdir().unwrap();
    for text in ["port = \"/dev/of-file\"\n", "[device.identify]\nport = \"/dev/of-file\"\n"] {
        let path = config(folder.path(), text);
        let identify = ["device", "identify"];
        let file = run_with_config(&path, &identify);
        assert!(file.says("/dev/of-file does not exist"), "{text}: {}", file.stderr);
        let both = run_with_config_and_port(&path, "/dev/of-environment", &identify);
        assert!(both.says("/dev/of-environment does not exist"), "{text}: {}", both.stderr);
        let arguments = ["device", "identify", "--port", "/dev/of-line"];
        let all_three = run_with_config_and_port(&path, "/dev/of-environment", &arguments);
        assert!(all_three.says("/dev/of-line does not exist"), "{text}: {}", all_three.stderr);
    }
}

/// What the guide shows can be typed.
#[test]
fn the_example_of_the_guide_is_taken() {
    let folder = tempfile::tempdir().unwrap();
    let guide = include_str!("../../README.md");
    let (_, after) = guide.split_once("Defaults of options can stand in a file").unwrap();
    let (_, example) = after.split_once("```toml").unwrap();
    let (example, _) = example.split_once("```").unwrap();
    let path = config(folder.path(), example);
    let data = "../tests/data/archive/version-1.massline";
    let exported =
        run_with_config(&path, &["export", data, "--format", "csv", "-o", "/dev/stdout"]);
    assert_eq!(exported.exit, 0, "{}", exported.stderr);
    assert!(exported.stdout.contains("mm"), "{}", exported.stdout);
}

#[test]
fn a_table_holds_for_its_command_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = config(folder.path(), "[demo]\nseed = 5\n[layout.check]\nnoise = 0.01\n");
    let arguments = ["demo", "--json", "--hits", "3"];
    let with = run_with_config(&path, &arguments);
    assert_eq!(with.exit, 0, "{}", with.stderr);
    assert_eq!(with.stdout, run(&[&arguments[..], &["--seed", "5"]].concat()).stdout);
    assert_ne!(with.stdout, run(&arguments).stdout);
    let checked = run_with_config(&path, &["layout", "check", LAYOUT, "--json"]);
    assert!(checked.stdout.contains("\"noise\":0.01"), "{}", checked.stdout);
}

#[test]
fn what_the_file_may_not_say_is_refused_with_its_name_and_the_way_out() {
    let folder = tempfile::tempdir().unwrap();
    for (text, phrase) in [
        ("prot = \"COM3\"", "prot: no command has the option --prot"),
        ("[slove]\nmethod = \"ml\"", "[slove]: there is no such command"),
        ("[solve]\nmethods = \"ml\"", "[solve]: methods: `massline solve` has no option --methods"),
        ("[[demo]]\nseed = 1", "demo: this is a command; its options stand below one line [demo]"),
        ("color = []", "config.toml:1: color: the list is empty; leave the line out"),
        (
            "[export]\nunits = [\"si\", \"t-mm\"]",
            "config.toml:2: [export]: units: one value is wanted, and here are 2",
        ),
        ("json = true", "json: this option is a switch"),
        (
            "port = true",
            "config.toml:1: port: give a text, a number, or a list of them, and not true",
        ),
        ("color = \"sometimes\"", "color: \"sometimes\" is not one of auto, always, never"),
        (
            "[demo]\nhits = \"many\"",
            "config.toml:2: [demo]: hits: invalid value 'many' for '--hits",
        ),
        ("[demo]\nseed = -1.5", "[demo]: seed: invalid value '-1.5' for '--seed"),
        ("[layout.check]\nnoise = \"loud\"", "[layout]: [check]: noise: invalid value 'loud'"),
        ("[export]\nframe = \"corner\"", "[export]: frame: invalid value 'corner'"),
        ("[export]\nunits = \"inch\"", "[export]: units: \"inch\" is not one of"),
        (
            "color = ",
            "config.toml:1: color: there is no value after the `=`; correct the configuration",
        ),
        (
            "\n[demo]\nhits = [5, { a = 1_0 }]",
            "config.toml:3: [demo]: hits: give a text, a number, or a list of them, and not [5, { a = 1_0 }]",
        ),
        (
            "demo = 3",
            "config.toml:1: demo: this is a command; its options stand below one line [demo]",
        ),
    ] {
        let path = config(folder.path(), text);
        let refused = run_with_config(&path, &["demo", "--help"]);
        assert_eq!(refused.exit, 2, "{text}: {}", refused.stderr);
        for phrase in [phrase, "config.toml", "MASSLINE_CONFIG="] {
            assert!(refused.says(phrase), "{text}: {phrase}: {}", refused.stderr);
        }
    }
    let missing = run_with_config(&folder.path().join("none.toml"), &["demo", "--help"]);
    assert!(missing.exit == 2 && missing.says("none.toml"), "{}", missing.stderr);
}

//! Runs the program, and makes the files for it.

use std::path::{Path, PathBuf};
use std::time::Duration;

use assert_cmd::Command;
use serde_json::Value;

use crate::documents;

/// A wall-clock limit that is reached only when something hangs.
pub const LATE: Duration = Duration::from_secs(120);
/// The layout of the paper's first test.
pub const LAYOUT: &str = "examples/three-bar-test-1.toml";

/// The outcome of a run.
pub struct Run {
    pub exit: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Run {
    /// Whether stderr contains these words; where its lines break depends on the lengths of paths and does not matter.
    pub fn says(&self, text: &str) -> bool {
        words(&self.stderr).contains(&words(text))
    }
}

/// The text with every run of white space replaced by one space.
pub fn words(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Runs the program without a port in its environment.
#[track_caller]
pub fn run(arguments: &[&str]) -> Run {
    finish(Command::new(env!("CARGO_BIN_EXE_massline")), arguments)
}

/// Runs the program with a configuration file.
#[track_caller]
pub fn run_with_config(config: &Path, arguments: &[&str]) -> Run {
    let mut program = Command::new(env!("CARGO_BIN_EXE_massline"));
    program.env("MASSLINE_CONFIG", config);
    finish(program, arguments)
}

/// Runs the program with a limit of the shell's `ulimit`: `-f 100` for instance lets no file grow beyond 100 blocks of
/// 512 bytes, as a full disk would, and `-d 524288` lets it have at most 512 MiB of memory.
#[cfg(unix)]
#[track_caller]
pub fn run_limited(limit: &str, arguments: &[&str]) -> Run {
    // A signal that is ignored leaves the error of the write to the program.
    run_in_shell(&format!("trap '' XFSZ; ulimit {limit}; exec \"$0\" \"$@\""), arguments)
}

/// Runs a shell script in which `"$0" "$@"` is the program with its arguments.
#[cfg(unix)]
#[track_caller]
pub fn run_in_shell(script: &str, arguments: &[&str]) -> Run {
    let mut shell = Command::new("sh");
    shell.args(["-c", script, env!("CARGO_BIN_EXE_massline")]);
    finish(shell, arguments)
}

/// Runs the program with a configuration file, and with a port in its environment.
#[track_caller]
pub fn run_with_config_and_port(config: &Path, port: &str, arguments: &[&str]) -> Run {
    let mut program = Command::new(env!("CARGO_BIN_EXE_massline"));
    program.env("MASSLINE_CONFIG", config).env("MASSLINE_PORT", port);
    finish(program, arguments)
}

#[track_caller]
fn finish(mut command: Command, arguments: &[&str]) -> Run {
    if command.get_envs().all(|(name, _)| name != "MASSLINE_CONFIG") {
        // The configuration of whoever runs the tests.
        command.env("MASSLINE_CONFIG", "");
    }
    if command.get_envs().all(|(name, _)| name != "MASSLINE_PORT") {
        command.env_remove("MASSLINE_PORT");
    }
    command.args(arguments).timeout(LATE);
    let output = command.output().expect("the program starts");
    let text = |bytes| String::from_utf8(bytes).expect("the program prints UTF-8");
    let (stdout, stderr) = (text(output.stdout), text(output.stderr));
    let ended = output.status.code();
    let exit = ended.unwrap_or_else(|| panic!("{arguments:?} ends by itself:\n{stdout}\n{stderr}"));
    Run { exit, stdout, stderr }
}

/// Runs the program with `--json`: the run and what it printed.
#[track_caller]
pub fn run_json(arguments: &[&str]) -> (Run, Value) {
    let run = run(&[&["--json"], arguments].concat());
    let value = serde_json::from_str(&run.stdout);
    let seen = |e| panic!("{arguments:?} prints JSON: {e}\n{}\n{}", run.stdout, run.stderr);
    let value: Value = value.unwrap_or_else(seen);
    assert_eq!(value["schema_version"], 1, "{arguments:?} names the version of its JSON");
    documents::check(arguments, &value);
    (run, value)
}

/// Like [`run_json`], but returns exit code and output only.
#[track_caller]
pub fn answer(arguments: &[&str]) -> (i32, Value) {
    let (run, value) = run_json(arguments);
    (run.exit, value)
}

/// The output with `--json` of a run that must succeed.
#[track_caller]
pub fn success(arguments: &[&str]) -> Value {
    let (run, value) = run_json(arguments);
    assert_eq!(run.exit, 0, "{arguments:?} succeeds: {}", run.stderr);
    value
}

/// A copy of [`LAYOUT`] in `folder`, with one text replaced by another.
#[track_caller]
pub fn changed_layout(folder: &Path, from: &str, to: &str) -> String {
    copy_of_layout(&folder.join("layout.toml"), from, to)
}

/// A copy of [`LAYOUT`] in `folder` with this number of hits at a DOF instead of the original five.
pub fn layout_with_hits(folder: &Path, hits: u8) -> String {
    let path = folder.join(format!("layout-{hits}.toml"));
    copy_of_layout(&path, "hits_per_dof = 5", &format!("hits_per_dof = {hits}"))
}

#[track_caller]
fn copy_of_layout(path: &Path, from: &str, to: &str) -> String {
    let text = include_str!("../../examples/three-bar-test-1.toml");
    assert!(text.contains(from), "the layout has {from}");
    std::fs::write(path, text.replace(from, to)).expect("the folder is writable");
    path.display().to_string()
}

/// A file of the tests' data.
pub fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data").join(name)
}

/// A path as an argument.
pub fn text(path: &Path) -> String {
    path.display().to_string()
}

//! Named pipes and the streams of the process as files.

use std::process::{Child, Command, Stdio};

use crate::program::{LAYOUT, run, run_in_shell};

fn pipe(folder: &tempfile::TempDir, name: &str) -> String {
    let path = folder.path().join(name);
    nix::unistd::mkfifo(&path, nix::sys::stat::Mode::S_IRWXU).unwrap();
    path.display().to_string()
}

/// All commands wait at the same time for a program that writes to the pipe.
#[test]
fn a_pipe_that_nothing_writes_to_is_not_waited_for_without_end() {
    let folder = tempfile::tempdir().unwrap();
    let fifo = pipe(&folder, "fifo.toml");
    let link = folder.path().join("link.toml").display().to_string();
    std::os::unix::fs::symlink(&fifo, &link).unwrap();
    let commands: [&[&str]; 6] = [
        &["layout", "check", &fifo],
        &["layout", "check", &link],
        &["simulate", LAYOUT, "--bench", &fifo],
        &["simulate", LAYOUT, "--bench", &link],
        &["simulate", LAYOUT, "--calibration", &link],
        &["hits", &link],
    ];
    let start = |arguments: &&[&str]| -> Child {
        let mut command = Command::new(env!("CARGO_BIN_EXE_massline"));
        command.args(*arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
    };
    let started: Vec<Child> = commands.iter().map(start).collect();
    for (child, arguments) in started.into_iter().zip(commands) {
        let ended = child.wait_with_output().unwrap();
        let message = crate::program::words(&String::from_utf8(ended.stderr).unwrap());
        assert_eq!(ended.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(
            message.contains("it is a pipe that no program writes to"),
            "{arguments:?}: {message}"
        );
    }
}

#[test]
fn a_pipe_with_a_writer_is_a_file_like_any_other() {
    let folder = tempfile::tempdir().unwrap();
    let fifo = pipe(&folder, "fifo.toml");
    let mut writer = Command::new("cp").args([LAYOUT, &fifo]).spawn().unwrap();
    let checked = run(&["layout", "check", &fifo]);
    assert_eq!(checked.exit, 0, "{}", checked.stderr);
    assert!(writer.wait().unwrap().success());
}

/// `/dev/stdout` is a file when the shell has redirected it; it is not replaced by another.
#[test]
fn the_standard_output_can_be_given_as_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("there.toml");
    for redirection in ["| cat > there.toml", "> there.toml", ">> there.toml"] {
        let script = format!("cd {}; \"$0\" \"$@\" {redirection}", folder.path().display());
        let run = run_in_shell(&script, &["layout", "new", "-o", "/dev/stdout"]);
        assert_eq!(run.exit, 0, "{redirection}: {}", run.stderr);
        let text = std::fs::read_to_string(&file).unwrap();
        assert!(text.contains("hits = ["), "{redirection}: {text}");
    }
    let tape = run(&["simulate", LAYOUT, "--tape", "/dev/stdout"]);
    assert_eq!(tape.exit, 2);
    assert!(tape.says("the name of a tape ends with .npy"), "{}", tape.stderr);
}

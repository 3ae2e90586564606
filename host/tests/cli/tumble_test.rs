//! `massline calibrate tumble` with a person who turns the sensors, or with nobody.

use std::path::Path;

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

use crate::on_terminal::Terminal;
use crate::program::{run, words};
use crate::virtual_process::VirtualProcess;

/// The arguments of a tumble test on this rig with its readings in this folder.
fn arguments(rig: &VirtualProcess, folder: &Path) -> [String; 6] {
    let readings = folder.join("readings.toml").display().to_string();
    ["calibrate", "tumble", "--readings", &readings, "--port", &rig.port].map(str::to_owned)
}

/// A tumble test on a terminal, which has asked for the first position.
fn on_screen(rig: &VirtualProcess, folder: &Path) -> Terminal {
    let arguments = arguments(rig, folder);
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let mut terminal = Terminal::start([80, 24], "xterm-256color", &arguments);
    assert!(terminal.until_shown(|shown| shown.contains("sensor 3")), "{}", terminal.screen_text());
    terminal
}

#[test]
fn without_a_person_the_error_says_that_one_is_needed() {
    let (rig, folder) = (VirtualProcess::start(&[]), tempfile::tempdir().unwrap());
    let arguments = arguments(&rig, folder.path());
    let ended = run(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!(ended.exit, 2, "{}", ended.stderr);
    assert!(ended.says("stdin has ended: run this in a terminal; what has been read is kept"));
}

#[test]
fn a_pause_and_a_signal_give_the_terminal_back_and_say_how_to_go_on() {
    let (rig, folder) = (VirtualProcess::start(&[]), tempfile::tempdir().unwrap());
    for keys in [Some("p"), Some("\x03"), None] {
        let mut terminal = on_screen(&rig, folder.path());
        match keys {
            Some(keys) => terminal.type_keys(keys),
            None => {
                kill(Pid::from_raw(terminal.process.id() as i32), Signal::SIGTERM).unwrap();
            }
        }
        let (exit, text) = terminal.end();
        assert_eq!(exit, 130, "{text}");
        let (_, after) = text.rsplit_once("\x1b[?1049l").expect("the alternate screen is left");
        assert!(words(after).contains("is kept: the same command goes on"), "{after}");
    }
}

/// The simulated object hangs as it is measured: z of every sensor points up.
#[test]
fn a_position_in_which_the_sensors_do_not_lie_is_not_stored() {
    let folder = tempfile::tempdir().unwrap();
    // The zeros of these sensors are those of the data sheet.
    let bench = folder.path().join("bench.toml");
    std::fs::write(&bench, "[sensor]\nzero_sigma_v = 0.0\n").unwrap();
    let rig = VirtualProcess::on_bench(bench.to_str().unwrap(), &[]);
    let file = folder.path().join("calibration.toml").display().to_string();
    let pulled = run(&["calibrate", "pull", &file, "--port", &rig.port]);
    assert_eq!(pulled.exit, 0, "{}", pulled.stderr);
    let text = std::fs::read_to_string(&file).unwrap();
    assert!(text.contains("method = \"data-sheet\""), "{text}");
    let calibrated = text.replace("method = \"data-sheet\"", "method = \"tumble\"");
    std::fs::write(&file, calibrated).unwrap();
    let pushed = run(&["calibrate", "push", &file, "--port", &rig.port]);
    assert_eq!(pushed.exit, 0, "{}", pushed.stderr);
    let mut terminal = on_screen(&rig, folder.path());
    assert!(
        terminal.until_shown(|shown| shown.contains("+Z, turn it")),
        "{}",
        terminal.screen_text()
    );
    terminal.type_keys("\r");
    let refused = terminal.until_shown(|shown| words(shown).contains("+X is not stored"));
    assert!(refused, "{}", terminal.screen_text());
    assert!(terminal.screen_text().contains("0 of 6 positions read"), "{}", terminal.screen_text());
    terminal.type_keys("p");
    terminal.end();
    let stored = std::fs::read_to_string(folder.path().join("readings.toml")).unwrap_or_default();
    assert!(!stored.contains("position"), "{stored}");
}

//! `massline measure` on a full screen.

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

use crate::program::layout_with_hits;
use crate::terminal::Terminal;
use crate::virtual_process::VirtualProcess;

const SMALL: [u16; 2] = [80, 24];
const LARGE: [u16; 2] = [200, 60];

/// Starts `measure` on a rig with this many hits at each of the three DOFs.
fn measure(rig: &VirtualProcess, size: [u16; 2], layout: &str, more: &[&str]) -> Terminal {
    let arguments = [&["measure", layout, "--port", &rig.port], more].concat();
    Terminal::of_size(size, "xterm-256color", &arguments)
}

#[test]
fn a_campaign_from_its_first_hit_to_its_result() {
    let folder = tempfile::tempdir().unwrap();
    let rig = VirtualProcess::start(&["--fast"]);
    let layout = layout_with_hits(folder.path(), 12);
    for size in [SMALL, LARGE] {
        let mut terminal = measure(&rig, size, &layout, &[]);
        let good = |shown: &str| shown.contains("last hit") && shown.contains("good");
        assert!(terminal.until_shown(size, good), "{}", terminal.shown(size));
        // Not all of it is there from the first picture on.
        for word in
            ["measurement:", "of 36 hits", "the arrow is the force on the", "level", "? help"]
        {
            let found = terminal.until_shown(size, |shown| shown.contains(word));
            assert!(found, "{word}:\n{}", terminal.shown(size));
        }
        assert!(terminal.until_shown(size, |shown| shown.contains("largest responses")));
        let (exit, text) = terminal.end();
        assert_eq!(exit, 0, "{text}");
        // The terminal is given back, and the answer is on it.
        let (_, answer) = text.rsplit_once("\x1b[?1049l").expect("the alternate screen is left");
        assert!(answer.contains("mass"), "{answer}");
    }
}

#[test]
fn keys_change_the_page_and_pause_the_campaign() {
    let folder = tempfile::tempdir().unwrap();
    let rig = VirtualProcess::start(&[]);
    let layout = layout_with_hits(folder.path(), 20);
    let mut terminal = measure(&rig, SMALL, &layout, &[]);
    terminal.type_keys("?");
    assert!(
        terminal.until_shown(SMALL, |shown| shown.contains("The rig keeps every accepted hit"))
    );
    terminal.type_keys("?\t");
    assert!(terminal.until_shown(SMALL, |shown| shown.contains("coherence")));
    terminal.type_keys("\t");
    assert!(terminal.until_shown(SMALL, |shown| shown.contains("estimate")));
    terminal.type_keys("p");
    let (exit, text) = terminal.end();
    assert_eq!(exit, 130, "{text}");
    assert!(text.contains("the same command"), "{text}");
}

/// The rig is stopped by a signal: it neither answers nor closes its port.
#[test]
fn a_silent_rig_is_told_of_on_the_screen_and_the_campaign_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let rig = VirtualProcess::start(&[]);
    let layout = layout_with_hits(folder.path(), 20);
    let mut terminal = measure(&rig, SMALL, &layout, &[]);
    assert!(terminal.until_shown(SMALL, |shown| shown.contains("good")));
    let process = Pid::from_raw(rig.process.id() as i32);
    kill(process, Signal::SIGSTOP).unwrap();
    assert!(terminal.until_shown(SMALL, |shown| shown.contains("asking again")));
    kill(process, Signal::SIGCONT).unwrap();
    let next = |shown: &str| shown.contains("measurement: 4 of");
    assert!(terminal.until_shown(SMALL, next), "{}", terminal.shown(SMALL));
    terminal.type_keys("\x03");
    assert_eq!(terminal.end().0, 130);
}

#[test]
fn lines_are_printed_where_they_are_wanted_and_on_a_terminal_that_moves_no_cursor() {
    let folder = tempfile::tempdir().unwrap();
    let rig = VirtualProcess::start(&["--fast"]);
    let layout = layout_with_hits(folder.path(), 2);
    for (name, more) in [("xterm", &["--plain"][..]), ("dumb", &[])] {
        let arguments = [&["measure", &layout, "--port", &rig.port], more].concat();
        let (exit, text) = Terminal::of_size(SMALL, name, &arguments).end();
        assert_eq!(exit, 0, "{text}");
        assert!(!text.contains("\x1b[?1049h") && text.contains("good"), "{text}");
    }
}

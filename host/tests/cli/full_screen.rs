//! `massline measure` on a full screen.

use std::io::Write;
use std::path::Path;
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

use crate::on_terminal::{Size, Terminal};
use crate::program::{layout_with_hits, words};
use crate::recording;
use crate::virtual_process::VirtualProcess;

const SMALL: Size = [80, 24];
/// The README shows it, bytes.
const LARGEST_RECORDING: usize = 600 << 10;
const LARGE: Size = [200, 60];

/// Starts `measure` on a rig with this many hits at each of the three DOFs.
fn measure(rig: &VirtualProcess, size: Size, layout: &str, more: &[&str]) -> Terminal {
    let arguments = [&["measure", layout, "--port", &rig.port], more].concat();
    Terminal::start(size, "xterm-256color", &arguments)
}

#[test]
fn a_campaign_from_its_first_hit_to_its_result() {
    let folder = tempfile::tempdir().unwrap();
    let rig = VirtualProcess::start(&["--fast"]);
    let layout = layout_with_hits(folder.path(), 12);
    for size in [SMALL, LARGE] {
        let mut terminal = measure(&rig, size, &layout, &[]);
        let good = |shown: &str| shown.contains("last hit") && shown.contains("good");
        assert!(terminal.until_shown(good), "{}", terminal.screen_text());
        // Not all of it is there from the first picture on.
        for word in ["measurement:", "of 36 hits", "arrow: force on the body", "level", "? help"] {
            let is_shown = terminal.until_shown(|shown| shown.contains(word));
            assert!(is_shown, "{word}:\n{}", terminal.screen_text());
        }
        assert!(terminal.until_shown(|shown| shown.contains("largest responses")));
        let (exit, text) = terminal.end();
        assert_eq!(exit, 0, "{text}");
        // The terminal is given back, and the answer is on it.
        let (_, answer) = text.rsplit_once("\x1b[?1049l").expect("the alternate screen is left");
        for word in ["Good: ", " J_yz ", "principal moments: ", "next: "] {
            assert!(answer.contains(word), "{word}: {answer}");
        }
    }
}

#[test]
fn keys_change_the_page_and_pause_the_campaign() {
    let folder = tempfile::tempdir().unwrap();
    let rig = VirtualProcess::start(&[]);
    let layout = layout_with_hits(folder.path(), 20);
    let mut terminal = measure(&rig, SMALL, &layout, &[]);
    terminal.type_keys("?");
    assert!(terminal.until_shown(|shown| shown.contains("keeps the DOFs that are finished")));
    terminal.type_keys("?\t");
    assert!(terminal.until_shown(|shown| shown.contains("coherence")));
    terminal.type_keys("\t");
    assert!(terminal.until_shown(|shown| shown.contains("estimate")));
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
    assert!(terminal.until_shown(|shown| shown.contains("good")));
    let process = Pid::from_raw(rig.process.id() as i32);
    kill(process, Signal::SIGSTOP).unwrap();
    assert!(terminal.until_shown(|shown| shown.contains("asking again")));
    kill(process, Signal::SIGCONT).unwrap();
    let next = |shown: &str| shown.contains("measurement: 4 of");
    assert!(terminal.until_shown(next), "{}", terminal.screen_text());
    terminal.type_keys("\x03");
    assert_eq!(terminal.end().0, 130);
}

/// Within this time, a program that waits for a silent rig ends after Ctrl-C. By itself it would wait for 7.5 s.
const SOON: Duration = Duration::from_secs(4);

#[test]
fn a_pause_ends_the_wait_for_a_silent_rig_soon_and_says_how_to_go_on() {
    let folder = tempfile::tempdir().unwrap();
    let layout = layout_with_hits(folder.path(), 20);
    for (more, key) in [(&[][..], "\x03"), (&[], "p"), (&["--plain"], "\x03")] {
        let rig = VirtualProcess::start(&[]);
        let mut terminal = measure(&rig, SMALL, &layout, more);
        assert!(terminal.until(|text| text.contains("good")));
        kill(Pid::from_raw(rig.process.id() as i32), Signal::SIGSTOP).unwrap();
        assert!(terminal.until(|text| text.contains("asking again")));
        let began = Instant::now();
        terminal.type_keys(key);
        let (exit, text) = terminal.end();
        assert!(began.elapsed() < SOON, "{more:?} {key:?}: {:?}\n{text}", began.elapsed());
        assert_eq!(exit, 130, "{text}");
        let text = words(text.rsplit("\x1b[?1049l").next().unwrap());
        assert!(text.contains("did not answer; the rig keeps the hits"), "{text}");
        assert!(text.contains("the same command goes on"), "{text}");
    }
}

/// The first one is dealt with when the rig answers, the second at once.
#[test]
fn a_second_signal_to_end_gives_the_terminal_back() {
    let folder = tempfile::tempdir().unwrap();
    let rig = VirtualProcess::start(&[]);
    let layout = layout_with_hits(folder.path(), 20);
    let mut terminal = measure(&rig, SMALL, &layout, &[]);
    assert!(terminal.until(|text| text.contains("good")));
    kill(Pid::from_raw(rig.process.id() as i32), Signal::SIGSTOP).unwrap();
    let process = Pid::from_raw(terminal.process.id() as i32);
    for _ in 0..2 {
        kill(process, Signal::SIGTERM).unwrap();
        // Two that come together are one.
        std::thread::sleep(Duration::from_millis(200));
    }
    let (exit, text) = terminal.end();
    assert_eq!(exit, 130, "{text}");
    let (_, after) = text.rsplit_once("\x1b[?1049l").expect("the alternate screen is left");
    assert_eq!(after, "\x1b[?25h", "{text}");
}

/// The screen asks the rig to wait with every hit.
#[test]
fn a_campaign_that_is_paused_on_the_screen_goes_on_in_lines_without_asking_for_verdicts() {
    let folder = tempfile::tempdir().unwrap();
    let rig = VirtualProcess::start(&["--fast"]);
    let layout = layout_with_hits(folder.path(), 12);
    let mut terminal = measure(&rig, SMALL, &layout, &[]);
    assert!(terminal.until_shown(|shown| shown.contains("good")));
    terminal.type_keys("p");
    assert_eq!(terminal.end().0, 130);
    let (exit, text) = measure(&rig, SMALL, &layout, &["--plain"]).end();
    assert_eq!(exit, 0, "{text}");
    assert!(text.contains("resuming") && !text.contains("accept this hit?"), "{text}");
}

#[test]
fn lines_are_printed_where_they_are_wanted_and_on_a_terminal_that_moves_no_cursor() {
    let folder = tempfile::tempdir().unwrap();
    let rig = VirtualProcess::start(&["--fast"]);
    let layout = layout_with_hits(folder.path(), 2);
    for (name, more) in [("xterm", &["--plain"][..]), ("dumb", &[])] {
        let arguments = [&["measure", &layout, "--port", &rig.port], more].concat();
        let (exit, text) = Terminal::start(SMALL, name, &arguments).end();
        assert_eq!(exit, 0, "{text}");
        assert!(!text.contains("\x1b[?1049h") && text.contains("good"), "{text}");
    }
}

/// A hit is graded within this time, on a busy machine too.
const ONE_HIT: Duration = Duration::from_secs(10);

/// A manual rig with its flash in this folder, and `measure` in a terminal of this size.
struct Session {
    rig: VirtualProcess,
    terminal: Terminal,
    /// What was on the screen.
    recorded: RecordedScreens,
}

/// Screens with their times, program by program.
type RecordedScreens = Vec<Vec<(Duration, vt100::Screen)>>;

/// The layout and the archive of a session, in its folder.
const FRAME: &str = "frame.toml";
const ARCHIVE: &str = "frame.massline";

impl Session {
    /// Switches the rig on, and starts or resumes the campaign.
    fn start(folder: &Path, size: Size) -> Self {
        let [flash, layout] =
            ["flash.bin", FRAME].map(|name| folder.join(name).display().to_string());
        // With this seed, the operator of the bench hits too hard at times.
        // At an address: the path of a pty whose rig is gone would soon be that of another test's rig.
        let at = ["--tcp", "127.0.0.1:0"];
        let bench = ["--manual", "--seed", "15", "--flash", &flash, "--layout", &layout];
        let rig = VirtualProcess::on_bench("default", &[&bench[..], &at].concat());
        let arguments = ["measure", FRAME, "-o", ARCHIVE, "--port", &rig.port, "--records"];
        let terminal = Self::program(folder, size, &arguments);
        Self { rig, terminal, recorded: Vec::new() }
    }

    /// The program with these arguments, whose screens are recorded.
    fn program(folder: &Path, size: Size, arguments: &[&str]) -> Terminal {
        let mut terminal = Terminal::start_in(folder, size, "xterm-256color", arguments);
        terminal.record(&format!("massline {}", arguments.join(" ")));
        terminal
    }

    /// Waits for the end of the program: its exit code, and what is then on the screen.
    fn end(&mut self) -> (i32, String) {
        let (exit, _) = self.terminal.end();
        self.recorded.push(self.terminal.seen());
        (exit, self.terminal.screen_text())
    }

    /// Waits for this on the screen.
    #[track_caller]
    fn see(&mut self, words: &str) {
        let is_shown = self.terminal.until_shown(|shown| shown.contains(words));
        assert!(is_shown, "{words}:\n{}", self.terminal.screen_text());
    }

    /// Taps when the rig waits for it.
    fn tap(&mut self) {
        self.see(" now: hit ");
        writeln!(self.rig.process.stdin.as_mut().unwrap()).unwrap();
    }

    /// The same, and waits until the hit is counted, or rejected.
    fn tap_and_see(&mut self) {
        let before = self.terminal.screen_text();
        self.tap_for(|shown| {
            last_hit_in(shown) != last_hit_in(&before)
                && (shown.contains("rejected: ") || count_in(shown) != count_in(&before))
        });
    }

    /// Taps until it shows; a tap between two looks of the screen at the rig may come before the rig waits for it.
    fn tap_for(&mut self, shows: impl Fn(&str) -> bool) {
        for _ in 0..5 {
            self.tap();
            if self.terminal.shown_within(ONE_HIT, &shows) {
                return;
            }
        }
        panic!("five taps change nothing:\n{}", self.terminal.screen_text());
    }

    /// Taps until this is on the screen.
    fn tap_until(&mut self, words: &str) {
        loop {
            // Then the last hit is counted.
            self.see(" now: hit ");
            if self.terminal.screen_text().contains(words) {
                return;
            }
            self.tap_and_see();
        }
    }
}

/// `1:+Y: 12.3 N, 4.5 m/s²`.
fn last_hit_in(shown: &str) -> String {
    let mut parts = shown.split(['│', '\n']);
    let numbers = parts.find(|part| part.contains(" N, ") && part.contains(" m/s²"));
    numbers.unwrap_or_default().to_owned()
}

/// `measurement: 4 of 12 hits`, and what follows.
fn count_in(shown: &str) -> String {
    let line = shown.lines().next().unwrap_or_default();
    let (_, count) = line.split_once("measurement: ").unwrap_or_default();
    count.split(" hits").next().unwrap_or_default().to_owned()
}

/// From the start to the report, with all that happens at a bench; returns what was on the screen.
fn a_campaign_with_mishaps(size: Size, other: Size) -> RecordedScreens {
    let folder = tempfile::tempdir().unwrap();
    let layout = layout_with_hits(folder.path(), 3);
    let text = std::fs::read_to_string(&layout).unwrap();
    // A fourth DOF, so that there are intervals before the end.
    let hits = [r#""4:+X"]"#, r#""4:+X", "3:+Z"]"#];
    assert!(text.contains(hits[0]));
    std::fs::write(folder.path().join(FRAME), text.replace(hits[0], hits[1])).unwrap();
    let mut session = Session::start(folder.path(), size);
    session.tap_and_see();
    session.see("good");
    session.terminal.resize(other);
    session.see("measurement: 1 of 12 hits");
    session.terminal.resize(size);
    // A hit can be undone while the rig waits for the next one.
    session.tap_until("2 of 12 hits");
    session.terminal.type_keys("u");
    session.see("undone");
    session.see("1 of 12 hits");
    session.tap_until("rejected: ");
    // A bad hit is drawn as well.
    let is_drawn = |shown: &str| shown.contains("force, N") && !shown.contains("that was read");
    assert!(session.terminal.until_shown(is_drawn), "{}", session.terminal.screen_text());
    session.tap_until("4 of 12 hits");
    session.terminal.type_keys("\t");
    session.see("1 hit: log");
    session.tap_until("5 of 12 hits");
    session.see("coherence over Hz");
    session.rig.process.kill().unwrap();
    let (exit, output) = session.end();
    assert_eq!(exit, 4, "{output}");
    assert!(output.contains("the same command"), "{output}");
    let mut recorded = session.recorded;
    drop(session.rig);

    // A rig without power keeps the DOFs that were finished.
    let mut session = Session::start(folder.path(), size);
    session.see("3 of 12 hits");
    session.tap_until("8 of 12 hits");
    session.terminal.type_keys("\t\t");
    session.tap_until("95 % intervals, 3 of 4 DOFs");
    session.see("mass");
    session.tap_until("11 of 12 hits");
    session.tap_for(|shown| shown.contains("archive written"));
    let (exit, output) = session.end();
    assert_eq!(exit, 0, "{output}");
    assert!(output.contains("archive written to frame.massline"), "{output}");
    session.terminal = Session::program(folder.path(), size, &["report", ARCHIVE]);
    let (exit, output) = session.end();
    assert_eq!(exit, 0, "{output}");
    let report = std::fs::read_to_string(folder.path().join("frame.html")).unwrap();
    for verdict in ["undone", "rejected", "accepted"] {
        assert!(report.contains(verdict), "{verdict}");
    }
    recorded.extend(session.recorded);
    recorded
}

#[test]
fn a_small_screen_sees_a_campaign_with_mishaps_to_its_report() {
    let recorded = a_campaign_with_mishaps(SMALL, LARGE);
    // The recording of the README, which no two runs make alike: MASSLINE_RECORD=1 writes it.
    let svg = recording::svg(&recorded, SMALL);
    assert!(svg.len() < LARGEST_RECORDING, "{} bytes", svg.len());
    if std::env::var_os("MASSLINE_RECORD").is_some() {
        std::fs::write("pictures/measure.svg", svg).unwrap();
    }
}

#[test]
fn a_large_screen_sees_a_campaign_with_mishaps_to_its_report() {
    a_campaign_with_mishaps(LARGE, SMALL);
}

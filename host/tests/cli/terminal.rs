//! What the program writes on a terminal: widths, colours, the progress bar.

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

use crate::on_terminal::Terminal;
use crate::program::{LAYOUT, layout_with_hits, run, words};
use crate::virtual_process::VirtualProcess;

/// The program on a terminal with this number of columns.
fn start(columns: u16, name: &str, arguments: &[&str]) -> Terminal {
    Terminal::start([columns, 50], name, arguments)
}

/// The text without sequences for the terminal.
fn plain(text: &str) -> String {
    let mut plain = String::new();
    let mut characters = text.chars();
    while let Some(c) = characters.next() {
        if c == '\x1b' && characters.next() == Some('[') {
            characters.by_ref().find(|c| ('@'..='~').contains(c));
        } else if c != '\x1b' {
            plain.push(c);
        }
    }
    plain
}

fn example(name: &str) -> String {
    format!("../tests/data/uff/{name}")
}

#[test]
fn every_text_fits_terminals_of_forty_eighty_and_two_hundred_columns() {
    let (layout, uff) = (example("a_irm_01.toml"), example("a_irm_01.ascii.uff"));
    let commands: [&[&str]; 7] = [
        &["--help"],
        &["measure", "--help"],
        &["simulate", "--help"],
        &["demo"],
        &["solve", &layout, &uff],
        &["layout", "check", LAYOUT],
        &["layout", "suggest", LAYOUT, "--starts", "1"],
    ];
    for arguments in commands {
        for columns in [40, 80, 200] {
            let (exit, text) = start(columns, "xterm", arguments).end();
            assert_eq!(exit, 0, "{arguments:?}: {text}");
            let text = plain(&text);
            // The bar, whose line is overwritten, leaves its last state before a carriage return.
            let lines = text.lines().map(|line| line.trim_end().rsplit('\r').next().unwrap());
            for line in lines {
                let wide = textwrap::core::display_width(line);
                // One word that is too long stays whole, and so does a command; clap breaks no line of usage.
                let words = line.trim();
                let is_command = words.starts_with('`') && words.ends_with('`');
                let is_whole = !words.contains(' ') || is_command || line.starts_with("Usage: ");
                assert!(
                    wide <= usize::from(columns) || is_whole,
                    "{arguments:?}, {columns}: {line}"
                );
            }
        }
    }
}

#[test]
fn narrow_terminals_break_no_word_of_a_help_text() {
    for command in [&["--help"][..], &["virtual", "--help"], &["layout", "check", "--help"]] {
        let help_words = |columns| words(&plain(&start(columns, "xterm", command).end().1));
        let wide = help_words(200);
        assert_eq!(help_words(40), wide, "{command:?}");
        assert_eq!(help_words(80), wide, "{command:?}");
    }
}

#[test]
fn help_and_errors_have_colours_where_they_are_wanted() {
    let coloured =
        |name: &str, arguments: &[&str]| start(80, name, arguments).end().1.contains("\x1b[");
    for arguments in [&["--help"][..], &["no-such-command"], &["layout", "check", "missing.toml"]] {
        assert!(coloured("xterm", arguments), "{arguments:?}");
        assert!(!coloured("dumb", arguments), "{arguments:?}");
        assert!(!coloured("xterm", &[arguments, &["--color", "never"]].concat()), "{arguments:?}");
        let piped = |color| run(&[arguments, &["--color", color]].concat());
        let escapes = |color| {
            let run = piped(color);
            (run.stdout + &run.stderr).contains("\x1b[")
        };
        assert!(escapes("always") && !escapes("auto"), "{arguments:?}");
    }
}

#[test]
fn a_verdict_has_the_colour_of_what_it_says() {
    let archive = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/data/archive/version-1.massline");
    let text_in = |color| run(&["solve", archive, "--details", "--color", color]).stdout;
    assert!(text_in("always").contains("\x1b[32mthe methods agree"), "{}", text_in("always"));
    let plain_text = text_in("never");
    assert!(plain_text.contains("the methods agree") && !plain_text.contains('\x1b'));
    assert_eq!(text_in("auto"), plain_text);
}

#[test]
fn control_characters_of_arguments_do_not_reach_the_terminal() {
    for strange in ["\x1b[2Jx", "\x1b]0;title\x07", "\u{9b}2J"] {
        for arguments in [
            &["layout", strange][..],
            &["layout", "check", strange],
            &["simulate", LAYOUT, "--seed", strange],
            &["demo", "--bench", strange],
        ] {
            let (exit, text) = start(80, "dumb", arguments).end();
            assert_eq!(exit, 2, "{arguments:?}: {text}");
            let control = |c: char| c.is_control() && !matches!(c, '\n' | '\r');
            assert!(!text.contains(control), "{arguments:?}: {text:?}");
        }
    }
}

#[test]
fn u_takes_back_the_last_hit_and_the_archive_has_only_the_others() {
    let folder = tempfile::tempdir().unwrap();
    let rig = VirtualProcess::start(&[]);
    let layout = layout_with_hits(folder.path(), 2);
    let archive = folder.path().join("a.massline").display().to_string();
    let arguments =
        ["measure", &layout, "--plain", "--port", &rig.port, "-o", &archive, "--records"];
    let mut measure = start(200, "xterm", &arguments);
    // The operator of the bench hits soon after each prompt, perhaps before the key arrives.
    let prompts = |text: &str| text.matches(" now (").count();
    let undone = |text: &str| plain(text).contains("m/s²  undone");
    while !undone(&measure.text) {
        let before = prompts(&measure.text);
        let ready = |text: &str| prompts(text) > before || undone(text);
        assert!(measure.until(ready), "{}", measure.text);
        measure.type_keys("u");
    }
    let (exit, text) = measure.end();
    let text = plain(&text);
    assert_eq!(exit, 0, "{text}");
    let line = text.lines().find(|line| line.ends_with("m/s²  undone")).unwrap();
    assert!(line.contains("hit ") && line.contains(":+") && line.contains(" N "), "{line}");
    assert!(!text.contains("another number of hit records"), "{text}");
    assert!(!text.contains("no frequency responses"), "{text}");
}

/// The rig is stopped by a signal: it neither answers nor closes its port.
#[test]
fn a_silent_rig_is_told_of_above_the_progress_bar() {
    let folder = tempfile::tempdir().unwrap();
    let rig = VirtualProcess::start(&[]);
    let layout = layout_with_hits(folder.path(), 20);
    let mut measure = start(80, "xterm", &["measure", &layout, "--plain", "--port", &rig.port]);
    assert!(measure.until(|text| text.contains("good")), "{}", measure.text);
    let process = Pid::from_raw(rig.process.id() as i32);
    kill(process, Signal::SIGSTOP).unwrap();
    assert!(measure.until(|text| text.contains("asking again")), "{}", measure.text);
    kill(process, Signal::SIGCONT).unwrap();
    let text = plain(&measure.text);
    let (before, _) = text.rsplit_once("no answer from").unwrap();
    assert!(before.ends_with(['\r', '\n']), "the bar is in the same line: {before}");
    let hits = measure.text.matches("good").count();
    assert!(measure.until(|text| text.matches("good").count() > hits), "{}", measure.text);
    // Ctrl-C of a terminal in raw mode.
    measure.type_keys("\x03");
    let (exit, text) = measure.end();
    assert_eq!(exit, 130, "{text}");
}

/// Lines of an answer on a terminal of 80 columns, from the verdict to the end, without those of the measurement. Wider
/// terminals wrap less.
#[track_caller]
fn lines_of_answer(exit: i32, arguments: &[&str]) -> usize {
    let (actual, text) = start(80, "dumb", arguments).end();
    assert_eq!(actual, exit, "{arguments:?}: {text}");
    let text = plain(&text);
    let verdicts = ["Good: ", "Use with care", "Do not use", "test 1: "];
    let is_verdict = |line: &&str| verdicts.iter().any(|verdict| line.starts_with(verdict));
    let lines: Vec<&str> = text.lines().map(|line| line.trim_end_matches('\r')).collect();
    let first = lines.iter().position(is_verdict).unwrap_or_else(|| panic!("{text}"));
    println!("{arguments:?}: {} lines", lines.len() - first);
    lines.len() - first
}

#[test]
fn an_answer_takes_at_most_forty_lines_and_twelve_more_with_corrected_values() {
    let [wheel, contradicted] =
        ["wheel.toml", "three-bar-test-1.toml"].map(|name| format!("examples/{name}"));
    let archive = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/data/archive/version-1.massline");
    let folder = tempfile::tempdir().unwrap();
    let layout = layout_with_hits(folder.path(), 3);
    let tape = folder.path().join("all.npy").display().to_string();
    let rig = VirtualProcess::start(&[]);
    let mut commands: Vec<(usize, i32, Vec<&str>)> = vec![
        (40, 0, vec!["solve", archive]),
        (40, 0, vec!["demo"]),
        (40, 0, vec!["demo", "wheel"]),
        (40, 0, vec!["demo", "wheel", "--tyre"]),
        (40, 0, vec!["measure", &layout, "--port", &rig.port]),
        (40, 0, vec!["results", "get", "1", "--port", &rig.port]),
        (40, 0, vec!["simulate", &layout, "--tape", &tape]),
        (40, 0, vec!["replay", &tape, "--layout", &layout]),
        (40, 0, vec!["simulate", &wheel, "--bench", "wheel"]),
        (52, 3, vec!["simulate", &contradicted, "--bench", "default", "--fault", "flip:2y"]),
        // Two mistakes that the data cannot tell apart.
        (52, 3, vec!["simulate", &contradicted, "--bench", "default", "--fault", "hit:1:4"]),
    ];
    let tests = ["1", "2", "3", "4"].map(|number| format!("examples/three-bar-test-{number}.toml"));
    commands.extend(tests.iter().map(|test| (40, 0, vec!["simulate", test])));
    for (most, exit, arguments) in &commands {
        let lines = lines_of_answer(*exit, arguments);
        assert!(lines <= *most, "{arguments:?}: {lines} lines");
    }
}

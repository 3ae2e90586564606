//! What is said about a test of the suspension profile: which answer to use, what puts it in doubt, and with what it
//! was measured.

use std::fs;
use std::path::Path;

use crate::program::{run, success, words};

/// The layout of the wheel.
const WHEEL: &str = "examples/wheel.toml";
/// Its bench.
const ON_BENCH: [&str; 2] = ["--bench", "wheel"];

/// The words of a report without its markup.
fn words_of(page: &str) -> String {
    let text = fs::read_to_string(page).unwrap();
    let text = text.split('<').filter_map(|part| Some(part.split_once('>')?.1)).collect::<Vec<_>>();
    words(&text.join(" ").replace('\u{a0}', " ").replace('−', "-"))
}

/// What stands between two headings of a report.
#[track_caller]
fn between<'a>(words: &'a str, from: &str, to: &str) -> &'a str {
    let (_, after) = words.split_once(from).unwrap_or_else(|| panic!("{from}: {words:.2000}"));
    after.split_once(to).unwrap_or_else(|| panic!("{to}: {after:.2000}")).0
}

#[test]
fn the_global_fit_stands_first_everywhere_and_no_other_method_puts_it_in_doubt() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("wheel.html").display().to_string();
    let shown =
        run(&[&["simulate", WHEEL][..], &ON_BENCH, &["--report", &page, "--details"]].concat());
    assert_eq!(shown.exit, 0, "{}", shown.stderr);
    let again = run(&["solve", &page, "--details"]);
    for text in [&shown.stdout, &again.stdout] {
        let text = words(text);
        let title = between(&text, "nothing puts this answer in doubt", "value");
        assert!(title.contains(": global-fit, 5 DOFs, 25 hits"), "{title}");
        // 2 % of the mass against some 2.1 % of it in all.
        assert!(
            text.contains("the hammer's gain, uncertain by 2.0 % (1 sd), accounts for"),
            "{text}"
        );
        assert!(text.contains("`massline calibrate block`"), "{text}");
        assert_eq!(text.matches("modal-constant: not applicable").count(), 1, "{text}");
    }
    let report = words_of(&page);
    assert!(report.contains("Good: nothing puts this answer in doubt"), "{report:.3000}");
    // The reason is that of the host, as in the text.
    let without = between(&report, "Methods without an answer", "Sensors and hits");
    let reason = between(without, "its standard deviation is", "of its scale");
    assert!(words(&again.stdout).contains(reason), "{reason}");

    let measured = between(&report, "record of a hit", "Calibration");
    assert!(measured.contains("41.0 s, 1.6 s of it before the hit"), "{measured}");
    let budget = between(&report, "Error budget of the answer", "Files and versions");
    for phrase in [
        "gain of the hammer from mark to mark: its linearity 0.50 %",
        "gain of a nonlinear converter for small responses 0.50 %",
        "direction of gravity about each axis across it 20 mrad",
        "budget used as stated",
    ] {
        assert!(budget.contains(phrase), "{phrase}: {budget}");
    }
    let unseen = between(&report, "This test cannot see", "Do the methods agree?");
    assert!(unseen.contains("the budget has 0.50 % (1 sd, converter_gain)"), "{unseen}");
    // The scale of the errors is the reference's, as in the text.
    assert!(report.contains("with m the expected mass and L ="), "{report:.6000}");
    let row = |text: &str| text.lines().find(|line| line.contains(" J_xx ")).unwrap().to_owned();
    let error = row(&shown.stdout).split_whitespace().last().unwrap().parse::<f64>().unwrap();
    let of_report = between(&report, "moment of inertia about x", "moment of inertia about y");
    assert!(of_report.contains(&format!(" {error:+.2} ")), "{error}: {of_report}");
}

#[test]
fn without_gravity_it_warns_before_the_first_hit_and_says_what_is_missing_in_place_of_an_answer() {
    let folder = tempfile::tempdir().unwrap();
    let layout = folder.path().join("no-gravity.toml").display().to_string();
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(WHEEL)).unwrap();
    fs::write(&layout, text.replacen("gravity = [0.0, 0.0, -9.80665]\n", "", 1)).unwrap();
    let shown = run(&[&["simulate", &layout][..], &ON_BENCH].concat());
    assert_eq!((shown.exit, shown.stdout.as_str()), (3, ""), "{}", shown.stderr);
    let (before, after) = shown.stderr.split_once("hit   1").expect("hits are shown");
    let needed = "the suspension profile needs the direction";
    assert!(words(before).contains(needed), "{}", shown.stderr);
    assert!(words(after).contains("error: the responses fit with gravity along -Z"), "{after}");
}

#[test]
fn a_flexible_mode_is_a_note_where_the_answer_is_that_of_the_global_fit() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("tyre.html").display().to_string();
    success(&["demo", "wheel", "--tyre", "--rig", "virtual", "--report", &page]);
    let report = words_of(&page);
    assert!(report.contains("Method: global-fit"), "{report:.3000}");
    assert!(!report.contains("The answer is in doubt"), "{report:.3000}");
    let verdict = between(&report, "massline report", "The ten properties");
    assert!(verdict.contains("Good: "), "{verdict}");
    assert_eq!(report.matches("rely on it").count(), 1, "{report:.3000}");
}

#[test]
fn a_layout_of_the_wheel_on_the_bench_of_another_object_is_told_its_bench() {
    for more in [&["--bench", "default"][..], &["--bench", "default", "--runs", "2"]] {
        let wrong = run(&[&["simulate", WHEEL][..], more].concat());
        assert_eq!(wrong.exit, 2);
        let benches =
            "give --bench wheel or --bench wheel-with-tyre or --bench FILE with a bench file";
        assert!(wrong.says(benches), "{}", wrong.stderr);
    }
}

#[test]
fn a_study_says_whose_errors_it_has_and_whether_its_hammer_is_calibrated() {
    let study = |more: &[&str]| {
        let layout = "examples/three-bar-test-1.toml";
        let value = success(&[&["simulate", layout, "--runs", "1"], more].concat());
        (value["errors"].clone(), value["calibrated_hammer"].clone())
    };
    assert_eq!(study(&[]), ("bench".into(), false.into()));
    let both = ["--errors", "layout", "--calibrated-hammer"];
    assert_eq!(study(&both), ("layout".into(), true.into()));
}

//! `massline plot`: the committed pictures of a committed archive and of the wheel's modes, and what cannot be drawn.

use std::fs;
use std::path::Path;

use serde_json::json;

use crate::edited_results::edited;
use crate::program::{data, run, success, text};

/// Compares pictures with those of `tests/data/pictures`, byte by byte: what is drawn is rounded to pixels.
/// `MASSLINE_BLESS=1` writes them.
fn compare(folder: &Path, names: &[&str]) {
    let committed = data("pictures");
    let mut drawn: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.ends_with(".svg"))
        .collect();
    drawn.sort();
    assert_eq!(drawn, names);
    for name in names {
        let picture = fs::read(folder.join(name)).unwrap();
        if std::env::var_os("MASSLINE_BLESS").is_some() {
            fs::create_dir_all(&committed).unwrap();
            fs::write(committed.join(name), &picture).unwrap();
        }
        let expected = fs::read(committed.join(name)).expect("a committed picture");
        assert!(picture == expected, "{name} differs from the committed one; look at both");
    }
}

#[test]
fn an_archive_has_pictures_of_answers_layout_and_responses() {
    let folder = tempfile::tempdir().unwrap();
    let archive = text(&data("archive/version-1.massline"));
    let pictures = text(folder.path());
    let printed = success(&["plot", &archive, "-o", &pictures]);
    assert_eq!(printed["written"].as_array().unwrap().len(), 8);
    compare(
        folder.path(),
        &[
            "version-1-budget.svg",
            "version-1-driving-points.svg",
            "version-1-estimates.svg",
            "version-1-frf-1+Y.svg",
            "version-1-frf-2+Z.svg",
            "version-1-frf-4+X.svg",
            "version-1-layout.svg",
            "version-1-pulls.svg",
        ],
    );
    // Nothing is replaced unless that is asked for.
    let again = run(&["plot", &archive, "-o", &pictures]);
    assert!(again.exit == 2 && again.says("--force"), "{}", again.stderr);
    success(&["plot", &archive, "-o", &pictures, "--force"]);
    let png = folder.path().join("one.png");
    success(&["plot", &archive, "--picture", "layout", "-o", &text(&png)]);
    assert!(fs::read(&png).unwrap().starts_with(b"\x89PNG"));
}

/// The text of one picture of these results.
fn drawn(folder: &Path, results: &[&str], picture: &str) -> String {
    let svg = text(&folder.join("one.svg"));
    let mut arguments = vec!["plot"];
    arguments.extend(results);
    arguments.extend(["--picture", picture, "-o", &svg, "--force"]);
    success(&arguments);
    fs::read_to_string(&svg).unwrap()
}

#[test]
fn answers_are_drawn_with_their_combination_and_with_what_their_intervals_cover() {
    let folder = tempfile::tempdir().unwrap();
    let archive = text(&data("archive/version-1.massline"));
    let svg = drawn(folder.path(), &[&archive], "estimates");
    for words in ["combined", "inertia-restraint (no interval: scatter between hits only)"] {
        assert!(svg.contains(words), "{words}");
    }
    // Of several results the best answers are shown, which no interval of another kind is among.
    let svg = drawn(folder.path(), &[&archive, &archive, &archive], "estimates");
    assert!(svg.contains("3 results: the ten properties"), "{svg:.400}");
    assert!(!svg.contains("combined") && !svg.contains("scatter"), "{svg:.400}");
}

/// A rig has room for the beginning of a title only.
#[test]
fn a_long_title_is_that_of_the_layout_and_ends_with_an_ellipsis() {
    let folder = tempfile::tempdir().unwrap();
    let whole = "Gestell mit drei Stäben, zwölf Stöße je Punkt, zweiter Tag";
    let archive = edited(folder.path(), "long", &|archive| {
        let toml = archive["layout"]["toml"].as_str().unwrap().to_owned();
        let first = toml.lines().find(|line| line.starts_with("title")).unwrap().to_owned();
        archive["layout"]["toml"] = toml.replace(&first, &format!("title = {whole:?}")).into();
        archive["result"]["head"]["title"] = "Gestell mit drei Stäben, zwölf Stöße je Pu".into();
    });
    let svg = drawn(folder.path(), &[&archive], "layout");
    assert!(
        svg.contains("Gestell mit drei Stäben, zwölf Stöße je…: the test in space"),
        "{svg:.900}"
    );
}

#[test]
fn suspension_modes_have_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let uff = text(&folder.path().join("wheel.uff"));
    let layout =
        success(&["demo", "wheel", "--write", &uff])["layout"].as_str().unwrap().to_owned();
    let modes = folder.path().join("modes.json");
    fs::write(&modes, success(&["modes", &layout, &uff]).to_string()).unwrap();
    let pictures = folder.path().join("pictures");
    success(&["plot", &text(&modes), "-o", &text(&pictures)]);
    compare(&pictures, &["modes-mac.svg", "modes-norm-indicator.svg", "modes-stabilisation.svg"]);
}

#[test]
fn what_cannot_be_drawn_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let archive = text(&data("archive/version-1.massline"));
    for (arguments, exit, phrase) in [
        (vec!["plot", "nothing.json"], 2, "cannot be read"),
        (vec!["plot", &archive, "--picture", "mac"], 3, "suspension modes"),
        (vec!["plot", &archive, "-o", "all.svg"], 2, "--picture"),
        (vec!["plot", &archive, "--picture", "frf", "-o", "frf.svg"], 2, "each of 3 hit DOFs"),
        (vec!["plot", &archive, "--picture", "hits"], 3, "--records"),
        (vec!["plot", &archive, "--picture", "taps"], 2, "stabilisation"),
        (vec!["plot", &archive, "-o", "x.gif"], 2, "a .svg or a .png file, not .gif"),
        (vec!["plot", &archive, "-o", "-"], 2, "the name of a file or of a folder"),
    ] {
        let refused = run(&arguments);
        assert_eq!(refused.exit, exit, "{arguments:?}: {}", refused.stderr);
        assert!(refused.says(phrase), "{arguments:?}: {}", refused.stderr);
    }
    // An answer alone does not say where the sensors are.
    let solved = folder.path().join("solved.json");
    fs::write(&solved, success(&["solve", &archive]).to_string()).unwrap();
    let [solved, to] = [solved.as_path(), folder.path()].map(text);
    let layout = run(&["plot", &solved, "--picture", "layout", "-o", &to]);
    assert!(layout.exit == 3 && layout.says("--layout"), "{}", layout.stderr);
    // Its properties and pulls do not need it.
    let others = success(&["plot", &solved, "-o", &to])["written"].to_string();
    for picture in ["solved-estimates.svg", "solved-pulls.svg"] {
        assert!(others.contains(picture), "{others}");
    }
}

#[test]
fn a_title_is_text_whatever_is_in_it() {
    let folder = tempfile::tempdir().unwrap();
    let layout = folder.path().join("layout.toml");
    let example = fs::read_to_string(data("../../host/examples/three-bar-test-1.toml")).unwrap();
    let first = example.lines().find(|line| line.starts_with("title")).unwrap().to_owned();
    let title = "<script>alert(1)</script> & \u{202e}kg";
    let file = example.replace(&first, &format!("title = {}", json!(title)));
    fs::write(&layout, file).unwrap();
    let archive = text(&data("archive/version-1.massline"));
    let solved = folder.path().join("solved.json");
    let mut document = success(&["solve", &archive]);
    document["title"] = json!(title);
    fs::write(&solved, document.to_string()).unwrap();
    let svg = folder.path().join("one.svg");
    let [solved, layout] = [&solved, &layout].map(|path| text(path));
    let one = ["plot", &solved, "--layout", &layout, "--picture", "layout", "-o", &text(&svg)];
    success(&one);
    let drawn = fs::read_to_string(&svg).unwrap();
    assert!(drawn.contains("&lt;script&gt;") && !drawn.contains("<script"), "{drawn}");
    assert!(!drawn.contains('\u{202e}'), "the direction of text is not changed");
}

#[test]
fn an_archive_with_records_has_a_picture_of_the_hits_of_a_dof() {
    let folder = tempfile::tempdir().unwrap();
    let archive = text(&data("pictures/records.massline"));
    let drawn = text(folder.path());
    success(&["plot", &archive, "--picture", "hits", "-o", &drawn]);
    compare(folder.path(), &["records-hits-1+Y.svg"]);
    let svg = fs::read_to_string(folder.path().join("records-hits-1+Y.svg")).unwrap();
    for words in ["hit 1", "hit 3", "force, N", "sensor at node 3", "time after the trigger, ms"] {
        assert!(svg.contains(words), "{words}");
    }
    // Without the calibration, codes have no unit.
    let silent = edited(folder.path(), "silent", &|archive| archive["calibration"] = json!(null));
    assert_eq!(run(&["plot", &silent, "--picture", "hits"]).exit, 3);
}

#[test]
fn responses_that_a_result_was_solved_from_are_drawn_with_their_coherence() {
    let folder = tempfile::tempdir().unwrap();
    let uff = text(&folder.path().join("wheel.uff"));
    let layout =
        success(&["demo", "wheel", "--write", &uff])["layout"].as_str().unwrap().to_owned();
    let solved = folder.path().join("wheel.json");
    fs::write(&solved, success(&["solve", &layout, &uff]).to_string()).unwrap();
    let (solved, to) = (text(&solved), text(&folder.path().join("pictures/")));
    let plot = ["plot", &solved, "--layout", &layout, "--responses", &uff, "-o", &to];
    let written = success(&plot)["written"].to_string();
    for picture in ["frf-101+X", "frf-105+X", "driving-points", "mac", "estimates", "layout"] {
        assert!(written.contains(&format!("wheel-{picture}.svg")), "{picture}: {written}");
    }
    let frf = fs::read_to_string(folder.path().join("pictures/wheel-frf-101+X.svg")).unwrap();
    assert!(frf.contains("phase, °") && !frf.contains("coherence"), "{frf:.900}");
    // What was understood of the file is said by every command that reads it.
    let page = text(&folder.path().join("wheel.html"));
    let report = ["report", &solved, "--layout", &layout, "--responses", &uff, "-o", &page];
    for arguments in [&[&plot[..], &["--force"]].concat(), &report[..], &["modes", &layout, &uff]] {
        let shown = run(arguments);
        assert!(
            shown.exit == 0 && shown.says("frequency responses: accelerance in"),
            "{}",
            shown.stderr
        );
    }
    // Beside each response its coherence, as analysers write it.
    let functions = fs::read(&uff).unwrap();
    let coherence = coherence_of(&functions);
    fs::write(&uff, [functions, coherence].concat()).unwrap();
    success(&[&plot[..], &["--force"]].concat());
    let frf = fs::read_to_string(folder.path().join("pictures/wheel-frf-101+X.svg")).unwrap();
    assert!(frf.contains("coherence"), "{frf:.900}");
    let archive = text(&data("archive/version-1.massline"));
    let refused = run(&["plot", &archive, "--layout", &layout, "--responses", &uff]);
    assert!(
        refused.exit == 2 && refused.says("an archive has the layout of its test"),
        "{}",
        refused.stderr
    );
}

/// The functions of a binary universal file again, as coherences.
fn coherence_of(functions: &[u8]) -> Vec<u8> {
    // The tenth line of a function begins with its type.
    let (from, to) = (b"\n    4 ", b"\n    6 ");
    let mut coherence = functions.to_vec();
    let mut place = 0;
    while let Some(offset) =
        coherence[place..].windows(from.len()).position(|window| window == from)
    {
        place += offset;
        coherence[place..place + to.len()].copy_from_slice(to);
    }
    assert!(place > 0, "the file has frequency responses");
    coherence
}

#[test]
fn results_of_one_name_are_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    let mut results = Vec::new();
    for name in ["s1", "s2"] {
        fs::create_dir(folder.path().join(name)).unwrap();
        let path = folder.path().join(name).join("a.massline");
        fs::copy(data("archive/version-1.massline"), &path).unwrap();
        results.push(text(&path));
    }
    let results: Vec<&str> = results.iter().map(String::as_str).collect();
    let svg = drawn(folder.path(), &results, "estimates");
    for number in 1..=2 {
        assert!(svg.contains(&format!("(a.massline, number {number})")), "{svg:.2000}");
    }
}

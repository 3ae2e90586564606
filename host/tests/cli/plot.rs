//! `massline plot`: the committed pictures of a committed archive and of the wheel's modes, and what cannot be drawn.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::json;

use crate::program::{run, success};

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data").join(name)
}

fn text(path: &Path) -> String {
    path.display().to_string()
}

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
        let found = fs::read(folder.join(name)).unwrap();
        if std::env::var_os("MASSLINE_BLESS").is_some() {
            fs::create_dir_all(&committed).unwrap();
            fs::write(committed.join(name), &found).unwrap();
        }
        let expected = fs::read(committed.join(name)).expect("a committed picture");
        assert!(found == expected, "{name} differs from the committed one; look at both");
    }
}

#[test]
fn an_archive_has_pictures_of_answers_layout_and_responses() {
    let folder = tempfile::tempdir().unwrap();
    let archive = text(&data("archive/version-1.massline"));
    let pictures = text(folder.path());
    let printed = success(&["plot", &archive, "-o", &pictures]);
    assert_eq!(printed["written"].as_array().unwrap().len(), 5);
    compare(
        folder.path(),
        &[
            "version-1-estimates.svg",
            "version-1-frf-1+Y.svg",
            "version-1-frf-2+Z.svg",
            "version-1-frf-4+X.svg",
            "version-1-layout.svg",
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
    for (arguments, exit, said) in [
        (vec!["plot", "nothing.json"], 2, "cannot be read"),
        (vec!["plot", &archive, "--picture", "mac"], 3, "suspension modes"),
        (vec!["plot", &archive, "-o", "all.svg"], 2, "--picture"),
        (vec!["plot", &archive, "--picture", "frf", "-o", "frf.svg"], 2, "each of 3 hit DOFs"),
        (vec!["plot", &archive, "--picture", "hits"], 2, "stabilisation"),
    ] {
        let found = run(&arguments);
        assert_eq!(found.exit, exit, "{arguments:?}: {}", found.stderr);
        assert!(found.says(said), "{arguments:?}: {}", found.stderr);
    }
    // An answer alone does not say where the sensors are.
    let solved = folder.path().join("solved.json");
    fs::write(&solved, success(&["solve", &archive]).to_string()).unwrap();
    let alone = run(&["plot", &text(&solved), "-o", &text(folder.path())]);
    assert!(alone.exit == 2 && alone.says("--layout"), "{}", alone.stderr);
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

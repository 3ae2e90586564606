//! Files whose numbers were edited: they are drawn or refused, whatever stands there.

use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use massline_result::{Document, TestResult};
use serde_json::{Value, json};

use super::of_archive;
use massline_files::archive::Archive;
use massline_report::page::html;
use massline_report::picture::{ImageFormat, Picture};
use massline_report::result_file::ResultFile;
use massline_result::{Error, Result};

/// Longer than any picture takes, also on a busy computer.
const LATE: Duration = Duration::from_secs(120);
/// Only the first element of a list is edited; the others are like it.
const EDITED: usize = 1;

/// Edits every number of a document, each to one of what no test gives, and draws; the choice differs from number to
/// number.
fn edit_every_number(document: Value, draw: fn(Value) -> Result<()>) {
    let wrong = [json!(0), json!(-1), json!(1e300), json!(-1e300), Value::Null];
    let mut places = Vec::new();
    numbers(&document, String::new(), &mut places);
    assert!(places.len() >= 10, "{} numbers", places.len());
    let (sender, receiver) = mpsc::channel();
    thread::spawn(move || {
        for (place, wrong) in places.iter().zip(wrong.iter().cycle()) {
            let mut edited = document.clone();
            *edited.pointer_mut(place).expect("a number") = wrong.clone();
            let edit = format!("{place} = {wrong}");
            let _ = sender.send(edit);
            // That it is refused is as good.
            let _ = draw(edited);
        }
        let _ = sender.send(String::new());
    });
    let mut last = String::new();
    loop {
        match receiver.recv_timeout(LATE) {
            Ok(edit) if edit.is_empty() => return,
            Ok(edit) => last = edit,
            Err(why) => panic!("{last}: {why}"),
        }
    }
}

/// The places of all numbers in a document.
fn numbers(value: &Value, place: String, places: &mut Vec<String>) {
    match value {
        Value::Number(_) => places.push(place),
        Value::Array(list) => list
            .iter()
            .enumerate()
            .take(EDITED)
            .for_each(|(k, value)| numbers(value, format!("{place}/{k}"), places)),
        // Kept as it is and not read.
        Value::Object(map) => map
            .iter()
            .filter(|(key, _)| *key != "answers")
            .for_each(|(key, value)| numbers(value, format!("{place}/{key}"), places)),
        _ => {}
    }
}

fn draw_all(source: ResultFile) -> Result<()> {
    let sources = [source];
    for picture in Picture::all() {
        // The others may be drawn.
        let _ = picture.of(&sources, ImageFormat::Svg);
    }
    html(&sources).map(|_| ())
}

#[test]
fn every_number_of_an_archive_may_be_wrong() {
    let text = include_str!("../../../../tests/data/pictures/records.massline");
    edit_every_number(serde_json::from_str(text).unwrap(), |document| {
        let archive = Archive::parse(document.to_string().as_bytes(), "edited")?;
        draw_all(of_archive(archive, "edited".into())?)
    });
}

#[test]
fn every_number_of_suspension_modes_may_be_wrong() {
    let mode = json!({
        "frequency_hz": { "value": 3.0, "sigma": 0.1 }, "damping_ratio": { "value": 0.01, "sigma": 0.001 },
        "shape": { "value": [1.0, 0.0, 0.0, 0.0, 0.0, 0.0], "sigma": [0.1, 0.1, 0.1, 0.1, 0.1, 0.1] },
        "complexity": 0.01, "norm_indicators": [{ "dof": "1:+Y", "value": 0.5 }], "better_hit": null,
    });
    let pole = json!({ "frequency_hz": 3.0, "damping_ratio": 0.01, "stable": true });
    let modes = json!({
        "schema_version": 1, "band_hz": [0.5, 12.5], "modes": [mode, mode],
        "modal_assurance": [[1.0, 0.1], [0.1, 1.0]],
        "modes_missing": 4, "hit_for_missing": "2:+Z",
        "orders": [{ "used": true, "poles": [pole, pole] }], "noise_m_per_s2_per_n": 0.001,
    });
    let draw = |document: Value| {
        let Ok((Document::Modes(modes), _)) =
            massline_result::read(document.to_string().as_bytes())
        else {
            return Err(Error::input("refused", "it cannot be read"));
        };
        let result = TestResult { suspension: Some(*modes), ..TestResult::default() };
        draw_all(ResultFile::of_result(result, None, "edited".into())?)
    };
    assert!(draw(modes.clone()).is_ok(), "{:?}", draw(modes.clone()).err());
    edit_every_number(modes, draw);
}

//! What `massline report` says of results that were edited: of their calibration, hits, noise, methods and sensors.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::program::{LAYOUT, layout_with_hits, run, success};
use crate::report::{archive, editable_archive, page};

/// A change of an archive.
type Change<'a> = &'a dyn Fn(&mut Value);

/// The committed archive, changed.
fn edited(folder: &Path, name: &str, change: Change<'_>) -> String {
    let mut value = editable_archive();
    change(&mut value);
    written(folder, &format!("{name}.massline"), &value)
}

/// A file with this document.
fn written(folder: &Path, name: &str, value: &Value) -> String {
    let path = folder.join(name);
    fs::write(&path, value.to_string()).unwrap();
    path.display().to_string()
}

/// The layout file of an archive, in which the first text is replaced by the second.
fn replace_in_layout(archive: &mut Value, from: &str, to: &str) {
    let toml = archive["layout"]["toml"].as_str().unwrap();
    assert!(toml.contains(from), "{toml}");
    archive["layout"]["toml"] = toml.replacen(from, to, 1).into();
}

/// What stands in the page after these words, up to the end of the element.
fn after<'a>(text: &'a str, words: &str, end: &str) -> &'a str {
    let start = text.find(words).unwrap_or_else(|| panic!("{words}"));
    text[start..].split_once(end).expect("its end").0
}

/// The sources of error of the ten properties together.
fn sources(text: &str) -> &str {
    after(text, "The uncertainty of all ten together comes from", "</p>")
}

#[test]
fn a_calibration_that_is_in_the_answer_is_in_its_limits() {
    let folder = tempfile::tempdir().unwrap();
    let (_, before) = page(folder.path(), &[&archive()]);
    assert!(sources(&before).contains("hammer gain"), "{}", sources(&before));
    let remedy = "calibrate it with a block of known mass";
    assert!(before.contains(remedy));
    let calibrated = edited(folder.path(), "calibrated", &|archive| {
        archive["result"]["head"]["gains"] =
            json!({ "gain": 0.001, "cross_axis": 0.001, "hammer_gain": 0.001 });
    });
    let (_, text) = page(folder.path(), &[&calibrated]);
    assert!(!sources(&text).contains("hammer gain"), "{}", sources(&text));
    assert!(!text.contains(remedy));
    let used = after(&text, "uncertainty in the answer", "</dd>");
    assert!(used.contains("hammer 0.10"), "{used}");
    let budget = after(&text, "Error budget of the answer", "</dl>");
    for calibrated in ["axis of a sensor", "of the hammer against the sensors"] {
        let row = after(budget, calibrated, "</dd>");
        assert!(row.contains("<bdi>0.10 %"), "{budget}");
    }
    // The document of the same result says so as well.
    let solved = success(&["solve", &calibrated]);
    // The rig stores single precision.
    assert!((solved["calibration_sigma"]["hammer_gain"].as_f64().unwrap() - 0.001).abs() < 1e-9);
    assert_eq!(success(&["solve", &archive()])["calibration_sigma"], Value::Null);
}

#[test]
fn hits_that_were_not_made_limit_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let skipped = edited(folder.path(), "skipped", &|archive| {
        let hits = archive["layout"]["resolved"]["hits"].as_array_mut().unwrap();
        let mut fourth = hits[0].clone();
        fourth["dof"]["axis"] = "Z".into();
        fourth["direction"] = json!([0.0, 0.0, 1.0]);
        hits.push(fourth);
        replace_in_layout(archive, "\"4:+X\"]", "\"4:+X\", \"1:+Z\"]");
    });
    let (_, text) = page(folder.path(), &[&skipped]);
    let (_, whole) = page(folder.path(), &[&archive()]);
    assert_eq!(sources(&text), sources(&whole));
    // None of the three that were made can be left out.
    assert!(!text.contains("Least useful hit"));
    assert!(text.contains("A further hit helps most at"));
}

#[test]
fn the_noise_is_that_of_the_data_or_said_to_be_assumed() {
    let folder = tempfile::tempdir().unwrap();
    let layout = layout_with_hits(folder.path(), 3);
    let mut document = success(&["solve", &archive()]);
    let limits = |document: &Value| {
        let path = written(folder.path(), "solved.json", document);
        sources(&page(folder.path(), &[&path, "--layout", &layout]).1).to_owned()
    };
    let measured = limits(&document);
    assert!(measured.contains("with these data"), "{measured}");
    let each = |document: &mut Value, factor: f64| {
        for line in document["mass_lines"].as_array_mut().unwrap() {
            for noise in line["noise_m_per_s2_per_n"].as_array_mut().unwrap() {
                *noise = json!(factor * noise.as_f64().unwrap());
            }
        }
    };
    each(&mut document, 100.0);
    let noisy = limits(&document);
    assert!(noisy.contains(": noise "), "{noisy}");
    assert!(!measured.contains(": noise "), "{measured}");
    each(&mut document, 0.0);
    let assumed = limits(&document);
    assert!(assumed.contains("assuming noise of 0.5"), "{assumed}");
}

#[test]
fn a_simulated_test_is_said_to_be_one_and_has_its_truth() {
    let folder = tempfile::tempdir().unwrap();
    let document = success(&["simulate", LAYOUT]);
    let path = written(folder.path(), "simulated.json", &document);
    let (_, text) = page(folder.path(), &[&path]);
    for words in [
        "Simulated: a simulated rig has measured a simulated object.",
        "<h3>Rig</h3>",
        "seed of the simulation",
        "<h3>Calibration</h3>",
        "error, % of scale",
    ] {
        assert!(text.contains(words), "{words}");
    }
    let mass = document["truth"][0].as_f64().unwrap();
    assert!(text.contains(&format!("<td class=\"number\">{mass:.3}</td>")), "{mass}");
}

#[test]
fn an_archive_keeps_its_layout() {
    let folder = tempfile::tempdir().unwrap();
    let to = folder.path().join("page.html").display().to_string();
    let refused = run(&["report", &archive(), "--layout", LAYOUT, "-o", &to]);
    assert!(refused.exit == 2 && refused.says("version-1.massline"), "{}", refused.stderr);
    assert!(refused.says("massline solve LAYOUT.toml ARCHIVE"), "{}", refused.stderr);
    // Beside a result that needs it, an archive stays as it is.
    let solved = written(folder.path(), "solved.json", &success(&["solve", &archive()]));
    let (_, text) = page(folder.path(), &[&archive(), &solved, "--layout", LAYOUT]);
    assert!(text.contains("three-bar frame, committed archive"));
}

#[test]
fn hits_that_nobody_has_followed_are_counted_in_the_page() {
    let folder = tempfile::tempdir().unwrap();
    let path = edited(folder.path(), "resumed", &|archive| {
        let hit = |number: u32| {
            json!({
                "dof": "4:+X", "hit": number, "verdict": "accepted", "findings": [], "graded": null,
                "peak_force_n": 20.0, "peak_acceleration_m_per_s2": 9.0,
            })
        };
        archive["hit_log"] = json!([hit(8), hit(9)]);
    });
    let (_, text) = page(folder.path(), &[&path]);
    assert!(text.contains("9 hits are in the answer; 7 of them are not in this log"));
    assert!(text.contains("Hits at <bdi>1:+Y</bdi>: 3 in the answer"));
    assert!(text.contains("and not in this table: 1</span>"));
    assert!(!text.contains("All 2 hits"));
}

/// The document of the archive's result, without its answers.
fn without_answer() -> Value {
    let mut document = success(&["solve", &archive()]);
    for key in ["results", "verdict_reasons"] {
        document[key] = json!([]);
    }
    for key in ["verdict", "agreement"] {
        document[key] = Value::Null;
    }
    document
}

#[test]
fn a_result_without_an_answer_is_left_out_of_the_figure_and_named() {
    let folder = tempfile::tempdir().unwrap();
    let none = written(folder.path(), "none.json", &without_answer());
    let (_, text) = page(folder.path(), &[&none, &archive()]);
    assert!(text.contains("1 of 2 results") && text.contains("none.json: no answer"));
    let svg = folder.path().join("both.svg").display().to_string();
    success(&["plot", &none, &archive(), "-o", &svg]);
    assert!(fs::read_to_string(&svg).unwrap().contains("none.json: no answer"));
    let nothing = run(&["plot", &none, &none, "-o", &svg, "--force"]);
    assert_eq!(nothing.exit, 3, "{}", nothing.stderr);
}

#[test]
fn a_page_without_an_answer_says_every_reason_once() {
    let folder = tempfile::tempdir().unwrap();
    let reason = "the hits are too few for such a body";
    let mut document = without_answer();
    let code = "fewer_than_three_hits";
    let refused = |method: &str| json!({ "method": method, "message": reason, "code": code, "codes": [code] });
    document["not_applicable"] =
        json!([refused("maximum-likelihood"), refused("inertia-restraint")]);
    document["diagnostics"] =
        json!([{ "code": "fewer_than_three_hits", "severity": "error", "message": reason }]);
    let shown = |document: &Value| {
        let path = written(folder.path(), "none.json", document);
        let (_, text) = page(folder.path(), &[&path]);
        text.split("<script type=\"application/json\" id=\"data-").next().unwrap().to_owned()
    };
    let text = shown(&document);
    assert_eq!(text.matches(reason).count(), 1);
    let sentence = format!("Maximum-likelihood, inertia-restraint: {reason}");
    assert!(text.contains(&sentence), "{text:.900}");

    let mut wider = refused("maximum-likelihood");
    wider["message"] = format!("{reason}; nor is it square").into();
    wider["codes"] = json!(["fewer_than_three_hits", "not_converged"]);
    document["not_applicable"] = json!([wider, refused("inertia-restraint")]);
    let text = shown(&document);
    assert_eq!(text.matches(reason).count(), 1);
    assert!(text.contains("Inertia-restraint: one of the reasons of maximum-likelihood"));
}

#[test]
fn the_best_answer_is_the_first_of_the_document_in_every_place() {
    let folder = tempfile::tempdir().unwrap();
    let mut document = success(&["solve", &archive()]);
    document["results"].as_array_mut().unwrap().reverse();
    let first = document["results"][0]["method"].as_str().unwrap().to_owned();
    assert_ne!(first, "maximum-likelihood");
    let path = written(folder.path(), "reversed.json", &document);
    let (_, text) = page(folder.path(), &[&path]);
    assert!(text.contains(&format!("Method: {first}")), "{first}");
    let exported = run(&["export", &path, "--format", "json"]);
    assert!(exported.stdout.contains(&format!("\"{first}\"")), "{}", exported.stdout);
}

#[test]
fn an_interval_that_covers_the_scatter_only_is_marked() {
    let folder = tempfile::tempdir().unwrap();
    let (_, text) = page(folder.path(), &[&archive()]);
    let row = after(&text, "<bdi>inertia-restraint</bdi>", "</tr>");
    assert!(row.contains("would cover the scatter between hits only"), "{row}");
    assert_eq!(text.matches("would cover the scatter between hits only").count(), 1);
}

#[test]
fn several_results_are_compared_by_method_and_by_sensors() {
    let folder = tempfile::tempdir().unwrap();
    let with_sensors = |name: &str, sensors: &str| {
        edited(folder.path(), name, &|archive| {
            let table = format!("[report]\nsensors = \"{sensors}\"\n[test]");
            replace_in_layout(archive, "[test]", &table);
        })
    };
    let [first, second] = [("one", "ADXL326, wax"), ("two", "ADXL356, screwed")];
    let [first, second] = [first, second].map(|(name, sensors)| with_sensors(name, sensors));
    let (_, text) = page(folder.path(), &[&first, &second]);
    let both = text.split("<section id=\"result-1\">").next().unwrap();
    for words in [
        "Best answer of each, ± 95",
        "<th scope=\"row\">sensors</th>",
        "<th scope=\"row\">calibration</th>",
        "sensitivities of the data sheets",
        "The answers of all results by each method",
        "class=\"group\"><bdi>maximum-likelihood</bdi>",
        "class=\"group\"><bdi>inertia-restraint</bdi>",
        "The best answers by the sensors",
        "class=\"group\"><bdi>ADXL326, wax</bdi>",
        "class=\"group\"><bdi>ADXL356, screwed</bdi>",
    ] {
        assert!(both.contains(words), "{words}: {both}");
    }
    // One kind of sensor is no comparison.
    let (_, same) = page(folder.path(), &[&first, &first]);
    assert!(!same.contains("The best answers by the sensors"));
}

#[test]
fn suspension_modes_of_a_file_have_advice_and_the_share_of_the_hammer_or_a_reason_why_none_is_known()
 {
    let folder = tempfile::tempdir().unwrap();
    let uff = folder.path().join("wheel.uff").display().to_string();
    let wheel = success(&["demo", "wheel", "--write", &uff]);
    let layout = wheel["layout"].as_str().unwrap();
    let mut document = success(&["solve", layout, &uff]);
    let limits = |document: &Value| {
        let path = written(folder.path(), "wheel.json", document);
        let (_, text) = page(folder.path(), &[&path, "--layout", layout]);
        // That the other form of damping does not fit is no doubt about the answer.
        assert!(text.contains("Good: nothing puts this answer in doubt"), "{text:.3000}");
        after(&text, "What limits the answer", "<h2>").to_owned()
    };
    let well = limits(&document);
    assert!(well.contains("of the variance of the mass: calibrate it"), "{well}");
    let diagnostics = document["diagnostics"].as_array_mut().unwrap();
    diagnostics.retain(|one| one["code"] != "hammer_gain_limits");
    let none = limits(&document);
    assert!(none.contains("is computed for tests by a rig in the suspension profile"), "{none}");
    document["suspension"]["modes"][2]["better_hit"] = json!({ "dof": "9:+Z", "shown": 0.12 });
    let better = limits(&document);
    assert!(better.contains("Mode 3 hardly shows under any hit (12"), "{better}");
    assert!(better.contains("hit 9:+Z"), "{better}");
}

/// Without a calibrated hammer its gain is most of the uncertainty of the mass, and the remedy says so.
#[test]
fn a_test_of_the_suspension_profile_has_shares_of_its_sources_of_error_and_a_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let layout = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/wheel.toml");
    let document = success(&["simulate", layout, "--bench", "wheel", "--seed", "1"]);
    let path = written(folder.path(), "test.json", &document);
    let (_, text) = page(folder.path(), &[&path, "--layout", layout]);
    let limits = after(&text, "What limits the answer", "<h2>");
    assert!(limits.contains("uncertainty of all ten together comes from"), "{limits}");
    assert!(limits.contains("with these data"), "{limits}");
    assert!(limits.contains("gain limits most: calibrate it with a block"), "{limits}");
    assert!(limits.contains("converter") && limits.contains("hit gain"), "{limits}");
    assert!(text.contains("hammer gain"), "{text:.3000}");
}

#[test]
fn the_items_of_a_report_of_impact_testing_are_there() {
    let folder = tempfile::tempdir().unwrap();
    let (_, text) = page(folder.path(), &[&archive()]);
    for words in [
        "Channels: zeros, sensitivities and low-passes",
        "5.8124 mV/(m/s²)",
        "22.5000 mV/N",
        "497.4",
        "responses up to",
        "dB below its maximum at 120.0 Hz",
        "estimator H1",
        "3 hits, as wanted",
    ] {
        assert!(text.contains(words), "{words}");
    }
}

//! The JSON output of `massline simulate`.

use serde_json::{Value, json};

use crate::program::{LAYOUT, answer, run, words};

fn simulate(arguments: &[&str]) -> (i32, Value) {
    simulate_layout(LAYOUT, arguments)
}

/// The text of the layout with a change, in a file of its own.
fn changed(change: impl FnOnce(String) -> String) -> tempfile::NamedTempFile {
    let file = tempfile::NamedTempFile::new().unwrap();
    let text = change(std::fs::read_to_string(LAYOUT).unwrap());
    std::fs::write(file.path(), text).unwrap();
    file
}

fn two_sensors() -> tempfile::NamedTempFile {
    changed(|text| text.replacen("sensors = [1, 2, 3]", "sensors = [1, 2]", 1))
}

fn simulate_layout(layout: &str, arguments: &[&str]) -> (i32, Value) {
    answer(&on_bench(layout, arguments))
}

/// A simulation on the bench of the demo, unless the arguments name another.
fn on_bench<'a>(layout: &'a str, arguments: &[&'a str]) -> Vec<&'a str> {
    let bench = match arguments.contains(&"--bench") {
        true => &[][..],
        false => &["--bench", "default"],
    };
    [&["simulate", layout], bench, arguments].concat()
}

#[test]
fn many_runs_tell_of_every_method_and_property() {
    let (code, value) = simulate(&["--runs", "3", "--budget", "bench", "--seed", "4"]);
    assert_eq!(code, 0);
    assert_eq!((&value["runs"], &value["seed"]), (&3.into(), &4.into()));
    let names: Vec<_> = value["methods"].as_array().unwrap().iter().map(|m| &m["method"]).collect();
    assert_eq!(names, ["maximum-likelihood", "inertia-restraint"]);
    for method in value["methods"].as_array().unwrap() {
        let properties = method["properties"].as_array().unwrap();
        let names: Vec<_> = properties.iter().map(|p| p["name"].as_str().unwrap()).collect();
        assert_eq!(names, massline_shared::body::INERTIAL_PARAMETERS.map(|p| p.symbol));
        for p in properties {
            let number = |key: &str| p[key].as_f64().unwrap();
            assert!(number("rms") >= number("bias").abs() && number("bound") > 0.0, "{p}");
            // Both are printed with all digits.
            assert!((number("ratio") - number("rms") / number("bound")).abs() < 1e-9, "{p}");
            assert!((0.0..=1.0).contains(&number("coverage95")), "{p}");
        }
    }
}

#[test]
fn the_bench_has_the_errors_of_the_layout_when_asked() {
    let study = |more: &[&str]| {
        let (code, value) = simulate(&[&["--runs", "2", "--errors", "layout"], more].concat());
        assert_eq!(code, 0, "{value}");
        value["methods"][0].clone()
    };
    let share = |method: &Value, key: &str| {
        let mass = &method["properties"][0];
        mass[key].as_f64().unwrap() / mass["truth"].as_f64().unwrap()
    };
    let (uncalibrated, calibrated) = (study(&[]), study(&["--calibrated-hammer"]));
    // The 2 % of a hammer that is not calibrated, which nothing else tells of; and 0.3 % with 1 % of nine sensor axes
    // and the placement of three marks, 1.3 % in all.
    assert!(share(&uncalibrated, "bound") > 0.02, "{uncalibrated}");
    assert!((0.003..0.016).contains(&share(&calibrated, "bound")), "{calibrated}");
    // The rig assumes the same: intervals of 1.96 times that, and what is learned may widen them by a half.
    assert!(share(&uncalibrated, "half_width95") > 0.039, "{uncalibrated}");
    assert!(share(&calibrated, "half_width95") < 0.036, "{calibrated}");
    assert_eq!((&calibrated["unanswered"], &calibrated["reasons"]), (&0.into(), &json!({})));
}

#[test]
fn a_fault_on_the_bench_is_named_beside_the_result() {
    let (code, value) = simulate(&["--fault", "flip:2y"]);
    assert_eq!(code, 3);
    let suspect = &value["single_faults"]["suspects"][0];
    assert_eq!((&suspect["code"], &suspect["sensor"]), (&"sensor_axes_suspect".into(), &2.into()));
    assert!(suspect["message"].as_str().unwrap().contains("y axis reversed"), "{suspect}");
    let diagnostics = value["diagnostics"].as_array().unwrap();
    assert!(
        diagnostics
            .iter()
            .any(|d| d["code"] == "sensor_axes_suspect" && d["severity"] == "warning")
    );
}

#[test]
fn a_fault_that_cannot_be_is_bad_input() {
    let (code, value) = simulate(&["--fault", "flip:7x"]);
    assert_eq!(code, 2);
    assert_eq!(value["error"]["code"], "bench_does_not_fit");
    let (code, _) = simulate(&["--fault", "drop:1"]);
    assert_eq!(code, 2);
    let (code, _) = simulate(&["--runs", "2", "--rig", "virtual"]);
    assert_eq!(code, 2);
}

#[test]
fn many_runs_with_a_target_tell_how_often_it_was_reached_and_what_it_saved() {
    let more = ("\"4:+X\"]", "\"4:+X\", \"1:+X\"]");
    let wide = ("[reference]", "[target]\nmass = 0.9\n\n[reference]");
    let file = changed(|text| text.replacen(more.0, more.1, 1).replacen(wide.0, wide.1, 1));
    let layout = file.path().to_str().unwrap();
    let (code, value) = simulate_layout(layout, &["--runs", "2"]);
    assert_eq!(code, 0, "{value}");
    // Any answer knows the mass to 90 %: the last DOF with its five hits is left out.
    let target = &value["target"];
    assert_eq!((&target["runs_at_target"], &target["hits_of_a_campaign"]), (&2.into(), &20.into()));
    assert_eq!(target["mean_hits_saved"], 5.0);
    assert_eq!(target["coverage95"], target["coverage95_at_target"]);
    let text = text_of(layout, &["--runs", "2"]);
    assert!(text.contains("target: 2 of 2 runs reached it; 5.0 of 20 hits saved"), "{text}");
    assert!(simulate(&["--runs", "2"]).1["target"].is_null());
}

#[track_caller]
fn text_of(layout: &str, arguments: &[&str]) -> String {
    text_with_exit(0, layout, arguments)
}

#[track_caller]
fn text_with_exit(exit: i32, layout: &str, arguments: &[&str]) -> String {
    let run = run(&on_bench(layout, arguments));
    assert_eq!(run.exit, exit, "{}", run.stderr);
    // As one line, because long lines are broken between words.
    words(&run.stdout)
}

#[test]
fn a_method_that_does_not_apply_is_said_with_its_reason() {
    let file = two_sensors();
    let layout = file.path().to_str().unwrap();
    for arguments in [&[][..], &["--runs", "2"]] {
        let (code, value) = simulate_layout(layout, arguments);
        assert_eq!(code, 0);
        let refused = value["not_applicable"].as_array().unwrap();
        assert_eq!(refused.len(), 1, "{refused:?}");
        assert_eq!(refused[0]["method"], "inertia-restraint");
        assert_eq!(refused[0]["code"], "fewer_than_three_sensors");
        assert!(refused[0]["message"].as_str().unwrap().contains("six motions"), "{refused:?}");
        let options = if arguments.is_empty() { &["--details"][..] } else { arguments };
        let text = text_of(layout, options);
        let line = "inertia-restraint: not applicable: fewer than three";
        assert!(text.contains(line), "{text}");
    }
}

#[test]
fn a_prior_that_contradicts_the_data_is_named() {
    let prior = "\n[prior]\nmass_kg = { value = 20.0, sigma = 0.0001 }\n";
    let file = changed(|text| text + prior);
    let layout = file.path().to_str().unwrap();
    // Inertia restraint answers, and the better method contradicts it. 20 kg are 16 times the mass.
    let text = text_with_exit(3, layout, &["--details"]);
    let mistake = ": one mistake explains the data: all accelerances are 16.";
    assert!(text.starts_with("Do not use this answer") && text.contains(mistake), "{text}");
    assert!(text.contains("maximum-likelihood: no answer: "), "{text}");
    let named = "the [prior] m = 20 kg (stated to 0.0001 kg, 1 sd) contradicts the data, \
                 which say 1.2";
    assert!(text.contains(named), "{text}");
    let (_, value) = simulate_layout(layout, &[]);
    let codes = &value["not_applicable"][0]["codes"];
    assert_eq!(codes, &serde_json::json!(["not_converged", "prior_inconsistent_with_data"]));
}

#[test]
fn a_prior_that_is_hardly_wrong_enough_is_named_in_place_of_a_sensor() {
    // Sensors and hammer are good to 2 %: 25 % is a dozen standard deviations, and the fit still
    // converges.
    let prior = "\n[prior]\nmass_kg = { value = 1.54, sigma = 0.0001 }\n";
    let file = changed(|text| text + prior);
    let layout = file.path().to_str().unwrap();
    let (code, value) = simulate_layout(layout, &[]);
    assert_eq!((code, &value["verdict"]), (3, &"do_not_use".into()));
    assert_eq!(value["results"][0]["method"], "maximum-likelihood");
    let diagnostics = value["results"][0]["diagnostics"].as_array().unwrap();
    assert!(
        diagnostics.iter().any(|d| d["code"] == "data_inconsistent_with_budget"),
        "{diagnostics:?}"
    );
    assert!(!diagnostics.iter().any(|d| d["code"] == "large_sensor_pull"), "{diagnostics:?}");
    let diagnostics = value["diagnostics"].as_array().unwrap();
    let named = diagnostics.iter().find(|d| d["code"] == "prior_inconsistent_with_data").unwrap();
    assert!(
        named["message"]
            .as_str()
            .unwrap()
            .contains("[prior] m = 1.54 kg (stated to 0.0001 kg, 1 sd)"),
        "{named}"
    );
}

#[test]
fn one_run_has_errors_and_no_statistics() {
    let (code, value) = simulate(&["--runs", "1"]);
    assert_eq!(code, 0);
    let mass = &value["methods"][0]["properties"][0];
    assert!(mass["bias"].is_number() && mass["rms"].is_null() && mass["coverage95"].is_null());
    assert!(value["notes"][0].as_str().unwrap().contains("one run has an error"), "{value}");
    assert!(text_of(LAYOUT, &["--runs", "1"]).contains("note: one run has an error and no rms"));
}

#[test]
fn a_bench_whose_hits_are_all_rejected_ends() {
    let bench = tempfile::Builder::new().suffix(".toml").tempfile().unwrap();
    std::fs::write(bench.path(), "[tap]\nforce_n = [500.0, 600.0]\n").unwrap();
    let (code, value) = simulate(&["--bench", bench.path().to_str().unwrap()]);
    assert_eq!((code, &value["error"]["code"]), (3, &"always_rejected".into()));
    assert!(value["error"]["message"].as_str().unwrap().contains("1:+Y"), "{value}");
}

#[test]
fn a_report_compares_with_the_simulated_object_and_does_not_change_the_result() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.html").display().to_string();
    // Without a reference of its own.
    let layout = changed(|text| text.split("[reference]").next().unwrap().to_owned());
    let layout = layout.path().display().to_string();
    let (code, mut with) = simulate_layout(&layout, &["--report", &page]);
    assert_eq!((code, with["report"].take()), (0, page.clone().into()));
    let (_, without) = simulate_layout(&layout, &[]);
    assert_eq!(with, without);
    let text = std::fs::read_to_string(&page).unwrap();
    for words in ["simulated", "expected", "is too small for a clear response"] {
        assert!(text.contains(words), "{words}");
    }
    let again = run(&on_bench(&layout, &["--report", &page]));
    assert_eq!(again.exit, 2, "{}", again.stderr);
    assert!(again.says("exists already"), "{}", again.stderr);
    assert_eq!(std::fs::read_to_string(&page).unwrap(), text);
}

/// A layout of an object that no bench has: five kilograms, nodes at other places, all of them stated.
const OWN: &str = "\
title = \"gearbox\"
gravity = [0.0, 0.0, -9.80665]
sensors = [1, 2, 3]
hits = [\"4:+X\", \"5:+Y\", \"6:+Z\", \"7:-X\"]
node = [
    { id = 1, position_m = [0.15, 0.0, 0.02] },
    { id = 2, position_m = [-0.12, 0.14, 0.0] },
    { id = 3, position_m = [-0.1, -0.13, 0.05] },
    { id = 4, position_m = [-0.16, 0.09, 0.08] },
    { id = 5, position_m = [0.13, -0.15, -0.06] },
    { id = 6, position_m = [0.1, 0.12, 0.1] },
    { id = 7, position_m = [0.17, -0.05, 0.12] },
]

[reference]
mass_kg = 5.0
center_of_mass_m = [0.004, -0.006, 0.02]
inertia_kg_m2 = [[0.045, 0.002, 0.0], [0.002, 0.05, -0.003], [0.0, -0.003, 0.06]]
";

#[test]
fn the_object_of_the_reference_is_simulated_whatever_its_geometry() {
    let file = changed(|_| OWN.into());
    let layout = file.path().to_str().unwrap();
    let (code, value) = answer(&["simulate", layout]);
    assert_eq!((code, &value["truth"][0]), (0, &5.0.into()), "{value}");
    let simulated = "simulated: rigid body of 5.00 kg, no elastic modes, suspension 3 Hz";
    assert_eq!(value["simulated"], simulated);
    let run = run(&["simulate", layout, "--runs", "2", "--suspension-hz", "2"]);
    assert_eq!(run.exit, 0, "{}", run.stderr);
    assert!(run.stderr.starts_with("simulated: rigid body of 5.00 kg"), "{}", run.stderr);
    assert!(run.stdout.contains("suspension 2 Hz"), "{}", run.stdout);
}

/// Usual hits of 18 to 30 N exceed the range of its sensors, and gentler ones that the rig still accepts do not.
#[test]
fn a_light_object_is_hit_so_gently_that_it_can_be_measured() {
    let light = OWN
        .replace("mass_kg = 5.0", "mass_kg = 0.15")
        .replace("0.045, 0.002", "0.00135, 0.00006")
        .replace("0.002, 0.05, -0.003", "0.00006, 0.0015, -0.00009")
        .replace("-0.003, 0.06", "-0.00009, 0.0018");
    let file = changed(|_| light);
    let layout = file.path().to_str().unwrap();
    let (code, value) = answer(&["simulate", layout]);
    let simulated = value["simulated"].as_str().unwrap();
    assert!(code == 0 && simulated.contains(", hits of "), "{value}");
}

#[test]
fn without_an_object_one_is_asked_for() {
    let file = changed(|_| OWN.split("[reference]").next().unwrap().to_owned());
    let layout = file.path().to_str().unwrap();
    let (code, value) = answer(&["simulate", layout]);
    assert_eq!((code, &value["error"]["code"]), (2, &"object_not_stated".into()));
    let message = value["error"]["message"].as_str().unwrap();
    assert!(message.contains("[reference]") && message.contains("--bench default"), "{message}");
}

#[test]
fn an_object_whose_numbers_look_like_another_unit_is_not_simulated() {
    let grams_and_millimetres = OWN
        .replace("0.045, 0.002", "4.5e7, 2e6")
        .replace("0.002, 0.05, -0.003", "2e6, 5e7, -3e6")
        .replace("-0.003, 0.06", "-3e6, 6e7");
    let file = changed(|_| grams_and_millimetres);
    let (code, value) = answer(&["simulate", file.path().to_str().unwrap()]);
    assert_eq!((code, &value["error"]["code"]), (2, &"object_doubtful".into()), "{value}");
    let message = value["error"]["message"].as_str().unwrap();
    assert!(message.contains("radius of gyration"), "{message}");
}

#[test]
fn a_study_whose_first_five_runs_all_fail_ends() {
    let bench = tempfile::Builder::new().suffix(".toml").tempfile().unwrap();
    std::fs::write(bench.path(), "[tap]\nforce_n = [500.0, 600.0]\n").unwrap();
    let bench = bench.path().to_str().unwrap();
    let (code, value) = simulate(&["--bench", bench, "--runs", "50"]);
    assert_eq!((code, &value["runs"]), (3, &5.into()), "{value}");
    let message = value["error"]["message"].as_str().unwrap();
    assert!(message.contains("the first 5 runs all failed"), "{message}");
}

/// No tap of the bench is as hard: each run gives up after 200 hits at its first DOF.
#[test]
fn the_rejected_hits_of_runs_without_an_answer_are_counted() {
    let hard = "hits_per_dof = 5\nmin_peak_force_n = 120.0";
    let layout = changed(|text| text.replacen("hits_per_dof = 5", hard, 1));
    let layout = layout.path().to_str().unwrap();
    let simulated = run(&["simulate", layout, "--bench", "default", "--runs", "2"]);
    let text = words(&(simulated.stdout + &simulated.stderr));
    assert!(text.contains("400 hits rejected and repeated"), "{text}");
}

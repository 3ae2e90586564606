//! The predicted uncertainty of a layout and the suggested alternatives, as the program prints them.

use std::path::{Path, PathBuf};

use serde_json::Value;
use tempfile::TempDir;

use crate::program::{answer, changed_layout, run};

/// The ten inertial parameters, as in every result.
const NAMES: [&str; 10] =
    ["m", "c_x", "c_y", "c_z", "J_xx", "J_yy", "J_zz", "J_xy", "J_xz", "J_yz"];

fn example(number: usize) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    folder.join(format!("three-bar-test-{number}.toml")).display().to_string()
}

/// `massline layout … --json`: exit code and what it printed.
#[track_caller]
fn layout(arguments: &[&str]) -> (i32, Value) {
    answer(&[&["layout"], arguments].concat())
}

fn total(value: &Value) -> f64 {
    value["total_percent_of_scale"].as_f64().unwrap_or_else(|| panic!("{value}"))
}

fn blocked(value: &Value, method: usize) -> Vec<&str> {
    let codes = value["methods"][method]["blocked_by"].as_array().unwrap();
    codes.iter().map(|code| code.as_str().unwrap()).collect()
}

#[test]
fn a_good_layout_has_ten_sigmas_their_causes_and_advice() {
    let (exit, value) = layout(&["check", &example(1)]);
    assert_eq!(exit, 0);
    assert_eq!(value["schema_version"], 1);
    assert_eq!(value["identifiable"], true);
    assert_eq!(value["codes"].as_array().unwrap().len(), 0);
    assert!(value["condition"].as_f64().unwrap() > 1.0);
    assert_eq!(value["rank"], 10);
    assert!(NAMES.iter().all(|name| value["sigma"][name].as_f64().unwrap() > 0.0), "{value}");
    let error_sources = value["error_sources"].as_array().unwrap();
    let sum: f64 = error_sources.iter().map(|source| source["share"].as_f64().unwrap()).sum();
    // The shares are slopes over steps of a ten-thousandth.
    assert!((sum - 1.0).abs() < 1e-3, "{sum}");
    let advice = &value["advice"];
    assert!(total(&advice["further_hit"]) < total(&value));
    assert!(total(&advice["further_sensor"]) < total(&value));
    assert_eq!(advice["without_hits"].as_array().unwrap().len(), 3);
    // With three hits none can be left out; with three sensors any one can (theory, section 4).
    assert!(advice["without_hits"][0]["total_percent_of_scale"].is_null());
    assert!(total(&advice["without_sensors"][0]) > total(&value));
}

#[test]
fn a_smaller_budget_gives_a_smaller_predicted_uncertainty() {
    let folder = tempfile::tempdir().unwrap();
    let calibrated = changed_layout(
        folder.path(),
        "[reference]",
        "[uncertainty]\nhammer_gain = 0.0\n[reference]",
    );
    let (exit, value) = layout(&["check", &calibrated]);
    let (_, before) = layout(&["check", &example(1)]);
    assert_eq!(exit, 0);
    assert!(total(&value) < 0.8 * total(&before), "{value}");
    let (_, loud) = layout(&["check", &example(1), "--noise", "0.05"]);
    assert!(total(&loud) > total(&before));
}

#[test]
fn sensors_that_stop_one_method_are_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let nodes = "[[node]]\nid = 5\nposition_m = [0.1, 0.0, 0.0]\n\n[test]";
    let more = changed_layout(folder.path(), "[test]", nodes);
    let more = std::fs::read_to_string(more).unwrap();
    for (sensors, code) in [
        ("sensors = [1, 2]", "fewer_than_three_sensors"),
        ("sensors = [1, 3, 5]", "sensors_collinear"),
    ] {
        let file = folder.path().join("fewer.toml").display().to_string();
        std::fs::write(&file, more.replace("sensors = [1, 2, 3]", sensors)).unwrap();
        let (exit, value) = layout(&["check", &file]);
        assert_eq!(exit, 0, "{value}");
        assert_eq!(value["identifiable"], true);
        let codes = value["codes"].as_array().unwrap();
        assert!(codes.contains(&code.into()) && codes.contains(&"response_rank_deficient".into()));
        assert_eq!(value["methods"][0]["method"], "maximum-likelihood");
        assert_eq!(blocked(&value, 0), [""; 0]);
        assert!(blocked(&value, 1).contains(&code));
        assert!(NAMES.iter().all(|name| value["sigma"][name].as_f64().unwrap() > 0.0), "{value}");
    }
}

#[test]
fn what_stops_every_method_ends_with_three_and_the_code() {
    let folder = tempfile::tempdir().unwrap();
    let hits = r#"hits = ["1:+Y", "2:+Z", "4:+X"]"#;
    for (from, to, code) in [
        (hits, r#"hits = ["3:+X", "3:+Y", "3:+Z"]"#, "hits_concurrent"),
        (hits, r#"hits = ["1:+Y", "2:+Y", "4:+Y", "3:-Y"]"#, "hits_all_parallel"),
        (hits, r#"hits = ["1:+Y", "2:+Z"]"#, "fewer_than_three_hits"),
        ("sensors = [1, 2, 3]", "sensors = [1]", "ten_parameters_not_identifiable"),
    ] {
        let (exit, value) = layout(&["check", &changed_layout(folder.path(), from, to)]);
        assert_eq!(exit, 3, "{value}");
        assert_eq!(value["identifiable"], false);
        assert_eq!(value["error"]["code"], code, "{value}");
        assert!(blocked(&value, 0).contains(&code) && blocked(&value, 1).contains(&code));
        assert!(value["sigma"]["m"].is_null());
    }
}

#[test]
fn a_suggestion_is_better_than_what_the_file_has() {
    for number in 1..=4 {
        let (exit, value) = layout(&["suggest", &example(number), "--starts", "4"]);
        assert_eq!(exit, 0, "{value}");
        assert!(total(&value) < total(&value["before"]), "{value}");
        assert_eq!(value["sensors"].as_array().unwrap().len(), 3);
        assert_eq!(value["hits"].as_array().unwrap().len(), 3);
        // More hits give a smaller predicted uncertainty (theory, section 8).
        let (_, five) = layout(&["suggest", &example(number), "--starts", "4", "--hits", "5"]);
        assert!(total(&five) < total(&value), "{five}");
    }
}

#[test]
fn equal_seeds_suggest_the_same() {
    let run = || layout(&["suggest", &example(2), "--starts", "3", "--seed", "5", "--hits", "4"]).1;
    assert_eq!(run(), run());
}

#[test]
fn nothing_forbidden_is_suggested() {
    let folder = tempfile::tempdir().unwrap();
    let from = "position_m = [0.20785060677922013, -0.1990185781623297, 0.14913081505846087]";
    let to = format!("{from}\ncan_carry_sensor = false\ncan_hit = [\"-X\", \"+Y\"]");
    let file = changed_layout(folder.path(), from, &to);
    for seed in ["1", "2", "3"] {
        let (exit, value) =
            layout(&["suggest", &file, "--hits", "6", "--starts", "2", "--seed", seed]);
        assert_eq!(exit, 0);
        assert!(!value["sensors"].as_array().unwrap().contains(&4.into()), "{value}");
        let hits = value["hits"].as_array().unwrap();
        for hit in hits.iter().map(|hit| hit.as_str().unwrap()).filter(|hit| hit.starts_with("4:"))
        {
            assert!(["4:-X", "4:+Y"].contains(&hit), "{value}");
        }
        assert_eq!(hits.len(), 6);
    }
}

#[test]
fn sensors_and_hits_that_are_to_be_kept_stay_in_the_suggestion() {
    let (_, value) = layout(&["suggest", &example(1), "--keep-sensors", "--hits", "4"]);
    assert_eq!(value["sensors"], serde_json::json!([1, 2, 3]));
    let (_, value) = layout(&["suggest", &example(1), "--keep-hits"]);
    assert_eq!(value["hits"], serde_json::json!(["1:+Y", "2:+Z", "4:+X"]));
}

#[test]
fn a_written_suggestion_has_the_uncertainty_that_was_printed() {
    let folder = tempfile::tempdir().unwrap();
    let path: PathBuf = folder.path().join("better.toml");
    let path = path.to_str().unwrap();
    let arguments = ["suggest", &example(1), "--hits", "5", "--hits-per-dof", "3", "--write", path];
    let (_, suggested) = layout(&arguments);
    let (exit, checked) = layout(&["check", path]);
    assert_eq!(exit, 0);
    for name in NAMES {
        let (a, b) = (suggested["sigma"][name].as_f64(), checked["sigma"][name].as_f64());
        // The positions are printed with all digits; the tolerance is rounding times the condition of the
        // information.
        assert!((a.unwrap() / b.unwrap() - 1.0).abs() < 1e-9, "{name}");
    }
    let text = std::fs::read_to_string(path).unwrap();
    assert!(text.contains("hits_per_dof = 3") && text.contains("# What the solid bars have"));
}

#[test]
fn nodes_alone_are_enough_to_begin_with() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(example(1)).unwrap();
    let (nodes, _) = text.split_once("[reference]").unwrap();
    let nodes = nodes.replace("[1, 2, 3]", "[]").replace(r#"["1:+Y", "2:+Z", "4:+X"]"#, "[]");
    let file = folder.path().join("nodes.toml").display().to_string();
    std::fs::write(&file, nodes).unwrap();
    let (exit, value) = layout(&["suggest", &file]);
    assert_eq!(exit, 0, "{value}");
    assert_eq!(value["sensors"].as_array().unwrap().len(), 3);
    assert_eq!(value["hits"].as_array().unwrap().len(), 5);
    assert!(value["before"]["total_percent_of_scale"].is_null());
    // The assumed body has the size of the nodes' extent, not one metre.
    assert!(total(&value) < 3.0, "{value}");
}

#[test]
fn responses_of_a_degenerate_layout_are_solved_or_refused_as_the_check_reports() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/uff");
    let frfs = data.join("a_irm_01.ascii.uff").display().to_string();
    let text = std::fs::read_to_string(data.join("a_irm_01.toml")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("layout.toml").display().to_string();
    let hits = r#"hits = ["1:+Y", "2:+Z", "4:+X"]"#;
    for (from, to, exit, code) in [
        ("sensors = [1, 2, 3]", "sensors = [1, 2]", 0, ""),
        ("sensors = [1, 2, 3]", "sensors = [1]", 3, "ten_parameters_not_identifiable"),
        (hits, r#"hits = ["1:+Y", "2:+Z"]"#, 3, "fewer_than_three_hits"),
        (hits, r#"hits = ["3:+X", "3:+Y", "3:+Z"]"#, 3, "hits_concurrent"),
    ] {
        assert!(text.contains(from));
        std::fs::write(&file, text.replace(from, to)).unwrap();
        assert_eq!(layout(&["check", &file]).0, exit);
        let (ended, value) = answer(&["solve", &file, &frfs]);
        assert_eq!(ended, exit, "{value}");
        match exit {
            0 => assert_eq!(value["results"][0]["method"], "maximum-likelihood"),
            _ => assert_eq!(value["error"]["code"], code),
        }
    }
}

#[test]
fn nodes_alone_are_enough_to_choose_from_and_nothing_else() {
    let folder = TempDir::new().unwrap();
    let text = std::fs::read_to_string(example(1)).unwrap();
    let bare: Vec<&str> =
        text.lines().filter(|l| !l.starts_with("sensors") && !l.starts_with("hits =")).collect();
    let path = folder.path().join("nodes.toml");
    std::fs::write(&path, bare.join("\n")).unwrap();
    let (path, better) = (path.display().to_string(), folder.path().join("better.toml"));
    let better = better.display().to_string();
    let (code, value) = layout(&["suggest", &path, "--starts", "2", "--write", &better]);
    assert_eq!(code, 0, "{value}");
    let counts = ["sensors", "hits"].map(|key| value[key].as_array().unwrap().len());
    assert_eq!(counts, [3, 5], "as the help says");
    assert!(value["before"]["total_percent_of_scale"].is_null());
    let (code, value) = layout(&["check", &better]);
    assert_eq!((code, &value["identifiable"]), (0, &true.into()));
    let (code, value) = layout(&["check", &path]);
    assert_eq!((code, &value["error"]["code"]), (2, &"layout_malformed".into()));
    assert!(value["error"]["message"].as_str().unwrap().contains("layout suggest"), "{value}");
    let (code, value) = layout(&["suggest", &path, "--keep-sensors"]);
    assert_eq!((code, &value["error"]["code"]), (2, &"nothing_to_keep".into()));
}

#[test]
fn a_hit_without_a_sign_is_refused_with_both_possible_signs() {
    let folder = TempDir::new().unwrap();
    let path = changed_layout(folder.path(), "\"1:+Y\"", "\"1:Y\"");
    let (code, value) = layout(&["check", &path]);
    assert_eq!(code, 2);
    assert!(value["error"]["message"].as_str().unwrap().contains("write 1:+Y or 1:-Y"), "{value}");
}

/// What is written into a file or a pipe, as the first example of the help does.
#[test]
fn the_layout_that_new_prints_can_be_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("new.toml");
    let template = run(&["layout", "new"]).stdout;
    let as_json = crate::program::success(&["layout", "new"]);
    assert_eq!(as_json["layout"].as_str().unwrap().trim_end(), template.trim_end());
    std::fs::write(&path, template).unwrap();
    let (exit, value) = layout(&["check", &path.display().to_string()]);
    assert_eq!(exit, 0, "{value}");
}

#[test]
fn the_mass_of_the_sensors_is_asked_for_until_it_is_declared() {
    let folder = tempfile::tempdir().unwrap();
    let (exit, value) = layout(&["check", &example(1)]);
    let note = value["notes"][0].as_str().unwrap();
    assert_eq!(exit, 0);
    // What it says to add is read as it stands.
    let entries = note.split_once("sensors = [").unwrap().1;
    let sensors = format!("sensors = [{entries}");
    let declared = changed_layout(folder.path(), "sensors = [1, 2, 3]", &sensors);
    let (exit, value) = layout(&["check", &declared]);
    assert_eq!((exit, value["notes"].as_array().unwrap().len()), (0, 0), "{value}");
}

/// Which keys there are, what they are called and what they hold is the same in both commands.
#[test]
fn a_suggestion_and_its_check_have_the_same_keys_and_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let better = folder.path().join("better.toml").display().to_string();
    let layout = example(1);
    let (code, suggested) =
        self::layout(&["suggest", &layout, "--starts", "2", "--write", &better]);
    assert_eq!(code, 0, "{suggested}");
    let (code, checked) = self::layout(&["check", &better]);
    assert_eq!(code, 0, "{checked}");
    for key in [
        "sigma",
        "percent_of_scale",
        "total_percent_of_scale",
        "characteristic_length_m",
        "scale",
        "noise_m_per_s2_per_n",
        "noise",
        "body",
        "rank",
        "condition",
        "methods",
        "identifiable",
        "sensors",
        "hits",
        "hits_per_dof",
        "layout_hash",
        "codes",
        "diagnostics",
    ] {
        assert!(!suggested[key].is_null(), "{key}");
        assert_eq!(suggested[key], checked[key], "{key}");
    }
    let shown = self::layout(&["show", &better]).1;
    assert_eq!(shown["characteristic_length_m"], checked["characteristic_length_m"]);
}

/// Every command that takes a layout looks at its units and at what a rig can measure with.
#[test]
fn millimetres_and_settings_of_no_rig_are_named_by_every_command() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(example(1)).unwrap();
    let millimetres = folder.path().join("mm.toml").display().to_string();
    let mut typed = text.clone();
    for (metres, value) in [("0.20785060677922013", "207.85"), ("0.1990185781623297", "199.02")] {
        assert!(typed.contains(metres));
        typed = typed.replace(metres, value);
    }
    std::fs::write(&millimetres, typed).unwrap();
    let block = ["calibrate", "block", "--mass", "2", "--rig", "virtual", "--layout"];
    for command in [
        &["layout", "check"][..],
        &["layout", "show"],
        &["layout", "suggest", "--starts", "1"],
        &["simulate"],
        &["simulate", "--runs", "2"],
        &["virtual", "--layout"],
        &block,
    ] {
        let run = crate::program::run(&[command, &[&millimetres]].concat());
        assert!(run.says("these look like millimetres"), "{command:?}: {}", run.stderr);
    }
    let wide = folder.path().join("wide.toml").display().to_string();
    std::fs::write(&wide, text.replace("band_hz = [10.0, 120.0]", "band_hz = [10.0, 1e6]"))
        .unwrap();
    for command in [&["simulate", "--runs", "2"][..], &["virtual", "--layout"], &block] {
        let (code, value) = crate::program::answer(&[command, &[&wide]].concat());
        assert_eq!((code, &value["error"]["code"]), (2, &"setting_out_of_range".into()));
        assert!(value["error"]["message"].as_str().unwrap().contains("wide.toml:"), "{value}");
    }
}

fn wheel() -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    folder.join("wheel.toml").display().to_string()
}

#[test]
fn in_the_suspension_profile_every_method_has_its_forecast_and_every_mode_its_hits() {
    let (exit, value) = layout(&["check", &wheel(), "--bench", "wheel"]);
    assert_eq!(exit, 0);
    assert!(value["body"]["source"].as_str().unwrap().contains("bench"), "{value}");
    let shares = value["error_sources"].as_array().unwrap();
    let sum: f64 = shares.iter().map(|source| source["share"].as_f64().unwrap()).sum();
    // The shares are slopes; what hits beside the mark do in second order, a thousandth here, counts twice.
    assert!((sum - 1.0).abs() < 3e-3, "{sum}");
    let forecast = &value["forecast"];
    let answers = forecast["answers"].as_array().unwrap();
    let methods: Vec<&str> =
        answers.iter().map(|answer| answer["method"].as_str().unwrap()).collect();
    assert_eq!(methods[0], "global-fit");
    assert!(methods.contains(&"toivola-nuutila") && methods.contains(&"conti-bretl"));
    assert!(NAMES.iter().all(|name| answers[1]["sigma"][name].as_f64().unwrap() > 0.0));
    assert!(total(&forecast["combined"]) > 0.0);
    // The bound is for the best method; the methods that use less of the data are less certain.
    assert!(answers[1..].iter().all(|answer| total(answer) > total(&value)), "{forecast}");
    let modes = forecast["modes"].as_array().unwrap();
    assert_eq!(modes.len(), 6);
    assert_eq!(modes[0]["norm_indicators"].as_array().unwrap().len(), 5);
    // Without a bench the modes are assumed, and the program says which.
    let (exit, assumed) = layout(&["check", &wheel()]);
    assert_eq!(exit, 0);
    assert!(assumed["body"]["source"].as_str().unwrap().contains("assumed to hang"), "{assumed}");
}

/// The wheel's layout with other hits.
fn wheel_with_hits(folder: &TempDir, hits: &str, more: &str) -> String {
    let text = std::fs::read_to_string(wheel()).unwrap();
    let changed = text.replace(
        "hits = [\"101:+X\", \"102:+Z\", \"103:+Z\", \"104:+Y\", \"105:+X\"]",
        &format!("hits = {hits}"),
    );
    assert_ne!(text, changed);
    let path = folder.path().join("hits.toml");
    std::fs::write(&path, changed + more).unwrap();
    path.display().to_string()
}

/// The methods of a layout check that do not apply, and what prevents them.
fn blocked_methods(value: &Value) -> Vec<(&str, &Value)> {
    let methods = value["methods"].as_array().unwrap().iter();
    let blocked = methods.filter(|method| method["applicable"] == false);
    blocked.map(|method| (method["method"].as_str().unwrap(), &method["blocked_by"])).collect()
}

/// One hit across all axes moves every mode of the bench, and mass lines, which would need three hits, are not asked.
#[test]
fn in_the_suspension_profile_one_hit_is_judged_by_the_modes_that_it_moves() {
    let folder = tempfile::tempdir().unwrap();
    let node = "\n[[node]]\nid = 110\nposition_m = [0.18, -0.21, -0.02]\n\
                axes = [[0.6, 0.64, 0.48], [-0.8, 0.48, 0.36]]\n";
    let path = wheel_with_hits(&folder, "[\"110:+X\"]", node);
    let (exit, value) = layout(&["check", &path, "--bench", "wheel"]);
    assert_eq!(exit, 0, "{value}");
    assert_eq!(value["identifiable"], true);
    assert!(value["rank"].is_null() && value["condition"].is_null(), "{value}");
    assert!(value["diagnostics"].as_array().unwrap().is_empty(), "{value}");
    assert!(value["codes"].as_array().unwrap().is_empty(), "{value}");
    let blocked = blocked_methods(&value);
    assert_eq!(blocked.len(), 1, "{blocked:?}");
    assert_eq!(blocked[0].0, "modal-constant");
    let text = run(&["layout", "check", &path, "--bench", "wheel"]);
    assert!(text.stdout.contains("this layout determines all ten properties"), "{}", text.stdout);
    for words in ["rank", "condition", "fewer than three hit DOFs"] {
        assert!(!text.stdout.contains(words) && !text.stderr.contains(words), "{words}");
    }
}

/// A push along x leaves three of the assumed modes at rest, so no method that uses the modes applies.
#[test]
fn in_the_suspension_profile_what_is_not_determined_is_so_for_every_method() {
    let folder = tempfile::tempdir().unwrap();
    let path = wheel_with_hits(&folder, "[\"101:+X\"]", "");
    let (exit, value) = layout(&["check", &path]);
    assert_eq!(exit, 3, "{value}");
    assert_eq!(value["identifiable"], false);
    assert!(value["sigma"]["m"].is_null() && value["rank"].is_null());
    assert_eq!(value["error"]["code"], "ten_parameters_not_identifiable");
    let count = value["methods"].as_array().unwrap().len();
    assert_eq!(blocked_methods(&value).len(), count, "{value}");
    assert!(value["forecast"]["answers"].as_array().unwrap().is_empty(), "{value}");
}

/// The wheel's test with gentler hits and other windows, the bench hitting as the layout says: its noise is that which
/// the check predicts. Nonlinearities are drawn for each test, so what they add scatters by 10 %.
#[test]
fn in_the_suspension_profile_the_predicted_noise_is_that_of_a_test_with_these_settings() {
    let folder = tempfile::tempdir().unwrap();
    let bench_text = include_str!("../../../shared/physics/benches/wheel.toml");
    for (part, decay) in [(1.0, 0.1), (0.25, 0.1), (1.0, 0.2)] {
        let [impulses, forces, weak] = [[0.8, 1.3], [88.0, 109.0], [15.0, 25.0]]
            .map(|[low, high]| format!("= [{}, {}]", low * part, high * part));
        let bench = bench_text.replace("= [88.0, 109.0]", &forces).replace("= [15.0, 25.0]", &weak);
        assert!(bench.contains(&forces) && bench.contains(&weak));
        let bench_path = folder.path().join("bench.toml").display().to_string();
        std::fs::write(&bench_path, bench).unwrap();
        let settings = format!(
            "[test]\nimpulse_ns {impulses}\nexponential_decay_per_s = {decay}\ntrigger_n = {}",
            3.0 * part
        );
        let text = std::fs::read_to_string(wheel()).unwrap().replace("[test]", &settings);
        let path = folder.path().join("layout.toml").display().to_string();
        std::fs::write(&path, text).unwrap();
        let (exit, check) = layout(&["check", &path, "--bench", &bench_path]);
        assert_eq!(exit, 0, "{check}");
        let (exit, test) = answer(&["simulate", &path, "--bench", &bench_path]);
        assert_eq!(exit, 0, "{test}");
        let averaged = test["suspension"]["noise_m_per_s2_per_n"].as_f64().unwrap();
        let hits = check["hits_per_dof"].as_f64().unwrap();
        let ratio = averaged * hits.sqrt() / check["noise_m_per_s2_per_n"].as_f64().unwrap();
        assert!((ratio - 1.0).abs() < 0.15, "{part}, {decay}: {ratio}");
    }
}

/// 200 kg: the noise that is assumed is more than 1/mass, and may also be stated.
#[test]
fn in_the_suspension_profile_noise_may_be_stated_for_a_heavy_object() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(wheel()).unwrap();
    let path = folder.path().join("heavy.toml").display().to_string();
    std::fs::write(&path, text.replace("mass_kg = 17.295", "mass_kg = 200.0")).unwrap();
    let (exit, value) = layout(&["check", &path, "--noise", "1.2"]);
    assert!((value["noise"].as_f64().unwrap() - 1.2).abs() < 1e-12, "{exit} {value}");
    let (exit, value) = layout(&["check", &example(1), "--noise", "1.2"]);
    assert_eq!((exit, &value["error"]["code"]), (2, &"usage".into()));
    let message = value["error"]["message"].as_str().unwrap();
    assert!(message.contains("up to 1"), "{message}");
}

#[test]
fn hits_that_leave_modes_without_motion_are_named_before_the_test() {
    let folder = tempfile::tempdir().unwrap();
    let path = wheel_with_hits(&folder, "[\"102:+Z\", \"103:+Z\", \"104:+Z\"]", "");
    let (exit, value) = layout(&["check", &path]);
    assert_eq!(exit, 3);
    assert_eq!(value["identifiable"], false);
    let modes = value["forecast"]["modes"].as_array().unwrap();
    // Hits along z leave the motions along x and y and the turn about z, which is the first of the assumed turns.
    let unmoved: Vec<bool> = modes.iter().map(|mode| !mode["better_hit"].is_null()).collect();
    assert_eq!(unmoved, [true, true, false, true, false, false], "{value}");
    let words = value["error"]["message"].as_str().unwrap();
    assert!(words.contains("mode 1 hardly shows under any hit"), "{words}");
}

#[test]
fn a_suggestion_for_the_suspension_profile_is_no_worse_than_the_layout_of_the_file() {
    let (exit, value) = layout(&["suggest", &wheel(), "--keep-sensors", "--starts", "1"]);
    assert_eq!(exit, 0);
    assert!(total(&value) <= total(&value["before"]), "{value}");
    assert!(!value["forecast"]["answers"].as_array().unwrap().is_empty());
}

/// A bracket of 120 g: the weakest hit of 8 N exceeds 16 g at its far sensors. On the frame of 1.23 kg it does not.
#[test]
fn masses_outside_of_what_sensors_and_hammer_can_do_are_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let bracket = |more: &str| {
        let path = folder.path().join("bracket.toml");
        let text = format!(
            "sensors = [1, 2, 3]\nhits = [\"2:+Z\", \"3:+Z\", \"2:+Y\", \"3:+X\", \"1:+X\"]\nnode = [\n\
             {{ id = 1, position_m = [0.0, 0.0, 0.0] }},\n{{ id = 2, position_m = [0.08, 0.0, 0.0] }},\n\
             {{ id = 3, position_m = [0.0, 0.08, 0.03] }},\n]\n{more}"
        );
        std::fs::write(&path, text).unwrap();
        run(&["layout", "check", &path.display().to_string()])
    };
    for stated in [
        "[reference]\nmass_kg = 0.03\n",
        "[prior]\nmass_kg = { value = 0.03, sigma = 0.001 }\n",
        "[reference]\nmass_kg = 0.12\ninertia_kg_m2 = [[1e-5, 0.0, 0.0], [0.0, 1e-5, 0.0], [0.0, 0.0, 1.5e-5]]\n\
         center_of_mass_m = [0.02, 0.02, 0.01]\n",
    ] {
        let checked = bracket(stated);
        assert!(
            checked.says("every hit of 8 N, the weakest that is accepted"),
            "{stated}: {}",
            checked.stderr
        );
    }
    let heavy = bracket("[reference]\nmass_kg = 500.0\n");
    assert!(heavy.says("little more than noise"), "{}", heavy.stderr);
    for fits in ["", "[reference]\nmass_kg = 2.0\n"] {
        let checked = bracket(fits);
        assert!(!checked.says("the weakest that is accepted"), "{}", checked.stderr);
        assert!(
            checked.stdout.contains("masses: sensors of ±16 g and hits from 8 N"),
            "{}",
            checked.stdout
        );
    }
}

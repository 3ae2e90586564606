//! The JSON output of calibration commands.

use serde_json::Value;

use crate::program::{answer, success};

/// The arguments of `calibrate` on the simulated block with its flash in this file.
fn on_block<'a>(arguments: &[&'a str], flash: &'a str) -> Vec<&'a str> {
    let block_rig = ["--rig", "virtual", "--seed", "7", "--flash", flash];
    [&["calibrate"], arguments, &block_rig].concat()
}

/// Runs `calibrate` on the simulated block with its flash in this file.
fn calibrate(arguments: &[&str], flash: &str) -> Value {
    success(&on_block(arguments, flash))
}

#[test]
fn the_json_of_a_block_test_has_the_rc_cutoffs_that_the_rig_stores() {
    let folder = tempfile::tempdir().unwrap();
    let flash = folder.path().join("flash.bin").display().to_string();
    let value = calibrate(&["block", "--mass", "2.0"], &flash);
    let kept = calibrate(&["show"], &flash);
    let cutoffs = value["block"]["rc_cutoffs"].as_array().unwrap();
    assert_eq!(cutoffs.len(), 9);
    let mut changed = 0;
    for (k, cutoff) in cutoffs.iter().enumerate() {
        let (sensor, axis) = (k / 3, k % 3);
        assert_eq!(cutoff["sensor"], sensor + 1);
        assert_eq!(cutoff["axis"], ["x", "y", "z"][axis]);
        assert!(cutoff["reason"].is_null(), "{cutoff}");
        let number = |name: &str| cutoff[name].as_f64().unwrap();
        let [measured, sigma, before] = ["cutoff_hz", "sigma_hz", "before_hz"].map(number);
        let is_changed = (measured - before).abs() > 3.0 * sigma;
        changed += usize::from(is_changed);
        assert_eq!(cutoff["verdict"], if is_changed { "changed" } else { "kept" });
        // The rig stores it in single precision.
        let stored = kept["sensors"][sensor]["rc_cutoff_hz"][axis].as_f64().unwrap();
        let expected = if is_changed { measured } else { before };
        assert!((stored / expected - 1.0).abs() < 1e-6, "{stored} {cutoff}");
    }
    // Cutoffs with a tolerance of 2 % (1 σ) are found to 0.25 %: most of nine are more than three of
    // these sigmas off.
    assert!(changed > 4, "{cutoffs:?}");
    let hammer = kept["hammer"]["rc_cutoff_hz"].as_f64().unwrap();
    assert!((hammer - 497.359).abs() < 1e-3, "{hammer}");
}

#[test]
fn a_tumble_and_a_block_test_are_stored_unless_told_otherwise_and_the_calibration_passes_its_check()
{
    let folder = tempfile::tempdir().unwrap();
    let [flash, readings] =
        ["flash.bin", "readings.toml"].map(|file| folder.path().join(file).display().to_string());
    let before = calibrate(&["show"], &flash);
    let tumble = ["tumble", "--readings", &readings];
    let tried = calibrate(&[&tumble[..], &["--dry-run"]].concat(), &flash);
    assert_eq!((&tried["stored"], &tried["tumble"]["hum"]), (&false.into(), &Value::Array(vec![])));
    assert_eq!(calibrate(&["show"], &flash), before);
    let tumbled = calibrate(&tumble, &flash);
    let kept = calibrate(&["show"], &flash);
    assert_eq!((&tumbled["stored"], &tumbled["sensors"]), (&true.into(), &kept["sensors"]));
    for (computed, kept) in
        [0, 1, 2].map(|k| (&tumbled["tumble"]["sensors"][k], &kept["sensors"][k]))
    {
        for axis in 0..3 {
            let zero = |sensor: &Value| sensor["zero_v"][axis].as_f64().unwrap();
            // The rig stores it in single precision.
            assert!((zero(computed) - zero(kept)).abs() < 1e-6, "{computed} {kept}");
        }
    }
    let block = calibrate(&["block", "--mass", "2"], &flash);
    assert_eq!(block["block"]["hammer"]["consistent"], true);
    let checked = calibrate(&["verify", "--mass", "2"], &flash);
    assert_eq!(checked["calibrated"], block["date"]);
    let sensors = checked["sensors"].as_array().unwrap();
    assert!(
        sensors.len() == 3 && sensors.iter().all(|sensor| sensor["outcome"] == "pass"),
        "{checked}"
    );
    assert_eq!(checked["channels"].as_array().unwrap().len(), 9);
}

#[test]
fn the_demonstration_calibrates_and_then_measures_better() {
    let value = success(&["calibrate", "demo"]);
    assert_eq!(value["calibration"]["method"], "tumble-and-block");
    for test in value["tests"].as_array().unwrap() {
        let error = |key: &str| test["rms_error_percent_of_scale"][key].as_f64().unwrap();
        assert!(error("calibrated") < error("data_sheet"), "{test}");
    }
}

#[test]
fn a_mistyped_mass_is_refused_with_the_one_that_agrees_and_nothing_is_stored() {
    let folder = tempfile::tempdir().unwrap();
    let flash = folder.path().join("flash.bin").display().to_string();
    let before = calibrate(&["show"], &flash);
    let (exit, value) = answer(&on_block(&["block", "--mass", "20"], &flash));
    assert_eq!(exit, 3, "{value}");
    let message = value["error"]["message"].as_str().unwrap();
    assert!(message.contains("check --mass"), "{message}");
    let (_, agreeing) =
        message.split_once("a block of ").and_then(|(_, m)| m.split_once("a block of ")).unwrap();
    let agreeing: f64 = agreeing.split_once(" kg").unwrap().0.parse().unwrap();
    // The block has 2 kg, and the median of nine sensitivities with a tolerance of 5 % is good to 2 %; five times that.
    assert!((agreeing / 2.0 - 1.0).abs() < 0.1, "{message}");
    assert_eq!(calibrate(&["show"], &flash), before);
    let (exit, value) = answer(&on_block(&["verify", "--mass", "20"], &flash));
    assert_eq!(exit, 3, "{value}");
}

#[test]
fn impossible_values_are_refused_before_any_hit() {
    let folder = tempfile::tempdir().unwrap();
    let flash = folder.path().join("flash.bin").display().to_string();
    for (arguments, named) in [
        (["block", "--mass", "1e9"].as_slice(), "--mass"),
        (&["block", "--mass", "2", "--temperature", "1e9"], "--temperature"),
        (&["block", "--mass", "2", "--sensor-ids", "a,b"], "--sensor-ids"),
    ] {
        let (exit, value) = answer(&on_block(arguments, &flash));
        assert_eq!(exit, 2, "{value}");
        assert!(value["error"]["message"].as_str().unwrap().contains(named), "{value}");
    }
}

/// A campaign that was left is refused before the person is asked to turn the block.
#[cfg(unix)]
#[test]
fn a_tumble_test_is_refused_before_it_prompts_when_the_rig_has_a_campaign() {
    use crate::program::{layout_with_hits, run};
    use crate::virtual_process::VirtualProcess;
    use std::io::{BufRead, BufReader};
    use std::process::{Command, Stdio};

    let rig = VirtualProcess::start(&[]);
    let folder = tempfile::tempdir().unwrap();
    let layout = layout_with_hits(folder.path(), 50);
    let mut measure = Command::new(env!("CARGO_BIN_EXE_massline"))
        .args(["measure", &layout, "--port", &rig.port])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(measure.stderr.take().unwrap()).lines();
    assert!(lines.map_while(Result::ok).any(|line| line.ends_with("good")));
    measure.kill().unwrap();
    measure.wait().unwrap();
    let readings = folder.path().join("readings.toml").display().to_string();
    let tumble = run(&["calibrate", "tumble", "--readings", &readings, "--port", &rig.port]);
    assert_eq!(tumble.exit, 4, "{}", tumble.stderr);
    assert!(tumble.says("in a campaign of `massline measure`; finish it with that command"));
    assert!(tumble.says("`massline device abort`") && !tumble.says("turn the sensors"));
}

#[test]
fn a_block_test_whose_hits_are_all_rejected_ends() {
    let folder = tempfile::tempdir().unwrap();
    let bench = folder.path().join("hard.toml").display().to_string();
    std::fs::write(
        &bench,
        "elastic_mode = []\n[tap]\nforce_n = [500.0, 600.0]\n[body]\nmass_kg = 2.0\n\
         center_of_mass_m = [0.0, 0.0, 0.0]\ninertia_kg_m2 = [0.01, 0.01, 0.01, 0.0, 0.0, 0.0]\n",
    )
    .unwrap();
    let block = ["calibrate", "block", "--mass", "2", "--rig", "virtual", "--bench", &bench];
    let (exit, value) = answer(&block);
    assert_eq!((exit, &value["error"]["code"]), (3, &"always_rejected".into()), "{value}");
}

/// The object of another bench is not that of the default layout.
#[cfg(unix)]
#[test]
fn a_virtual_rig_with_another_object_asks_for_its_layout() {
    use std::io::{BufRead, BufReader};
    use std::process::{Command, Stdio};

    let mut rig = Command::new(env!("CARGO_BIN_EXE_massline"))
        .args(["virtual", "--bench", "block"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(rig.stderr.take().unwrap()).lines().map_while(Result::ok);
    let text = lines.take(2).collect::<Vec<_>>().join(" ");
    rig.kill().unwrap();
    rig.wait().unwrap();
    assert!(text.contains("without --layout"), "{text}");
}

//! `massline simulate` as other programs read it.

use serde_json::Value;

const LAYOUT: &str = "examples/three-bar-test-1.toml";

fn simulate(arguments: &[&str]) -> (Option<i32>, Value) {
    let output = assert_cmd::Command::cargo_bin("massline")
        .unwrap()
        .args(["simulate", LAYOUT, "--json"])
        .args(arguments)
        .output()
        .unwrap();
    (output.status.code(), serde_json::from_slice(&output.stdout).unwrap())
}

#[test]
fn many_runs_tell_of_every_method_and_property() {
    let (code, value) = simulate(&["--runs", "3", "--budget", "bench", "--seed", "4"]);
    assert_eq!(code, Some(0));
    assert_eq!((&value["runs"], &value["seed"]), (&3.into(), &4.into()));
    let names: Vec<_> = value["methods"].as_array().unwrap().iter().map(|m| &m["method"]).collect();
    assert_eq!(names, ["maximum-likelihood", "inertia-restraint"]);
    for method in value["methods"].as_array().unwrap() {
        let properties = method["properties"].as_array().unwrap();
        let names: Vec<_> = properties.iter().map(|p| p["name"].as_str().unwrap()).collect();
        assert_eq!(names, massline_shared::layout::PROPERTIES);
        for p in properties {
            let of = |key: &str| p[key].as_f64().unwrap();
            assert!(of("rms") >= of("bias").abs() && of("bound") > 0.0, "{p}");
            // Both are printed with all their digits.
            assert!((of("ratio") - of("rms") / of("bound")).abs() < 1e-9, "{p}");
            assert!((0.0..=1.0).contains(&of("coverage95")), "{p}");
        }
    }
}

#[test]
fn a_fault_on_the_bench_is_named_beside_the_result() {
    let (code, value) = simulate(&["--fault", "flip:2y"]);
    assert_eq!(code, Some(0));
    let suspect = &value["single_faults"]["suspects"][0];
    assert_eq!((&suspect["code"], &suspect["sensor"]), (&"sensor_axes_suspect".into(), &2.into()));
    assert!(suspect["message"].as_str().unwrap().contains("y axis reversed"), "{suspect}");
    let said = value["diagnostics"].as_array().unwrap();
    assert!(said.iter().any(|d| d["code"] == "sensor_axes_suspect" && d["severity"] == "warning"));
}

#[test]
fn a_fault_that_cannot_be_is_bad_input() {
    let (code, value) = simulate(&["--fault", "flip:7x"]);
    assert_eq!(code, Some(2));
    assert_eq!(value["error"]["code"], "bench_does_not_fit");
    let (code, _) = simulate(&["--fault", "drop:1"]);
    assert_eq!(code, Some(2));
    let (code, _) = simulate(&["--runs", "2", "--rig", "virtual"]);
    assert_eq!(code, Some(2));
}

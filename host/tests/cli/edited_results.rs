//! Archives and documents that were edited: what no test gives is drawn or refused by name, and nothing crashes or
//! hangs.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::program::{data, run, success, text};

/// A change of an archive.
type Change<'a> = &'a dyn Fn(&mut Value);

/// The archive with the records of three hits, changed.
pub fn edited(folder: &Path, name: &str, change: Change<'_>) -> String {
    let bytes = fs::read(data("pictures/records.massline")).unwrap();
    let mut archive: Value = serde_json::from_slice(&bytes).unwrap();
    change(&mut archive);
    let path = folder.join(format!("{name}.massline"));
    fs::write(&path, archive.to_string()).unwrap();
    text(&path)
}

#[test]
fn edited_archives_are_drawn_or_refused_but_nothing_panics() {
    let folder = tempfile::tempdir().unwrap();
    let pictures = text(&folder.path().join("pictures"));
    let fourth_sensor = |archive: &mut Value| {
        let sensors = archive["layout"]["resolved"]["sensors"].as_array_mut().unwrap();
        let mut fourth = sensors[0].clone();
        fourth["node"] = json!(9);
        sensors.push(fourth);
    };
    let one_bin = |archive: &mut Value| {
        let spectra = &mut archive["spectra"][0];
        let shorten = |list: &mut Value| list.as_array_mut().unwrap().truncate(1);
        shorten(&mut spectra["force_auto"]);
        for key in ["cross", "response_auto"] {
            spectra[key].as_array_mut().unwrap().iter_mut().for_each(shorten);
        }
    };
    let scans = |archive: &mut Value, count: usize| {
        for record in archive["hit_records"].as_array_mut().unwrap() {
            record["codes"].as_array_mut().unwrap().truncate(count);
        }
    };
    let changes: [(&str, Change<'_>); 10] = [
        ("fourth-sensor", &fourth_sensor),
        ("one-bin", &one_bin),
        ("no-scan", &|archive| scans(archive, 0)),
        ("one-scan", &|archive| scans(archive, 1)),
        ("few-scans", &|archive| scans(archive, 5)),
        ("silent-hammer", &|archive| {
            for record in archive["hit_records"].as_array_mut().unwrap() {
                for scan in record["codes"].as_array_mut().unwrap() {
                    scan[0] = json!(137);
                }
            }
        }),
        ("reversed-band", &|archive| {
            archive["result"]["dofs"][0]["band_hz"] = json!([120.0, 10.0]);
        }),
        ("further-hits", &|archive| {
            let records = archive["hit_records"].as_array_mut().unwrap();
            let one = records[0].clone();
            records.extend((0..66).map(|_| one.clone()));
        }),
        ("other-spectra", &|archive| archive["spectra"][0]["dof"] = json!("<b>")),
        ("other-dof", &|archive| {
            archive["hit_records"][0]["dof"] = json!("../../1:+Y");
        }),
    ];
    for (name, change) in changes {
        let archive = edited(folder.path(), name, change);
        let plotted = run(&["plot", &archive, "-o", &pictures]);
        assert!([0, 2, 3].contains(&plotted.exit), "{name}: {} {}", plotted.exit, plotted.stderr);
    }
    let bits = edited(folder.path(), "bits", &|archive| {
        archive["rig"]["sampler"]["adc"]["bits"] = json!(60);
    });
    let refused = run(&["plot", &bits, "-o", &pictures]);
    assert!(refused.exit == 2 && refused.says("rig.sampler.adc"), "{}", refused.stderr);
    let further = folder.path().join("pictures/further-hits-hits-1+Y.svg");
    let further = fs::read_to_string(further).unwrap();
    assert!(further.contains("the first 64 of 69 hits at 1:+Y"), "{further:.900}");
}

/// Each of these has hung or crashed the program.
#[test]
fn numbers_that_no_test_gives_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let pictures = text(&folder.path().join("pictures"));
    let resolution = |value: Value| {
        move |archive: &mut Value| archive["spectra"][0]["resolution_hz"] = value.clone()
    };
    let changes: [(&str, Change<'_>, &str); 3] = [
        ("no-resolution", &resolution(json!(0.0)), "spectra[0]: resolution_hz"),
        ("negative-resolution", &resolution(json!(-1.0)), "spectra[0]: resolution_hz"),
        (
            "long-direction",
            &|archive| {
                archive["layout"]["resolved"]["hits"][0]["direction"] = json!([1e200, 0.0, 0.0]);
            },
            "a direction or an axis has no unit length",
        ),
    ];
    for (name, change, phrase) in changes {
        let archive = edited(folder.path(), name, change);
        let refused = run(&["plot", &archive, "-o", &pictures]);
        assert!(refused.exit == 2 && refused.says(phrase), "{name}: {}", refused.stderr);
    }
    let mode = |indicator: f64| {
        let zeros = [0.0; 6];
        json!({
            "frequency_hz": { "value": 3.0, "sigma": 0.1 },
            "damping_ratio": { "value": 0.01, "sigma": 0.001 },
            "shape": { "value": zeros, "sigma": zeros }, "complexity": 0.0, "better_hit": null,
            "norm_indicators": [{ "dof": "1:+Y", "value": indicator }],
        })
    };
    let modes = |modes: Vec<Value>, assurance: Vec<Vec<f64>>| {
        json!({
            "schema_version": 1, "band_hz": [0.5, 12.5], "modes": modes,
            "modal_assurance": assurance, "orders": [],
            "modes_missing": 0, "hit_for_missing": null,
        })
    };
    let path = folder.path().join("modes.json");
    for (document, phrase) in [
        (modes(vec![mode(-1e300)], vec![vec![1.0]]), "norm_indicator is negative"),
        (modes(vec![mode(0.5)], vec![vec![0.5; 2000]; 2000]), "modal_assurance: it is not 1 by 1"),
        (modes(vec![mode(0.5); 25], vec![vec![0.5; 25]; 25]), "there are 25"),
    ] {
        fs::write(&path, document.to_string()).unwrap();
        let refused = run(&["plot", &text(&path), "-o", &pictures]);
        assert!(refused.exit == 2 && refused.says(phrase), "{phrase}: {}", refused.stderr);
    }
}

#[test]
fn malformed_details_and_bands_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let archive = text(&data("pictures/records.massline"));
    let layout = text(&data("../../host/examples/three-bar-test-1.toml"));
    let document = success(&["solve", &archive]);
    let path = folder.path().join("solved.json");
    let plot = |document: &Value, picture: &str| {
        fs::write(&path, document.to_string()).unwrap();
        let to = text(folder.path());
        run(&[
            "plot",
            &text(&path),
            "--layout",
            &layout,
            "--picture",
            picture,
            "-o",
            &to,
            "--force",
        ])
    };
    assert_eq!(plot(&document, "pulls").exit, 0);
    assert_eq!(plot(&document, "budget").exit, 0);
    let mut changed = document.clone();
    changed["details"]["sensors"][0]["pull"] = json!("much");
    let refused = plot(&changed, "pulls");
    assert!(refused.exit == 2 && refused.says("details.sensors[0].pull"), "{}", refused.stderr);
    let mut huge = document.clone();
    huge["details"]["hits"][0]["pull"] = json!(1e300);
    huge["details"]["hits"][0]["dof"] = json!("<b>".repeat(4000));
    huge["details"]["error_budget"]["constant_scale"]["learned"] = json!(1e308);
    assert_eq!(plot(&huge, "pulls").exit, 0);
    assert_eq!(plot(&huge, "budget").exit, 0);
    let mut band = document;
    band["suspension"] = json!({
        "band_hz": [9.0, 2.0],
        "modes": [],
        "modal_assurance": [],
        "orders": [],
        "modes_missing": 6,
    });
    let refused = plot(&band, "mac");
    assert!(refused.exit == 2 && refused.says("is no band"), "{}", refused.stderr);
}

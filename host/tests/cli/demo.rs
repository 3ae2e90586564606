//! The JSON output of the demo.

use std::fs;

use crate::program::{run, success};

/// Largest page, bytes: one that can be mailed.
const MOST: usize = 2 << 20;

#[test]
fn the_json_of_the_demo_has_four_tests_with_truth_and_results() {
    let value = success(&["demo", "--bench", "ideal", "--seed", "2", "--hits", "3"]);
    let tests = value["tests"].as_array().unwrap();
    assert_eq!(tests.len(), 4);
    for (k, test) in tests.iter().enumerate() {
        assert_eq!(test["name"], format!("three-bar-test-{}", k + 1));
        assert_eq!(test["seed"], 2);
        let truth: Vec<f64> =
            test["truth"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
        assert_eq!(truth.len(), 10);
        let result = &test["results"][0];
        assert_eq!(result["method"], "maximum-likelihood");
        let linear = &test["results"][1];
        assert_eq!(linear["method"], "inertia-restraint");
        let measured = result["mass_kg"]["value"].as_f64().unwrap();
        // The mass error that the test reports must match its own mass and truth.
        let error = test["error_percent_of_scale"][0].as_f64().unwrap();
        assert!((100.0 * (measured / truth[0] - 1.0) - error).abs() < 1e-9);
        assert_eq!(test["mass_lines"][0]["hits"], 3);
        assert_eq!(result["covariance"].as_array().unwrap().len(), 10);
        let codes = linear["diagnostics"].as_array().unwrap();
        assert!(codes.iter().any(|d| d["code"] == "sigma_covers_scatter_only"), "{linear}");
    }
}

#[test]
fn the_same_seed_gives_the_same_numbers_and_another_seed_others() {
    let results = |seed: &str| {
        success(&["demo", "--seed", seed, "--hits", "3"])["tests"][0]["results"].clone()
    };
    assert_eq!(results("5"), results("5"));
    assert_ne!(results("5"), results("6"));
}

#[test]
fn the_text_says_what_the_standard_deviations_cover() {
    let demo = run(&["demo", "--hits", "3"]);
    let (text, progress) = (demo.stdout, demo.stderr);
    for name in ["± 95 %", "test 1", "three-bar frame, test 4: maximum-likelihood", "worst", "J_yz"]
    {
        assert!(text.contains(name), "{name}\n{text}");
    }
    // When stderr is not a terminal, progress is plain lines.
    assert!(progress.lines().filter(|line| line.ends_with("good")).count() >= 36, "{progress}");
    assert!(!progress.contains('\x1b'));
}

#[test]
fn the_report_holds_the_four_tests_and_does_not_change_them() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("demo.html").display().to_string();
    let with = success(&["demo", "--report", &page]);
    let without = success(&["demo"]);
    assert_eq!(with["report"], page);
    assert!(without["report"].is_null());
    assert_eq!(with["tests"], without["tests"]);
    let text = fs::read_to_string(&page).unwrap();
    assert!(text.len() < MOST, "{} bytes", text.len());
    for number in 1..=4 {
        let solved = success(&["solve", &format!("{page}#result-{number}")]);
        let of_host = &with["tests"][number - 1]["results"];
        assert_eq!(&solved["results"], of_host, "test {number}");
        // Beside the accepted hits, those that the rig has rejected are told of.
        assert!(text.contains(&format!("three-bar frame, test {number}")));
    }
    assert!(text.contains("is too small for a clear response"));
    // All hits of every DOF are drawn.
    assert_eq!(text.matches("<summary>All hits overlaid, hits at ").count(), 12);
    assert!(!text.contains("has no room for the pictures"));
}

#[test]
fn the_wheel_has_a_report_with_its_responses() {
    let folder = tempfile::tempdir().unwrap();
    for more in [&[][..], &["--tyre"]] {
        let page = folder.path().join("wheel.html").display().to_string();
        let wheel = ["demo", "wheel", "--set", "all", "--report", &page, "--force"];
        assert_eq!(success(&[&wheel[..], more].concat())["report"], page);
        let text = fs::read_to_string(&page).unwrap();
        assert!(text.len() < MOST, "{} bytes", text.len());
        for words in ["frequency responses to hits at 101:+X", "imaginary part", "Norm Indicator"] {
            assert!(text.contains(words), "{more:?}: {words}");
        }
    }
    let without = run(&["demo", "wheel", "--set", "A"]);
    assert!(without.says("--report page.html` makes a page"), "{}", without.stderr);
}

#[test]
fn a_demonstration_without_a_report_offers_one() {
    let demo = run(&["demo", "--hits", "3"]);
    assert!(
        demo.says("next: `massline demo --hits 3 --report page.html` makes a page"),
        "{}",
        demo.stderr
    );
}

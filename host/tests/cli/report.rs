//! `massline report`: the page of a committed archive, what it holds, and texts that look like markup.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

#[cfg(unix)]
use crate::program::run_in_shell;
use crate::program::{run, success};
#[cfg(unix)]
use crate::rig::Rig;

/// Largest page, bytes: one that can be mailed.
const MOST: usize = 2 << 20;

pub fn archive() -> String {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/archive/version-1.massline");
    path.display().to_string()
}

/// The same to be edited, without its checksum.
pub fn editable_archive() -> Value {
    let mut value: Value = serde_json::from_slice(&fs::read(archive()).unwrap()).unwrap();
    value.as_object_mut().unwrap().remove("checksum").unwrap();
    value
}

/// The page of these results.
pub fn page(folder: &Path, results: &[&str]) -> (PathBuf, String) {
    let path = folder.join("page.html");
    let name = path.display().to_string();
    let mut arguments = vec!["report"];
    arguments.extend(results);
    arguments.extend(["-o", &name, "--force"]);
    let printed = success(&arguments);
    assert_eq!(printed["written"], name);
    let text = fs::read_to_string(&path).unwrap();
    (path, text)
}

#[test]
fn a_page_has_the_ten_properties_and_needs_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let (_, text) = page(folder.path(), &[&archive()]);
    for words in
        ["The ten properties", "moment of inertia about x", "How it was measured", "<canvas"]
    {
        assert!(text.contains(words), "{words}");
    }
    // The address of the SVG name space is a name; nothing is fetched from it.
    let other = text.replace("http://www.w3.org/2000/svg", "");
    for address in ["http://", "https://", "src=", "@import", "url("] {
        assert!(!other.contains(address), "{address}");
    }
    assert!(text.len() < MOST, "{} bytes", text.len());
}

/// Under the table of the answer, under that of the methods, and with two results under their comparison.
#[test]
fn the_convention_of_the_inertia_stands_under_every_table() {
    let folder = tempfile::tempdir().unwrap();
    for (results, tables) in [(1, 2), (2, 5)] {
        let (_, text) = page(folder.path(), &vec![&*archive(); results]);
        let below = text.split("</table>").skip(1);
        let stated = below.filter(|text| {
            let text = text.trim_start().trim_start_matches("</div>").trim_start();
            text.starts_with(
                "<p class=\"remark\">J about the centre of mass, body axes; J_xy = −∫xy dm</p>",
            )
        });
        assert_eq!(stated.count(), tables, "{results} results");
    }
}

#[test]
fn the_methods_are_compared_in_all_ten_properties_and_with_their_combination() {
    let folder = tempfile::tempdir().unwrap();
    let (_, text) = page(folder.path(), &[&archive()]);
    let start = text.find("Do the methods agree?").expect("the comparison");
    let table = &text[start..start + text[start..].find("</table>").unwrap()];
    for index in ["x", "y", "z", "xx", "yy", "zz", "xy", "xz", "yz"] {
        assert!(table.contains(&format!("<sub>{index}</sub>")), "{index}: {table}");
    }
    let combined =
        table.lines().find(|line| line.contains("<bdi>combined</bdi>")).expect("its row");
    assert_eq!(combined.matches("<td").count(), 10, "{combined}");
    assert_eq!(combined.matches('±').count(), 10, "{combined}");
}

#[test]
fn a_body_that_cannot_be_is_said_to_have_no_ellipsoid() {
    let folder = tempfile::tempdir().unwrap();
    let mut document = success(&["solve", &archive()]);
    for answer in document["results"].as_array_mut().unwrap() {
        answer["inertia_kg_m2"]["value"] =
            json!([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 9.0]]);
        answer["interval95"] = Value::Null;
    }
    let path = folder.path().join("solved.json").display().to_string();
    fs::write(&path, document.to_string()).unwrap();
    let layout = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("examples/three-bar-test-1.toml")
        .display()
        .to_string();
    let (_, text) = page(folder.path(), &[&path, "--layout", &layout]);
    assert!(text.contains("Green: centre of mass; no real body"), "{text:.200}");
    assert!(!text.contains("principal axes and the ellipsoid"));
    let (_, text) = page(folder.path(), &[&archive()]);
    assert!(text.contains("Green: centre of mass, principal axes and the ellipsoid"));
}

#[test]
fn a_page_is_solved_like_its_archive() {
    let folder = tempfile::tempdir().unwrap();
    let (path, _) = page(folder.path(), &[&archive()]);
    let of_page = success(&["solve", &path.display().to_string()]);
    let of_archive = success(&["solve", &archive()]);
    assert_eq!(of_page, of_archive);
}

#[test]
fn of_two_results_in_a_page_one_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let (path, text) = page(folder.path(), &[&archive(), &archive()]);
    assert!(text.contains("side by side"));
    let links: Vec<&str> =
        text.split("href=\"#").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    assert!(links.contains(&"result-2-pictures"), "{links:?}");
    for to in links {
        assert_eq!(text.matches(&format!("id=\"{to}\"")).count(), 1, "{to}");
    }
    let name = path.display().to_string();
    let none = run(&["solve", &name]);
    assert!(none.exit == 2 && none.says("#result-1"), "{}", none.stderr);
    let second = success(&["solve", &format!("{name}#result-2")]);
    assert_eq!(second, success(&["solve", &archive()]));
    let third = run(&["solve", &format!("{name}#result-3")]);
    assert!(third.exit == 2 && third.says("holds 2 results"), "{}", third.stderr);
}

#[cfg(unix)]
#[test]
fn a_page_of_one_result_of_a_page_does_not_replace_it() {
    let folder = tempfile::tempdir().unwrap();
    let (path, both) = page(folder.path(), &[&archive(), &archive()]);
    let here = format!("cd '{}'; exec \"$0\" \"$@\"", folder.path().display());
    let second = run_in_shell(&here, &["report", "page.html#result-2", "--force"]);
    assert_eq!(second.exit, 0, "{}", second.stderr);
    assert!(folder.path().join("page-result-2.html").is_file(), "{}", second.stdout);
    let itself = run_in_shell(&here, &["report", "page.html", "--force"]);
    assert!(itself.exit == 2 && itself.says("page.html is the result itself"), "{}", itself.stderr);
    assert_eq!(fs::read_to_string(&path).unwrap(), both);
    let drawn = run_in_shell(&here, &["plot", "page.html#result-2", "--picture", "layout"]);
    assert!(drawn.stdout.contains("page-result-2-layout.svg"), "{}", drawn.stderr);
}

#[test]
fn a_page_without_mass_lines_says_what_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let solved = folder.path().join("solved.json").display().to_string();
    fs::write(&solved, success(&["solve", &archive()]).to_string()).unwrap();
    let (path, _) = page(folder.path(), &[&solved]);
    let refused = run(&["solve", &path.display().to_string()]);
    assert!(
        refused.exit == 2 && refused.says("not an archive with mass lines"),
        "{}",
        refused.stderr
    );
}

/// Markup, signs that turn the direction of text, and a text without end.
#[test]
fn texts_of_a_result_are_text() {
    let folder = tempfile::tempdir().unwrap();
    let hostile = [
        "</title><script>alert('title')</script>".to_owned(),
        "\u{202e}desrever <img src=x onerror=alert(1)>".to_owned(),
        "<b>&".repeat(1024),
    ];
    for title in hostile {
        let mut value = editable_archive();
        value["layout"]["title"] = title.clone().into();
        let toml = value["layout"]["toml"].as_str().unwrap();
        let first = toml.lines().find(|line| line.starts_with("title")).unwrap();
        let statements = format!("\n[report]\nsupport = {0}\n", Value::from(title.as_str()));
        let changed =
            toml.replace(first, &format!("title = {}", Value::from(title.as_str()))) + &statements;
        value["layout"]["toml"] = changed.into();
        let path = folder.path().join("hostile.massline");
        fs::write(&path, value.to_string()).unwrap();
        let (_, text) = page(folder.path(), &[&path.display().to_string()]);
        for markup in ["<script>alert", "<img", "<b>"] {
            assert!(!text.contains(markup), "{markup} in the page of {title:.40}");
        }
        // The page's own scripts: the test in space, the result, and the one that turns.
        assert_eq!(text.matches("<script").count(), 3, "{title:.40}");
        assert!(text.len() < MOST);
    }
}

#[test]
fn what_is_no_result_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let other = folder.path().join("other.html");
    fs::write(&other, "<!DOCTYPE html><p>hello").unwrap();
    let refused = run(&["report", &other.display().to_string(), "-o", "/nowhere/page.html"]);
    assert!(refused.exit == 2 && refused.says("nowhere"), "{}", refused.stderr);
    let page = folder.path().join("page.html").display().to_string();
    let refused = run(&["report", &other.display().to_string(), "-o", &page]);
    assert!(refused.exit == 2 && refused.says("holds no result"), "{}", refused.stderr);
    success(&["report", &archive(), "-o", &page]);
    let again = run(&["report", &archive(), "-o", &page]);
    assert!(again.exit == 2 && again.says("--force"), "{}", again.stderr);
}

#[cfg(unix)]
#[test]
fn every_hit_of_a_measurement_has_its_verdict_in_the_page() {
    let rig = Rig::start(&["--fast"]);
    let layout = rig.layout(3);
    let path = rig.folder.path().join("a.massline").display().to_string();
    // Some hits of the bench are weaker than that.
    let text = fs::read_to_string(&layout).unwrap();
    fs::write(&layout, text.replace("[test]", "[test]\nmin_peak_force_n = 20.0")).unwrap();
    let (exit, measured) = rig.run(&["measure", &layout, "-o", &path]);
    assert_eq!(exit, 0, "{measured}");
    let log = measured["hit_log"].as_array().unwrap();
    let count = |verdict: &str| log.iter().filter(|hit| hit["verdict"] == verdict).count();
    assert_eq!(count("accepted"), 9, "{log:?}");
    let weak = log.iter().find(|hit| hit["verdict"] == "rejected").unwrap();
    assert_eq!(weak["findings"][0]["code"], "too_weak");
    assert!(weak["peak_force_n"].as_f64().unwrap() < 20.0, "{weak}");
    assert!(weak["graded"].is_string(), "{weak}");

    let archived: Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
    assert_eq!(archived["hit_log"], measured["hit_log"]);
    let (page, text) = page(rig.folder.path(), &[&path]);
    assert!(text.contains("Every hit and its verdict"));
    assert!(text.contains("is too small for a clear response; hit harder."), "{text:.100}");
    let counts = format!("{} hits, of which 9 are in the answer", log.len());
    assert!(text.contains(&counts), "{counts}");
    // The page holds the log like the archive.
    let (_, again) = self::page(rig.folder.path(), &[&page.display().to_string()]);
    assert!(again.contains(&counts));
}

#[test]
fn a_hostile_log_of_hits_is_text() {
    let folder = tempfile::tempdir().unwrap();
    let mut value = editable_archive();
    let hostile = "<img src=x onerror=alert(1)>`</code><script>alert(2)</script>`";
    let finding = json!({ "code": "no_plateau", "severity": "warning", "message": hostile });
    let hit = |dof: &str, verdict: &str| {
        json!({
            "dof": dof, "hit": 1, "verdict": verdict, "findings": [finding], "graded": hostile,
            "peak_force_n": 1e30, "peak_acceleration_m_per_s2": null,
        })
    };
    value["hit_log"] = json!([hit(hostile, "rejected"), hit("1:+Y", "outlier_removed")]);
    let path = folder.path().join("hostile.massline").display().to_string();
    fs::write(&path, value.to_string()).unwrap();
    let (_, text) = page(folder.path(), &[&path]);
    for markup in ["<script>alert", "<img", "</code><"] {
        assert!(!text.contains(markup), "{markup}");
    }
    assert!(text.contains("outlier, removed"));

    for (place, hostile) in [
        ("/hit_log/0/verdict", "excellent"),
        ("/hit_log/0/findings/0/code", hostile),
        ("/hit_log/0/findings/0/severity", hostile),
    ] {
        let mut value = value.clone();
        *value.pointer_mut(place).unwrap() = hostile.into();
        fs::write(&path, value.to_string()).unwrap();
        let page = folder.path().join("refused.html").display().to_string();
        let refused = run(&["report", &path, "-o", &page]);
        assert_eq!(refused.exit, 2, "{}", refused.stderr);
        let key = place.rsplit('/').next().unwrap();
        assert!(refused.says("hit_log[0]") && refused.says(key), "{}", refused.stderr);
    }
}

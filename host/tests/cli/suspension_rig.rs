//! The suspension profile with a rig: lines of the wheel, solved here, archived and solved again.

use serde_json::{Value, json};

use crate::program::{answer, run, run_json, success, words};

/// The layout of the wheel, whose profile is that of the suspension modes.
const WHEEL: &str = "examples/wheel.toml";
/// Its bench.
const ON_BENCH: [&str; 2] = ["--bench", "wheel"];
/// What the host finds from the lines.
const FOUND: [&str; 5] = ["results", "suspension", "global_fit", "agreement", "lines"];

/// The layout of the wheel with one text replaced by another, in `folder`.
#[track_caller]
fn changed(folder: &tempfile::TempDir, from: &str, to: &str) -> String {
    let text = include_str!("../../examples/wheel.toml");
    assert!(text.contains(from), "the layout has {from}");
    let path = folder.path().join("changed.toml");
    std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
    path.display().to_string()
}

/// Code and message of the error of a run that ends with this exit code.
#[track_caller]
fn refusal(exit: i32, arguments: &[&str]) -> (String, String) {
    let (actual, value) = answer(arguments);
    assert_eq!(actual, exit, "{arguments:?}: {value}");
    let entry = |key: &str| value["error"][key].as_str().unwrap_or_default().to_owned();
    (entry("code"), entry("message"))
}

fn methods(results: &Value) -> Vec<&str> {
    let results = results.as_array().unwrap().iter();
    results.map(|result| result["method"].as_str().unwrap()).collect()
}

#[test]
fn a_simulated_wheel_is_solved_beside_the_truth_and_again_from_its_report() {
    let folder = tempfile::tempdir().unwrap();
    let report = folder.path().join("wheel.html").display().to_string();
    let simulated =
        success(&[&["simulate", WHEEL][..], &ON_BENCH, &["--report", &report]].concat());
    assert_eq!(simulated["profile"], "suspension");
    assert_eq!(simulated["mass_lines"], json!([]));
    let lines = simulated["lines"].as_array().unwrap();
    let dofs: Vec<_> = lines
        .iter()
        .map(|dof_lines| (dof_lines["dof"].as_str().unwrap(), &dof_lines["hits"]))
        .collect();
    let five = json!(5);
    let hits = ["101:+X", "102:+Z", "103:+Z", "104:+Y", "105:+X"];
    assert_eq!(dofs, hits.map(|dof| (dof, &five)));
    let answers = methods(&simulated["results"]);
    assert_eq!(answers, ["global-fit", "toivola-nuutila", "conti-bretl", "dppim"]);
    assert_eq!(simulated["suspension"]["modes"].as_array().unwrap().len(), 6);
    assert!(simulated["agreement"]["combined"].is_object());
    // 2 % of the mass is the standard deviation of the hammer's gain; 5 % leaves room for the other sources of error.
    let errors = simulated["error_percent_of_scale"].as_array().unwrap();
    assert!(errors.iter().all(|error| error.as_f64().unwrap().abs() < 5.0), "{errors:?}");

    // The report holds the lines: the same numbers to the last digit.
    let again = success(&["solve", &report]);
    for key in FOUND {
        assert_eq!(again[key], simulated[key], "{key}");
    }
    let page = std::fs::read_to_string(&report).unwrap();
    assert!(
        page.contains("band of the suspension modes") && !page.contains("band of the mass lines")
    );
    let pictures = folder.path().join("pictures").display().to_string();
    let drawn = success(&["plot", &report, "-o", &pictures]);
    let drawn = drawn.to_string();
    for picture in ["norm-indicator", "mac", "stabilisation", "driving-points", "frf-101+X"] {
        assert!(drawn.contains(picture), "{picture}: {drawn}");
    }
    // The exported answer is the best one of the host.
    let exported = run(&["export", &report, "--format", "csv"]);
    assert_eq!(exported.exit, 0, "{}", exported.stderr);
    let (code, message) = refusal(2, &["solve", &report, "--method", "ml"]);
    assert_eq!(code, "usage");
    assert!(message.contains("maximum-likelihood needs mass lines"), "{message}");
    let one = success(&["solve", &report, "--method", "dppim"]);
    assert_eq!(methods(&one["results"]), ["dppim"]);
}

#[test]
fn settings_that_do_not_go_with_the_profile_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let profile = "profile = \"suspension\"";
    for (settings, says) in [
        (
            "profile = \"suspension\"\nband_hz = \"auto\"",
            "the band of the suspension profile is not found from the data",
        ),
        ("profile = \"suspension\"\nimpulse_ns = [1.3, 0.8]", "impulse_ns"),
        ("profile = \"suspension\"\nimpulse_ns = [-0.1, 0.8]", "impulse_ns"),
        ("profile = \"modal\"", "modal"),
    ] {
        let layout = changed(&folder, profile, settings);
        let (_, message) = refusal(2, &[&["simulate", &layout][..], &ON_BENCH].concat());
        assert!(words(&message).contains(says), "{settings}: {message}");
    }
}

#[test]
fn the_option_for_the_profile_replaces_that_of_the_layout() {
    let folder = tempfile::tempdir().unwrap();
    // A band that is found from the data goes with mass lines only: it is set aside, and the port is looked for.
    let automatic = changed(&folder, "profile = \"suspension\"", "band_hz = \"auto\"");
    let no_port = ["--port", "/dev/no-such-port"];
    let of_band = ["measure", &automatic];
    let modes = run(&[&of_band[..], &["--profile", "suspension"], &no_port].concat());
    assert_eq!(modes.exit, 4, "{}", modes.stderr);
    assert!(modes.says("states band_hz for another profile"), "{}", modes.stderr);
    let in_profile =
        |profile| refusal(4, &[&of_band[..], &["--profile", profile], &no_port].concat());
    assert_eq!(in_profile("mass-line"), refusal(4, &[&of_band[..], &no_port].concat()));
    let unknown = [&of_band[..], &["--profile", "modal"], &no_port].concat();
    assert_eq!(refusal(2, &unknown).0, "usage");
    // Records of half a second are those of mass lines.
    let archive = folder.path().join("a.massline").display().to_string();
    let wheel = ["measure", WHEEL, "--output", &archive, "--records", no_port[0], no_port[1]];
    let (code, message) = refusal(2, &wheel);
    assert_eq!(code, "usage");
    assert!(message.contains("--records"), "{message}");
    let mass_lines = [&wheel[..], &["--profile", "mass-line"]].concat();
    assert_eq!(refusal(4, &mass_lines).0, in_profile("mass-line").0);
}

/// The layout of the wheel with a single DOF, whose hit moves all six modes, and two hits.
fn one_dof(folder: &tempfile::TempDir) -> String {
    let hits = r#"["101:+X", "102:+Z", "103:+Z", "104:+Y", "105:+X"]"#;
    let layout = changed(folder, hits, r#"["110:+X"]"#);
    let text = std::fs::read_to_string(&layout).unwrap();
    let oblique = "\n[[node]]\nid = 110\nposition_m = [0.18, -0.21, -0.02]\n\
                   axes = [[0.6, 0.64, 0.48], [-0.8, 0.48, 0.36]]\n";
    let text = text.replace("[test]\n", "[test]\nhits_per_dof = 2\n") + oblique;
    std::fs::write(&layout, text).unwrap();
    layout
}

#[test]
fn a_tape_of_the_wheel_gives_the_same_result_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (layout, tape) = (one_dof(&folder), path("wheel.npy"));
    let (ran, simulated) =
        run_json(&[&["simulate", &layout, "--tape", &tape][..], &ON_BENCH].concat());
    let (again, replayed) = run_json(&["replay", &tape, "--layout", &layout]);
    assert_eq!((ran.exit, again.exit), (0, 0), "{} {}", ran.stderr, again.stderr);
    for key in ["lines", "suspension", "results"] {
        assert_eq!(replayed[key], simulated[key], "{key}");
    }
    assert_eq!(replayed["suspension"]["modes"].as_array().unwrap().len(), 6);
    let hits = |stderr: &str| -> Vec<String> {
        let lines = stderr.lines().filter(|line| line.starts_with("hit "));
        lines.map(str::to_owned).collect()
    };
    assert_eq!(hits(&again.stderr), hits(&ran.stderr));
    assert_eq!(hits(&again.stderr).len(), 2);
    // The last 30 s are missing: the tape ends while the object still rings.
    let whole = std::fs::read(&tape).unwrap();
    let (header, scans) = whole.split_at(whole.iter().position(|&byte| byte == b'\n').unwrap() + 1);
    let (count, missing) = (scans.len() / 20, 30 * 4000);
    let header = String::from_utf8_lossy(header).into_owned();
    let short = header.replace(&count.to_string(), &(count - missing).to_string());
    assert!(short != header && short.len() == header.len(), "{header}");
    // The first bytes are no text.
    let magic = whole[..10].iter().chain(&short.as_bytes()[short.find('{').unwrap()..]);
    let cut: Vec<u8> = magic.chain(&scans[..20 * (count - missing)]).copied().collect();
    std::fs::write(&tape, cut).unwrap();
    let (code, message) = refusal(2, &["replay", &tape, "--layout", &layout]);
    assert_eq!(code, "tape_ends_in_a_record", "{message}");
}

#[test]
fn what_a_rig_does_not_keep_of_long_records_is_refused_before_the_first_hit() {
    let record =
        ["record", WHEEL, "-o", "unused.npy", "--triggered", "--port", "/dev/no-such-port"];
    let (code, message) = refusal(2, &record);
    assert_eq!(code, "usage");
    assert!(message.contains("without --triggered"), "{message}");
}

#[test]
fn the_demonstration_measures_the_wheel_with_a_simulated_rig() {
    let demo = success(&["demo", "wheel", "--rig", "virtual", "--seed", "3"]);
    let same = [&["simulate", WHEEL, "--seed", "3"][..], &ON_BENCH].concat();
    assert_eq!(demo, success(&same));
    for other in [&["--set", "A"][..], &["--runs", "2"], &["--noise", "0.01"]] {
        let both = [&["demo", "wheel", "--rig", "virtual"][..], other].concat();
        assert_eq!(refusal(2, &both).0, "usage", "{other:?}");
    }
    assert_eq!(refusal(2, &["demo", "wheel", "--firmware", "x"]).0, "usage");
}

#[cfg(unix)]
mod on_a_rig {
    use super::*;
    use crate::virtual_process::VirtualProcess;

    #[test]
    fn a_measured_wheel_is_archived_fetched_and_solved_to_the_same_last_digit() {
        let rig = VirtualProcess::on_bench("wheel", &["--layout", WHEEL, "--fast"]);
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name).display().to_string();
        let (measured_to, fetched_to) = (path("measured.massline"), path("fetched.massline"));
        let port = ["--port", &rig.port];
        let plain =
            changed(&folder, "[test]\nprofile = \"suspension\"\n", "[test]\nhits_per_dof = 2\n");
        let measure = ["measure", &plain, "--profile", "suspension", "-o", &measured_to];
        let (run, measured) = run_json(&[&measure[..], &port].concat());
        assert_eq!(run.exit, 0, "{}", run.stderr);
        for phrase in
            ["when it hangs still, hit 101:+X", "ringing, 40 s left: do not touch it", "N s"]
        {
            assert!(run.says(phrase), "{phrase}: {}", run.stderr);
        }
        after_each_point(&run.stderr, &measured["modes_after_each_dof"]);
        let log = measured["hit_log"].as_array().unwrap();
        let accepted: Vec<_> = log.iter().filter(|hit| hit["verdict"] == "accepted").collect();
        assert_eq!(accepted.len(), 5 * 2);
        for hit in accepted {
            let impulse = hit["impulse_n_s"].as_f64().unwrap();
            assert!((0.8..=1.3).contains(&impulse), "the profile's default: {impulse}");
        }
        let fetched =
            success(&[&["results", "get", "1", "--output", &fetched_to][..], &port].concat());
        for (file, document) in [(&measured_to, &measured), (&fetched_to, &fetched)] {
            let solved = success(&["solve", file]);
            for key in FOUND {
                assert_eq!(solved[key], document[key], "{key} of {file}");
            }
        }
        let modes = success(&["modes", &fetched_to]);
        assert_eq!(modes["modes"].as_array().unwrap().len(), 6, "{modes}");
        // Over the band of the test, whichever command reads it.
        assert_eq!(modes["band_hz"], measured["suspension"]["band_hz"]);
        // With a layout that was corrected, as `solve` takes it. That of the archive has the single precision of a rig,
        // which moves what depends on positions by less than a millionth.
        let corrected = success(&["modes", &plain, &measured_to]);
        assert_eq!(corrected["band_hz"], modes["band_hz"]);
        let frequencies = |document: &Value| -> Vec<f64> {
            let modes = document["modes"].as_array().unwrap();
            modes.iter().map(|mode| mode["frequency_hz"]["value"].as_f64().unwrap()).collect()
        };
        let pairs = frequencies(&corrected).into_iter().zip(frequencies(&modes));
        assert!(pairs.into_iter().all(|(one, other)| (one / other - 1.0).abs() < 1e-6));
        let (code, message) = refusal(2, &["modes", &measured_to, WHEEL]);
        assert_eq!(code, "usage", "{message}");
        assert!(message.contains("massline modes LAYOUT.toml"), "{message}");
        lines_that_are_missing(&measured_to, &path("cut.massline"));
        for archive in success(&["history", &path("")])["archives"].as_array().unwrap() {
            let of_best = &measured["results"][0];
            assert_eq!(archive["method"], "global-fit", "{archive}");
            if archive["file"] == measured_to.as_str() {
                assert_eq!(archive["mass_kg"], of_best["mass_kg"], "{archive}");
            }
        }
        // Another test in between does no harm, and the file is that of the test in the profile that was measured.
        let between = path("between.toml");
        let one_hit = std::fs::read_to_string(WHEEL).unwrap();
        let one_hit = one_hit.replace("[test]\n", "[test]\nhits_per_dof = 1\n");
        std::fs::write(&between, one_hit).unwrap();
        let (of_test, tested) = run_json(&[&["measure", &between][..], &port].concat());
        assert_eq!(of_test.exit, 0, "{}", of_test.stderr);
        assert!(!of_test.says("the rig keeps result"), "{}", of_test.stderr);
        assert_eq!(tested["number"], 2);
        for layout in [&[][..], &["--layout", &plain]] {
            let again = success(&[&["results", "get", "1"][..], layout, &port].concat());
            assert_eq!(again["lines"], fetched["lines"]);
            // The file has the positions in double precision.
            let of_best = |document: &Value| document["results"][0].clone();
            assert_eq!(of_best(&again)["method"], "global-fit");
            assert!(!layout.is_empty() || of_best(&again) == of_best(&fetched), "{again}");
        }
        let (code, message) =
            refusal(2, &[&["results", "get", "1", "--layout", &between][..], &port].concat());
        assert_eq!(code, "another_layout", "{message}");
        assert!(message.contains("leave --layout out"), "{message}");
        let (again, _) = run_json(&[&["measure", &between][..], &port].concat());
        assert!(
            again.says("a new test; the rig keeps result 2 of this layout"),
            "{}",
            again.stderr
        );

        success(&[&["results", "delete", "1", "--yes"][..], &port].concat());
        let (code, message) = refusal(2, &[&["results", "get", "1"][..], &port].concat());
        assert_eq!(code, "not_found", "{message}");
    }

    #[test]
    fn where_points_that_miss_modes_have_no_answer_the_modes_and_a_point_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let bench = folder.path().join("bench.toml");
        std::fs::write(&bench, equal_cords()).unwrap();
        let (layout, bench) = (one_dof(&folder), bench.display().to_string());
        let text = std::fs::read_to_string(&layout).unwrap();
        // Above the middle of the wheel.
        let middle = text
            .replace("\"110:+X\"", "\"110:+Z\"")
            .replace("[0.18, -0.21, -0.02]", "[0.0, 0.0, 0.03]")
            .replace("\naxes = [[0.6, 0.64, 0.48], [-0.8, 0.48, 0.36]]", "");
        std::fs::write(&layout, middle).unwrap();
        let rig = VirtualProcess::on_bench(&bench, &["--layout", &layout, "--fast"]);
        let measure = ["measure", &layout, "--any-layout", "--port", &rig.port];
        let (measured, answer) = run_json(&measure);
        assert_eq!(measured.exit, 3, "{}", measured.stderr);
        let message = answer["error"]["message"].as_str().unwrap();
        assert!(message.contains("a force unlike those of the hits so far"), "{message}");
        let reports = answer["modes_after_each_dof"].as_array().unwrap();
        assert_eq!(reports.len(), 1, "{answer}");
        let report = &reports[0];
        assert!(report["modes_missing"].as_u64().unwrap() >= 2, "{report}");
        // What is listed is a mode of the bench, and no pole that stands for noise.
        for mode in report["modes"].as_array().unwrap() {
            let damping = mode["damping_ratio"].as_f64().unwrap();
            assert!((0.005..0.03).contains(&damping), "the bench has 1.4 %: {report}");
        }
        let dof = report["next"]["dof"].as_str().unwrap();
        assert!(measured.says("after 1 of 1 points"), "{}", measured.stderr);
        assert!(measured.says(&format!("add {dof} (axes of the body)")), "{}", measured.stderr);
    }

    /// The bench of the wheel on four cords that are all the same.
    fn equal_cords() -> String {
        let text = include_str!("../../../shared/physics/benches/wheel.toml");
        let (before, rest) = text.split_once("[[suspension.cord]]").unwrap();
        let (_, after) = rest.split_once("# The data sheet of the ADXL326").unwrap();
        let cord = |[x, y]: [f64; 2]| {
            format!(
                "[[suspension.cord]]\npoint_m = [{x:.1}, {y:.1}, 0.1]\n\
                 spring_n_per_m = [3000.0, 3000.0, 9000.0]\n"
            )
        };
        let cords = [[0.2, 0.0], [-0.2, 0.0], [0.0, 0.2], [0.0, -0.2]].map(cord);
        format!("{before}{}# {after}", cords.concat())
    }

    /// After each point the modes that show are listed, for people and for programs.
    fn after_each_point(printed: &str, listed: &Value) {
        let reports = listed.as_array().unwrap();
        assert_eq!(reports.len(), 5, "{listed}");
        for (place, report) in (1..).zip(reports) {
            // After the last one the answer follows.
            let heading = format!("after {place} of 5 points");
            assert_eq!(printed.contains(&heading), place < 5, "{printed}");
            assert_eq!(report["dofs_measured"], place, "{report}");
            let (seen, missing) = (&report["modes"], report["modes_missing"].as_u64().unwrap());
            assert_eq!(seen.as_array().unwrap().len() as u64 + missing, 6, "{report}");
        }
        let first = &reports[0];
        let next = &first["next"];
        let dof = next["dof"].as_str().unwrap();
        let words = match next["points_before"].as_u64().unwrap() {
            0 => format!("hit {dof} next"),
            1 => format!("{dof}, after 1 more point, "),
            before => format!("{dof}, after {before} more points, "),
        };
        assert!(printed.contains(&words), "{words}: {printed}");
        assert_eq!(reports[4]["modes_missing"], 0, "{listed}");
    }

    /// An archive without lines of a DOF is solved without that DOF, and one without any is refused.
    fn lines_that_are_missing(archive: &str, cut_to: &str) {
        let mut whole: Value = serde_json::from_slice(&std::fs::read(archive).unwrap()).unwrap();
        // With it, an edited archive is refused.
        assert!(whole.as_object_mut().unwrap().remove("checksum").is_some());
        let with_lines = |count: usize| {
            let mut cut = whole.clone();
            cut["lines"].as_array_mut().unwrap().truncate(count);
            std::fs::write(cut_to, cut.to_string()).unwrap();
        };
        with_lines(4);
        let solved = success(&["solve", cut_to]);
        assert_eq!(solved["verdict"], "use_with_care");
        let reasons = solved["verdict_reasons"].as_array().unwrap();
        let missing = reasons.iter().find(|reason| reason["code"] == "lines_missing").unwrap();
        let message = missing["message"].as_str().unwrap();
        assert!(message.starts_with("the lines of 105:+X are missing"), "{message}");
        let indicators = &solved["suspension"]["modes"][0]["norm_indicators"];
        assert_eq!(indicators.as_array().unwrap().len(), 4);
        with_lines(0);
        // The rig's own answers are not what this command is asked for.
        let (code, message) = refusal(3, &["solve", cut_to]);
        assert_eq!(code, "lines_missing");
        assert!(message.contains("101:+X, 102:+Z, 103:+Z, 104:+Y, 105:+X"), "{message}");
        let mut damaged = whole.clone();
        damaged["lines"][0]["responses"].as_array_mut().unwrap().pop();
        std::fs::write(cut_to, damaged.to_string()).unwrap();
        let (code, message) = refusal(2, &["solve", cut_to]);
        assert_eq!(code, "archive_malformed");
        assert!(message.contains("lines[0] (101:+X)"), "{message}");
    }
}

#[cfg(target_os = "linux")]
mod on_a_screen {
    use super::*;
    use crate::on_terminal::{Size, Terminal};
    use crate::virtual_process::VirtualProcess;

    /// `measure` on a terminal of this size.
    fn on_terminal(size: Size, rig: &VirtualProcess, layout: &str, more: &[&str]) -> Terminal {
        let measure = [&["measure", layout, "--port", &rig.port], more].concat();
        Terminal::start(size, "xterm-256color", &measure)
    }

    #[test]
    fn a_wheel_is_measured_on_a_full_screen_of_either_size() {
        let folder = tempfile::tempdir().unwrap();
        let layout = one_dof(&folder);
        let rig = VirtualProcess::on_bench("wheel", &["--layout", &layout, "--fast"]);
        for size in [[80, 24], [200, 60]] {
            let mut terminal = on_terminal(size, &rig, &layout, &[]);
            let hit = |shown: &str| shown.contains(" N s") && shown.contains("good");
            assert!(terminal.until_shown(hit), "{}", terminal.screen_text());
            // Wrapped where it does not fit a line.
            let shown = terminal.screen_text();
            assert!(shown.contains("the records of 40 s stay on the rig;"), "{shown}");
            assert!(shown.contains("what they give"), "{shown}");
            let (exit, text) = terminal.end();
            assert_eq!(exit, 0, "{text}");
            let (_, answer) = text.rsplit_once("\x1b[?1049l").expect("the screen is left");
            for phrase in ["global-fit", "J_xy = ", "what limits it: ", "next: "] {
                assert!(answer.contains(phrase), "{phrase}: {answer}");
            }
        }
    }

    /// At the speed of a real rig.
    #[test]
    fn the_ringing_is_counted_down_and_a_campaign_that_was_paused_meanwhile_goes_on() {
        let folder = tempfile::tempdir().unwrap();
        let layout = one_dof(&folder);
        let rig = VirtualProcess::on_bench("wheel", &["--layout", &layout]);
        for (more, goes_on) in [(&[][..], false), (&["--plain"], true)] {
            let mut terminal = on_terminal([80, 24], &rig, &layout, more);
            for phrase in ["when it hangs still, hit 110:+X", "39 s left", "38 s left"] {
                let shown = |shown: &str| words(shown).contains(phrase);
                assert!(terminal.until_shown(shown), "{phrase}: {}", terminal.screen_text());
            }
            terminal.type_keys("\x03");
            let (exit, text) = terminal.end();
            assert_eq!((exit, text.contains("resuming the interrupted campaign")), (130, goes_on));
            assert!(words(&text).contains("the same command"), "{text}");
        }
    }
}

//! Errors in arguments and files are reported with their exit code, the same in JSON and in text.

use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::program::{data, run, run_json, success, text};

/// A folder with a valid layout and a few invalid ones.
struct Files(TempDir);

const NODES: &str = "
node = [
    { id = 1, position_m = [0.0, 0.0, 0.0] },
    { id = 2, position_m = [0.2, -0.2, 0.0] },
    { id = 3, position_m = [0.2, 0.0, 0.0] },
    { id = 4, position_m = [0.2, -0.2, 0.15] },
    { id = 5, position_m = [0.4, 0.0, 0.0] },
]
";

impl Files {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) -> String {
        let path = self.path(name);
        std::fs::write(&path, content).unwrap();
        path.display().to_string()
    }

    /// A layout file with these sensors and hits on [`NODES`].
    fn layout(&self, sensors: &str, hits: &str) -> String {
        let text = format!("sensors = {sensors}\nhits = {hits}\n{NODES}");
        self.write("layout.toml", text)
    }

    fn good(&self) -> String {
        let text = format!("sensors = [1, 2, 3]\nhits = {HITS}\n{NODES}");
        self.write("good.toml", text)
    }

    /// A tape whose array has this header, with `bytes` bytes of scans and a valid sidecar.
    fn tape(&self, descr: &str, shape: &str, bytes: usize) -> String {
        let dictionary =
            format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}\n");
        let mut npy = b"\x93NUMPY\x01\x00".to_vec();
        npy.extend((dictionary.len() as u16).to_le_bytes());
        npy.extend(dictionary.as_bytes());
        npy.extend(vec![0; bytes]);
        self.write(
            "tape.toml",
            "scan_rate_hz = 4000.0\nchannels = 10\nadc_bits = 12\nadc_reference_v = 3.0\n\
             channel_delay_s = 1e-5\npre_trigger_scans = 80\nlayout_hash = 1\n\
             [calibration]\nhammer = { zero_v = 0.1, sensitivity_v_per_n = 0.0225 }\n",
        );
        self.write("tape.npy", npy)
    }

    /// A bench without elastic modes, so that nodes may be anywhere.
    fn rigid_bench(&self) -> String {
        let bench = "elastic_mode = []\n[body]\nmass_kg = 1.0\n\
                     center_of_mass_m = [0.1, -0.1, 0.0]\n\
                     inertia_kg_m2 = [0.01, 0.01, 0.01, 0.0, 0.0, 0.0]\n";
        self.write("rigid.toml", bench)
    }
}

const HITS: &str = r#"["1:+Y", "2:+Z", "4:+X"]"#;

/// Runs with and without `--json`; exit code, error object and text must agree.
#[track_caller]
fn fails(arguments: &[&str], exit: i32, code: &str) {
    let (run, value) = run_json(arguments);
    let seen = format!("{arguments:?}\nstdout: {}\nstderr: {}", run.stdout, run.stderr);
    assert_eq!(run.exit, exit, "{seen}");
    assert_eq!(value["error"]["exit"], exit, "{seen}");
    assert_eq!(value["error"]["code"], code, "{seen}");
    let message = value["error"]["message"].as_str().expect(&seen);
    assert!(!message.is_empty() && !run.stderr.contains("error:"), "{seen}");
    let text = crate::program::run(arguments);
    assert!(text.says(message), "{seen}\n{}", text.stderr);
}

#[test]
fn malformed_command_lines_are_usage_errors() {
    for arguments in [
        &["no-such-command"][..],
        &["demo", "--rig", "real"],
        &["demo", "--seed", "abc"],
        &["demo", "--hits", "0"],
        &["layout"],
        &["layout", "check"],
        &["layout", "new", "extra"],
        &["device"],
        &["device", "identify", "--port"],
        &["measure"],
        &["measure", "a.toml", "b.toml"],
        &["results", "get"],
        &["results", "get", "0"],
        &["results", "get", "-1"],
        &["results", "delete"],
        &["results", "delete", "x"],
        &["results", "delete", "5-2"],
        &["results", "delete", "--all", "1"],
        &["measure", "a.toml", "--records"],
        &["solve", "a.toml"],
        &["solve", "a.toml", "b.uff", "--reference-point", "here"],
        &["replay", "a.npy"],
        &["record", "a.toml"],
        &["simulate", "a.toml", "--tape"],
        &["virtual", "--manual", "--fast"],
        &["virtual", "--seed", "1.5"],
    ] {
        fails(arguments, 2, "usage");
    }
}

#[test]
fn the_demo_names_what_is_wrong_with_its_bench_and_its_firmware() {
    let files = Files::new();
    fails(&["demo", "--bench", "no-such-bench"], 2, "unknown_bench");
    fails(&["demo", "--bench", "no-such-file.toml"], 2, "cannot_read");
    let malformed = files.write("bench.toml", "[sensor]\nnoise = \"loud\"\n");
    fails(&["demo", "--bench", &malformed], 2, "malformed_bench");
    let impossible = files.write("bench.toml", "[adc]\nbits = 40\n");
    fails(&["demo", "--bench", &impossible], 2, "malformed_bench");
    fails(&["demo", "--firmware", "image.elf"], 2, "firmware_needs_qemu");
    fails(&["demo", "--rig", "qemu", "--firmware", "no-such.elf"], 2, "no_firmware");
}

#[test]
fn a_wrong_layout_is_refused_with_the_code_of_its_fault() {
    let files = Files::new();
    let check = |path: &str, code: &str| fails(&["layout", "check", path], 2, code);
    check("no-such-layout.toml", "layout_not_readable");
    check(&files.write("l.toml", "sensors = [1, 2\n"), "layout_malformed");
    check(&files.layout("[1, 2, 9]", HITS), "unknown_node");
    check(&files.layout("[1, 2, 3]", r#"["1:+Y", "2:+Z", "9:+X"]"#), "unknown_node");
    check(&files.layout("[1, 2, 2]", HITS), "two_sensors_on_one_node");
    let skew = NODES.replace("0.15]", "0.15], axes = [[1.0, 0.0, 0.0], [0.7, 0.7, 0.0]]");
    let skew = format!("sensors = [1, 2, 3]\nhits = {HITS}\n{skew}");
    check(&files.write("l.toml", skew), "axes_not_orthonormal");
    let nan = format!("sensors = [1, 2, 3]\nhits = {HITS}\n{}", NODES.replace("0.15", "nan"));
    check(&files.write("l.toml", nan), "layout_not_finite");
}

#[test]
fn layouts_that_cannot_determine_the_ten_properties_end_with_exit_code_3() {
    let files = Files::new();
    let bench = files.rigid_bench();
    for (sensors, hits, code) in [
        ("[1, 2, 3]", r#"["1:+Y", "2:+Z"]"#, "fewer_than_three_hits"),
        ("[1, 2, 3]", r#"["1:+Y", "2:+Y", "4:+Y"]"#, "hits_all_parallel"),
        ("[1, 2, 3]", r#"["2:+X", "2:+Y", "2:+Z"]"#, "hits_concurrent"),
    ] {
        let layout = files.layout(sensors, hits);
        fails(&["layout", "check", &layout], 3, code);
        // A rig refuses it as well, before the first hit.
        fails(&["simulate", &layout, "--bench", &bench], 3, code);
    }
}

#[test]
fn suggestions_that_cannot_be_made_are_refused() {
    let files = Files::new();
    let good = files.good();
    fails(&["layout", "suggest", "no-such-layout.toml"], 2, "layout_not_readable");
    let too_many = ["layout", "suggest", &good, "--sensors"];
    fails(&[&too_many[..], &["6"]].concat(), 2, "too_few_candidates");
    fails(&["layout", "suggest", &good, "--hits", "16"], 2, "too_few_candidates");
    for option in ["--sensors", "--hits", "--starts", "--hits-per-dof", "--noise"] {
        for value in ["-1", "0", "1e9", "many"] {
            fails(&["layout", "suggest", &good, option, value], 2, "usage");
        }
    }
    fails(&["layout", "suggest", &good, "--keep-sensors", "--keep-hits"], 2, "usage");
    fails(&["layout", "suggest", &good, "--write", &good], 2, "file_exists");
    let forbidden = NODES.replace("] },", "], can_hit = [], can_carry_sensor = false },");
    let forbidden = format!("sensors = [1, 2, 3]\nhits = {HITS}\n{forbidden}");
    let forbidden = files.write("forbidden.toml", forbidden);
    fails(&["layout", "suggest", &forbidden], 2, "too_few_candidates");
    fails(&["layout", "suggest", &forbidden, "--keep-sensors"], 2, "too_few_candidates");
    let sideways = NODES.replace("] },", "], can_hit = [\"sideways\"] },");
    let sideways = format!("sensors = [1, 2, 3]\nhits = {HITS}\n{sideways}");
    fails(&["layout", "suggest", &files.write("l.toml", sideways)], 2, "layout_malformed");
    let line = "sensors = [1, 2, 3]\nhits = [\"1:+Y\", \"2:+Z\", \"3:+X\"]\nnode = [
        { id = 1, position_m = [0.0, 0.0, 0.0] },
        { id = 2, position_m = [0.1, 0.0, 0.0] },
        { id = 3, position_m = [0.3, 0.0, 0.0] },
    ]
    [reference]
    center_of_mass_m = [0.13, 0.0, 0.0]
    ";
    let line = files.write("line.toml", line);
    fails(&["layout", "suggest", &line], 3, "ten_parameters_not_identifiable");
}

#[test]
fn files_are_not_overwritten_by_layout_new() {
    let files = Files::new();
    let good = files.good();
    fails(&["layout", "new", "--output", &good], 2, "file_exists");
    success(&["layout", "new", "--output", &good, "--force"]);
    fails(&["layout", "new", "--output", "/no/such/folder/l.toml"], 2, "cannot_write");
}

#[test]
fn a_missing_port_is_named_by_every_command_that_needs_one() {
    let files = Files::new();
    let good = files.good();
    let port = ["--port", "/dev/no-such-port"];
    for arguments in [
        &["device", "identify"][..],
        &["device", "stats"],
        &["results", "list"],
        &["results", "get", "1"],
        &["results", "delete", "1", "--yes"],
        &["measure", &good],
        &["record", &good, "--output", "unused.npy"],
    ] {
        fails(&[arguments, &port].concat(), 4, "port_not_found");
    }
}

#[test]
fn a_measurement_is_refused_without_a_good_layout_or_a_keyboard() {
    let files = Files::new();
    fails(&["measure", "no-such-layout.toml"], 2, "layout_not_readable");
    fails(&["measure", &files.write("l.toml", "title = 5\n")], 2, "layout_malformed");
    let good = files.good();
    fails(&["measure", &good, "--confirm"], 2, "no_keyboard");
    fails(&["measure", &good, "--calibration", "no-such.toml"], 2, "calibration_malformed");
    let four = files.layout("[1, 2, 3, 4]", HITS);
    fails(&["measure", &four], 2, "layout_too_large");
}

#[test]
fn solve_refuses_a_missing_layout_and_unreadable_frfs() {
    let files = Files::new();
    let good = files.good();
    let frfs = |path: &str| files.write("frfs.uff", path);
    fails(&["solve", "no-such-layout.toml", &frfs("")], 2, "layout_not_readable");
    fails(&["solve", &good, "no-such.uff"], 2, "uff_not_readable");
    fails(&["solve", &good, &frfs("")], 2, "uff_corrupt");
    fails(&["solve", &good, &frfs("no universal file at all\n")], 2, "uff_corrupt");
    fails(&["solve", &good, &frfs("    -1\n    58\n")], 2, "uff_truncated");
}

#[test]
fn replay_names_what_is_wrong_with_a_tape() {
    let files = Files::new();
    let good = files.good();
    let run = |tape: &str, code| fails(&["replay", tape, "--layout", &good], 2, code);
    run("no-such-tape.npy", "tape_not_readable");
    run(&files.write("tape.npy", "text"), "tape_malformed");
    run(&files.tape("<f8", "(2, 10)", 160), "tape_wrong_type");
    run(&files.tape(">u2", "(2, 10)", 40), "tape_wrong_type");
    run(&files.tape("<u2", "(4, 5)", 40), "tape_wrong_shape");
    run(&files.tape("<u2", "(20,)", 40), "tape_wrong_shape");
    run(&files.tape("<u2", "(20, 10)", 40), "tape_truncated");
    run(&files.tape("<u2", "(2, 10)", 40), "tape_wrong_layout");
    std::fs::remove_file(files.path("tape.toml")).unwrap();
    run(path_text(&files.path("tape.npy")), "sidecar_not_readable");
    let tape = files.tape("<u2", "(2, 10)", 40);
    fails(&["replay", &tape, "--layout", "no-such.toml"], 2, "layout_not_readable");
}

#[test]
fn record_and_simulate_name_the_file_that_they_cannot_use() {
    let files = Files::new();
    let good = files.good();
    fails(&["record", "no-such.toml", "--output", "x.npy"], 2, "layout_not_readable");
    fails(&["simulate", "no-such.toml"], 2, "layout_not_readable");
    fails(&["simulate", &good, "--bench", "no-such-bench"], 2, "unknown_bench");
    // The bundled bench defines its elastic modes only at its own nodes.
    let elsewhere = files.layout("[1, 2, 5]", HITS);
    fails(&["simulate", &elsewhere, "--bench", "default"], 2, "bench_does_not_fit");
    fails(&["simulate", &elsewhere], 2, "object_not_stated");
    let bench = files.rigid_bench();
    for tape in ["/no/such/folder/t.npy", path_text(&files.path("named.toml"))] {
        let arguments = ["simulate", &good, "--bench", &bench, "--tape", tape];
        fails(&arguments, 2, "cannot_write");
    }
    let four = files.layout("[1, 2, 3, 4]", HITS);
    fails(&["simulate", &four], 2, "layout_too_large");
}

#[test]
fn the_virtual_rig_names_the_file_that_it_cannot_use() {
    let files = Files::new();
    fails(&["virtual", "--bench", "no-such-bench"], 2, "unknown_bench");
    fails(&["virtual", "--layout", "no-such.toml"], 2, "layout_not_readable");
    let elsewhere = files.layout("[1, 2, 5]", HITS);
    fails(&["virtual", "--layout", &elsewhere], 2, "bench_does_not_fit");
    let folder = files.0.path().display().to_string();
    fails(&["virtual", "--flash", &folder], 2, "virtual_rig");
    let short = files.write("flash.bin", "not a flash");
    fails(&["virtual", "--flash", &short], 2, "virtual_rig");
}

#[test]
fn every_command_has_examples_in_its_help() {
    for command in [
        &["demo"][..],
        &["layout"],
        &["layout", "new"],
        &["layout", "check"],
        &["layout", "suggest"],
        &["layout", "show"],
        &["layout", "schema"],
        &["device"],
        &["device", "list"],
        &["device", "identify"],
        &["device", "stats"],
        &["measure"],
        &["results"],
        &["results", "list"],
        &["results", "get"],
        &["results", "delete"],
        &["history"],
        &["solve"],
        &["export"],
        &["replay"],
        &["record"],
        &["simulate"],
        &["virtual"],
    ] {
        let help = run(&[command, &["--help"]].concat());
        assert_eq!(help.exit, 0, "{command:?}");
        let text = help.stdout;
        assert!(text.contains(&format!("  massline {}", command.join(" "))), "{command:?}\n{text}");
    }
}

#[test]
fn without_json_an_error_leaves_stdout_empty_and_has_no_colour_in_a_pipe() {
    let run = run(&["layout", "check", "no-such-layout.toml"]);
    assert!(run.stdout.is_empty(), "{}", run.stdout);
    let text = run.stderr;
    assert!(text.starts_with("error: no-such-layout.toml"), "{text}");
    assert!(!text.contains('\x1b'));
}

#[test]
fn a_layout_of_the_template_is_good() {
    let files = Files::new();
    let path = files.path("new.toml");
    let created = run(&["layout", "new", "--output", path_text(&path)]);
    assert_eq!(created.exit, 0, "{}", created.stderr);
    let checked = run(&["layout", "check", path_text(&path)]);
    assert_eq!(checked.exit, 0, "{}", checked.stderr);
}

#[test]
fn the_template_of_the_suspension_profile_has_a_forecast_by_every_sort_of_method() {
    let files = Files::new();
    let created = run(&["layout", "new", "--profile", "suspension"]);
    let modes = files.write("modes.toml", created.stdout);
    let (checked, value) = run_json(&["layout", "check", &modes]);
    assert_eq!(checked.exit, 0, "{}", checked.stderr);
    let answers = value["forecast"]["answers"].as_array().unwrap();
    let methods: Vec<&str> =
        answers.iter().map(|answer| answer["method"].as_str().unwrap()).collect();
    for method in ["global-fit", "toivola-nuutila", "conti-bretl", "dppim"] {
        assert!(methods.contains(&method), "{method}: {methods:?}");
    }
}

#[test]
fn a_layout_of_modes_that_no_method_answers_or_whose_window_hides_them_is_refused() {
    let files = Files::new();
    let text = run(&["layout", "new", "--profile", "suspension"]).stdout;
    let narrow = text.replace("band_hz = [0.5, 12.4] ", "band_hz = [0.5, 1.2] ");
    let narrow = files.write("narrow.toml", narrow);
    let checked = run(&["layout", "check", &narrow]);
    assert_eq!(checked.exit, 3, "{}", checked.stderr);
    assert_eq!(run_json(&["layout", "check", &narrow]).1["identifiable"], false);
    assert!(checked.says("none of the methods of the suspension profile would answer"));
    // The settings of the other profile, with the name of this one.
    let mixed = run(&["layout", "new"]).stdout;
    let mixed = mixed.replace("profile = \"mass-line\" ", "profile = \"suspension\" ");
    let checked = run(&["layout", "check", &files.write("mixed.toml", mixed)]);
    assert_eq!(checked.exit, 2, "{}", checked.stderr);
    assert!(checked.says("the window hides the modes; without the line it is 0.1 1/s"));
}

fn path_text(path: &Path) -> &str {
    path.to_str().unwrap()
}

#[test]
fn a_setting_that_no_rig_has_is_named_with_file_and_line() {
    let files = Files::new();
    let text = std::fs::read_to_string(files.good()).unwrap();
    let wide = files.write("wide.toml", text + "\n[test]\nband_hz = [10.0, 1e6]\n");
    let line = std::fs::read_to_string(&wide).unwrap().lines().count();
    let place = format!("{wide}:{line}: test.band_hz: ");
    for command in ["simulate", "measure"] {
        let (run, value) = run_json(&[command, &wide]);
        assert_eq!((run.exit, &value["error"]["code"]), (2, &"setting_out_of_range".into()));
        let message = value["error"]["message"].as_str().unwrap();
        assert!(message.starts_with(&place), "{message}");
    }
    let checked = run(&["layout", "check", &wide]);
    assert_eq!(checked.exit, 0);
    let is_said = checked.says(&place) && checked.says("only `massline solve` takes it");
    assert!(is_said, "{}", checked.stderr);
}

#[test]
fn more_threads_than_any_computer_has_are_refused() {
    let files = Files::new();
    let good = files.good();
    for threads in ["0", "100000", "many"] {
        fails(&["simulate", &good, "--runs", "2", "--threads", threads], 2, "usage");
    }
}

#[test]
fn endless_files_are_not_read_to_their_end() {
    let files = Files::new();
    let good = files.good();
    fails(&["simulate", &good, "--bench", "/dev/zero"], 2, "cannot_read");
    let image = ["flash", "--board", "blackpill-f411", "--dry-run", "--image", "/dev/zero"];
    fails(&image, 2, "image_not_read");
    fails(&["layout", "check", "/dev/zero"], 2, "layout_not_readable");
    fails(&["hits", "/dev/zero"], 2, "recording_not_readable");
    fails(&["solve", &good, "/dev/zero"], 2, "uff_not_readable");
    fails(&["flash", "--board", "blackpill-f411", "--dry-run"], 2, "no_image");
}

#[test]
fn a_key_that_is_there_twice_is_named_with_its_line() {
    let files = Files::new();
    let good = files.good();
    let layout = files.write("layout.toml", "title = \"a\"\ntitle = \"b\"\n");
    let calibration = files.write("calibration.toml", "[hammer]\nzero_v = 1\nzero_v = 2\n");
    let bench = files.write("bench.toml", "[sensor]\nzero_v = 1\nzero_v = 2\n");
    for (arguments, place) in [
        (&["layout", "check", &layout][..], format!("{layout}:2: title: ")),
        (&["simulate", &good, "--calibration", &calibration], format!("{calibration}:3: zero_v: ")),
        (&["simulate", &good, "--bench", &bench], format!("{bench}:3: zero_v: ")),
    ] {
        let refused = run(arguments);
        assert_eq!(refused.exit, 2, "{}", refused.stderr);
        let sentence = format!("{place}this key is in the file twice; delete one");
        assert!(refused.says(&sentence), "{}", refused.stderr);
    }
}

#[test]
fn advice_about_a_path_is_given_where_the_path_is_wrong() {
    let files = Files::new();
    let folder = files.0.path().display().to_string();
    let good = files.good();
    for command in [&["layout", "check"][..], &["hits"], &["solve", &good]] {
        let advice = |path: &str| run(&[command, &[path]].concat());
        assert!(advice("no-such-file").says("check the path"), "{command:?}");
        let of_folder = advice(&folder);
        assert!(of_folder.says("give the name of a file"), "{command:?}: {}", of_folder.stderr);
        assert!(!of_folder.says("check the path"), "{command:?}");
        assert!(!advice("/dev/zero").says("check the path"), "{command:?}");
    }
}

#[test]
fn a_file_that_is_missing_or_cut_short_is_said_to_be() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| text(&folder.path().join(name));
    let whole = data("archive/version-1.massline");
    let page = path("whole.html");
    assert_eq!(run(&["report", &text(&whole), "-o", &page]).exit, 0);
    let bytes = std::fs::read(&page).unwrap();
    let half = path("half.html");
    std::fs::write(&half, &bytes[..bytes.len() / 2]).unwrap();
    let cut = run(&["solve", &half]);
    assert!(
        cut.exit == 2 && cut.says("its end is missing, so copy or write it again"),
        "{}",
        cut.stderr
    );
    for name in ["missing", "missing.massline"] {
        let missing = run(&["report", &path(name)]);
        assert!(missing.exit == 2 && missing.says("check the path"), "{}", missing.stderr);
    }
}

#[test]
fn each_number_out_of_range_is_told_its_own_range_with_the_unit() {
    for (option, value, range) in [
        ("--noise", "0", "--noise must lie between 1e-9 and 1 (m/s²)/N"),
        ("--spacing", "9", "--spacing must lie between 0.1 and 0.4 Hz"),
    ] {
        let wrong = run(&["demo", "wheel", option, value]);
        assert!(wrong.exit == 2 && wrong.says(range), "{}", wrong.stderr);
        assert_eq!(wrong.stderr.matches("must lie").count(), 1, "{}", wrong.stderr);
    }
}

//! `massline export`: every format against the committed files, and what it refuses.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use massline_files::archive::Archive;
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::program::{LATE, LAYOUT, answer, run, run_json, success};
use crate::rig::Rig;

/// The committed files of the result, and the arguments that make them.
const FILES: [(&str, &[&str]); 13] = [
    ("frame.urdf", &["--format", "urdf"]),
    ("frame-node.urdf", &["--format", "urdf", "--frame", "5"]),
    ("frame.sdf", &["--format", "sdf"]),
    ("frame.xml", &["--format", "mjcf"]),
    ("frame-principal.xml", &["--format", "mjcf", "--frame", "principal"]),
    ("frame.bdf", &["--format", "conm2"]),
    ("frame-t-mm.bdf", &["--format", "conm2", "--units", "t-mm", "--frame", "5"]),
    ("frame.inp", &["--format", "abaqus"]),
    ("frame.yaml", &["--format", "yaml"]),
    ("frame.csv", &["--format", "csv", "--frame", "com"]),
    ("frame.json", &["--format", "json", "--frame", "5", "--units", "slinch-in"]),
    ("frame.npz", &["--format", "npz"]),
    ("frame.mat", &["--format", "mat"]),
];

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/export").join(name)
}

fn data_text(name: &str) -> String {
    data(name).display().to_string()
}

/// A folder with changed copies of the document.
struct Documents(TempDir);

impl Documents {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) -> String {
        let path = self.0.path().join(name);
        fs::write(&path, content).unwrap();
        path.display().to_string()
    }

    fn changed(&self, change: impl Fn(&mut Value)) -> String {
        let mut value: Value =
            serde_json::from_slice(&fs::read(data("result.json")).unwrap()).unwrap();
        change(&mut value);
        self.write("changed.json", value.to_string())
    }
}

/// The message of an export that must fail; without `-o` among the arguments it is to a file of its own.
#[track_caller]
fn fails(arguments: &[&str], exit: i32, code: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("unwritten").display().to_string();
    let target: &[&str] = if arguments.contains(&"-o") { &[] } else { &["-o", &path] };
    let (run, value) = run_json(&[&["export"], arguments, target].concat());
    assert_eq!((run.exit, &value["error"]["code"]), (exit, &json!(code)), "{arguments:?}: {value}");
    assert!(!Path::new(&path).exists(), "{arguments:?} writes a file");
    value["error"]["message"].as_str().unwrap().to_owned()
}

#[test]
fn every_format_is_as_committed() {
    let (result, layout) = (data_text("result.json"), data_text("layout.toml"));
    let folder = tempfile::tempdir().unwrap();
    let archive = data_text("../archive/version-1.massline");
    let from_result = FILES
        .map(|(name, options)| (name, [&[result.as_str(), "--layout", &layout], options].concat()));
    let from_archive = ("archive.uff", vec![archive.as_str(), "--format", "uff"]);
    for (name, arguments) in from_result.into_iter().chain([from_archive]) {
        let path = folder.path().join(name).display().to_string();
        let written = run(&[&["export", "-o", &path], &arguments[..]].concat());
        assert_eq!(written.exit, 0, "{name}: {}", written.stderr);
        let now = fs::read(&path).unwrap();
        if std::env::var_os("MASSLINE_BLESS").is_some() {
            fs::write(data(name), &now).unwrap();
        }
        let committed = fs::read(data(name)).expect("the file is committed");
        assert!(now == committed, "{name} differs from the committed file: {arguments:?}");
    }
}

#[test]
fn standard_output_holds_the_same_file() {
    let (result, layout) = (data_text("result.json"), data_text("layout.toml"));
    let common = ["export", result.as_str(), "--layout", &layout, "--format"];
    let text = run(&[&common[..], &["urdf"]].concat());
    assert_eq!(text.stdout, fs::read_to_string(data("frame.urdf")).unwrap());
    let mut command = Command::new(env!("CARGO_BIN_EXE_massline"));
    let output = command.args(common).arg("npz").timeout(LATE).output().unwrap();
    assert!(output.stdout == fs::read(data("frame.npz")).unwrap());
}

#[test]
fn a_document_may_come_through_a_pipe() {
    let document = fs::read(data("result.json")).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_massline"));
    let arguments = ["export", "-", "--format", "csv"];
    let output = command.args(arguments).write_stdin(document).timeout(LATE).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("\nJ_xy,0.004253,6.0e-5,"), "{text}");
}

#[test]
fn what_the_program_prints_itself_can_be_exported() {
    let files = Documents::new();
    let simulated = success(&["simulate", LAYOUT]);
    let path = files.write("frame.json", simulated.to_string());
    let exported = run(&["export", &path, "--format", "json", "--layout", LAYOUT]);
    assert_eq!(exported.exit, 0, "{}", exported.stderr);
    assert!(!exported.says("the layout differs"), "{}", exported.stderr);
    let value: Value = serde_json::from_str(&exported.stdout).unwrap();
    let of_host = &simulated["results"][0];
    assert_eq!(value["mass"], of_host["mass_kg"]["value"]);
    assert_eq!(value["inertia"], of_host["inertia_kg_m2"]["value"]);
    // The halves of the host's matrix differ by rounding; the lower one is taken.
    for (i, j) in (0..10).flat_map(|i| (0..=i).map(move |j| (i, j))) {
        assert_eq!(value["covariance"][i][j], of_host["covariance"][i][j], "{i}, {j}");
        assert_eq!(value["covariance"][j][i], value["covariance"][i][j], "{i}, {j}");
    }
    // Another method by its short name, another layout with a warning.
    let other = ["export", &path, "--format", "yaml", "--method", "irm"];
    let other = run(&[&other[..], &["--layout", &data_text("layout.toml")]].concat());
    assert!(other.stdout.contains("method: \"inertia-restraint\""), "{}", other.stdout);
    assert!(other.stdout.contains("verdict: \"use_with_care\""), "{}", other.stdout);
    assert!(other.says("the layout differs from that of the test"), "{}", other.stderr);
}

#[test]
fn wrong_documents_are_refused_with_what_is_wrong() {
    let files = Documents::new();
    let urdf = |path: &str, exit, code| fails(&[path, "--format", "urdf"], exit, code);
    urdf("no-such-result.json", 2, "result_not_readable");
    urdf("/dev/zero", 2, "result_not_readable");
    urdf(&files.write("empty.json", ""), 2, "result_malformed");
    let whole = fs::read(data("result.json")).unwrap();
    urdf(&files.write("cut.json", &whole[..whole.len() / 2]), 2, "result_malformed");
    let newer = files.changed(|v| v["schema_version"] = json!(2));
    assert!(urdf(&newer, 2, "result_too_new").contains("update massline"));
    let none = files.changed(|v| {
        v["results"] = json!([]);
        v["verdict"] = Value::Null;
    });
    urdf(&none, 3, "no_answer");
    // NaN is null in JSON.
    let nan = files.changed(|v| v["results"][0]["mass_kg"]["value"] = Value::Null);
    assert!(
        urdf(&nan, 2, "result_value_wrong")
            .contains("results[0].mass_kg.value: invalid type: null")
    );
    let cut = files.changed(|v| drop(v["results"][0].as_object_mut().unwrap().remove("mass_kg")));
    assert!(urdf(&cut, 2, "result_value_wrong").contains("results[0]: missing field `mass_kg`"));
    let checked = success(&["layout", "check", LAYOUT]);
    urdf(&files.write("check.json", checked.to_string()), 2, "result_malformed");
    let (_, error) = answer(&["layout", "check", "no-such-layout.toml"]);
    urdf(&files.write("error.json", error.to_string()), 2, "result_is_error");
}

#[test]
fn an_unphysical_result_is_written_on_request_only() {
    let files = Documents::new();
    let path = files.changed(|v| {
        v["results"][0]["inertia_kg_m2"]["value"][2][2] = json!(0.05);
        v["results"][0]["interval95"] = Value::Null;
    });
    let message = fails(&[&path, "--format", "urdf"], 3, "unphysical_result");
    assert!(
        message.contains("sum of the other two") && message.contains("--despite-verdict"),
        "{message}"
    );
    // Replacing a file is another matter.
    let target = files.write("frame.urdf", "mine");
    fails(&[&path, "--format", "urdf", "-o", &target, "--force"], 3, "unphysical_result");
    assert_eq!(fs::read(&target).unwrap(), b"mine");
    let written = run(&["export", &path, "--format", "urdf", "--despite-verdict"]);
    assert_eq!(written.exit, 0, "{}", written.stderr);
    assert!(written.says("this is not a physical body"), "{}", written.stderr);
    assert!(written.stdout.contains("NOT A PHYSICAL BODY"), "{}", written.stdout);
    let negative = files.changed(|v| {
        v["results"][0]["mass_kg"]["value"] = json!(-1.0);
        v["results"][0]["interval95"] = Value::Null;
    });
    let message = fails(&[&negative, "--format", "csv"], 3, "unphysical_result");
    assert!(message.contains("the mass is -1.0 kg"), "{message}");
}

#[test]
fn options_that_do_not_go_together_are_refused() {
    let files = Documents::new();
    let (result, layout) = (data_text("result.json"), data_text("layout.toml"));
    let export =
        |arguments: &[&str], code| fails(&[&[result.as_str()], arguments].concat(), 2, code);
    export(&["--format", "urdf", "--units", "t-mm"], "units_not_for_format");
    export(&["--format", "uff", "--frame", "principal"], "frame_not_for_format");
    let message = export(&["--format", "urdf", "--frame", "2"], "unknown_node");
    assert!(message.contains("--layout"), "{message}");
    let message =
        export(&["--format", "urdf", "--frame", "9", "--layout", &layout], "unknown_node");
    assert!(message.contains("has 1, 2, 3, 4, 5"), "{message}");
    export(&["--format", "urdf", "--frame", "tip"], "usage");
    export(&["--format", "stl"], "usage");
    export(&["--format", "urdf", "--method", "conti-bretl"], "no_such_answer");
    let message = export(&["--format", "uff", "--layout", &layout], "no_responses");
    assert!(message.contains("frequency responses"), "{message}");
    // Standard output cannot hold both a file and a JSON object.
    let (run, value) = run_json(&["export", &result, "--format", "npz"]);
    assert_eq!((run.exit, &value["error"]["code"]), (2, &json!("output_needed")));
    let existing = files.write("frame.npz", "mine");
    export(&["--format", "npz", "-o", &existing], "file_exists");
    export(&["--format", "npz", "-o", "/no/such/folder/frame.npz"], "cannot_write");
    let written = success(&["export", &result, "--format", "npz", "-o", &existing, "--force"]);
    assert_eq!(written["method"], "maximum-likelihood");
    assert_eq!(written["physically_consistent"], true);
    fails(&["7", "--format", "urdf", "--port", "/dev/no-such-port"], 4, "port_not_found");
}

#[test]
fn an_archive_is_exported_with_its_nodes_and_responses() {
    let rig = Rig::start(&["--fast"]);
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (layout, archive) = (rig.layout(5), path("frame.massline"));
    let (exit, measured) = rig.run(&["measure", &layout, "-o", &archive]);
    assert_eq!(exit, 0, "{measured}");
    let json = ["export", &archive, "--format", "json", "--frame", "4"];
    let at_node = run(&json);
    assert_eq!(at_node.exit, 0, "{}", at_node.stderr);
    let at_node: Value = serde_json::from_str(&at_node.stdout).unwrap();
    let of_host = &measured["results"][0];
    assert_eq!(at_node["mass"], of_host["mass_kg"]["value"]);
    // Node 4 has the axes of the body: the inertia is the same.
    assert_eq!(at_node["inertia"], of_host["inertia_kg_m2"]["value"]);
    assert_eq!(
        (&at_node["title"], &at_node["source"]),
        (&measured["title"], &json!("frame.massline"))
    );

    let responses = path("frame.uff");
    let written = success(&["export", &archive, "--format", "uff", "-o", &responses]);
    assert_eq!(written["format"], "uff");
    let decay = Archive::read(archive.as_ref()).unwrap().spectra[0].decay_per_s;
    let text = fs::read_to_string(&responses).unwrap();
    assert!(text.contains(&format!("decay {decay:?} 1/s")), "{decay}");
    let solved = success(&["solve", &layout, &responses, "--decay", &decay.to_string()]);
    // Rig and host choose their bands and lines themselves, so the answers differ by a part of a standard deviation;
    // every product of inertia is 30 of them or more, so a wrong sign or axis is far outside.
    let of_file = &solved["results"][0];
    for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
        let [of_file, of_host] = [of_file, of_host]
            .map(|answer| answer["inertia_kg_m2"]["value"][i][j].as_f64().unwrap());
        let sigma = measured["results"][0]["inertia_kg_m2"]["sigma"][i][j].as_f64().unwrap();
        assert!((of_file - of_host).abs() < sigma && of_host.abs() > 30.0 * sigma, "{i}, {j}");
    }
    let [of_file, of_host] =
        [of_file, of_host].map(|answer| answer["mass_kg"]["value"].as_f64().unwrap());
    assert!((of_file / of_host - 1.0).abs() < 0.01, "{of_file} {of_host}");
}

#[test]
fn a_damaged_archive_is_refused_by_name() {
    let files = Documents::new();
    let cut = files.write("cut.massline", r#"{"format":"massline-archive","schema_ver"#);
    fails(&[&cut, "--format", "urdf"], 2, "archive_cut_short");
    let newer = files.write("new.massline", r#"{"format":"massline-archive","schema_version":9}"#);
    fails(&[&newer, "--format", "uff"], 2, "archive_too_new");
    let other = files.write("other.massline", fs::read(data("result.json")).unwrap());
    fails(&[&other, "--format", "uff"], 2, "not_an_archive");
}

#[test]
fn without_a_format_the_formats_and_a_command_are_named() {
    let archive = data_text("../archive/version-1.massline");
    let refused = run(&["export", &archive]);
    assert_eq!(refused.exit, 2, "{}", refused.stderr);
    assert!(refused.says("give one of urdf, sdf, mjcf, conm2"), "{}", refused.stderr);
    let command = format!("massline export {archive} --format csv");
    assert!(refused.says(&command), "{}", refused.stderr);
    let words: Vec<&str> = command.split(' ').skip(1).collect();
    let exported = run(&words);
    assert_eq!(exported.exit, 0, "{}", exported.stderr);
    assert!(exported.stdout.contains("mass"), "{}", exported.stdout);
}

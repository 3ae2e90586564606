//! Archives: written by `measure` and `results get`, listed by `history`, solved again years later.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Command, Stdio};

use massline::support::collected::archive_part::Part;
use massline_client::{self, Client};
use massline_files::archive::Archive;
use massline_result::HitVerdict;
use massline_shared::measurement::campaign::{self, Phase};
use nix::pty::openpty;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use serde_json::{Value, json};

use crate::program::{LAYOUT, Run, answer, run, run_json, success, words};
use crate::rig::Rig;

/// Exit code and code of the error.
fn refusal((exit, answer): (i32, Value)) -> (i32, String) {
    (exit, answer["error"]["code"].as_str().unwrap_or_default().to_owned())
}

fn refused(exit: i32, code: &str) -> (i32, String) {
    (exit, code.to_owned())
}

#[test]
fn an_archive_is_solved_to_the_same_last_digit() {
    let rig = Rig::start(&["--fast"]);
    let folder = tempfile::tempdir().unwrap();
    let layout = rig.layout(3);
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (measured_to, fetched_to) = (path("measured.massline"), path("fetched.massline"));
    let (exit, measured) = rig.run(&["measure", &layout, "-o", &measured_to, "--records"]);
    assert_eq!((exit, &measured["archive"]), (0, &json!(measured_to)), "{measured}");
    let (exit, fetched) = rig.run(&["results", "get", "1", "--output", &fetched_to]);
    assert_eq!(exit, 0, "{fetched}");
    for (file, document) in [(&measured_to, &measured), (&fetched_to, &fetched)] {
        let (exit, solved) = answer(&["solve", file]);
        assert_eq!(exit, 0, "{solved}");
        assert_eq!(solved["results"], document["results"], "{file}");
        for key in ["verdict", "details", "rig", "title", "measured", "mass_lines", "layout_hash"] {
            assert_eq!(solved[key], document[key], "{key} of {file}");
        }
    }
    let archive = Archive::read(measured_to.as_ref()).unwrap();
    assert_eq!(archive.result.dofs.len(), 3);
    for dof in &archive.result.dofs {
        let name = dof.dof.to_string();
        let records = archive.hit_records.iter().filter(|record| record.dof == name).count();
        assert_eq!(records, usize::from(dof.hits), "{name}");
        assert!(
            archive.spectra.iter().any(|spectra| spectra.dof == name && spectra.hits == dof.hits),
            "{name}"
        );
    }
    // Three sensors with three axes each.
    assert_eq!(archive.frfs().len(), 9 * 3);
    assert!(archive.calibration().is_some());
    // The clock of this computer, to within the hour that no test takes.
    let measured_at = archive.measured.unwrap();
    assert_eq!(measured_at.len(), "2026-11-24T08:30:00Z".len());
    assert!(measured_at <= archive.written, "{measured_at} {}", archive.written);

    // The layout in a file of its own gives the same answer.
    let (exit, with_layout) = answer(&["solve", &layout, &measured_to]);
    assert_eq!((exit, &with_layout["results"]), (0, &measured["results"]));
    // Its name does not matter.
    let renamed = path("renamed.json");
    std::fs::copy(&measured_to, &renamed).unwrap();
    assert_eq!(answer(&["solve", &renamed]).1["results"], measured["results"]);
}

#[test]
fn an_existing_archive_is_kept_before_the_rig_is_even_asked() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.massline").display().to_string();
    std::fs::write(&path, "mine").unwrap();
    let no_port = ["--port", "/dev/no-such-port"];
    for command in [&["measure", LAYOUT][..], &["results", "get", "1"]] {
        let with = |more: &[&str]| refusal(answer(&[command, more, &no_port].concat()));
        assert_eq!(with(&["-o", &path]), refused(2, "file_exists"));
        assert_eq!(with(&["-o", &path, "--force"]), refused(4, "port_not_found"));
        assert_eq!(with(&["-o", "/no/such/folder/a.massline"]), refused(2, "cannot_write"));
    }
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
}

/// Runs `measure` into a full disk, with this folder for temporary files.
fn measure_to_a_full_disk(rig: &Rig, temporary: &Path) -> Run {
    let output = Command::new(env!("CARGO_BIN_EXE_massline"))
        .args(["measure", &rig.layout(2), "--output", "/dev/full"])
        .args(["--port", &rig.process.port])
        .env("TMPDIR", temporary)
        .output()
        .unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    let (stdout, stderr) = (text(output.stdout), text(output.stderr));
    Run { exit: output.status.code().unwrap(), stdout, stderr }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_costs_neither_the_answer_nor_the_archive() {
    let rig = Rig::start(&["--fast"]);
    let temporary = tempfile::tempdir().unwrap();
    let measured = measure_to_a_full_disk(&rig, temporary.path());
    assert_eq!(measured.exit, 2, "{}", measured.stderr);
    assert!(measured.stdout.contains("kg"), "the answer is printed: {}", measured.stdout);
    assert!(measured.says("/dev/full: cannot be written: No space left"), "{}", measured.stderr);
    let entries = std::fs::read_dir(temporary.path()).unwrap();
    let [rescued] = &entries.map(|entry| entry.unwrap().path()).collect::<Vec<_>>()[..] else {
        panic!("one file is in the folder for temporary files")
    };
    assert_eq!(Archive::read(rescued).unwrap().spectra.len(), 3);
    let place = rescued.file_name().unwrap().to_str().unwrap();
    assert!(measured.says(place), "{place}: {}", measured.stderr);

    let nowhere = measure_to_a_full_disk(&rig, Path::new("/no/such/folder"));
    assert_eq!(nowhere.exit, 2, "{}", nowhere.stderr);
    let way_out = "result 2 stays on the rig: `massline results get 2 --output FILE`";
    assert!(nowhere.says(way_out), "{}", nowhere.stderr);
    let file = temporary.path().join("2.massline").display().to_string();
    assert_eq!(rig.run(&["results", "get", "2", "--output", &file]).0, 0);
}

#[test]
fn an_interrupted_measurement_loses_neither_frequency_responses_nor_records() {
    // In real time fifteen hits take many seconds, so the interruption comes during the campaign.
    let rig = Rig::start(&[]);
    let layout = rig.layout(5);
    let path = rig.folder.path().join("a.massline");
    let command = ["measure", &layout, "--records", "-o", path.to_str().unwrap()];
    let mut measure = rig.spawn(&command);
    let mut lines = BufReader::new(measure.stderr.take().unwrap()).lines().map_while(Result::ok);
    // Five hits finish the first DOF; its spectra are read before the next one's first hit is accepted.
    assert_eq!(lines.by_ref().filter(|line| line.ends_with("good")).take(7).count(), 7);
    kill(Pid::from_raw(measure.id() as i32), Signal::SIGINT).unwrap();
    let stderr = words(&lines.collect::<Vec<_>>().join(" "));
    assert_eq!(measure.wait().unwrap().code(), Some(130), "{stderr}");
    assert!(stderr.contains("read so far (frequency responses: 1, records of hits: "), "{stderr}");
    assert!(stderr.contains("the same command adds it to the archive"), "{stderr}");
    assert!(!path.exists());

    let (run, measured) = run_json(&[&command[..], &["--port", &rig.process.port]].concat());
    assert_eq!(run.exit, 0, "{measured}");
    assert!(!run.stderr.contains("warning: the archive"), "{}", run.stderr);
    let archive = Archive::read(&path).unwrap();
    assert_eq!((archive.spectra.len(), archive.hit_records.len()), (3, 15));
    assert!(!Part::path(&path).exists());
}

/// Discards the hits of the DOF in hand and takes as many others, as another program or the panel may do.
fn hit_again_elsewhere(rig: &Rig) {
    let mut client = Client::new(massline_client::open(&rig.process.port).unwrap());
    let before = client.status().unwrap().accepted;
    client.command(campaign::Command::Redo).unwrap();
    let mut status = client.command(campaign::Command::Resume).unwrap();
    while status.accepted != before {
        if status.phase == u8::from(Phase::Confirming) {
            client.command(campaign::Command::Accept).unwrap();
        }
        status = client.status().unwrap();
    }
    client.command(campaign::Command::Pause).unwrap();
}

#[test]
fn hits_that_were_replaced_meanwhile_are_not_archived_as_those_of_the_answer() {
    let rig = Rig::start(&[]);
    let layout = rig.layout(5);
    let path = rig.folder.path().join("a.massline");
    let command = ["measure", &layout, "--records", "-o", path.to_str().unwrap()];
    let mut measure = rig.spawn(&command);
    let lines = BufReader::new(measure.stderr.take().unwrap()).lines().map_while(Result::ok);
    assert_eq!(lines.filter(|line| line.ends_with("good")).take(7).count(), 7);
    kill(Pid::from_raw(measure.id() as i32), Signal::SIGINT).unwrap();
    assert_eq!(measure.wait().unwrap().code(), Some(130));
    hit_again_elsewhere(&rig);

    let (run, measured) = run_json(&[&command[..], &["--port", &rig.process.port]].concat());
    assert_eq!(run.exit, 0, "{measured}");
    assert!(run.says("another number of hit records than hits"), "{}", run.stderr);
    let archive = Archive::read(&path).unwrap();
    let hits_with = |verdict: HitVerdict| {
        let hits = archive.hit_log.iter().filter(move |hit| hit.verdict == verdict);
        hits.filter(|hit| hit.dof == "2:+Z").map(|hit| hit.hit).collect::<Vec<_>>()
    };
    assert!(!hits_with(HitVerdict::Unknown).is_empty(), "{:?}", archive.hit_log);
    let records = archive.hit_records.iter().filter(|record| record.dof == "2:+Z");
    let records: Vec<_> = records.map(|record| record.hit).collect();
    assert_eq!(records, hits_with(HitVerdict::Accepted), "{:?}", archive.hit_log);
    // The first DOF was finished before.
    assert_eq!(archive.spectra.len(), 3);
}

#[test]
fn an_archive_without_all_frequency_responses_says_whose_are_missing() {
    let rig = Rig::start(&[]);
    let layout = rig.layout(5);
    let mut measure = rig.spawn(&["measure", &layout]);
    let lines = BufReader::new(measure.stderr.take().unwrap()).lines().map_while(Result::ok);
    assert_eq!(lines.filter(|line| line.ends_with("good")).take(7).count(), 7);
    kill(Pid::from_raw(measure.id() as i32), Signal::SIGINT).unwrap();
    measure.wait().unwrap();

    let path = rig.folder.path().join("a.massline");
    let output = ["-o", path.to_str().unwrap(), "--port", &rig.process.port];
    let measured = run(&[&["measure", &layout][..], &output].concat());
    assert_eq!(measured.exit, 0, "{}", measured.stderr);
    assert!(
        measured.says("the archive has no frequency responses of 1:+Y:"),
        "{}",
        measured.stderr
    );
    assert_eq!(Archive::read(&path).unwrap().spectra.len(), 2);
}

#[test]
fn a_result_of_another_layout_or_calibration_is_archived_without_mixing_them() {
    let rig = Rig::start(&["--fast"]);
    let (first, second) = (rig.layout(3), rig.layout(2));
    let path = |name: &str| rig.folder.path().join(name).display().to_string();
    assert_eq!(rig.run(&["measure", &first]).0, 0);
    assert_eq!(rig.run(&["measure", &second]).0, 0);
    let file = path("first.massline");
    let get = ["results", "get", "1", "--output", &file];
    // The rig keeps its last four layouts.
    let (exit, kept) = rig.run(&["results", "get", "1"]);
    assert_eq!(exit, 0, "{kept}");
    assert_eq!(kept["solved_by"], "host", "{kept}");
    for hits in [1, 4, 5] {
        assert_eq!(rig.run(&["measure", &rig.layout(hits)]).0, 0);
    }
    let (exit, unknown) = rig.run(&get);
    // The rig's own answer is printed; the host cannot solve it again without its layout.
    assert_eq!(exit, 2, "{unknown}");
    assert_eq!(unknown["error"]["code"], "layout_unknown");
    let (_, other) = rig.run(&[&get[..], &["--layout", &second]].concat());
    assert_eq!(other["error"]["code"], "another_layout");

    let calibration = path("calibration.toml");
    assert_eq!(rig.run(&["calibrate", "pull", &calibration]).0, 0);
    let text = std::fs::read_to_string(&calibration).unwrap();
    let changed = text.replacen("sensor_range_m_per_s2 = ", "sensor_range_m_per_s2 = 1", 1);
    std::fs::write(&calibration, changed).unwrap();
    assert_eq!(rig.run(&["calibrate", "push", &calibration]).0, 0);
    let with_layout = [&get[..], &["--layout", &first, "--port", &rig.process.port]].concat();
    let (fetched, document) = run_json(&with_layout);
    assert_eq!(fetched.exit, 0, "{document}");
    let warned = "warning: the rig has another calibration by now";
    assert!(fetched.says(warned), "{}", fetched.stderr);
    let archive = Archive::read(file.as_ref()).unwrap();
    assert_eq!(archive.calibration(), None);
    assert_eq!(answer(&["solve", &file]).1["results"], document["results"]);
}

#[test]
fn the_history_of_a_folder_names_what_it_cannot_read() {
    let rig = Rig::start(&["--fast"]);
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let folder_name = folder.path().display().to_string();
    assert!(run(&["history", &folder_name]).stdout.contains("has no archives that can be read"));
    let layout = rig.layout(3);
    for name in ["b.massline", "a.massline"] {
        assert_eq!(rig.run(&["measure", &layout, "-o", &path(name)]).0, 0);
    }
    std::fs::write(path("cut.massline"), "{\"format\":").unwrap();
    std::fs::write(path("layout.toml"), "title = 5\n").unwrap();
    std::fs::create_dir(path("folder.massline")).unwrap();
    let (exit, history) = answer(&["history", &folder_name]);
    let files = |list: &Value| -> Vec<String> {
        list.as_array()
            .unwrap()
            .iter()
            .map(|entry| entry["file"].as_str().unwrap().to_owned())
            .collect()
    };
    assert_eq!(exit, 0);
    assert_eq!(files(&history["archives"]).len(), 2);
    assert_eq!(files(&history["unreadable"]), [path("cut.massline"), path("folder.massline")]);
    assert_eq!(history["unreadable"][0]["code"], "archive_cut_short");
    assert_eq!(history["unreadable"][1]["code"], "archive_not_readable");
    let one = &history["archives"][0];
    assert_eq!(one["title"], "three-bar frame, test 1");
    assert_eq!(one["verdict"], history["archives"][1]["verdict"]);
    assert!(one["mass_kg"]["sigma"].as_f64().unwrap() > 0.0, "{one}");

    let text = run(&["history", &folder_name]);
    assert_eq!(text.exit, 0);
    assert!(text.says("cut.massline: this archive is cut short"), "{}", text.stderr);
    for word in ["title", "measured", "method", "mass", "verdict", "a.massline", "±"] {
        assert!(text.stdout.contains(word), "{word}: {}", text.stdout);
    }
    assert_eq!(refusal(answer(&["history", "/no/such/folder"])), refused(2, "folder_not_readable"));
    assert_eq!(
        refusal(answer(&["history", &path("a.massline")])),
        refused(2, "folder_not_readable")
    );
}

/// Runs `results delete` at a terminal where this answer is typed: exit code, and what is on the terminal.
fn delete_at_a_terminal(rig: &Rig, numbers: &str, typed: &str) -> (i32, String) {
    let terminal = openpty(None, None).unwrap();
    let end = || Stdio::from(terminal.slave.try_clone().unwrap());
    let mut command = Command::new(env!("CARGO_BIN_EXE_massline"));
    command.args(["results", "delete", numbers, "--port", &rig.process.port]);
    command.stdin(end()).stdout(end()).stderr(end());
    let mut process = command.spawn().unwrap();
    // The terminal keeps what is typed until the question is asked.
    File::from(terminal.master.try_clone().unwrap()).write_all(typed.as_bytes()).unwrap();
    let exit = process.wait().unwrap().code().unwrap();
    drop((command, terminal.slave));
    // Reading a terminal without a program ends with an error.
    let mut shown = Vec::new();
    let _ = File::from(terminal.master).read_to_end(&mut shown);
    (exit, words(&String::from_utf8_lossy(&shown)))
}

#[test]
fn results_are_deleted_at_a_terminal_only_after_a_yes() {
    let rig = Rig::start(&["--fast"]);
    let layout = rig.layout(2);
    for _ in 0..4 {
        assert_eq!(rig.run(&["measure", &layout]).0, 0);
    }
    let kept = || {
        let (_, list) = rig.run(&["results", "list"]);
        let numbers = list["results"].as_array().unwrap().iter();
        numbers.map(|result| result["number"].as_u64().unwrap()).collect::<Vec<_>>()
    };
    let (exit, shown) = delete_at_a_terminal(&rig, "2-3", "n\n");
    assert_eq!((exit, kept()), (130, vec![1, 2, 3, 4]), "{shown}");
    assert!(shown.contains("delete results 2, 3? [y/N]"), "{shown}");
    assert!(shown.contains("nothing was deleted"), "{shown}");
    let (exit, shown) = delete_at_a_terminal(&rig, "2-3", "y\n");
    assert_eq!((exit, kept()), (0, vec![1, 4]), "{shown}");
    assert!(shown.contains("results 2, 3 deleted"), "{shown}");

    // Nobody can be asked: the way out is named before the rig is.
    let unasked = run(&["results", "delete", "--all", "--port", "/dev/no-such-port"]);
    assert_eq!(unasked.exit, 2);
    assert!(unasked.says("there is no keyboard; add --yes"), "{}", unasked.stderr);
    assert_eq!(
        rig.run(&["results", "delete", "2-3", "--yes"]).1["error"]["code"],
        "no_such_result"
    );
    assert_eq!(rig.run(&["results", "delete", "--all", "--yes"]).1["deleted"], json!([1, 4]));
}

/// The archive of version 1 and the numbers of the day on which it was written.
const VERSION_1: &str =
    concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/data/archive/version-1.massline");

/// Mass, centre of mass and the elements xx, yy, zz, xy, xz, yz of the inertia tensor.
fn ten(answer: &Value) -> [f64; 10] {
    let mass = answer["mass_kg"]["value"].as_f64().unwrap();
    let center = |k: usize| answer["center_of_mass_m"]["value"][k].as_f64().unwrap();
    let inertia = |i: usize, k: usize| answer["inertia_kg_m2"]["value"][i][k].as_f64().unwrap();
    [
        mass,
        center(0),
        center(1),
        center(2),
        inertia(0, 0),
        inertia(1, 1),
        inertia(2, 2),
        inertia(0, 1),
        inertia(0, 2),
        inertia(1, 2),
    ]
}

#[test]
fn an_archive_of_version_1_gives_the_numbers_of_its_day() {
    let (exit, solved) = answer(&["solve", VERSION_1]);
    assert_eq!(exit, 0, "{solved}");
    assert_eq!(solved["title"], "three-bar frame, committed archive");
    assert_eq!(solved["measured"], "2026-11-27T23:23:32Z");
    assert_eq!(solved["layout_hash"], "ed77bc53");
    // What the rig has found is only read, so it is the same to the last digit.
    let archive: Value =
        serde_json::from_str(&std::fs::read_to_string(VERSION_1).unwrap()).unwrap();
    let rig = &archive["result"]["estimates"];
    assert_eq!(rig[0]["properties"][0], 1.2543043);
    assert_eq!(rig[1]["properties"][0], 1.2494882);
    // What the host finds is computed. Another order of its operations changes the last digits; a part in a million,
    // far below every standard deviation, is another answer.
    let close = |actual: [f64; 10], expected: [f64; 10]| {
        for (actual, expected) in actual.into_iter().zip(expected) {
            assert!((actual / expected - 1.0).abs() < 1e-6, "{actual} instead of {expected}");
        }
    };
    let host = &solved["results"];
    assert_eq!(host[0]["method"], "maximum-likelihood");
    let likely = [
        1.2543038849226078,
        0.16973513097032697,
        -0.08690966294071951,
        0.0185890923222829,
        0.011237046414482841,
        0.007037380352423246,
        0.014219173596611567,
        0.004441038771395667,
        -0.0009236021944461107,
        0.002694425923416184,
    ];
    close(ten(&host[0]), likely);
    assert_eq!(host[1]["method"], "inertia-restraint");
    let restrained = [
        1.249487829000673,
        0.17003650984354493,
        -0.08688990592460222,
        0.018423259028745895,
        0.011220625661758497,
        0.007110524105830223,
        0.014227558401618065,
        0.004460381513919716,
        -0.0011495183437991285,
        0.0026262782486336867,
    ];
    close(ten(&host[1]), restrained);

    let archive = Archive::read(VERSION_1.as_ref()).unwrap();
    assert_eq!(
        (archive.rig.board.as_str(), archive.written.as_str()),
        ("virtual", "2026-11-27T23:23:32Z")
    );
    assert!(archive.layout.toml.is_some_and(|text| text.contains("hits_per_dof = 3")));
    let hits: Vec<u8> = archive.result.dofs.iter().map(|dof| dof.hits).collect();
    assert_eq!(hits, [3, 3, 3]);
}

#[test]
fn options_without_effect_on_an_archive_are_refused_by_name() {
    for (option, value) in [
        ("--reference-point", "origin"),
        ("--shapes", "all"),
        ("--lines-per-side", "2"),
        ("--hits", "1:+Y"),
        ("--quantity", "mobility"),
        ("--decay", "10"),
        ("--suspension-band", "1:10"),
    ] {
        for files in [&[VERSION_1][..], &[LAYOUT, VERSION_1]] {
            let (run, refused) = run_json(&[&["solve"], files, &[option, value]].concat());
            assert_eq!((run.exit, &refused["error"]["code"]), (2, &"usage".into()), "{option}");
            let message = refused["error"]["message"].as_str().unwrap();
            assert!(
                message.contains(&format!("{option} does not apply to an archive")),
                "{message}"
            );
        }
    }
    let usage = refused(2, "usage");
    // A method of suspension modes has no lines about them.
    assert_eq!(refusal(answer(&["solve", VERSION_1, "--method", "dppim"])), usage);
    let (exit, one) = answer(&["solve", VERSION_1, "--method", "irm"]);
    assert_eq!((exit, one["results"].as_array().unwrap().len()), (0, 1));
    // The wrong order, and a layout alone.
    assert_eq!(refusal(answer(&["solve", VERSION_1, LAYOUT])), usage);
    assert_eq!(refusal(answer(&["solve", LAYOUT])), usage);
}

#[test]
fn an_archive_is_solved_with_a_corrected_layout_but_not_with_that_of_another_test() {
    let folder = tempfile::tempdir().unwrap();
    let archive = Archive::read(VERSION_1.as_ref()).unwrap();
    let text = archive.layout.toml.unwrap();
    let solve = |from: &str, to: &str| {
        assert!(text.contains(from), "{from} is in {text}");
        let path = folder.path().join("layout.toml");
        std::fs::write(&path, text.replace(from, to)).unwrap();
        run_json(&["solve", path.to_str().unwrap(), VERSION_1])
    };
    // Ten millimetres at one sensor.
    let (solved, corrected) = solve("0.2079, 0.0, 0.0", "0.2179, 0.0, 0.0");
    assert_eq!(solved.exit, 0, "{corrected}");
    let (_, as_measured) = answer(&["solve", VERSION_1]);
    // The answer is the one with the corrected layout.
    assert_ne!(corrected["results"], as_measured["results"]);
    assert_eq!(
        (&corrected["rig"]["agrees"], &as_measured["rig"]["agrees"]),
        (&false.into(), &true.into())
    );
    // It stands alone, and the rig's answer is compared with it in a line.
    let path = folder.path().join("layout.toml");
    let text_of = run(&["solve", path.to_str().unwrap(), VERSION_1]).stdout;
    let tables = text_of.lines().filter(|line| line.contains("± 95 %")).count();
    assert_eq!((tables, text_of.matches("\nrig: its ").count()), (1, 1), "{text_of}");
    // A band has no effect on mass lines, and the program says so.
    let (run, same) = solve("hits_per_dof = 3", "hits_per_dof = 3\nband_hz = [20.0, 100.0]");
    assert_eq!(same["results"], as_measured["results"]);
    assert!(run.says("band_hz and terms of [test] have no effect"), "{}", run.stderr);

    let (_, other) = solve("\"4:+X\"", "\"4:+Y\"");
    assert_eq!(other["error"]["code"], "another_layout");
    let message = other["error"]["message"].as_str().unwrap();
    assert!(message.contains("layout.toml") && message.contains("version-1.massline"), "{message}");
}

/// Cut, newer, of another kind, empty, a folder, endless: each is named with the file and what to do.
#[test]
fn what_is_no_archive_of_this_version_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let whole = std::fs::read_to_string(VERSION_1).unwrap();
    let newer = whole.replacen("\"schema_version\":1", "\"schema_version\":2", 1);
    let nan = whole.replacen("\"noise\":[", "\"noise\":[NaN,", 1);
    let result = "{\"schema_version\":1,\"results\":[]}";
    for (content, code, way_out) in [
        (&whole[..whole.len() / 2], "archive_cut_short", "`massline results get`"),
        (&newer, "archive_too_new", "update the program"),
        (&nan, "not_an_archive", "it is not JSON"),
        (result, "not_an_archive", "`massline measure -o` write archives"),
        ("title = \"a layout\"\n", "not_an_archive", "it is not JSON"),
        ("", "not_an_archive", "this file is empty"),
    ] {
        let path = folder.path().join("a.massline").display().to_string();
        std::fs::write(&path, content).unwrap();
        let (run, refused) = run_json(&["solve", &path]);
        assert_eq!((run.exit, &refused["error"]["code"]), (2, &json!(code)), "{refused}");
        let message = refused["error"]["message"].as_str().unwrap();
        assert!(message.starts_with(&path) && message.contains(way_out), "{message}");
        // Beside a layout the same.
        assert_eq!(answer(&["solve", LAYOUT, &path]).1["error"]["code"], code);
    }
    let folder_itself = folder.path().join("b.massline");
    std::fs::create_dir(&folder_itself).unwrap();
    let not_readable = refused(2, "archive_not_readable");
    assert_eq!(refusal(answer(&["solve", folder_itself.to_str().unwrap()])), not_readable);
    assert_eq!(refusal(answer(&["solve", "no-such.massline"])), not_readable);
    let endless = folder.path().join("c.massline");
    std::os::unix::fs::symlink("/dev/zero", &endless).unwrap();
    assert_eq!(refusal(answer(&["solve", endless.to_str().unwrap()])), not_readable);
}

/// A file system may have names that are not UTF-8, which JSON cannot have.
#[cfg(target_os = "linux")]
#[test]
fn the_history_lists_a_file_whose_name_is_not_utf_8() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;

    let folder = tempfile::tempdir().unwrap();
    for name in [b"m\xfcller.massline".as_slice(), b"plain.massline"] {
        std::fs::copy(VERSION_1, folder.path().join(OsStr::from_bytes(name))).unwrap();
    }
    std::fs::write(folder.path().join(OsStr::from_bytes(b"\xff.massline")), "{").unwrap();
    let history = success(&["history", folder.path().to_str().unwrap()]);
    let names = |list: &str| -> Vec<String> {
        let files = history[list].as_array().unwrap().iter();
        let name = |path: &str| path.rsplit_once('/').unwrap().1.to_owned();
        files.map(|file| name(file["file"].as_str().unwrap())).collect()
    };
    assert_eq!(names("archives"), ["m\u{fffd}ller.massline", "plain.massline"]);
    assert_eq!(names("unreadable"), ["\u{fffd}.massline"]);
}

/// The same node, moved by hand in one of the places that state it.
#[test]
fn an_archive_that_contradicts_itself_is_neither_solved_nor_exported() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(VERSION_1).unwrap();
    let archive: Value = serde_json::from_str(&text).unwrap();
    for place in ["/layout/nodes/1/position_m/0", "/layout/resolved/sensors/1/position/0"] {
        let mut moved = archive.clone();
        let number = moved.pointer_mut(place).unwrap();
        *number = json!(number.as_f64().unwrap() + 0.02);
        let path = folder.path().join("moved.massline").display().to_string();
        std::fs::write(&path, moved.to_string()).unwrap();
        for command in [
            &["solve", &path][..],
            &["export", &path, "--format", "csv", "-o", "/dev/null", "--force"],
        ] {
            let (exit, code) = refusal(answer(command));
            assert_eq!(exit, 2, "{command:?}: {code}");
        }
        let refused = run(&["solve", &path]);
        assert!(refused.says("layout.resolved.sensors[1].position is"), "{}", refused.stderr);
        assert!(refused.says("layout.nodes (node 2) says"), "{}", refused.stderr);
    }
}

#[test]
fn the_next_step_that_is_proposed_can_be_typed() {
    let rig = Rig::start(&["--fast"]);
    let folder = rig.folder.path();
    let kept = folder.join("my test.massline").display().to_string();
    let typed = |arguments: &[&str]| {
        let shown = run(arguments);
        assert_eq!(shown.exit, 0, "{}", shown.stderr);
        let text = shown.stdout + &shown.stderr;
        let (_, next) = text.rsplit_once("next: `").expect("a next step");
        let line = next.split('`').next().unwrap().to_owned();
        let program = env!("CARGO_BIN_EXE_massline");
        let line = line.replacen("massline", program, 1);
        let mut shell = std::process::Command::new("sh");
        let ended = shell.args(["-c", &line]).current_dir(folder).output().unwrap();
        assert!(ended.status.success(), "{line}: {}", String::from_utf8_lossy(&ended.stderr));
    };
    typed(&["measure", &rig.layout(2), "--port", rig.port()]);
    assert!(folder.join("result-1.massline").is_file());
    typed(&["measure", &rig.layout(2), "-o", &kept, "--port", rig.port()]);
    // A page that exists is kept.
    let copy = folder.join("copy.massline").display().to_string();
    std::fs::copy(&kept, &copy).unwrap();
    typed(&["solve", &copy]);
}

//! `massline hits` on hammer data recorded by a third party, and on files that are not recordings.

use std::path::{Path, PathBuf};

use serde_json::Value;
use tempfile::TempDir;

use crate::program::{self, run_json};

pub const RATE: f64 = 51_200.0;

pub fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/pyfrf-impact").join(name)
}

/// Units of a recording that states none: force first.
pub const SI: [&str; 4] = ["--unit", "1=N", "--unit", "*=m/s^2"];

/// Exit code, JSON and text.
pub fn run(arguments: &[&str]) -> (i32, Value, String) {
    let (run, value) = run_json(&[&["hits"], arguments].concat());
    (run.exit, value, run.stderr)
}

/// Segment, verdict and codes of every hit.
#[track_caller]
pub fn verdicts(arguments: &[&str]) -> Vec<(u64, String, Vec<String>)> {
    let (exit, value, stderr) = run(arguments);
    assert_eq!(exit, 0, "{stderr}");
    let summary = |hit: &Value| {
        let codes = hit["codes"].as_array().unwrap().iter();
        let codes = codes.map(|code| code.as_str().unwrap().to_owned()).collect();
        (hit["segment"].as_u64().unwrap(), hit["verdict"].as_str().unwrap().to_owned(), codes)
    };
    value["hits"].as_array().unwrap().iter().map(summary).collect()
}

/// The five hits as the record's own description grades them.
fn expected() -> Vec<(u64, String, Vec<String>)> {
    let hit = |segment, verdict: &str, codes: &[&str]| {
        (segment, verdict.to_owned(), codes.iter().map(|&code| code.to_owned()).collect())
    };
    vec![
        hit(0, "rejected", &["overload"]),
        hit(1, "accepted", &[]),
        hit(2, "rejected", &["double_hit"]),
        hit(3, "accepted", &[]),
        hit(4, "accepted", &[]),
    ]
}

/// The segments of the third-party record: rows of force and response.
pub fn segments() -> Vec<Vec<[f64; 2]>> {
    const SAMPLES: usize = 4608;
    let file = std::fs::read(data("impact2_response0.npy")).unwrap();
    let values = &file[file.len() - 5 * SAMPLES * 2 * 8..];
    let rows: Vec<[f64; 2]> = values
        .chunks_exact(16)
        .map(|row| [0, 8].map(|at| f64::from_le_bytes(row[at..at + 8].try_into().unwrap())))
        .collect();
    rows.chunks_exact(SAMPLES).map(<[_]>::to_vec).collect()
}

#[test]
fn the_real_record_is_graded_as_described_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, content: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        path.display().to_string()
    };
    let npy = data("impact2_response0.npy").display().to_string();
    let rate = ["--rate-hz", "51200"];
    assert_eq!(verdicts(&[&[npy.as_str()], &rate[..], &SI].concat()), expected());

    let lvm = data("impact2_response0.lvm").display().to_string();
    assert_eq!(verdicts(&[&lvm]), expected());
    let comma = std::fs::read_to_string(&lvm).unwrap().replace('.', ",");
    assert_eq!(verdicts(&[&write("comma.lvm", &comma)]), expected());

    let mut uff = String::new();
    for segment in segments() {
        for (channel, data_type) in [(0, 13), (1, 12)] {
            uff += &time_record(&segment, channel, data_type);
        }
    }
    assert_eq!(verdicts(&[&[write("impact.uff", &uff).as_str()], &SI[..]].concat()), expected());
}

/// A dataset 58 with a time record: ASCII, double precision, even abscissa.
pub fn time_record(segment: &[[f64; 2]], channel: usize, data_type: i32) -> String {
    time_record_in(segment, channel, (data_type, "NONE"))
}

/// The same with a label of the unit.
pub fn time_record_in(
    segment: &[[f64; 2]],
    channel: usize,
    (data_type, unit): (i32, &str),
) -> String {
    let mut text = time_header(channel, (segment.len(), Some(RATE.recip())), (data_type, unit));
    for row in segment.chunks(4) {
        row.iter().for_each(|values| text += &format!("{:20.11e}", values[channel]));
        text.push('\n');
    }
    text + "    -1\n"
}

/// What stands before the values of a time record in double precision: of so many points, and with this step of an even
/// abscissa.
pub fn time_header(
    channel: usize,
    (points, step): (usize, Option<f64>),
    (data_type, unit): (i32, &str),
) -> String {
    let mut text = format!("    -1\n    58\n{}", "NONE\n".repeat(5));
    let nodes = format!("{:10} {:9}   3 {:10} {:9}   3", "NONE", channel + 1, "NONE", 1);
    text += &format!("    1         0    0         0 {nodes}\n");
    let (spacing, step) = (u8::from(step.is_some()), step.unwrap_or_default());
    text += &format!("{:10}{points:10}{spacing:10}{:13.5e}{step:13.5e}{:13.5e}\n", 4, 0.0, 0.0);
    for (kind, unit) in [(17, "NONE"), (data_type, unit), (0, "NONE"), (0, "NONE")] {
        text += &format!("{kind:10}    0    0    0 {:20} {unit:20}\n", "NONE");
    }
    text
}

#[test]
fn a_continuous_text_file_is_cut_into_its_hits() {
    let folder = tempfile::tempdir().unwrap();
    // The hits, each after 20 ms of rest, in German and in English format.
    let (mut german, mut english) = (String::from("Zeit [s];Kraft [N];a [m/s²]\n"), String::new());
    let mut n = 0;
    for segment in segments() {
        let rest = segment[..40].iter().cycle().take(1100);
        for [force, response] in rest.chain(&segment) {
            let row = [f64::from(n) / RATE, *force, *response].map(|v| format!("{v:.7}"));
            german += &(row.join(";").replace('.', ",") + "\n");
            english += &(row.join(",") + "\r\n");
            n += 1;
        }
    }
    for text in [german, english] {
        let path = folder.path().join("taps.csv");
        std::fs::write(&path, text).unwrap();
        let path = path.display().to_string();
        let hits = verdicts(&[&[path.as_str(), "--record-s", "0.09"], &SI[..]].concat());
        assert_eq!(hits, expected());
    }
}

#[test]
fn a_policy_changes_the_verdict_and_keep_the_number_of_hits() {
    let npy = data("impact2_response0.npy").display().to_string();
    let known = [&[npy.as_str(), "--rate-hz", "51200"], &SI[..]].concat();
    let hits = verdicts(&[&known[..], &["--policy", "double_hit=warn"]].concat());
    assert_eq!(hits[2].1, "warning");
    let (_, value, _) = run(&[&known[..], &["--keep", "2"]].concat());
    let kept = value["hits"].as_array().unwrap().iter().filter(|hit| hit["kept"] == true).count();
    assert_eq!(kept, 2);
    // With the hammer's range given: the good hits of 154 to 177 N come close to 180 N.
    let hits = verdicts(&[&known[..], &["--force-range-n", "180"]].concat());
    assert!(hits[1].2.contains(&"too_hard".to_owned()), "{hits:?}");
}

/// A file with invalid content, which must end with exit code 2, this error code and a message with these
/// words.
struct BadRecording<'a> {
    name: &'a str,
    content: Vec<u8>,
    arguments: &'a [&'a str],
    code: &'a str,
    words: &'a [&'a str],
}

#[test]
fn whatever_is_no_recording_is_named() {
    let lvm = std::fs::read_to_string(data("impact2_response0.lvm")).unwrap();
    let npy = std::fs::read(data("impact2_response0.npy")).unwrap();
    let rows = |line: &str| format!("Force;Acc\n{}", line.repeat(100));
    let rate: &[&str] = &["--rate-hz", "4000"];
    let units: &[&str] = &SI;
    let both: &[&str] = &["--rate-hz", "4000", "--unit", "1=N", "--unit", "*=m/s^2"];
    let bad = |name, content: &[u8], arguments, code, words| BadRecording {
        name,
        content: content.to_vec(),
        arguments,
        code,
        words,
    };
    let ragged = rows("1.0;2.0\n") + "3.0\n";
    let wrong_decimal = lvm.replacen("-0.158373", "-0,158373", 1);
    let point_in_a_row: String = (1..)
        .zip(triggered_record().lines())
        .map(|(n, line)| if n == 14 { line.replace(',', ".") } else { line.to_owned() } + "\n")
        .collect();
    let infinite = rows("1.0;2.0\n") + "1e999;2.0\n";
    let absurd = rows("1.0;2.0\n") + "1e300;2.0\n";
    let not_a_number = rows("1.0;2.0\n") + "NaN;2.0\n";
    let shape =
        String::from_utf8_lossy(&npy[..128]).replace("(5, 4608, 2)", "(5, 9999999999999, 2)");
    assert!(shape.contains("9999999999999"));
    let mut huge_shape = npy[..10].to_vec();
    huge_shape.extend(shape.chars().skip(10).map(|c| c as u8));
    let header = u16::try_from(huge_shape.len() - 10).unwrap();
    huge_shape[8..10].copy_from_slice(&header.to_le_bytes());
    for bad in [
        bad("empty.csv", b"", rate, "recording_empty", &["empty"]),
        bad("blank.csv", b"\n \r\n", rate, "recording_empty", &["empty"]),
        bad("picture.png", b"\x89PNG\r\n\x1a\n\0\0", rate, "recording_unknown_format", &["lvm"]),
        bad("prose.txt", b"Dear Sir or Madam", rate, "recording_unknown_format", &["CSV"]),
        bad(
            "nan.csv",
            not_a_number.as_bytes(),
            rate,
            "data_not_finite",
            &["sample 100", "channel 1"],
        ),
        bad("absurd.csv", absurd.as_bytes(), rate, "data_not_finite", &["sample 100"]),
        bad("infinite.csv", infinite.as_bytes(), rate, "data_not_finite", &["inf"]),
        bad(
            "ragged.csv",
            ragged.as_bytes(),
            rate,
            "recording_malformed",
            &["line 102", "1 columns"],
        ),
        bad(
            "text.csv",
            (rows("1.0;2.0\n") + "1.0;two\n").as_bytes(),
            rate,
            "recording_malformed",
            &["line 102", "column 2", "\"two\""],
        ),
        bad(
            "decimal.lvm",
            wrong_decimal.as_bytes(),
            &[],
            "recording_malformed",
            &["line 24", "-0,158373", "decimal point"],
        ),
        bad(
            "both.lvm",
            point_in_a_row.as_bytes(),
            &[],
            "recording_malformed",
            &["line 14, column 2", "decimal comma"],
        ),
        bad(
            "thousands.csv",
            (rows("1,5;2,5\n") + "1.234,5;2,5\n").as_bytes(),
            rate,
            "recording_malformed",
            &["line 102, column 1", "1.234,5", "decimal comma"],
        ),
        bad(
            "commas.csv",
            b"Force,Acc\n1,5,2,25\n",
            rate,
            "recording_malformed",
            &["line 2, column 2", "\"5\"", "semicolons"],
        ),
        bad(
            "nameless_commas.csv",
            "1,5,2,0625\n".repeat(100).as_bytes(),
            rate,
            "recording_malformed",
            &["line 1, column 4", "\"0625\""],
        ),
        bad("cut.lvm", &lvm.as_bytes()[..90_000], &[], "recording_truncated", &["2048 samples"]),
        bad("header.lvm", &lvm.as_bytes()[..100], &[], "recording_truncated", &["End_of_Header"]),
        bad("cut.npy", &npy[..9000], rate, "recording_truncated", &["4608"]),
        bad("huge.npy", &huge_shape, rate, "recording_truncated", &["9999999999999"]),
        bad(
            "one.csv",
            "1.5\n2.5\n1.5\n".repeat(50).as_bytes(),
            rate,
            "no_response",
            &["one channel"],
        ),
        bad(
            "names.csv",
            "left;right\n1.0;2.0\n".as_bytes(),
            rate,
            "no_force",
            &["1 \"left\"", "2 \"right\"", "--force"],
        ),
        bad("rate.csv", rows("1.0;2.0\n").as_bytes(), units, "no_rate", &["--rate-hz"]),
        bad("quiet.csv", rows("0.1;0.2\n").as_bytes(), both, "no_hit", &["--trigger-n"]),
        bad(
            "frf.uff",
            &std::fs::read(data("../uff/a_irm_01.ascii.uff")).unwrap(),
            rate,
            "recording_malformed",
            &["time records", "solve"],
        ),
        bad(
            "forces.csv",
            "Force [N];Reaction force;a\n1.0;2.0;3.0\n".as_bytes(),
            rate,
            "several_forces",
            &["2 \"Reaction force\"", "--leave-out"],
        ),
        bad(
            "rates.lvm",
            lvm.replacen("Delta_X\t", "Delta_X\t0.5\t", 1).as_bytes(),
            &[],
            "recording_malformed",
            &["Delta_X", "one rate"],
        ),
        bad("cut.uff", b"    -1\n    58\nNONE\n", rate, "uff_truncated", &["dataset 1"]),
    ] {
        let folder = tempfile::tempdir().unwrap();
        check(&folder, &bad);
    }
}

#[track_caller]
fn check(folder: &TempDir, bad: &BadRecording<'_>) {
    let path = folder.path().join(bad.name);
    std::fs::write(&path, &bad.content).unwrap();
    let path = path.display().to_string();
    let mut arguments = vec![path.as_str()];
    arguments.extend(bad.arguments);
    let (exit, value, stderr) = run(&arguments);
    assert_eq!(exit, 2, "{}: {stderr}", bad.name);
    assert_eq!(value["error"]["code"], bad.code, "{}: {stderr}", bad.name);
    let message = value["error"]["message"].as_str().unwrap();
    for word in bad.words.iter().copied().chain([bad.name]) {
        assert!(message.contains(word), "{}: {word:?} is not in {message:?}", bad.name);
    }
}

#[test]
fn a_file_that_is_too_long_or_not_there_is_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("long.csv");
    let file = std::fs::File::create(&path).unwrap();
    // A sparse file, which takes no space on disk.
    file.set_len(massline_files::recording::MAX_BYTES + 1).unwrap();
    let (exit, value, _) = run(&[&path.display().to_string()]);
    assert_eq!((exit, &value["error"]["code"]), (2, &"recording_not_readable".into()));
    let (exit, value, _) = run(&[&folder.path().join("none.csv").display().to_string()]);
    assert_eq!((exit, &value["error"]["code"]), (2, &"recording_not_readable".into()));
}

#[test]
fn another_rate_than_that_of_the_file_is_said() {
    let file = data("impact2_response0.lvm").display().to_string();
    let (exit, value, stderr) = run(&[&file, "--rate-hz", "25600"]);
    assert_eq!(exit, 0);
    let sentence = "the file states 51200 Hz, using 25600 Hz from --rate-hz";
    assert!(stderr.contains(&format!("warning: {sentence}")), "{stderr}");
    assert_eq!(value["notes"][0], sentence);
    let (_, value, stderr) = run(&[&file, "--rate-hz", "51200"]);
    assert!(stderr.is_empty() && value["notes"].as_array().unwrap().is_empty(), "{stderr}");
}

#[test]
fn more_than_sixty_four_hits_are_all_compared() {
    // One good hit several times, each slightly louder so that none is a copy, and one whose response is
    // inverted.
    let folder = TempDir::new().unwrap();
    let good = segments().swap_remove(1);
    let times = 70;
    let mut values: Vec<f64> = Vec::new();
    for k in 0..times {
        let gain = 1.0 + 1e-3 * f64::from(k);
        let sign = if k == times - 2 { -1.0 } else { 1.0 };
        values.extend(
            good.iter().flat_map(|[force, response]| [gain * force, sign * gain * response]),
        );
    }
    let shape = format!("({times}, {}, 2)", good.len());
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut npy = b"\x93NUMPY\x01\x00".to_vec();
    npy.extend((header.len() as u16).to_le_bytes());
    npy.extend(header.as_bytes());
    npy.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    let path = folder.path().join("many.npy");
    std::fs::write(&path, npy).unwrap();
    let path = path.display().to_string();
    let rate = RATE.to_string();
    let (exit, value, stderr) = run(&[&[path.as_str(), "--rate-hz", &rate], &SI[..]].concat());
    assert_eq!(exit, 0, "{stderr}");
    let hits = value["hits"].as_array().unwrap();
    assert!(hits.iter().all(|hit| hit["distance_relative"].is_number()));
    let odd: Vec<_> = hits.iter().filter(|hit| hit["kept"] == false).collect();
    assert_eq!(odd.len(), 1);
    assert_eq!((&odd[0]["segment"], &odd[0]["codes"][0]), (&68.into(), &"hit_elsewhere".into()));
}

#[test]
fn advice_about_the_band_names_the_option() {
    let file = data("impact2_response0.lvm").display().to_string();
    let text = program::run(&["hits", &file, "--band-hz", "10", "9000"]).stdout;
    assert!(text.contains("force_spectrum_low") && text.contains("--band-hz"), "{text}");
    assert!(!text.contains("test.band_hz"), "{text}");
}

/// A LabVIEW file with decimal comma of one triggered hit: the second of the third-party record, from 0.6 ms
/// before its force rises, with the acceleration in g.
pub fn triggered_record() -> String {
    let rows = &segments()[1];
    let touch = rows.iter().position(|[force, _]| *force > 3.0).unwrap();
    let lead = (0.6e-3 * RATE).round() as usize;
    let rows = &rows[touch - lead..];
    let mut text = String::from(
        "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t,\nX_Columns\tOne\n\
         ***End_of_Header***\t\n\t\nChannels\t2\t\t\n",
    );
    text += &format!("Samples\t{0}\t{0}\n", rows.len());
    text += "Y_Unit_Label\tNewtons\tg\nDelta_X\t1,953125E-5\t1,953125E-5\n***End_of_Header***\n";
    text += "X_Value\tForce\tAcceleration\tComment\n";
    for (n, [force, acceleration]) in rows.iter().enumerate() {
        let row = format!("{}\t{force:.6}\t{:.8}\n", n as f64 / RATE, acceleration / 9.80665);
        text += &row.replace('.', ",");
    }
    text
}

/// The third-party record in the forms that other programs export.
#[test]
fn quotes_comments_units_orders_and_bytes_of_other_programs_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, content: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        path.display().to_string()
    };
    let (rate, good) = (["--rate-hz", "51200"], vec![(0, "accepted".to_owned(), Vec::new())]);
    let hit = &segments()[1];
    let rows = |quote: &str| -> String {
        let row = |[f, a]: &[f64; 2]| format!("{quote}{f}{quote},{quote}{a}{quote}\n");
        hit.iter().map(row).collect()
    };
    for header in [
        "\"Force, top\",\"Acc\"\n",
        "# exported by hand\n# 2026-11-24, 10:00, rig 3\nForce,Acc\n",
        "# Force,Acc\n",
        "Force,Acc\nN,m/s²\n",
        "Force,Acc\n[N],[m/s^2]\n",
    ] {
        for quote in ["", "\""] {
            let file = write("taps.csv", (header.to_owned() + &rows(quote)).as_bytes());
            assert_eq!(verdicts(&[&[file.as_str()], &rate[..], &SI].concat()), good, "{header}");
        }
    }
    // The unit of a row of its own counts.
    let peak = |file: &str| {
        let (_, value, _) = run(&[&[file], &rate[..]].concat());
        value["hits"][0]["peak_force_n"].as_f64().unwrap()
    };
    let newtons = peak(&write("n.csv", ("Force,Acc\nN,g\n".to_owned() + &rows("")).as_bytes()));
    let pounds = peak(&write("lbf.csv", ("Force,Acc\nlbf,g\n".to_owned() + &rows("")).as_bytes()));
    // The larger force reaches the trigger a sample earlier, which moves the zero level by its noise.
    assert!((pounds / newtons - 4.448_221_6).abs() < 1e-4, "{newtons} {pounds}");

    let samples = hit.len();
    let npy = |descr: &str, fortran: bool, data: Vec<u8>| {
        let order = if fortran { "True" } else { "False" };
        let head = format!(
            "{{'descr': '{descr}', 'fortran_order': {order}, 'shape': ({samples}, 2), }}\n"
        );
        let mut bytes = b"\x93NUMPY\x01\0".to_vec();
        bytes.extend(u16::try_from(head.len()).unwrap().to_le_bytes());
        bytes.extend(head.bytes());
        bytes.extend(data);
        bytes
    };
    let by_row = || hit.iter().flatten();
    let by_column = || (0..2).flat_map(|k| hit.iter().map(move |row| &row[k]));
    let big = by_row().flat_map(|v| v.to_be_bytes()).collect();
    let columns = by_column().flat_map(|v| v.to_le_bytes()).collect();
    for (name, bytes) in
        [("big.npy", npy(">f8", false, big)), ("columns.npy", npy("<f8", true, columns))]
    {
        let file = write(name, &bytes);
        assert_eq!(verdicts(&[&[file.as_str()], &rate[..], &SI].concat()), good, "{name}");
    }
}

#[test]
fn a_recording_of_rejected_hits_alone_is_no_success() {
    let lvm = data("impact2_response0.lvm").display().to_string();
    let arguments = [lvm.as_str(), "--min-peak-force-n", "5000"];
    let (exit, value, _) = run(&arguments);
    assert_eq!((exit, &value["error"]["code"]), (3, &"all_hits_rejected".into()));
    assert_eq!(value["hits"].as_array().unwrap().len(), 5);
    let text = program::run(&[&["hits"], &arguments[..]].concat());
    assert_eq!(text.exit, 3);
    assert!(text.stdout.contains("best consistent set: none"), "{}", text.stdout);
    assert!(text.says("all 5 hits were rejected"), "{}", text.stderr);
}

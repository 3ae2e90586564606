//! `massline hits` on what other recorders write: times, encodings, separators, decimal signs, headers, signals in mV.
//!
//! All files hold the same hit: a half sine of 60 N at 0.4 s, sampled at 5120 Hz, and a response that reaches 24.7 m/s².

use std::fmt::Write;

use serde_json::Value;
use tempfile::TempDir;

use crate::hits::{run, time_header};
use crate::program;

const RATE: f64 = 5120.0;
const SAMPLES: usize = 6144;
/// The sample at which the force begins, after 0.4 s.
const CONTACT: usize = 2048;
const PEAK_N: f64 = 60.0;
const PEAK_M_PER_S2: f64 = 24.7;

/// Force and response of a row.
fn sample(row: usize) -> [f64; 2] {
    let since = row.wrapping_sub(CONTACT);
    // Noise of a tenth of a newton, the same in every run.
    let noise = |seed: usize| ((row * 7919 + seed) % 101) as f64 * 2e-3 - 0.1;
    if since >= SAMPLES {
        return [noise(0), 0.1 * noise(50)];
    }
    let t = since as f64 / RATE;
    let pulse =
        if since <= 16 { PEAK_N * (std::f64::consts::PI * since as f64 / 16.0).sin() } else { 0.0 };
    let ringing = PEAK_M_PER_S2 * (-30.0 * t).exp() * (std::f64::consts::TAU * 60.0 * t).sin();
    [pulse + noise(0), ringing / 0.88 + 0.1 * noise(50)]
}

/// A file with these lines before the numbers; `row` writes a row of time, force and response.
fn text(header: &str, row: impl Fn(usize, f64, [f64; 2]) -> String) -> String {
    let mut text = header.to_owned();
    for k in 0..SAMPLES {
        text += &row(k, k as f64 / RATE, sample(k));
        text.push('\n');
    }
    text
}

/// Columns with a comma, and the time times a factor.
fn scaled(header: &str, factor: f64) -> String {
    text(header, |_, t, [f, a]| format!("{},{f:.5},{a:.5}", t * factor))
}

struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) -> String {
        let path = self.0.path().join(name);
        std::fs::write(&path, content).unwrap();
        path.display().to_string()
    }
}

/// Grades a file and checks rate and peaks of its only hit.
#[track_caller]
fn graded(arguments: &[&str]) -> Value {
    let (exit, value, stderr) = run(arguments);
    assert_eq!(exit, 0, "{value} {stderr}");
    let number = |value: &Value| value.as_f64().unwrap();
    let rate = number(&value["recording"]["rate_hz"]);
    // A time of two significant digits gives the rate to better than a thousandth.
    assert!((rate / RATE - 1.0).abs() < 1e-3, "{rate}");
    let hits = value["hits"].as_array().unwrap();
    assert_eq!(hits.len(), 1, "{value}");
    // The noise is 0.1 N; the peak of the response lies between samples.
    let peak = number(&hits[0]["peak_force_n"]);
    assert!((peak - PEAK_N).abs() < 0.5, "{peak}");
    let peak = number(&hits[0]["peak_response_m_per_s2"]);
    assert!((peak - PEAK_M_PER_S2).abs() < 1.0, "{peak}");
    assert!((number(&hits[0]["start_s"]) - 0.4).abs() < 2e-3, "{value}");
    value
}

/// Checks that a file is refused with this code and these words; gives the message.
#[track_caller]
fn refused(arguments: &[&str], code: &str, words: &[&str]) -> String {
    let (exit, value, _) = run(arguments);
    assert_eq!((exit, &value["error"]["code"]), (2, &code.into()), "{value}");
    let message = value["error"]["message"].as_str().unwrap().to_owned();
    for word in words {
        assert!(message.contains(word), "{word:?} is not in {message:?}");
    }
    message
}

#[test]
fn the_unit_of_a_time_column_is_read() {
    let folder = Folder::new();
    for (name, factor) in [
        ("Time (s)", 1.0),
        ("Time (sec)", 1.0),
        ("time [seconds]", 1.0),
        ("Time (ms)", 1e3),
        ("Time (msec)", 1e3),
        ("Time (milliseconds)", 1e3),
        ("t_ms", 1e3),
        ("timeMs", 1e3),
        ("Time [us]", 1e6),
        ("time_us", 1e6),
        ("Time (µs)", 1e6),
        ("Time (μs)", 1e6),
        ("Time (usec)", 1e6),
        ("[ns]", 1e9),
        ("timestamp_ns", 1e9),
        ("Time (min)", 1.0 / 60.0),
        ("t/ms", 1e3),
    ] {
        let file =
            folder.write("t.csv", scaled(&format!("{name},Force (N),Acc (m/s^2)\n"), factor));
        let value = graded(&[&file]);
        assert_eq!(value["recording"]["rate_source"], "time_column", "{name}");
        assert_eq!(value["recording"]["time_unit_assumed"], false, "{name}");
    }
}

#[test]
fn times_of_a_clock_and_since_1970_are_read() {
    let folder = Folder::new();
    let clock = |t: f64| format!("12:{:02}:{:09.6}", 59 + (t / 60.0) as u32, t % 60.0);
    let csv = |write: &dyn Fn(f64) -> String| {
        text("stamp,Force (N),Acc (m/s^2)\n", |_, t, [f, a]| format!("{},{f:.5},{a:.5}", write(t)))
    };
    for text in [
        csv(&clock),
        csv(&|t| format!("2026-01-02T{}Z", clock(t))),
        csv(&|t| format!("2026-01-02 {}+01:00", clock(t))),
        csv(&|t| {
            format!(
                "{}:{:09.6}",
                if t < 0.5 { "23:59" } else { "00:00" },
                if t < 0.5 { 59.5 + t } else { t - 0.5 }
            )
        }),
    ] {
        graded(&[&folder.write("clock.csv", text)]);
    }
    for (first, factor) in [(1.7e9, 1.0), (1.7e12, 1e3), (1.7e15, 1e6), (1.7e18, 1e9)] {
        let file = text("timestamp,force (N),acc (m/s^2)\n", |_, t, [f, a]| {
            format!("{},{f:.5},{a:.5}", first + factor * t)
        });
        let value = graded(&[&folder.write("epoch.csv", file)]);
        let recording = &value["recording"];
        assert_eq!(
            (&recording["time_unit_assumed"], recording["notes"].is_null()),
            (&true.into(), true)
        );
        assert!(value["notes"][0].as_str().unwrap().contains("since 1970"), "{value}");
    }
}

#[test]
fn what_stands_in_brackets_is_not_taken_for_newtons() {
    let folder = Folder::new();
    let file = |header: &str| folder.write("brackets.csv", scaled(header, 1.0));
    for (header, words) in [
        ("Time (s),Force (kg),Acc (m/s^2)\n", ["\"Force\"", "\"kg\""]),
        ("Time (s),Force (furlong),Acc (m/s^2)\n", ["\"Force (furlong)=UNIT\"", "no unit"]),
        ("Time (s),Force (N),Acc (dB re 1 um/s^2)\n", ["re 1 um/s^2)=UNIT\"", "no unit"]),
        ("Time (s),Force (N),Acc (deg/s^2)\n", ["\"Acc\"", "\"deg/s^2\" is no unit"]),
        ("Time (s),Force (N),Strain (ue)\n", ["\"Strain\"", "\"ue\" is no unit"]),
    ] {
        let (exit, value, _) = run(&[&file(header)]);
        assert_eq!(exit, 2, "{value}");
        let message = value["error"]["message"].as_str().unwrap();
        assert!(words.iter().all(|word| message.contains(word)), "{header}: {message}");
        assert!(!message.contains("=N\"") && !message.contains("=m/s^2\""), "{message}");
    }
    // Without brackets nothing contradicts the usual unit.
    refused(&[&file("Time (s),Force,Acc (m/s^2)\n")], "recording_no_unit", &["\"Force=N\""]);
}

#[test]
fn a_unit_in_a_name_is_proposed_and_one_that_its_row_contradicts_is_refused() {
    let folder = Folder::new();
    let file = |header: &str| folder.write("named.csv", scaled(header, 1.0));
    for (name, unit) in [("Acc_g", "g"), ("Acc: mm/s^2", "mm/s^2"), ("Acc {g}", "g")] {
        let header = format!("Time (s),Force (N),{name}\n");
        let option = format!("\"{name}={unit}\"");
        refused(&[&file(&header)], "recording_no_unit", &[&option]);
    }
    let header = "Time (s),Force (N),Acc (g)\ns,N,m/s^2\n";
    let words = ["states g", "stated as m/s^2", "\"Acc (g)=g\""];
    refused(&[&file(header)], "recording_unit_contradicted", &words);
    graded(&[&file(header), "--unit", "Acc (g)=m/s^2"]);
    // The factor of another column is no contradiction.
    graded(&[&file("Time (s),Force (top) [N],Acc (m/s^2)\n")]);
}

#[test]
fn a_column_with_the_other_decimal_sign_is_no_column_of_zeros() {
    let folder = Folder::new();
    let comma = |value: f64| format!("{value:.7}").replace('.', ",");
    let file = text("Zeit (s);Kraft (N);a (m/s^2)\n", |_, t, [f, a]| {
        format!("{};{};{a:.5}", comma(t), comma(f))
    });
    refused(
        &[&folder.write("mixed.csv", file)],
        "recording_malformed",
        &["line 2", "decimal comma"],
    );
    // A point may separate thousands as a comma may.
    let thousands = |value: f64| {
        let value = (1000.0 * value).round() as i64;
        let (sign, size) = (if value < 0 { "-" } else { "" }, value.abs());
        match size / 1000 {
            0 => format!("{sign}{size}"),
            front => format!("{sign}{front}.{:03}", size % 1000),
        }
    };
    let file = text("Kraft (N);a (mm/s^2)\n", |_, _, [f, a]| format!("{f:.0};{}", thousands(a)));
    let file = folder.write("thousands.csv", file);
    refused(&[&file, "--rate-hz", "5120"], "recording_malformed", &["thousands"]);
}

#[test]
fn two_times_of_one_recording_have_to_run_alike() {
    let folder = Folder::new();
    let file = |other: &dyn Fn(usize, f64) -> String| {
        let header = "Time (s),Force (N),Time (s),Acc (m/s^2)\n";
        text(header, |k, t, [f, a]| format!("{t:.7},{f:.5},{},{a:.5}", other(k, t)))
    };
    let alike = folder.write("alike.csv", file(&|_, t| format!("{t:.7}")));
    graded(&[&alike]);
    let faster = |_, t: f64| format!("{:.7}", 2.0 * t);
    let later = |_, t: f64| format!("{:.7}", t + 0.01);
    let gap = |k, t: f64| format!("{:.7}", if k < 3000 { t } else { t + 40.0 / RATE });
    let others: [&dyn Fn(usize, f64) -> String; 3] = [&faster, &later, &gap];
    for other in others {
        let file = folder.write("pair.csv", file(other));
        refused(&[&file], "recording_malformed", &["state different times"]);
    }
}

#[test]
fn stamps_longer_than_a_step_show_losses_and_how_little_they_say() {
    let folder = Folder::new();
    let file = |decimals: usize, kept: &dyn Fn(usize) -> bool| {
        let mut file = String::from("Time (s),Force (N),Acc (m/s^2)\n");
        for k in (0..SAMPLES).filter(|&k| kept(k)) {
            let [f, a] = sample(k);
            writeln!(file, "{:.decimals$},{f:.5},{a:.5}", k as f64 / RATE).unwrap();
        }
        file
    };
    let whole = folder.write("whole.csv", file(2, &|_| true));
    let value = graded(&[&whole]);
    assert!(value["notes"][0].as_str().unwrap().contains("rounded to 0.01"), "{value}");
    let lossy = folder.write("lossy.csv", file(2, &|k| !(3000..3040).contains(&k)));
    let missing = ["samples are missing", "0.59"];
    refused(&[&lossy], "samples_lost", &missing);
    refused(&[&lossy, "--rate-hz", "5120"], "samples_lost", &missing);
    let coarse = folder.write("coarse.csv", file(0, &|_| true));
    refused(&[&coarse], "time_too_coarse", &["rounded to 1", "--rate-hz"]);
    graded(&[&coarse, "--rate-hz", "5120"]);
    // A count shows a loss where there is no time.
    let mut counted = String::from("Index,Force (N),Acc (m/s^2)\n");
    for k in (0..SAMPLES).filter(|k| !(2300..2340).contains(k)) {
        let [f, a] = sample(k);
        writeln!(counted, "{k},{f:.5},{a:.5}").unwrap();
    }
    let counted = folder.write("counted.csv", counted);
    refused(&[&counted, "--rate-hz", "5120"], "samples_lost", &["40 samples are missing"]);
    // A line of text behind the numbers is no sample.
    let footer = file(7, &|_| true) + "Max,60,24.7\n";
    let footer = folder.write("footer.csv", footer);
    for options in [&[][..], &["--rate-hz", "5120"]] {
        let words = ["line 6146", "\"Max\""];
        refused(&[&[footer.as_str()], options].concat(), "recording_malformed", &words);
    }
}

#[test]
fn a_time_that_falls_and_an_encoding_that_is_not_read_are_named() {
    let folder = Folder::new();
    let header = "Time (s),Force (N),Acc (m/s^2)\n";
    let falling = folder.write("falling.csv", scaled(header, -1.0));
    refused(&[&falling], "recording_malformed", &["\"Time\" goes from", "never rises"]);
    let still = folder.write("still.csv", scaled(header, 0.0));
    refused(&[&still], "recording_malformed", &["goes from 0 to 0", "never rises"]);
    let wide: Vec<u8> =
        scaled(header, 1.0).chars().flat_map(|c| u32::from(c).to_le_bytes()).collect();
    let wide = folder.write("wide.csv", [&b"\xff\xfe\0\0"[..], &wide].concat());
    refused(&[&wide], "recording_unknown_format", &["UTF-32", "UTF-8"]);
}

#[test]
fn a_time_that_is_not_understood_is_refused_with_what_to_do() {
    let folder = Folder::new();
    let file = |name: &str, factor: f64| {
        folder.write("t.csv", scaled(&format!("{name},Force (N),Acc (m/s^2)\n"), factor))
    };
    let unknown = file("Time (ticks)", 1e3);
    refused(&[&unknown], "time_unit_unknown", &["\"ticks\"", "--unit \"Time=", "--rate-hz"]);
    graded(&[&unknown, "--unit", "Time=ms"]);
    graded(&[&unknown, "--rate-hz", "5120"]);
    refused(&[&file("Time", 1e3)], "time_unit_unknown", &["0.19531", "--unit"]);
    refused(&[&file("time_ms (s)", 1.0)], "time_unit_unknown", &["ms", "says s"]);
    // An index is no time.
    let index = folder.write("index.csv", text("", |k, _, [f, a]| format!("{k},{f:.5},{a:.5}")));
    let units = ["--unit", "1=N", "--unit", "*=m/s^2"];
    refused(
        &[&[index.as_str()], &units[..]].concat(),
        "no_rate",
        &["counts the samples", "--rate-hz"],
    );
    refused(&[&index], "recording_no_unit", &["counts the samples", "--unit \"1=N\""]);
    graded(&[&[index.as_str(), "--rate-hz", "5120"], &units[..]].concat());
    // A rate that shows nothing of the band.
    refused(&[&file("Time (s)", 1e3)], "rate_too_low", &["5.12 Hz", "120 Hz", "\"Time\" in s"]);
    // Seconds are assumed where they give a rate of a hammer test, and said.
    let value = graded(&[&file("Time", 1.0)]);
    assert_eq!(value["recording"]["time_unit_assumed"], true);
    assert!(value["notes"][0].as_str().unwrap().contains("is read in s"), "{value}");
}

/// A universal file of force and acceleration that states each time; `time` says when a row was sampled, or that it is
/// missing.
fn timed_universal_file(time: impl Fn(usize, f64) -> Option<f64>) -> String {
    let mut file = String::new();
    for (channel, quantity) in [(13, "N"), (12, "m/s^2")].into_iter().enumerate() {
        let rows: Vec<(f64, f64)> = (0..SAMPLES)
            .filter_map(|k| Some((time(k, k as f64 / RATE)?, sample(k)[channel])))
            .collect();
        file += &time_header(channel, (rows.len(), None), quantity);
        for pair in rows.chunks(2) {
            pair.iter().for_each(|(t, value)| write!(file, "{t:13.5e}{value:20.11e}").unwrap());
            file.push('\n');
        }
        file += "    -1\n";
    }
    file
}

#[test]
fn a_universal_file_that_states_each_time_is_read_or_refused_like_a_table() {
    let folder = Folder::new();
    // Six digits: after a second the last one is a twentieth of a step.
    graded(&[&folder.write("even.uff", timed_universal_file(|_, t| Some(t)))]);
    let lossy = timed_universal_file(|k, t| (!(2300..2340).contains(&k)).then_some(t));
    let lossy = folder.write("lost.uff", lossy);
    for options in [&[][..], &["--rate-hz", "5120"]] {
        let words = ["40 samples are missing", "0.449023"];
        refused(&[&[lossy.as_str()], options].concat(), "samples_lost", &words);
    }
    let jitter = timed_universal_file(|_, t| Some(t + 5e-5 * (t * RATE * 0.7).sin()));
    let jitter = folder.write("jitter.uff", jitter);
    refused(&[&jitter], "time_uneven", &["abscissa of force 1:3", "--rate-hz"]);
    graded(&[&jitter, "--rate-hz", "5120"]);
}

#[test]
fn rounded_lost_uneven_and_restarted_times_are_told_apart() {
    let folder = Folder::new();
    let csv = |write: &dyn Fn(f64) -> String| {
        text("Time (s),Force (N),Acc (m/s^2)\n", |_, t, [f, a]| {
            format!("{},{f:.5},{a:.5}", write(t))
        })
    };
    for decimals in [3, 4, 5] {
        let value = graded(&[&folder.write("rounded.csv", csv(&|t| format!("{t:.decimals$}")))]);
        assert!(value["notes"][0].as_str().unwrap().contains("rounded"), "{value}");
    }
    // Scientific, without names: the times are not the hammer.
    let scientific = text("", |_, t, [f, a]| format!("{t:.2E}\t{f:.5}\t{a:.5}"));
    let scientific = folder.write("scientific.txt", scientific);
    graded(&[&scientific, "--unit", "1=N", "--unit", "2=m/s^2"]);
    // Forty lost samples are not closed up, whatever the options.
    let lines: Vec<String> = csv(&|t| t.to_string()).lines().map(str::to_owned).collect();
    let mut lossy = lines.clone();
    lossy.drain(2300..2340);
    let lossy = folder.write("lost.csv", lossy.join("\n"));
    for options in [&[][..], &["--rate-hz", "5120"]] {
        let words = ["40 samples are missing", "0.448828", "line 2300"];
        refused(&[&[lossy.as_str()], options].concat(), "samples_lost", &words);
    }
    // Uneven steps.
    let jitter = csv(&|t| (t + 5e-5 * (t * RATE * 0.7).sin()).to_string());
    let jitter = folder.write("jitter.csv", jitter);
    refused(&[&jitter], "time_uneven", &["differ", "--rate-hz"]);
    graded(&[&jitter, "--rate-hz", "5120"]);
    // Three hits, each with its own time.
    let mut blocks = String::from("Time (s),Force (N),Acc (m/s^2)\n");
    for _ in 0..3 {
        for k in 1900..2500 {
            let [force, response] = sample(k);
            writeln!(blocks, "{},{force:.5},{response:.5}", (k - 1900) as f64 / RATE).unwrap();
        }
    }
    let (exit, value, stderr) = run(&[&folder.write("blocks.csv", blocks)]);
    assert_eq!(exit, 0, "{value} {stderr}");
    assert_eq!(
        (&value["recording"]["segments"], value["hits"].as_array().unwrap().len()),
        (&3.into(), 3)
    );
}

#[test]
fn text_in_any_encoding_is_read() {
    let folder = Folder::new();
    let german = text("Zeit (s);Kraft (N);X (m/s²)\r\n", |_, t, [f, a]| {
        format!("{t};{f:.5};{a:.5}").replace('.', ",") + "\r"
    });
    let latin: Vec<u8> = german.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
    let utf16 =
        |bytes: fn(u16) -> [u8; 2]| german.encode_utf16().flat_map(bytes).collect::<Vec<u8>>();
    let marked = |mark: &[u8], bytes: &[u8]| [mark, bytes].concat();
    for (bytes, encoding) in [
        (german.as_bytes().to_vec(), "UTF-8"),
        (marked(b"\xef\xbb\xbf", german.as_bytes()), "UTF-8"),
        (latin.clone(), "Windows-1252"),
        (marked(b"\xff\xfe", &utf16(u16::to_le_bytes)), "UTF-16LE"),
        (marked(b"\xfe\xff", &utf16(u16::to_be_bytes)), "UTF-16BE"),
        (utf16(u16::to_le_bytes), "UTF-16LE"),
    ] {
        let value = graded(&[&folder.write("e.csv", bytes)]);
        assert_eq!(
            (&value["recording"]["encoding"], &value["recording"]["decimal"]),
            (&encoding.into(), &"comma".into())
        );
    }
    // Japanese names in Shift-JIS, and the ² of another code page: 0xB2 is no unit in Shift-JIS.
    let head = b"\x8e\x9e\x8a\xd4 [s],\x97\xcd Force [N],\x89\xc1\x91\xac\x93x [m/s\xb2]\n";
    let numbers = scaled("", 1.0);
    let value = graded(&[&folder.write("sjis.csv", [&head[..], numbers.as_bytes()].concat())]);
    assert_eq!(value["recording"]["encoding"], "Shift-JIS");
    assert_eq!(value["recording"]["channels"][1]["unit"], "m/s²");
    // A file that is cut or no text.
    let odd = marked(b"\xff\xfe", &utf16(u16::to_le_bytes)[..101]);
    refused(&[&folder.write("odd.csv", odd)], "recording_malformed", &["UTF-16LE"]);
    refused(
        &[&folder.write("x.xlsx", b"PK\x03\x04\x14\0")],
        "recording_unknown_format",
        &["binary"],
    );
}

#[test]
fn separators_decimal_signs_and_headers_are_those_of_the_whole_file() {
    let folder = Folder::new();
    let si = ["--unit", "1=N", "--unit", "*=m/s^2"];
    // Whole numbers in the quiet lines, then a decimal comma.
    let quiet = text("Kraft (N);X (m/s^2)\n", |_, _, [f, a]| {
        let short = |value: f64| {
            if value.abs() < 0.15 {
                "0".to_owned()
            } else {
                format!("{value:.2}").replace('.', ",")
            }
        };
        format!("{};{}", short(f), short(a))
    });
    graded(&[&folder.write("quiet.csv", quiet), "--rate-hz", "5120"]);
    let blanks = |header: &str| text(header, |_, t, [f, a]| format!("   {t:.7e}  {f:.7e} {a:.7e}"));
    for header in ["", "# t f a\n", "% made by a program\n"] {
        let file = folder.write("savetxt.txt", blanks(header));
        let names: &[&str] = if header.starts_with("# t") { &["--force", "f"] } else { &[] };
        graded(&[&[file.as_str()], &si[..], names].concat());
    }
    graded(&[&folder.write("units.txt", blanks("# Time (s) Force (N) Acc (m/s^2)\n"))]);
    let tabs = |header: &str| text(header, |_, t, [f, a]| format!("{t}\t{f:.5}\t{a:.5}"));
    let names = "Time (s)\tForce (N)\tX (m/s2)\n";
    for header in [
        format!(
            "{}{names}",
            "File: t.dxd\nRecorder; 4 channels\nStart: 05.01.2026\nRate: 5120 Hz\nData\n"
                .repeat(60)
        ),
        format!("Rate;5120\nRange;100\nComment;none, really\n{names}"),
        "Time (s);Force (N);X (m/s2)\n".to_owned(),
    ] {
        graded(&[&folder.write("header.txt", tabs(&header))]);
    }
    let endless = tabs(&format!("{}{names}", "a line of text\n".repeat(1001)));
    refused(
        &[&folder.write("long.txt", endless)],
        "recording_unknown_format",
        &["within 1000 lines"],
    );
    // A comma that may separate thousands.
    let thousands = "Force (N);Acc (g)\n1,234;5\n567;6\n2,345;7\n";
    let thousands = folder.write("thousands.csv", thousands);
    refused(&[&thousands, "--rate-hz", "5120"], "recording_malformed", &["--decimal", "\"1,234\""]);
    // It is read then, and is no recording of a hit.
    let comma = [&thousands, "--rate-hz", "5120", "--decimal", "comma"];
    refused(&comma, "recording_too_short", &[]);
}

#[test]
fn a_row_of_units_keeps_its_names_when_one_is_unknown() {
    let folder = Folder::new();
    let csv = |header: &str, last: &str| {
        text(header, |_, t, [f, a]| format!("{t},{f:.5},{:.7}{last}", a / 9.80665))
    };
    for (unit, text) in [
        ("K", csv("Time,Force,Acc,Temp\ns,N,g,K\n", ",295")),
        ("flames", csv("Time,Force,Acc,Temp\nsec,N,g,flames\n", ",295")),
        ("mm", csv("Time,Force,Acc,Temp\n[s],[N],[g],[mm]\n", ",295")),
    ] {
        let file = folder.write("units.csv", text);
        let value = graded(&[&file]);
        let left_out = &value["recording"]["left_out"][0];
        assert_eq!(
            (&left_out["name"], value["recording"]["left_out"].as_array().unwrap().len()),
            (&"Temp".into(), 1)
        );
        assert!(left_out["reason"].as_str().unwrap().contains(unit), "{left_out}");
        // The line for people says so too.
        let shown = program::words(&program::run(&["hits", &file]).stdout);
        for words in [
            "force \"Force\" in N",
            "response \"Acc\" in g",
            "5120 Hz from the time column \"Time\"",
            "left out: \"Temp\"",
        ] {
            assert!(shown.contains(words), "{words}: {shown}");
        }
    }
}

#[test]
fn a_signal_needs_the_sensitivity_of_its_sensor() {
    let folder = Folder::new();
    let csv = |force: &str, response: &str, [per_n, per_m_s2]: [f64; 2]| {
        let header = format!("Time (s),Force ({force}),X ({response})\n");
        folder.write(
            "signal.csv",
            text(&header, |_, t, [f, a]| format!("{t},{:.6},{:.6}", f * per_n, a * per_m_s2)),
        )
    };
    let g = 9.80665;
    let file = csv("mV", "mg", [2.3, 1e3 / g]);
    let message =
        refused(&[&file], "recording_needs_sensitivity", &["\"mV\"", "--sensitivity \"Force="]);
    assert!(!message.contains("--unit \"Force=N"), "{message}");
    refused(
        &[&file, "--unit", "Force=N"],
        "recording_needs_sensitivity",
        &["the file states mV", "--sensitivity"],
    );
    graded(&[&file, "--sensitivity", "Force=2.3 mV/N"]);
    for ([force, response], per, [hammer, sensor]) in [
        (["V", "V"], [0.0023, 0.0102], ["Force=2.3 mV/N", "X=10.2 mV/(m/s²)"]),
        (["mV", "mV"], [2.3, 100.0 / g], ["Force=0.0023 V/N", "X=100 mV/g"]),
        (["pC", "pC"], [4.0, 2.0], ["Force=4 pC/N", "X=2 pC/m/s^2"]),
        (["counts", "LSB"], [1000.0, 300.0], ["Force=1000 counts/N", "X=300 counts/(m/s^2)"]),
    ] {
        let file = csv(force, response, per);
        let value = graded(&[&file, "--sensitivity", hammer, "--sensitivity", sensor]);
        assert_eq!(value["recording"]["channels"][0]["unit_source"], "sensitivity", "{value}");
        refused(
            &[&file, "--sensitivity", hammer],
            "recording_needs_sensitivity",
            &["\"X\"", "--leave-out \"X\""],
        );
    }
    for (option, words) in
        [("Force=4 pC/N", "is not the signal"), ("Force=100 mV/g", "acceleration")]
    {
        let file = csv("mV", "mg", [2.3, 1e3 / g]);
        let arguments = [file.as_str(), "--force", "Force", "--sensitivity", option];
        refused(&arguments, "sensitivity_does_not_fit", &[words]);
    }
    let file = csv("N", "m/s^2", [1.0, 1.0]);
    refused(
        &[&file, "--sensitivity", "Force=2.3 mV/N"],
        "sensitivity_does_not_fit",
        &["needs no sensitivity"],
    );
    for option in ["Force=2.3", "Force=-2 mV/N", "=2.3 mV/N", "Force=2.3 mV/parsec"] {
        assert_eq!(program::run(&["hits", &file, "--sensitivity", option]).exit, 2, "{option}");
    }
}

#[test]
fn a_hammer_of_reversed_polarity_is_named_and_turned() {
    let folder = Folder::new();
    let negative = |rebound: f64| {
        text("Time (s),Force (N),X (m/s^2)\n", |k, t, [f, a]| {
            // An overshoot after the pulse, which is above the trigger.
            let overshoot = if (CONTACT + 20..CONTACT + 30).contains(&k) { rebound } else { 0.0 };
            format!("{t},{:.5},{a:.5}", overshoot - f)
        })
    };
    for rebound in [0.0, 5.0] {
        let file = folder.write("negative.csv", negative(rebound));
        refused(&[&file], "force_reversed", &["pulses of -60 N", "--reverse \"Force\""]);
        let value = run(&[&file, "--reverse", "force"]).1;
        assert!(
            (value["hits"][0]["peak_force_n"].as_f64().unwrap() - PEAK_N).abs() < 0.5,
            "{value}"
        );
        assert_eq!(value["recording"]["channels"][0]["reversed"], true);
    }
    let healthy = folder.write("healthy.csv", scaled("Time (s),Force (N),X (m/s^2)\n", 1.0));
    graded(&[&healthy, "--reverse", "X"]);
    refused(&[&healthy, "--reverse", "Force"], "force_reversed", &["leave this option out"]);
    refused(&[&healthy, "--reverse", "Y"], "no_such_channel", &["\"Y\""]);
}

/// A LabVIEW file of these columns; `entry` are the lines `Samples` and `Delta_X` of the segment.
fn lvm(x_columns: &str, entries: &str, names: &str, rows: &str) -> String {
    format!(
        "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t.\nMulti_Headings\tNo\nX_Columns\t{x_columns}\n\
         ***End_of_Header***\t\n\t\nChannels\t2\n{entries}\nY_Unit_Label\tN\tm/s^2\nX_Dimension\tTime\tTime\n\
         ***End_of_Header***\n{names}\n{rows}"
    )
}

#[test]
fn a_labview_file_with_a_wrong_step_or_one_header_for_several_blocks_is_read() {
    let folder = Folder::new();
    let names = "X_Value\tHammer\tAcc\tComment";
    let rows = |range: std::ops::Range<usize>, time: bool| -> String {
        let row = |k: usize| {
            let [force, response] = sample(k);
            let x = if time {
                format!("{:.6}", (k - range.start) as f64 / RATE)
            } else {
                String::new()
            };
            format!("{x}\t{force:.6}\t{response:.6}\n")
        };
        range.clone().map(row).collect()
    };
    let whole = rows(0..SAMPLES, true);
    // Software timing states a step of one second.
    let entries = "Samples\t6144\t6144\nDelta_X\t1.000000\t1.000000";
    let value = graded(&[&folder.write("delta.lvm", lvm("One", entries, names, &whole))]);
    let note = value["notes"][0].as_str().unwrap();
    assert!(note.contains("Delta_X states 1 Hz") && note.contains("5120 Hz"), "{note}");
    // A step that agrees with the X values costs no note.
    let entries = "Samples\t6144\t6144\nDelta_X\t1.953125E-4\t1.953125E-4";
    let value = graded(&[&folder.write("fine.lvm", lvm("One", entries, names, &whole))]);
    assert!(value["notes"].as_array().unwrap().is_empty(), "{value}");
    // Three blocks under one header.
    let blocks = |time: bool| rows(1900..2412, time).repeat(3);
    for (x_columns, time) in [("No", false), ("One", true)] {
        let entries = "Samples\t512\t512\nDelta_X\t1.953125E-4\t1.953125E-4";
        let (exit, value, stderr) =
            run(&[&folder.write("blocks.lvm", lvm(x_columns, entries, names, &blocks(time)))]);
        assert_eq!((exit, &value["recording"]["segments"]), (0, &3.into()), "{value} {stderr}");
        let peaks = value["hits"]
            .as_array()
            .unwrap()
            .iter()
            .map(|hit| hit["peak_force_n"].as_f64().unwrap());
        assert!(
            peaks.clone().count() == 3 && peaks.clone().all(|peak| (peak - PEAK_N).abs() < 0.5),
            "{value}"
        );
    }
    // The header of a table that was written row by row.
    let entries = "Samples\t1\t1\nDelta_X\t1.000000\t1.000000";
    graded(&[&folder.write("single.lvm", lvm("One", entries, names, &whole))]);
    // Lost samples and a cut block.
    let lossy = rows(0..2300, true)
        + &rows(0..SAMPLES, true).split_inclusive('\n').skip(2340).collect::<String>();
    let entries = "Samples\t6104\t6104\nDelta_X\t1.953125E-4\t1.953125E-4";
    refused(
        &[&folder.write("lost.lvm", lvm("One", entries, names, &lossy))],
        "samples_lost",
        &["40 samples"],
    );
    let entries = "Samples\t512\t512\nDelta_X\t1.953125E-4\t1.953125E-4";
    let cut = blocks(false) + &rows(0..100, false);
    refused(
        &[&folder.write("cut.lvm", lvm("No", entries, names, &cut))],
        "recording_truncated",
        &["last segment", "100"],
    );
}

#[test]
fn empty_and_slow_channels_of_a_labview_file_cost_no_hit() {
    let folder = Folder::new();
    let file = |entries: &str, last: &str| {
        let rows: String = (0..SAMPLES)
            .map(|k| {
                let [force, response] = sample(k);
                format!("{:.6}\t{force:.6}\t{response:.6}\t{last}\n", k as f64 / RATE)
            })
            .collect();
        let text = lvm("One", entries, "X_Value\tHammer\tAcc\tUntitled\tComment", &rows);
        folder.write("three.lvm", text.replace("Channels\t2", "Channels\t3"))
    };
    let empty = file("Samples\t6144\t6144\t0\nDelta_X\t1.953125E-4\t1.953125E-4\t1.0", "");
    for options in [&[][..], &["--leave-out", "Untitled"]] {
        let value = graded(&[&[empty.as_str()], options].concat());
        assert_eq!(value["recording"]["left_out"][0]["name"], "Untitled", "{value}");
    }
    let slow = file("Samples\t6144\t6144\t6144\nDelta_X\t1.953125E-4\t1.953125E-4\t1.0", "5.0");
    let options = ["--unit", "Untitled=g"];
    refused(
        &[&[slow.as_str()], &options[..]].concat(),
        "recording_malformed",
        &["Delta_X", "--leave-out \"Untitled\""],
    );
    graded(&[&slow, "--leave-out", "Untitled"]);
}

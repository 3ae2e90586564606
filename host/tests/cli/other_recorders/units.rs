//! Units, encodings, separators and signals of other recorders.

use super::*;
use crate::program;

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

#[test]
fn a_factor_beside_the_units_is_refused_by_name_until_the_unit_is_stated() {
    let folder = Folder::new();
    let file = |header: &str| {
        let rows = |_: usize, t: f64, [f, a]: [f64; 2]| format!("{t:.7};{:.2};{a:.5}", 1e3 * f);
        folder.write("factor.csv", text(header, rows))
    };
    for (header, column, words) in [
        ("Time;Force;Acc\ns;N;m/s^2\nFactor;0.001;1\n", "Force", "the row \"Factor\" in line 3"),
        ("Scale;0,001;1\nTime (s);Force (N);Acc (m/s^2)\n", "Force", "the row \"Scale\" in line 1"),
        ("Time (s);Force (x0.001) [N];Acc (m/s^2)\n", "Force (x0.001)", "its name"),
        ("Time (s);Force × 10^-3 (N);Acc (m/s^2)\n", "Force × 10^-3", "its name"),
    ] {
        let option = format!("--unit \"{column}=UNIT\"");
        let words = [words, "states the factor", option.as_str()];
        refused(&[&file(header)], "recording_unit_contradicted", &words);
        graded(&[&file(header), "--unit", &format!("{column}=mN")]);
    }
    // A factor of one, and a direction.
    let plain = |header: &str| folder.write("plain.csv", scaled(header, 1.0));
    graded(&[&plain("Time (s),Force (N),Acc (m/s^2)\nGain,1,1\n")]);
    graded(&[&plain("Time (s),Force (N),Acc x 2 (m/s^2)\n")]);
    let time = file("Time (x0.001) [s];Force (mN);Acc (m/s^2)\n");
    refused(&[&time], "recording_malformed", &["the time column", "states the factor 0.001"]);
}

#[test]
fn units_in_a_column_of_their_own_or_behind_a_word_are_read() {
    let folder = Folder::new();
    let lbf = 4.448_221_615_260_5;
    let columns = text("Time (s);Force;Unit;Acc;Unit\n", |_, t, [f, a]| {
        format!("{t:.7};{:.6};lbf;{:.5};mm/s^2", f / lbf, 1e3 * a)
    });
    graded(&[&folder.write("columns.csv", columns)]);
    let words = text("# columns: time force acc\n# units: s lbf m/s^2\n", |_, t, [f, a]| {
        format!("{t:.7} {:.6} {a:.5}", f / lbf)
    });
    graded(&[&folder.write("words.txt", words)]);
    let french = text("Temps;Force;Accélération\nsecondes;newtons;m/s²\n", |_, t, [f, a]| {
        format!("{t:.7};{f:.5};{a:.5}").replace('.', ",")
    });
    graded(&[&folder.write("french.csv", french)]);
}

#[test]
fn what_is_no_row_of_names_names_no_channel() {
    let folder = Folder::new();
    let semicolons = |_: usize, t: f64, [f, a]: [f64; 2]| format!("{t:.7};{f:.5};{a:.5}");
    let blanks = |_: usize, t: f64, [f, a]: [f64; 2]| format!("{t:.7} {f:.5} {a:.5}");
    let extremes = "Time;Force;Acc\ns;N;m/s^2\nMin;-0.1;-20\nMax;60;24.7\n";
    let value = graded(&[&folder.write("extremes.csv", text(extremes, semicolons))]);
    assert_eq!(value["recording"]["channels"][0]["name"], "Force", "{value}");
    let oscilloscope = "Horizontal Units;s\nVertical Units;N;m/s^2\nTime (s);Hammer;Acc\n";
    graded(&[&folder.write("oscilloscope.csv", text(oscilloscope, semicolons))]);
    let statement = folder.write("statement.txt", text("Function: Time Record\n", blanks));
    graded(&[&statement, "--unit", "1=N", "--unit", "*=m/s^2"]);
    // Numbers in quotes may have a decimal comma between commas.
    let quoted = text("\"Time (s)\",\"Force (N)\",\"Acc (m/s^2)\"\n", |_, t, [f, a]| {
        let numbers = [t, f, a].map(|value| format!("\"{value:.7}\"").replace('.', ","));
        numbers.join(",")
    });
    graded(&[&folder.write("quoted.csv", quoted)]);
}

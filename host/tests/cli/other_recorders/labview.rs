//! LabVIEW measurement files.

use super::*;

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

#[test]
fn channels_of_a_labview_file_with_times_of_their_own_have_to_agree() {
    let folder = Folder::new();
    let header =
        |entries: &str| format!("Samples\t6144\t6144\n{entries}Delta_X\t1.953125E-4\t1.953125E-4");
    let names = "X_Value\tHammer\tX_Value\tAcc\tComment";
    let multi = |entries: &str, names: &str, x: &dyn Fn(usize, f64) -> f64| {
        let rows: String = (0..SAMPLES)
            .map(|k| {
                let ([force, response], t) = (sample(k), k as f64 / RATE);
                format!("{t:.7}\t{force:.6}\t{:.7}\t{response:.6}\t\n", x(k, t))
            })
            .collect();
        folder.write("multi.lvm", lvm("Multi", &header(entries), names, &rows))
    };
    graded(&[&multi("", names, &|_, t| t)]);
    let others: [(TimeOfRow<'_>, &str); 3] = [
        (
            &|k, t| if k < 3000 { t } else { t + 40.0 / RATE },
            "line 3015: the X value of channel 2 \"Acc\"",
        ),
        (&|_, t| 2.0 * t, "line 16: the X value of channel 2 \"Acc\""),
        (&|_, t| t + 100.0, "channel 2 \"Acc\" is 100 here and that of channel 1 \"Hammer\" 0"),
    ];
    for (x, words) in others {
        let words = [words, "--leave-out \"Acc\""];
        refused(&[&multi("", names, x)], "recording_malformed", &words);
    }
    // Channels that begin at different times.
    let beginnings = [
        ("X0\t0.0\t0.01\n", "X0: channel 2 begins 0.01 s after channel 1"),
        ("Time\t10:00:00.5\t10:00:00.0\n", "Time: channel 2 begins 0.5 s before channel 1"),
    ];
    for (entries, words) in beginnings {
        refused(&[&multi(entries, names, &|_, t| t)], "recording_malformed", &[words, "line 10"]);
    }
    let dates = "Date\t2026/01/05\t2026/01/06\nTime\t10:00:00\t10:00:00\n";
    refused(&[&multi(dates, names, &|_, t| t)], "recording_malformed", &["begins 86400 s after"]);
    graded(&[&multi("Time\t10:00:00.5\t10:00:00.5\nX0\t0.2\t0.2\n", names, &|_, t| t)]);
}

#[test]
fn an_x_value_that_is_missing_hides_no_gap() {
    let folder = Folder::new();
    let rows: String = (0..SAMPLES)
        .map(|k| {
            let [force, response] = sample(k);
            let t = k as f64 / RATE + if k < 3000 { 0.0 } else { 0.1 };
            let x = if k == 100 { String::new() } else { format!("{t:.7}") };
            format!("{x}\t{force:.6}\t{response:.6}\t\n")
        })
        .collect();
    let entries = "Samples\t6144\t6144\nDelta_X\t1.953125E-4\t1.953125E-4";
    let file = folder.write("x.lvm", lvm("One", entries, "X_Value\tHammer\tAcc\tComment", &rows));
    refused(&[&file], "recording_malformed", &["line 115", "no X value"]);
}

#[test]
fn units_beneath_the_names_of_a_labview_file_are_read() {
    let folder = Folder::new();
    let file = |units: &str, scale: f64| {
        let rows: String = (0..SAMPLES)
            .map(|k| {
                let ([force, response], t) = (sample(k), k as f64 / RATE);
                format!("{t:.7}\t{force:.6}\t{t:.7}\t{:.6}\t\n", response * scale)
            })
            .collect();
        let names = format!("X_Value\tHammer\tX_Value\tAcc\tComment\n{units}");
        let entries = "Samples\t6144\t6144\nDelta_X\t1.953125E-4\t1.953125E-4";
        folder.write(
            "units.lvm",
            lvm("Multi", entries, &names, &rows).replace("Y_Unit_Label\tN\tm/s^2\n", ""),
        )
    };
    for units in ["\tN\t\tm/s^2", "s\tN\ts\tm/s^2\t", "[s]\t[N]\t[s]\t[m/s^2]\t"] {
        graded(&[&file(units, 1.0)]);
    }
    graded(&[&file("s\tN\ts\tmm/s^2", 1e3)]);
    refused(&[&file("s\tmV\ts\tg", 1.0)], "recording_needs_sensitivity", &["\"Hammer\"", "mV"]);
    refused(&[&file("s\tN\ts\tfurlong", 1.0)], "recording_unknown_unit", &["\"furlong\""]);
    refused(&[&file("ticks\tN\tticks\tg", 1.0)], "time_unit_unknown", &["\"ticks\""]);
}

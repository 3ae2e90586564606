//! Times of other recorders: their units, clocks, steps, losses and what contradicts them.

use std::fmt::Write;

use super::*;
use crate::hits::time_header;

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
        csv(&|t| format!("20260102T{}Z", clock(t).replace(':', ""))),
        csv(&|t| format!("2026-01-02 {} CET", clock(t))),
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
    // The microseconds of an Arduino, full after a third of a second.
    let micros = |t: f64| (4_294_637_312.0 + 1e6 * t).round() % 4_294_967_296.0;
    let file = text("micros,force (N),acc (m/s^2)\n", |_, t, [f, a]| {
        format!("{:.0},{f:.5},{a:.5}", micros(t))
    });
    let value = graded(&[&folder.write("micros.csv", file)]);
    assert_eq!(value["recording"]["segments"], 1, "{value}");
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

/// Seconds since midnight as a clock with microseconds.
fn clock(seconds: f64) -> String {
    let (hours, rest) = ((seconds / 3600.0).floor(), seconds % 3600.0);
    format!("{hours:02}:{:02.0}:{:09.6}", (rest / 60.0).floor(), rest % 60.0)
}

/// A table whose rows begin with these texts.
fn stamped(header: &str, stamp: impl Fn(usize, f64) -> String) -> String {
    text(header, |k, t, [f, a]| format!("{},{f:.5},{a:.5}", stamp(k, t)))
}

#[test]
fn a_clock_is_read_over_zones_and_dates_and_one_that_was_set_is_refused() {
    let folder = Folder::new();
    let header = "stamp,Force (N),Acc (m/s^2)\n";
    // The ends of summer time and of winter time, in the quiet after the hit.
    let set = |second: f64, by: f64, zones: [&str; 2]| {
        stamped(header, |_, t| {
            let (zone, by) = if t < 0.9 { (zones[0], 0.0) } else { (zones[1], by) };
            format!("2026-10-25T{}{zone}", clock(second + t + by))
        })
    };
    graded(&[&folder.write("end.csv", set(10_799.1, -3600.0, ["+02:00", "+01:00"]))]);
    graded(&[&folder.write("begin.csv", set(7199.1, 3600.0, ["+01:00", "+02:00"]))]);
    for (second, by, words) in [
        (10_799.1, -3600.0, "goes back by 3600 s"),
        (10_000.0, -3000.0, "goes back by 3000 s"),
        (7199.1, 3600.0, "goes forward by an hour"),
    ] {
        let file = folder.write("set.csv", set(second, by, ["", ""]));
        for options in [&[][..], &["--rate-hz", "5120"]] {
            let words = [words, "line 4609", "UTC"];
            refused(&[&[file.as_str()], options].concat(), "recording_malformed", &words);
        }
    }
    // A date that goes on by two days is no midnight, in the stamp and in a column of its own.
    let day = |t: f64, later: u8| if t < 0.9 { 25 } else { later };
    for later in [26, 27] {
        let over_night = |t: f64| clock((86_399.1 + t) % 86_400.0);
        let stamp = stamped(header, |_, t| format!("{}.10.2026 {}", day(t, later), over_night(t)));
        let columns = stamped("Date,Time,Force (N),Acc (m/s^2)\n", |_, t| {
            format!("2026-10-{},{}", day(t, later), over_night(t))
        });
        for file in [stamp, columns] {
            let file = folder.write("days.csv", file);
            match later {
                26 => drop(graded(&[&file])),
                _ => drop(refused(
                    &[&file],
                    "samples_lost",
                    &["44236", "samples are missing", "line 4609"],
                )),
            }
        }
    }
}

#[test]
fn the_milliseconds_beside_a_clock_are_part_of_its_time() {
    let folder = Folder::new();
    let header = "Time,Milliseconds,Force (N),Acc (m/s^2)\n";
    let second = |t: f64| clock(t + 43_200.6).split('.').next().unwrap().to_owned();
    let fraction = |t: f64| (t + 0.6) % 1.0 * 1e3;
    let both = stamped(header, |_, t| format!("{},{:.4}", second(t), fraction(t)));
    let value = graded(&[&folder.write("both.csv", both)]);
    assert_eq!(value["recording"]["segments"], 1, "{value}");
    assert_eq!(value["recording"]["left_out"][0]["name"], "Milliseconds", "{value}");
    // Milliseconds that begin again without the clock.
    let apart = stamped(header, |_, t| format!("{},{:.4}", second(t + 0.2), fraction(t)));
    refused(
        &[&folder.write("apart.csv", apart)],
        "recording_malformed",
        &["begins again", "goes on"],
    );
}

#[test]
fn what_is_wrong_with_uneven_times_is_named_with_its_place_and_no_loss_is_overridden() {
    let folder = Folder::new();
    let header = "Time (s),Force (N),Acc (m/s^2)\n";
    let rate = ["--rate-hz", "5120"];
    let file = |time: &dyn Fn(usize, f64) -> f64| {
        folder.write("uneven.csv", stamped(header, |k, t| format!("{:.9}", time(k, t))))
    };
    let jitter = |t: f64| t + 5e-5 * (t * RATE * 0.7).sin();
    let cases: [(TimeOfRow<'_>, &[&str]); 5] = [
        (&|k, t| if k == 3000 { t - 1.0 / RATE } else { t }, &["1 row has the time", "line 3002"]),
        (&|k, t| if k == 3000 { t - 3.0 / RATE } else { t }, &["goes back", "line 3001"]),
        (&|k, t| if k < 3000 { t } else { 2.0 * t }, &["differ", "samples may be missing"]),
        // A loss that jitter hides.
        (&|k, t| jitter(t) + if k < 3000 { 0.0 } else { 0.002 }, &["0.00221", "line 3001"]),
        (&|_, t| t + 0.05 * t * t, &["differ", "line 6144"]),
    ];
    for (time, words) in cases {
        let file = file(time);
        for options in [&[][..], &rate] {
            let message = refused(&[&[file.as_str()], options].concat(), "time_uneven", words);
            assert!(!message.contains("--rate-hz"), "{message}");
        }
    }
    // A stamp for each block of rows shows that none is missing.
    let blocks = file(&|k, _| (k / 128 * 128) as f64 / RATE);
    refused(&[&blocks], "time_uneven", &["6096 rows have the time", "line 3", "--rate-hz"]);
    graded(&[&[blocks.as_str()], &rate[..]].concat());
    // An uneven segment before an even one, and a row of factors among the times.
    let mut segments = String::from(header);
    for k in 0..600 {
        let [f, a] = sample(1900 + k);
        writeln!(
            segments,
            "{},{f},{a}",
            (k + k / 300 * 2) as f64 / RATE + f64::from(k == 100) * 9e-5
        )
        .unwrap();
    }
    for k in 0..600 {
        writeln!(segments, "{},{},{}", k as f64 / RATE, sample(1900 + k)[0], sample(1900 + k)[1])
            .unwrap();
    }
    refused(&[&folder.write("two.csv", segments)], "time_uneven", &["line 301"]);
    let factors = scaled(&format!("{header}1,0.001,1\n"), 1.0);
    let words = ["line 2", "goes from 1 to 0 in the next row", "factors"];
    refused(&[&folder.write("factors.csv", factors)], "recording_malformed", &words);
}

#[test]
fn a_rate_in_the_header_is_compared_with_the_times_and_used_without_them() {
    let folder = Folder::new();
    let timed = "Time (s),Force (N),Acc (m/s^2)\n";
    let file = |line: &str| folder.write("rate.csv", format!("{line}\n{}", scaled(timed, 1.0)));
    for line in ["Sample rate: 5000", "Sampling frequency = 5 kHz", "# Abtastrate: 5000 Hz"] {
        let value = graded(&[&file(line)]);
        let note = value["notes"][0].as_str().unwrap();
        let words = "states 5000 Hz and the time column 5120 Hz: the time column is used";
        assert!(note.contains("line 1") && note.contains(words), "{note}");
    }
    for line in ["Sample rate: 5120", "Sampling rate: 5.12 kHz", "dt: 0.0001953 s", "Rated: 5000"] {
        let value = graded(&[&file(line)]);
        assert_eq!(value["notes"], serde_json::json!([]), "{line}");
        assert_eq!(value["recording"]["rate_source"], "time_column", "{line}");
    }
    let untimed = |line: &str| {
        let rows = text("Force (N),Acc (m/s^2)\n", |_, _, [f, a]| format!("{f:.5},{a:.5}"));
        folder.write("untimed.csv", format!("{line}\n{rows}"))
    };
    for line in ["Sample Rate (Hz),5120", "fs = 5.12 kHz", "Sampling interval: 195.3125 us"] {
        assert_eq!(graded(&[&untimed(line)])["recording"]["rate_source"], "header", "{line}");
    }
    // A count of the samples leaves the rate to the header, and a wrong unit of the time is named with it.
    let indexed = |line: &str| {
        let rows =
            text("Index,Force (N),Acc (m/s^2)\n", |k, _, [f, a]| format!("{k},{f:.5},{a:.5}"));
        folder.write("indexed.csv", format!("{line}\n{rows}"))
    };
    graded(&[&indexed("Sample rate: 5120 Hz")]);
    refused(&[&indexed("Sample rate: 5120")], "no_rate", &["line 1", "without a unit"]);
    let slow = format!("Sample rate: 5120 Hz\n{}", scaled(timed, 1e3));
    refused(&[&folder.write("slow.csv", slow)], "rate_too_low", &["line 1", "states 5120 Hz"]);
    refused(&[&untimed("Sample rate: 5120")], "no_rate", &["line 1", "without a unit"]);
    refused(&[&untimed("dt = 0.0002 s")], "time_too_coarse", &["line 1", "25 %"]);
}

#[test]
fn what_rises_in_every_row_is_a_time_or_a_count_and_text_in_a_time_is_named() {
    let folder = Folder::new();
    let rising = stamped("Signal,gps_sow,Force (N),Acc (m/s^2)\n", |k, t| {
        format!("{k},{:.7}", 345_600.0 + t)
    });
    let value = graded(&[&folder.write("rising.csv", rising)]);
    assert_eq!(value["recording"]["time_column"], "gps_sow", "{value}");
    assert_eq!(value["recording"]["left_out"][0]["name"], "Signal", "{value}");
    let header = "Time,Force (N),Acc (m/s^2)\n";
    let with_unit = stamped(header, |_, t| format!("{t:.7} sec"));
    let words = ["line 2, column 1", "\"0.0000000 sec\""];
    refused(&[&folder.write("unit.csv", with_unit)], "recording_malformed", &words);
    // A line that says that samples were lost, and one that says nothing.
    let remark = |remark: &str| {
        let lines = stamped("Force (N),Acc (m/s^2)\n", |_, _| String::new()).replace("\n,", "\n");
        let mut lines: Vec<&str> = lines.lines().collect();
        lines.insert(3001, remark);
        folder.write("remark.csv", lines.join("\n"))
    };
    let rate = ["--rate-hz", "5120"];
    let lost = remark("# buffer overflow, 40 samples lost");
    refused(&[&[lost.as_str()], &rate[..]].concat(), "recording_malformed", &["line 3002", "lost"]);
    graded(&[&[remark("# lost samples: 0").as_str()], &rate[..]].concat());
    let dropped =
        format!("# dropped samples: 40\n{}", scaled("Time (s),Force (N),Acc (m/s^2)\n", 1.0));
    let dropped = folder.write("dropped.csv", dropped);
    refused(&[&[dropped.as_str()], &rate[..]].concat(), "recording_malformed", &["dropped"]);
    let value = graded(&[&[remark("# temperature 21").as_str()], &rate[..]].concat());
    assert!(value["notes"][0].as_str().unwrap().contains("line 3002"), "{value}");
}

#[test]
fn columns_that_begin_at_different_times_are_not_aligned() {
    let folder = Folder::new();
    let file = |second: &str| {
        let header =
            format!("t0;05.01.2026 10:00:00,000;05.01.2026 {second}\nForce [N];Acc [m/s^2]\n");
        folder.write("t0.csv", text(&header, |_, _, [f, a]| format!("{f:.5};{a:.5}")))
    };
    let words = ["line 1", "the row \"t0\"", "0.01 s after", "--leave-out \"Acc\""];
    refused(&[&file("10:00:00,010"), "--rate-hz", "5120"], "recording_malformed", &words);
    graded(&[&file("10:00:00,000"), "--rate-hz", "5120"]);
}

#[test]
fn seconds_and_their_fractions_in_two_columns_are_one_time_and_a_strange_zone_is_named() {
    let folder = Folder::new();
    let split = stamped("timestamp_s,timestamp_ns,Force (N),Acc (m/s^2)\n", |_, t| {
        let second = (t + 0.6).floor();
        format!("{:.0},{:.0}", 1.7e9 + second, (t + 0.6 - second) * 1e9)
    });
    graded(&[&folder.write("split.csv", split)]);
    let named =
        stamped("time,Force (N),Acc (m/s^2)\n", |_, t| format!("2026-01-05 {} XYZ", clock(t)));
    let words = ["line 2, column 1", "XYZ", "+01:00"];
    refused(&[&folder.write("named.csv", named)], "recording_malformed", &words);
}

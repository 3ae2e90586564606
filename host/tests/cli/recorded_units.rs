//! `massline hits` on recordings with units: declared, stated on the command line, missing or wrong.

use serde_json::Value;

use crate::hits::{
    RATE, SI, data, run, segments, time_header, time_record, time_record_in, triggered_record,
    verdicts,
};

#[test]
fn one_triggered_record_in_g_with_a_short_lead_is_graded_without_options() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("triggered.lvm");
    std::fs::write(&path, triggered_record()).unwrap();
    let path = path.display().to_string();
    assert_eq!(verdicts(&[&path]), [(0, "accepted".to_owned(), vec![])]);
    let (_, value, _) = run(&[&path]);
    let npy = data("impact2_response0.npy").display().to_string();
    let (_, whole, _) = run(&[&[npy.as_str(), "--rate-hz", "51200"], &SI[..]].concat());
    for key in ["peak_force_n", "peak_response_m_per_s2"] {
        let number = |value: &Value, hit: usize| value["hits"][hit][key].as_f64().unwrap();
        let (cut, whole) = (number(&value, 0), number(&whole, 1));
        // The rest value comes from 8 samples here, and from other ones there: their noise and a slow drift.
        assert!((cut / whole - 1.0).abs() < 0.01, "{key}: {cut} {whole}");
    }
}

#[test]
fn units_of_the_file_and_of_the_command_line_are_converted_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let lines = |force: &str, response: &str| {
        let mut text = format!("Hammer [{force}];z [{response}]\n");
        for n in 0..512 {
            let pulse = if (100..116).contains(&n) { 20.0 } else { 0.0 };
            text += &format!("{};{}\n", pulse, 0.5 * pulse);
        }
        text
    };
    let file = |name: &str, force: &str, response: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, lines(force, response)).unwrap();
        path.display().to_string()
    };
    let peaks = |arguments: &[&str]| {
        let (exit, value, stderr) = run(&[arguments, &["--rate-hz", "4000"]].concat());
        assert_eq!(exit, 0, "{stderr}");
        let hit = &value["hits"][0];
        ["peak_force_n", "peak_response_m_per_s2"].map(|key| hit[key].as_f64().unwrap())
    };
    let close = |actual: [f64; 2], expected: [f64; 2]| {
        // Findings are in single precision.
        let near = |k: usize| (actual[k] / expected[k] - 1.0).abs() < 1e-6;
        assert!(near(0) && near(1), "{actual:?} {expected:?}");
    };
    close(peaks(&[&file("si.csv", "N", "m/s²")]), [20.0, 10.0]);
    close(peaks(&[&file("g.csv", "lbf", "g")]), [88.964_432_3, 98.0665]);
    let volts = file("volts.csv", "N", "V");
    close(peaks(&[&volts, "--sensitivity", "z=1 V/(mm/s^2)"]), [20.0, 0.01]);
    // The first channel in one unit of acceleration, the second in none.
    let mixed = lines("N", "g").replacen("z [g]", "y [g];z [mm]", 1);
    let mixed: String = mixed
        .lines()
        .map(|line| {
            let last = line.rsplit(';').next().unwrap();
            if line.contains('[') { format!("{line}\n") } else { format!("{line};{last}\n") }
        })
        .collect();
    let path = folder.path().join("mixed.csv");
    std::fs::write(&path, mixed).unwrap();
    let (exit, value, stderr) = run(&[&path.display().to_string(), "--rate-hz", "4000"]);
    assert_eq!(exit, 0, "{stderr}");
    let left_out = &value["recording"]["left_out"][0];
    assert_eq!(left_out["name"], "z");
    assert!(left_out["reason"].as_str().unwrap().contains("\"mm\""), "{left_out}");
    // Of a file that states none the units are asked for, with the options that state them.
    let silent = file("silent.csv", "", "");
    let (exit, value, _) = run(&[&silent, "--rate-hz", "4000"]);
    assert_eq!((exit, &value["error"]["code"]), (2, &"recording_no_unit".into()), "{value}");
    let message = value["error"]["message"].as_str().unwrap();
    assert!(message.contains("--unit \"Hammer=N\" --unit \"z=m/s^2\""), "{message}");
    close(peaks(&[&silent, "--unit", "Hammer=N", "--unit", "*=g"]), [20.0, 98.0665]);
    let (exit, value, _) = run(&[&volts, "--rate-hz", "4000"]);
    let code = &value["error"]["code"];
    assert_eq!((exit, code), (2, &"recording_needs_sensitivity".into()), "{value}");
    let message = value["error"]["message"].as_str().unwrap();
    assert!(message.contains("\"z\"") && message.contains("--sensitivity \"z="), "{message}");
    // A signal is no acceleration because an option says so.
    let (exit, value, _) = run(&[&volts, "--rate-hz", "4000", "--unit", "z=g"]);
    assert_eq!((exit, &value["error"]["code"]), (2, &"recording_needs_sensitivity".into()));
}

/// Universal files of the third-party record, whose channels are converted or refused by their data types.
#[test]
fn quantities_and_units_of_a_universal_file_are_honoured_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let segments = segments();
    let hit = &segments[1];
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.display().to_string()
    };
    let peaks = |arguments: &[&str]| {
        let (exit, value, stderr) = run(arguments);
        assert_eq!(exit, 0, "{stderr}");
        ["peak_force_n", "peak_response_m_per_s2"]
            .map(|key| value["hits"][0][key].as_f64().unwrap())
    };
    let force = time_record(hit, 0, 13);
    let plain = write("plain.uff", &(force.clone() + &time_record(hit, 1, 12)));
    let plain = peaks(&[&[plain.as_str()], &SI[..]].concat());
    // Units of the user's own: 1000 mm to the metre, newtons.
    let system = format!(
        "    -1\n   164\n{:10}{:20}{:10}\n{:25.17e}{:25.17e}{:25.17e}\n{:25.17e}\n    -1\n",
        9, "mm, N", 2, 1e3, 1.0, 1.0, 0.0
    );
    let millimetres = system + &force + &time_record(hit, 1, 12);
    let millimetres = write("millimetres.uff", &millimetres);
    let of_file = peaks(&[&millimetres]);
    // A unit that is stated takes the place of that of the file.
    let stated = peaks(&[&millimetres, "--unit", "1=N", "--unit", "2=g"]);
    for (actual, factors) in [(of_file, [1.0, 1e-3]), (stated, [1.0, 9.80665])] {
        for k in 0..2 {
            // Findings are in single precision.
            assert!(
                (actual[k] / (plain[k] * factors[k]) - 1.0).abs() < 1e-6,
                "{actual:?} {plain:?}"
            );
        }
    }
    for (data_type, unit, words) in [
        (8, "NONE", ["displacement 2:3", "\"m\""]),
        (11, "NONE", ["velocity 2:3", "\"m/s\""]),
        (12, "m/s", ["acceleration 2:3", "\"m/s\""]),
    ] {
        let text = force.clone() + &time_record_in(hit, 1, (data_type, unit));
        let (exit, value, _) = run(&[&write("other.uff", &text)]);
        assert_eq!((exit, &value["error"]["code"]), (2, &"recording_unknown_unit".into()));
        let message = value["error"]["message"].as_str().unwrap();
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    }
    // Segments in different units.
    let other = time_record(&segments[3], 0, 13) + &time_record_in(&segments[3], 1, (12, "g"));
    let (exit, value, _) =
        run(&[&write("two.uff", &(force.clone() + &time_record(hit, 1, 12) + &other))]);
    assert_eq!((exit, &value["error"]["code"]), (2, &"recording_malformed".into()));
    let message = value["error"]["message"].as_str().unwrap();
    assert!(message.contains("line ") && message.contains("first segment"), "{message}");
}

#[test]
fn a_column_that_is_no_accelerometer_can_be_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("warm.csv");
    let rows = segments()[1].iter().map(|[f, a]| format!("{f};21.5;{a}\n")).collect::<String>();
    std::fs::write(&path, format!("Force [N];Room [°C];z [m/s²]\n{rows}")).unwrap();
    let path = path.display().to_string();
    let rate = RATE.to_string();
    let (exit, value, stderr) = run(&[&path, "--rate-hz", &rate]);
    assert_eq!(exit, 0, "{stderr}");
    let reason = &value["recording"]["left_out"][0];
    assert_eq!(reason["name"], "Room");
    assert!(reason["reason"].as_str().unwrap().contains("°C"), "{reason}");
    let left_out = [&path, "--rate-hz", &rate, "--leave-out", "room"];
    assert_eq!(verdicts(&left_out), [(0, "accepted".to_owned(), vec![])]);
    let (exit, value, _) = run(&[&left_out[..4], &["Force", "--force", "Force"]].concat());
    assert_eq!((exit, &value["error"]["code"]), (2, &"force_left_out".into()));
    let (exit, value, _) = run(&[&left_out[..4], &["Humidity"]].concat());
    assert_eq!((exit, &value["error"]["code"]), (2, &"no_such_channel".into()));
}

/// The third-party record with its second segment at half the rate.
#[test]
fn segments_of_unequal_rates_are_named_with_both() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |name: &str, text: &str| {
        let path = folder.path().join(name).display().to_string();
        std::fs::write(&path, text).unwrap();
        let (code, value, _) = run(&[&path]);
        assert_eq!(code, 2, "{value}");
        let message = value["error"]["message"].as_str().unwrap().to_owned();
        assert!(message.contains("line ") && message.contains("one rate"), "{message}");
        assert!(message.contains("51200") && message.contains("25600"), "{message}");
    };
    let first = triggered_record();
    let (_, segment) = first.split_once("***End_of_Header***\t\n\t\n").unwrap();
    let slower = segment.replace("1,953125E-5", "3,90625E-5");
    assert_ne!(slower, segment);
    refused("two.lvm", &format!("{first}\n{slower}"));

    let [force, response] = [(0, 13), (1, 12)]
        .map(|(channel, data_type)| time_record(&segments()[1], channel, data_type));
    let step = format!("{:13.5e}", RATE.recip());
    let slower =
        [&force, &response].map(|record| record.replace(&step, &format!("{:13.5e}", 2.0 / RATE)));
    assert_ne!(slower[0], force);
    // The abscissa of a universal file has six digits.
    let path = folder.path().join("two.uff").display().to_string();
    std::fs::write(&path, [&force, &response, &slower[0], &slower[1]].map(String::as_str).concat())
        .unwrap();
    let (code, value, _) = run(&[&path]);
    let message = value["error"]["message"].as_str().unwrap_or_default();
    assert!(code == 2 && message.contains("export all records at one rate"), "{value}");
}

#[test]
fn a_second_force_is_named_also_when_the_first_is_stated() {
    let folder = tempfile::tempdir().unwrap();
    let grade = |heads: &str, options: &[&str]| {
        let path = folder.path().join("two.csv").display().to_string();
        let segments = segments();
        let rows = segments[1].iter().enumerate().map(|(n, [force, response])| {
            format!("{},{force},{force},{response}\n", n as f64 / RATE)
        });
        std::fs::write(&path, heads.to_owned() + "\n" + &rows.collect::<String>()).unwrap();
        let (code, value, _) = run(&[&[path.as_str()], options].concat());
        (code, value["error"]["message"].as_str().unwrap_or_default().to_owned())
    };
    let stated = ["--force", "Hammer"];
    for heads in ["Time,Hammer,Force 2,a", "Time,Hammer [N],Cell [lbf],a [m/s^2]"] {
        let (code, message) = grade(heads, &stated);
        assert!(
            code == 2 && message.contains("channel 2 is a force as well"),
            "{heads}: {message}"
        );
        let name = if heads.contains("Cell") { "Cell" } else { "Force 2" };
        assert!(message.contains(&format!("--leave-out \"{name}\"")), "{message}");
        let units = ["--unit", "Hammer=N", "--unit", "*=m/s^2"];
        let (code, message) = grade(heads, &[&stated[..], &["--leave-out", name], &units].concat());
        assert_eq!(code, 0, "{message}");
    }
    let unit = ["--unit", "Hammer=N", "--unit", "Force 2=g", "--unit", "a=g"];
    let unit = [&stated[..], &unit].concat();
    assert_eq!(grade("Time,Hammer,Force 2,a", &unit).0, 0);
}

#[test]
fn a_dataset_164_that_contradicts_itself_or_the_labels_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let hit = &segments()[1];
    let notes = |system: (i32, &str, [f64; 2]), units: [&str; 2]| {
        let (code, description, [length, force]) = system;
        let mut text = format!(
            "    -1\n   164\n{code:10}{description:20}{:10}\n{length:25.17e}{force:25.17e}{:25.17e}\n{:25.17e}\n    -1\n",
            2, 1.0, 0.0
        );
        for (channel, (data_type, unit)) in [13, 12].into_iter().zip(units).enumerate() {
            text += &time_record_in(hit, channel, (data_type, unit));
        }
        let path = folder.path().join("units.uff");
        std::fs::write(&path, text).unwrap();
        let (exit, value, stderr) = run(&[&path.display().to_string()]);
        assert_eq!(exit, 0, "{value} {stderr}");
        (value["notes"].to_string(), value["recording"]["channels"][1]["factor_to_si"].clone())
    };
    let none = ["NONE", "NONE"];
    let (silent, factor) = notes((9, "mm, N", [1e3, 1.0]), none);
    assert_eq!((silent.as_str(), factor), ("[]", 1e-3.into()));
    for (system, units, words) in [
        (
            (9, "Meter (newton)", [1e3, 1.0]),
            none,
            "by the description the values of acceleration 2:3 would be 1000 times",
        ),
        (
            (9, "mm, N", [1e-3, 1.0]),
            none,
            "the units factors of dataset 1 (164) and its description",
        ),
        (
            (1, "Meter (newton)", [1e3, 1.0]),
            none,
            "the units code of dataset 1 (164) and its factors",
        ),
        (
            (1, "mm (newton)", [1.0, 1.0]),
            none,
            "by the description the values of acceleration 2:3 would be 0.001 times",
        ),
        (
            (1, "Meter (newton)", [1.0, 1.0]),
            ["N", "g"],
            "the labels of the file state g and its dataset 1 (164)",
        ),
    ] {
        let (notes, _) = notes(system, units);
        assert!(notes.contains(words), "{notes}");
    }
}

#[test]
fn a_byte_order_or_an_increment_that_cannot_be_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let hit = &segments()[1];
    let refused = |name: &str, bytes: &[u8], words: &[&str]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let (exit, value, _) = run(&[&path.display().to_string()]);
        assert_eq!((exit, &value["error"]["code"]), (2, &"uff_corrupt".into()), "{value}");
        let message = value["error"]["message"].as_str().unwrap();
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    };
    for (stated, bytes_of) in [(1, f64::to_be_bytes as fn(f64) -> [u8; 8]), (2, f64::to_le_bytes)] {
        let mut bytes = Vec::new();
        for (channel, quantity) in [(13, "N"), (12, "m/s^2")].into_iter().enumerate() {
            let first = format!(
                "    58b{stated:6}     2          11{:12}     0     0           0           0",
                8 * hit.len()
            );
            let header = time_header(channel, (hit.len(), Some(RATE.recip())), quantity);
            bytes.extend(header.replacen("    58", &first, 1).bytes());
            bytes.extend(hit.iter().flat_map(|values| bytes_of(values[channel])));
            bytes.extend(b"    -1\n");
        }
        let order = ["little-endian (1)", "big-endian (2)"][stated - 1];
        let words = [&format!("the header states {order}"), "of the 4608 values", "byte order"];
        refused("order.uff", &bytes, &words);
    }
    for step in [0.0, -RATE.recip()] {
        let header = time_header(0, (hit.len(), Some(step)), (13, "N"));
        let rows: String = hit
            .chunks(4)
            .map(|row| {
                row.iter().map(|values| format!("{:20.11e}", values[0])).collect::<String>() + "\n"
            })
            .collect();
        let words =
            ["dataset 1, line 1", "the increment of the abscissa (record 7) is", "positive"];
        refused("step.uff", format!("{header}{rows}    -1\n").as_bytes(), &words);
    }
}

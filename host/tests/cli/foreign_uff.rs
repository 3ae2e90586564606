//! `massline solve` and `massline hits` on universal files as other programs write them: units and their places,
//! encodings, DOFs, words for no number. Each file holds the exact responses of a rigid body of 2.5 kg.

use std::path::{Path, PathBuf};

use nalgebra::{Matrix3, Vector3};
use serde_json::Value;

use crate::program::{self, Run, run};

const MASS: f64 = 2.5;
const CENTER: [f64; 3] = [0.1, -0.03, 0.04];
const INERTIA: [[f64; 3]; 3] = [[0.02, -0.003, 0.002], [-0.003, 0.03, 0.001], [0.002, 0.001, 0.04]];
const SENSORS: [(i64, [f64; 3]); 3] =
    [(1, [0.0, 0.0, 0.0]), (2, [0.25, 0.02, 0.0]), (3, [0.05, -0.2, 0.1])];
/// Node, position, axis and sign of each hit.
const HITS: [(i64, [f64; 3], usize, f64); 5] = [
    (11, [0.2, -0.15, 0.05], 1, 1.0),
    (12, [-0.05, 0.1, 0.12], 2, -1.0),
    (13, [0.15, 0.12, -0.08], 0, 1.0),
    (14, [0.02, -0.1, -0.06], 2, 1.0),
    (11, [0.2, -0.15, 0.05], 0, -1.0),
];
const BINS: usize = 12;
const G: f64 = 9.806_65;
const LBF: f64 = 4.448_221_615_260_5;

/// How a program writes a function.
struct Style {
    /// Type, name and unit of numerator and denominator.
    numerator: (i64, &'static str, &'static [u8]),
    denominator: (i64, &'static str, &'static [u8]),
    /// The accelerances in the file over those in SI.
    scale: f64,
    component: &'static str,
    swapped: bool,
    scalar: bool,
    /// Values for the bin at 0 Hz, where there is one.
    zero_frequency: Option<&'static str>,
    /// A value in place of that at this bin.
    replaced: Option<(usize, &'static str)>,
}

const PLAIN: Style = Style {
    numerator: (12, "Acceleration", b"m/s^2"),
    denominator: (13, "Excitation Force", b"N"),
    scale: 1.0,
    component: "NONE",
    swapped: false,
    scalar: false,
    zero_frequency: None,
    replaced: None,
};

/// The accelerance of a point along an axis due to a force, 1/kg.
fn accelerance(at: [f64; 3], axis: usize, hit: &(i64, [f64; 3], usize, f64)) -> f64 {
    let inertia = Matrix3::from_fn(|row, column| INERTIA[row][column]);
    let center = Vector3::from(CENTER);
    let mut force = Vector3::zeros();
    force[hit.2] = hit.3;
    let torque = (Vector3::from(hit.1) - center).cross(&force);
    let angular = inertia.try_inverse().unwrap() * torque;
    (force / MASS + angular.cross(&(Vector3::from(at) - center)))[axis]
}

impl Style {
    fn functions(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        for hit in &HITS {
            for (node, at) in SENSORS {
                for axis in 0..3 {
                    self.function((node, axis), hit, accelerance(at, axis, hit), &mut bytes);
                }
            }
        }
        bytes
    }

    fn function(
        &self,
        (node, axis): (i64, usize),
        hit: &(i64, [f64; 3], usize, f64),
        value: f64,
        bytes: &mut Vec<u8>,
    ) {
        bytes.extend(b"    -1\n    58\nFRF\nNONE\nNONE\nNONE\nNONE\n");
        let direction =
            |axis: usize, sign: f64| if self.scalar { 0 } else { sign as i64 * (axis as i64 + 1) };
        let place =
            |name: &str, node: i64, direction: i64| format!(" {name:10}{node:10}{direction:4}");
        let response = place(self.component, node, direction(axis, 1.0));
        let reference = place("NONE", hit.0, direction(hit.2, hit.3));
        let dofs = if self.swapped { reference + &response } else { response + &reference };
        bytes.extend(format!("    4         1    1         0{}{dofs}\n", "").bytes());
        let (points, first) = match self.zero_frequency {
            Some(_) => (BINS + 1, 0.0),
            None => (BINS, 10.0),
        };
        bytes.extend(
            format!("         6{points:10}         1{first:13.5e}{:13.5e}{:13.5e}\n", 10.0, 0.0)
                .bytes(),
        );
        for (data_type, name, unit) in
            [(18, "Frequency", &b"Hz"[..]), self.numerator, self.denominator, (0, "NONE", b"NONE")]
        {
            let pad = " ".repeat(20_usize.saturating_sub(name.len()));
            bytes.extend(format!("{data_type:10}    0    0    0 {name}{pad} ").bytes());
            bytes.extend(unit);
            bytes.extend(b"\n");
        }
        if let Some(text) = self.zero_frequency {
            bytes.extend(format!("{text:>20}{text:>20}\n").bytes());
        }
        for bin in 0..BINS {
            let number = format!("{:.11e}", value * self.scale);
            let text = match self.replaced {
                Some((place, text)) if place == bin => text.to_owned(),
                _ => number,
            };
            bytes.extend(format!("{text:>20}{:20.11e}\n", 0.0).bytes());
        }
        bytes.extend(b"    -1\n");
    }
}

fn layout_text(tables: &str) -> String {
    let axes = ["X", "Y", "Z"];
    let hits = HITS.map(|(node, _, axis, sign)| {
        format!("\"{node}:{}{}\"", if sign < 0.0 { '-' } else { '+' }, axes[axis])
    });
    let mut text = format!("sensors = [1, 2, 3]\nhits = [{}]\n", hits.join(", "));
    let mut nodes: Vec<(i64, [f64; 3])> = SENSORS.to_vec();
    nodes.extend(HITS.iter().take(4).map(|hit| (hit.0, hit.1)));
    for (node, at) in nodes {
        text += &format!("[[node]]\nid = {node}\nposition_m = {at:?}\n");
    }
    text + tables
}

fn reference(mass: f64, center: [f64; 3], inertia: [[f64; 3]; 3]) -> String {
    format!(
        "[reference]\nmass_kg = {mass:?}\ncenter_of_mass_m = {center:?}\ninertia_kg_m2 = {inertia:?}\n"
    )
}

fn write(folder: &Path, name: &str, bytes: impl AsRef<[u8]>) -> String {
    let path: PathBuf = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    path.display().to_string()
}

fn solve_with(tables: &str, uff: &[u8], options: &[&str]) -> Run {
    let folder = tempfile::tempdir().unwrap();
    let (layout, uff) =
        (write(folder.path(), "l.toml", layout_text(tables)), write(folder.path(), "f.uff", uff));
    run(&[&["solve", &layout, &uff, "--method", "irm"], options].concat())
}

/// The answer to these functions, which is that of the body, and what was understood.
#[track_caller]
fn answer(uff: &[u8], options: &[&str]) -> Value {
    let run = solve_with(&reference(MASS, CENTER, INERTIA), uff, &[options, &["--json"]].concat());
    assert_eq!(run.exit, 0, "{}\n{}", run.stdout, run.stderr);
    let value: Value = serde_json::from_str(&run.stdout).unwrap();
    let result = &value["results"][0];
    let mass = result["mass_kg"]["value"].as_f64().unwrap();
    // The numbers of the files have twelve digits, and equations of condition 20.
    assert!((mass / MASS - 1.0).abs() < 1e-8, "{mass} kg\n{}", run.stderr);
    for (axis, expected) in CENTER.iter().enumerate() {
        let center = result["center_of_mass_m"]["value"][axis].as_f64().unwrap();
        assert!((center - expected).abs() < 1e-8, "{center} m");
    }
    let read = &value["frequency_responses"];
    assert_eq!((read["functions"].as_u64(), read["bins"].as_u64()), (Some(45), Some(BINS as u64)));
    assert_eq!(read["range_hz"], serde_json::json!([10.0, 120.0]));
    value
}

fn refused(uff: &[u8], options: &[&str], words: &[&str]) {
    let run = solve_with("", uff, options);
    assert_eq!(run.exit, 2, "{}\n{}", run.stdout, run.stderr);
    assert!(words.iter().all(|words| run.says(words)), "{words:?}: {}", run.stderr);
}

fn dataset_164(code: i32, length: f64, force: f64) -> Vec<u8> {
    let system =
        format!("{code:10}{:20}{:10}\n{length:25.17e}{force:25.17e}{:25.17e}", "units", 2, 1.0);
    format!("    -1\n   164\n{system}\n{:25.17e}\n    -1\n", 0.0).into_bytes()
}

#[test]
fn a_stated_quantity_does_not_drop_the_units() {
    let general = |numerator, denominator, scale| {
        Style {
            numerator: (1, "Acceleration", numerator),
            denominator: (1, "Force", denominator),
            scale,
            ..PLAIN
        }
        .functions()
    };
    for (numerator, denominator, scale, unit) in [
        (&b"g/N"[..], &b"NONE"[..], 1.0 / G, "g/N"),
        (b"g", b"lbf", LBF / G, "g/lbf"),
        (b"G's", b"lbF", LBF / G, "G's/lbF"),
        (b"mm/s\xb2", b"KN", 1e6, "(mm/s²)/KN"),
    ] {
        let value = answer(&general(numerator, denominator, scale), &["--quantity", "accelerance"]);
        let read = &value["frequency_responses"]["units"];
        assert_eq!(
            (read[0]["unit"].as_str(), read[0]["source"].as_str()),
            (Some(unit), Some("labels"))
        );
    }
    let both =
        [dataset_164(7, 1.0 / 0.0254, 1.0 / LBF), general(b"NONE", b"NONE", LBF / 0.0254)].concat();
    let value = answer(&both, &["--quantity", "accelerance"]);
    assert_eq!(value["frequency_responses"]["units"][0]["source"], "dataset 164");
    refused(
        &general(b"g/N", b"NONE", 1.0),
        &["--quantity", "receptance"],
        &["\"g/N\" is not a known unit of displacement"],
    );
    refused(
        &general(b"EU", b"N", 1.0),
        &["--quantity", "accelerance"],
        &["\"EU\"", "needs the sensitivity"],
    );
}

#[test]
fn names_in_other_alphabets_and_encodings_shift_no_unit() {
    for (name, numerator, denominator, scale) in [
        ("Kraft Stößel", &b"m/s^2"[..], &b"kN"[..], 1e3),
        ("加速度", b"g", b"N", 1.0 / G),
        ("Accélération", b"mm/s^2", b"N", 1e3),
        ("Acceleration", b"m/s\xb2", b"N", 1.0),
        ("Acceleration", b"(1/N)*(m/s\xb2)", b"N", 1.0),
    ] {
        let style = Style {
            numerator: (12, name, numerator),
            denominator: (13, name, denominator),
            scale,
            ..PLAIN
        };
        answer(&style.functions(), &[]);
    }
    let long = Style { denominator: (13, "Force of the hammer 1", b"kN"), ..PLAIN };
    refused(&long.functions(), &[], &["is not a known unit of force"]);
}

#[test]
fn dataset_164_holds_before_and_after_the_functions_and_contradictions_are_named() {
    let unlabelled = Style {
        numerator: (12, "NONE", b"NONE"),
        denominator: (13, "NONE", b"NONE"),
        scale: 1e3,
        ..PLAIN
    }
    .functions();
    let millimetres = dataset_164(9, 1e3, 1.0);
    for uff in [[&millimetres, &unlabelled], [&unlabelled, &millimetres]] {
        let value = answer(&uff.map(Vec::as_slice).concat(), &[]);
        assert_eq!(value["frequency_responses"]["units"][0]["unit"], "(mm/s^2)/N");
    }
    // Labels precede, with both readings.
    let value = answer(&[&PLAIN.functions(), &millimetres].map(Vec::as_slice).concat(), &[]);
    let findings = value["diagnostics"].to_string();
    assert!(
        findings.contains("by dataset 164 the accelerances would be 0.001 times as large"),
        "{findings}"
    );
    // Nothing is stated.
    let silent =
        Style { numerator: (12, "NONE", b"NONE"), denominator: (13, "NONE", b"NONE"), ..PLAIN }
            .functions();
    let value = answer(&silent, &[]);
    assert!(
        value["diagnostics"].to_string().contains("states no unit of its responses"),
        "{value}"
    );
    let run = solve_with("", &silent, &[]);
    let understood = "45 frequency responses: accelerance in (m/s^2)/N (assumed: the file states no unit); 12 bins \
                      from 10 to 120 Hz";
    assert!(run.says(understood), "{}", run.stderr);
}

#[test]
fn words_for_no_number_empty_functions_and_marks_cost_nothing() {
    for text in ["-1.#IND000000", "1.#QNAN", "-nan(ind)", "NaN", "1.#INF", "************"] {
        let value = answer(&Style { zero_frequency: Some(text), ..PLAIN }.functions(), &[]);
        assert_eq!(
            value["frequency_responses"]["left_out"],
            serde_json::json!(["the bin at 0 Hz"])
        );
    }
    let plain = PLAIN.functions();
    let text = String::from_utf8(plain.clone()).unwrap();
    let end = text.find("\n    -1\n    -1\n").unwrap() + 8;
    let header: Vec<&str> = text[..end].lines().take(13).collect();
    let empty = header
        .join("\n")
        .replacen("        12         1", "         0         1", 1)
        .replacen("         1   1", "        99   1", 1);
    let value = answer(format!("{empty}\n    -1\n{text}").as_bytes(), &[]);
    let left_out = value["frequency_responses"]["left_out"].to_string();
    assert!(left_out.contains("functions without values (dataset 1)"), "{left_out}");
    for around in [
        [&b"\xef\xbb\xbf"[..], &plain, b""],
        [b"", &plain, b"\x1a"],
        [b"\n", &plain, b"\n\x1a\x1a\0"],
    ] {
        answer(&around.concat(), &[]);
    }
    // Above the band a bin is left out, in the band it is named.
    let tables = format!("[test]\nband_hz = [10.0, 100.0]\n{}", reference(MASS, CENTER, INERTIA));
    let above =
        solve_with(&tables, &Style { replaced: Some((11, "-1.#IND")), ..PLAIN }.functions(), &[]);
    assert_eq!(above.exit, 0, "{}", above.stderr);
    assert!(
        above.says("11 bins from 10 to 110 Hz; left out: bins without a number at 120 Hz"),
        "{}",
        above.stderr
    );
    let inside = Style { replaced: Some((4, "1.#QNAN")), ..PLAIN }.functions();
    refused(
        &inside,
        &[],
        &["node 1, axis X, due to the hit 11:+Y (dataset 1) is NaN or infinite at 50 Hz"],
    );
}

#[test]
fn a_missing_response_is_refused_with_what_the_file_holds() {
    let missing = "no frequency response of the sensor on node 1, axis X, due to the hit 11:+Y";
    let swapped = Style { swapped: true, ..PLAIN }.functions();
    refused(
        &swapped,
        &[],
        &[missing, "response and reference swapped, in dataset 1 (response 11:2, reference 1:1)"],
    );
    let scalar = Style { scalar: true, ..PLAIN }.functions();
    refused(&scalar, &[], &[missing, "responses at 1:0 due to 11:0", "directions 1, 2 and 3"]);
    // The name of the component and the node of the response.
    let text = String::from_utf8(PLAIN.functions())
        .unwrap()
        .replace("NONE               1", "NONE              77");
    refused(
        text.as_bytes(),
        &[],
        &[missing, "the file has responses at 2:1, 2:2, 2:3", "77:3 due to forces at 11:-1, 11:2"],
    );
}

#[test]
fn components_with_the_same_nodes_are_told_apart() {
    let body = Style { component: "Body", ..PLAIN }.functions();
    let table = Style { component: "Table", scale: 3.0, ..PLAIN }.functions();
    // The object is complete, of the table there is one node.
    let of_first_node = table.split_inclusive(|b| *b == b'\n').collect::<Vec<_>>().concat();
    let one = of_first_node.windows(8).position(|w| w == b"-1\n    -").unwrap();
    let value = answer(&[&body[..], &of_first_node[..one + 3]].concat(), &[]);
    let notes = value["notes"].to_string();
    assert!(notes.contains("Body") && notes.contains("those of \\\"Table\\\" are not"), "{notes}");
    refused(
        &[body, table].concat(),
        &[],
        &[
            "of several components",
            "\"Body\"",
            "\"Table\"",
            "export the functions of the object alone",
        ],
    );
}

#[test]
fn a_reference_in_other_units_decides_nothing_and_is_named() {
    let uff = PLAIN.functions();
    let scaled = INERTIA.map(|row| row.map(|value| value * 1e9));
    for (tables, words) in [
        (
            reference(MASS, CENTER, scaled),
            "[reference] describes a body with a radius of gyration of",
        ),
        (
            reference(MASS, CENTER.map(|value| value * 1e3), INERTIA),
            "[reference] describes a body whose centre of mass lies",
        ),
        (
            reference(MASS * 1e3, CENTER, INERTIA),
            "the accelerances are 1000.0000 times what the mass of [reference]",
        ),
    ] {
        let run = solve_with(&tables, &uff, &["--json"]);
        assert_eq!(run.exit, 0, "{}", run.stderr);
        let value: Value = serde_json::from_str(&run.stdout).unwrap();
        let mass = value["results"][0]["mass_kg"]["value"].as_f64().unwrap();
        assert!((mass / MASS - 1.0).abs() < 1e-8, "{mass}");
        assert!(value["diagnostics"].to_string().contains(words), "{}", value["diagnostics"]);
    }
    // Where there is no answer, the warning is not lost.
    let error = solve_with(&reference(MASS, CENTER, scaled), b"    -1\n   151\n    -1\n", &[]);
    assert_eq!(error.exit, 2);
    assert!(error.says("radius of gyration"), "{}", error.stderr);
}

#[test]
fn values_that_look_like_another_unit_are_named() {
    let named = |style: Style, tables: &str| {
        let run = solve_with(tables, &style.functions(), &["--json"]);
        // A prior that the data contradict leaves no answer that can be used.
        let is_contradicted = style.scale != 1.0 && tables.contains("[prior]");
        assert_eq!(run.exit, if is_contradicted { 3 } else { 0 }, "{}", run.stderr);
        serde_json::from_str::<Value>(&run.stdout).unwrap()["diagnostics"].to_string()
    };
    let expected = reference(MASS, CENTER, INERTIA);
    for (scale, words) in [
        (1.0 / G, "are the accelerations in g, not in m/s^2?"),
        (LBF, "are the forces in lbf, not in N?"),
        (1e3, "are the accelerations in mm/s^2"),
        (LBF / G, "are the accelerations in g and the forces in lbf?"),
        (1.0 / 0.0254, "are the accelerations in in/s^2"),
    ] {
        for tables in [&expected[..], "[prior]\nmass_kg = { value = 2.5, sigma = 0.1 }\n"] {
            let notes = named(Style { scale, ..PLAIN }, tables);
            assert!(notes.contains(words), "{scale}: {notes}");
        }
    }
    assert!(!named(PLAIN, &expected).contains("times what"));
    assert!(!named(Style { scale: 1.3, ..PLAIN }, &expected).contains("times what"));
    let mut opposite = INERTIA;
    for (row, column) in [(0, 1), (0, 2), (1, 2), (1, 0), (2, 0), (2, 1)] {
        opposite[row][column] = -opposite[row][column];
    }
    let notes = named(PLAIN, &reference(MASS, CENTER, opposite));
    assert!(notes.contains("opposite signs") && notes.contains("−∫xy dm"), "{notes}");
    assert!(!named(PLAIN, &expected).contains("opposite signs"));
}

/// Channels of 2048 samples with a hit: a half sine of 60 N over 2 ms, and responses to it.
fn time_records(places: &[((i64, i64), i64)], unit: &str, step: f64) -> Vec<u8> {
    let mut text = String::new();
    for ((node, direction), data_type) in places {
        text += &format!("    -1\n    58\n{}", "NONE\n".repeat(5));
        text += &format!(
            "    1         0    0         0 {:10}{node:10}{direction:4} {:10}{:10}{:4}\n",
            "NONE", "NONE", 0, 0
        );
        text += &format!("         4      2048         1{:13.5e}{step:13.5e}{:13.5e}\n", 0.0, 0.0);
        let axis =
            |kind: i64, unit: &str| format!("{kind:10}    0    0    0 {:20} {unit:20}\n", "NONE");
        text += &(axis(17, unit)
            + &axis(*data_type, if *data_type == 13 { "N" } else { "m/s^2" })
            + &axis(0, "NONE")
            + &axis(0, "NONE"));
        for k in 0..2048_u32 {
            let phase = (f64::from(k) - 400.0) / 10.0;
            let pulse = if (0.0..1.0).contains(&phase) {
                (std::f64::consts::PI * phase).sin()
            } else {
                0.0
            };
            let noise = 1e-3 * f64::from((k * 7919) % 13);
            text +=
                &format!("{:20.11e}\n", pulse * if *data_type == 13 { 60.0 } else { 20.0 } + noise);
        }
        text += "    -1\n";
    }
    text.into_bytes()
}

#[test]
fn time_records_of_one_dof_are_channels() {
    let folder = tempfile::tempdir().unwrap();
    let (force, response) = (13, 12);
    let hits = |name: &str, places: &[((i64, i64), i64)], unit: &str, step: f64| {
        let path = write(folder.path(), name, time_records(places, unit, step));
        let run = program::run(&["hits", &path, "--json"]);
        assert_eq!(run.exit, 0, "{}\n{}", run.stdout, run.stderr);
        serde_json::from_str::<Value>(&run.stdout).unwrap()
    };
    let one_hit = |value: &Value| {
        let hits = value["hits"].as_array().unwrap();
        let peak = hits[0]["peak_force_n"].as_f64().unwrap();
        assert!(hits.len() == 1 && (peak / 60.0 - 1.0).abs() < 1e-3, "{value}");
    };
    let again = [((1, 3), response), ((2, 3), response), ((3, 3), force), ((1, 3), response)];
    one_hit(&hits("again.uff", &again, "s", 2e-4));
    let nowhere = [((0, 0), response), ((0, 0), response), ((0, 0), response), ((0, 0), force)];
    one_hit(&hits("nowhere.uff", &nowhere, "NONE", 2e-4));
    // The same in milliseconds; and twice over, as two segments.
    one_hit(&hits("milliseconds.uff", &again, "msec", 0.2));
    let twice = hits("twice.uff", &[nowhere, nowhere].concat(), "s", 2e-4);
    assert_eq!(twice["hits"].as_array().unwrap().len(), 2);
    let path = write(folder.path(), "samples.uff", time_records(&again, "samples", 1.0));
    let run = program::run(&["hits", &path]);
    assert!(run.exit == 2 && run.says("\"samples\"") && run.says("seconds"), "{}", run.stderr);
    let cut =
        [((1, 3), force), ((2, 3), response), ((1, 3), force), ((2, 3), response), ((1, 3), force)];
    let path = write(folder.path(), "cut.uff", time_records(&cut, "s", 2e-4));
    let run = program::run(&["hits", &path]);
    assert!(run.exit == 2 && run.says("truncated"), "{}", run.stderr);
}

#[test]
fn a_description_in_dataset_164_and_an_increment_that_cannot_be_are_named() {
    let unlabelled = Style {
        numerator: (12, "NONE", b"NONE"),
        denominator: (13, "NONE", b"NONE"),
        scale: 1e3,
        ..PLAIN
    }
    .functions();
    let system = String::from_utf8(dataset_164(9, 1e3, 1.0)).unwrap();
    let system = system.replace("units               ", "Meter (newton)      ");
    let value = answer(&[system.as_bytes(), &unlabelled].concat(), &[]);
    let words = "by the description the accelerances would be 1000 times as large";
    assert!(value["diagnostics"].to_string().contains(words), "{value}");
    let text = String::from_utf8(PLAIN.functions()).unwrap();
    let spacing = format!("{:13.5e}{:13.5e}{:13.5e}\n", 10.0, 10.0, 0.0);
    for increment in [0.0, -10.0] {
        let other = format!("{:13.5e}{increment:13.5e}{:13.5e}\n", 10.0, 0.0);
        let words = ["the increment of the abscissa (record 7) is", "it must be positive"];
        refused(text.replace(&spacing, &other).as_bytes(), &[], &words);
    }
    let far = format!("{:13.5e}{:13.5e}{:13.5e}\n", 1e30, 10.0, 0.0);
    let words = ["is 10,", "not vanish beside the minimum of"];
    refused(text.replace(&spacing, &far).as_bytes(), &[], &words);
}

use massline_shared::diagnosis::Code;
use massline_shared::layout::{
    ApparatusUncertainty, HitUncertainty, Prior, SensorUncertainty, uncertainty_keys,
};

use super::*;
use massline_shared::layout::{
    FrfEstimator, TARGET_KEYS, TEST_KEYS, Target, TestProfile, TestSettings,
};
use massline_shared::mass_line::Terms;

const GOOD: &str = include_str!("../../../examples/three-bar-test-1.toml");

/// The template of mass lines.
fn commented() -> String {
    template(TestProfile::MassLine)
}

fn parse(text: &str) -> Result<LayoutFile, LayoutFileError> {
    LayoutFile::parse(text, "bar.toml")
}

/// The example with one text replaced; the text must occur in it.
fn with(from: &str, to: &str) -> String {
    assert!(GOOD.contains(from), "{from}");
    GOOD.replacen(from, to, 1)
}

/// The message of a bad layout, which must name the file and the line.
fn message(text: &str, line: usize) -> String {
    let error = parse(text).unwrap_err();
    let message = error.to_string();
    assert!(message.starts_with(&format!("bar.toml:{line}: ")), "{message}");
    assert_eq!(error.exit_code(), 2);
    message
}

#[test]
fn the_paper_s_four_tests_are_resolved() {
    let [a, b, c] = [0.207_850_606_779_220_13, -0.199_018_578_162_329_7, 0.149_130_815_058_460_87];
    let expected = {
        let first: [([f64; 3], [f64; 3]); 3] = [
            ([0.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
            ([a, b, 0.0], [0.0, 0.0, 1.0]),
            ([a, b, c], [1.0, 0.0, 0.0]),
        ];
        let second = [
            ([0.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
            ([a, b, 0.0], [0.0, 0.0, 1.0]),
            ([a, b, 0.0], [0.0, 1.0, 0.0]),
        ];
        let [three, four] = [[a, 0.0, 0.0], [a, b, c]];
        [
            ([1, 2, 3], three, first),
            ([1, 2, 4], four, first),
            ([1, 2, 3], three, second),
            ([1, 2, 4], four, second),
        ]
    };
    let files = [
        GOOD,
        include_str!("../../../examples/three-bar-test-2.toml"),
        include_str!("../../../examples/three-bar-test-3.toml"),
        include_str!("../../../examples/three-bar-test-4.toml"),
    ];
    for (text, (sensors, last, hits)) in files.into_iter().zip(expected) {
        let file = parse(text).unwrap();
        assert!(file.layout.sensors.iter().map(|s| s.node).eq(sensors));
        assert_eq!(file.layout.sensors[2].position, last);
        assert!(file.layout.hits.iter().map(|h| (h.position, h.direction)).eq(hits));
        // Theory, section 11.
        let ten = file.reference.unwrap().complete().unwrap();
        let theta = [
            1.23, 0.169, -0.089, 0.020, 0.011134, 0.006762, 0.013942, 0.004253, -0.000956, 0.002706,
        ];
        // The theory prints six decimals.
        assert!(ten.iter().zip(theta).all(|(x, y)| (x - y).abs() < 5e-7));
        assert!(file.hash().is_some());
    }
}

#[test]
fn the_template_is_a_valid_layout() {
    let file = parse(&commented()).unwrap();
    assert_eq!(file.layout.sensors.len(), 3);
    // The template claims to show the defaults.
    let layout = &file.layout;
    assert!(layout.sensors.iter().all(|s| s.uncertainty == SensorUncertainty::default()));
    assert!(layout.hits.iter().all(|h| h.uncertainty == HitUncertainty::default()));
    assert_eq!(layout.apparatus, ApparatusUncertainty::default());
    // And it has all keys.
    let template = commented();
    for key in uncertainty_keys() {
        assert!(template.contains(&format!("\n{} = {} ", key.name, key.default)), "{}", key.name);
    }
    for key in TEST_KEYS {
        assert!(template.contains(&format!("\n{} = ", key.name)), "{}", key.name);
    }
    assert_eq!(file.layout.test, massline_shared::layout::TestSettings::default());
}

#[test]
fn a_number_of_hits_is_written_without_a_decimal_point() {
    let with =
        |count: &str| commented().replace("hits_per_dof = 5 ", &format!("hits_per_dof = {count} "));
    assert_eq!(parse(&with("50")).unwrap().layout.test.hits_per_dof, 50);
    for wrong in ["5.0", "5.5", "1e300", "nan", "\"five\"", "0", "51", "-1"] {
        let error = parse(&with(wrong)).unwrap_err().to_string();
        assert!(error.contains("whole number"), "{wrong}: {error}");
    }
}

#[test]
fn the_template_of_the_suspension_profile_has_its_defaults() {
    let text = template(TestProfile::Suspension);
    let file = parse(&text).unwrap();
    assert_eq!(file.layout.test, TestSettings::of_profile(TestProfile::Suspension));
    let commented = commented();
    // Profile, band, decay, window, hits.
    let (old, new): (Vec<_>, Vec<_>) = (commented.lines().collect(), text.lines().collect());
    assert_eq!(new.iter().filter(|line| !old.contains(line)).count(), 5);
    assert_eq!(new.len(), old.len());
}

#[test]
fn under_another_profile_band_and_windows_are_its_own() {
    let changed =
        |text: &str, profile| LayoutFile::parse_in_profile(text, "t.toml", profile).unwrap();
    let modes = changed(&commented(), Some(TestProfile::Suspension));
    assert_eq!(modes.set_aside, ["band_hz", "exponential_decay_per_s", "force_window_s"]);
    let of_profile = TestSettings::of_profile(TestProfile::Suspension);
    assert_eq!(modes.layout.test, of_profile);
    let same = changed(&template(TestProfile::Suspension), Some(TestProfile::Suspension));
    assert!(same.set_aside.is_empty() && same.layout.test == of_profile);
    assert!(changed(&commented(), None).set_aside.is_empty());
}

#[test]
fn windows_of_the_other_profile_are_refused_by_name() {
    let modes = template(TestProfile::Suspension);
    for (from, to, key) in [
        (
            "exponential_decay_per_s = 0.1 ",
            "exponential_decay_per_s = 10.0",
            "test.exponential_decay_per_s",
        ),
        ("force_window_s = 0.05 ", "force_window_s = 0.012", "test.force_window_s"),
    ] {
        let error = parse(&modes.replace(from, to)).unwrap_err();
        assert_eq!(error.place().unwrap().key, key);
        assert!(error.to_string().contains("without the line"), "{error}");
    }
}

#[test]
fn the_template_s_comments_are_valid_too() {
    let mut text = String::new();
    for line in commented().lines() {
        let bare = line.strip_prefix("# ").unwrap_or(line);
        let is_table =
            ["[target]", "[prior]", "[[attached]]", "[reference]", "[report]"].contains(&bare);
        let is_entry = [
            "mass =",
            "center_m =",
            "inertia =",
            "mass_kg =",
            "center_of_mass_m =",
            "inertia_kg_m2 =",
            "    [",
            "]",
            "axes",
        ];
        let is_value = line.starts_with("# ") && is_entry.iter().any(|e| bare.starts_with(e));
        text += if is_table || is_value && !bare.contains("the sensor's") { bare } else { line };
        text.push('\n');
    }
    let file = parse(&text).unwrap();
    assert_eq!(*file.layout.priors, [Prior { property: 0, value: 1.23, sigma: 0.001 }]);
    assert_eq!(file.layout.target.values(), TARGET_KEYS.map(|key| Some(key.example)));
    assert_eq!(file.layout.attached.len(), 1);
    assert!(file.reference.unwrap().complete().is_some());
}

#[test]
fn a_target_is_read_in_its_units_and_each_key_is_optional() {
    let target = |table: &str| parse(&format!("{}\n[target]\n{table}", commented()));
    let read = target("mass = 0.01\ncenter_m = 0.001").unwrap().layout.target;
    assert_eq!(read, Target { mass: Some(0.01), center: Some(0.001), inertia: None });
    assert!(!target("").unwrap().layout.target.is_set());
    let lines = commented().lines().count();
    for (table, key) in [
        ("mass = 0", "target.mass"),
        ("center_m = -1", "target.center_m"),
        ("inertia = inf", "target.inertia"),
    ] {
        let error = target(table).unwrap_err();
        let place = error.place().unwrap();
        assert_eq!((place.line, place.key.as_str()), (lines + 3, key));
    }
    assert!(target("center = 0.001").unwrap_err().to_string().contains("center"));
}

#[test]
fn the_policy_of_the_template_is_the_default_one() {
    use massline_shared::layout::HitPolicy;
    let policy = parse(&commented()).unwrap().layout.test.policy;
    for code in HitPolicy::CODES {
        assert_eq!(policy.treatment(code), HitPolicy::default_treatment(code), "{}", code.name());
        assert!(commented().contains(&format!("\n{} = ", code.name())), "{}", code.name());
    }
}

#[test]
fn a_policy_changes_the_verdict_of_its_code_alone() {
    use massline_shared::diagnosis::Code;
    use massline_shared::layout::{HitPolicy, HitTreatment};
    let text = format!("{}\n[policy]\ndouble_hit = \"keep\"\n", GOOD);
    let policy = parse(&text).unwrap().layout.test.policy;
    assert_eq!(policy, HitPolicy::default().with(Code::DoubleHit, HitTreatment::Keep));
    let wrong = text.replace("\"keep\"", "\"ignore\"");
    let message = parse(&wrong).unwrap_err().to_string();
    assert!(message.contains("`keep`, `warn` or `reject`"), "{message}");
}

#[test]
fn local_axes_turn_sensors_and_hits() {
    let text = with(
        "position_m = [0.0, 0.0, 0.0]",
        "position_m = [0.0, 0.0, 0.0]\naxes = [[0, 1, 0], [-1, 0, 0]]",
    );
    let file = parse(&text).unwrap();
    // Local y of node 1 is −x of the body.
    assert_eq!(file.layout.hits[0].direction, [-1.0, 0.0, 0.0]);
    let axes = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    assert_eq!(file.layout.sensors[0].axes, axes);
}

#[test]
fn sensors_and_hits_may_be_tables() {
    let text = with(
        "sensors = [1, 2, 3]",
        "sensors = [{ node = 1, axes = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]], senses_gravity = false, \
         calibration = \"A17\", attached_mass_kg = 0.002, uncertainty = { gain = 0.05 } }, 2, 3]",
    );
    let text = text.replacen(
        "\"1:+Y\"",
        "{ dof = \"1:-Y\", uncertainty = { hit_position_m = 0.001 } }",
        1,
    );
    let file = parse(&text).unwrap();
    let sensor = &file.layout.sensors[0];
    assert_eq!(sensor.axes, [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    assert!(!sensor.senses_gravity);
    assert_eq!(file.sensors[0].calibration.as_deref(), Some("A17"));
    assert_eq!(file.layout.attached[0].phi[0], 0.002);
    assert_eq!(sensor.uncertainty.gain, 0.05);
    assert_eq!(file.layout.sensors[1].uncertainty.gain, 0.01);
    assert_eq!(file.layout.hits[0].direction, [0.0, -1.0, 0.0]);
    assert_eq!(file.layout.hits[0].uncertainty.position, 0.001);
}

#[test]
fn axes_of_four_digits_are_made_exact() {
    let text = with(
        "position_m = [0.0, 0.0, 0.0]",
        "position_m = [0.0, 0.0, 0.0]\naxes = [[0.7071, 0.7071, 0], [-0.7071, 0.7071, 0]]",
    );
    let axes = parse(&text).unwrap().layout.sensors[0].axes;
    let r = std::f64::consts::FRAC_1_SQRT_2;
    // The tolerance covers the rounding of a normalisation.
    assert!((axes[0][0] - r).abs() < 1e-15 && (axes[1][0] + r).abs() < 1e-15);
}

#[test]
fn malformed_toml_is_named_with_its_line() {
    let text = with("hits = [\"1:+Y\"", "hits = [\"1:+Y");
    assert!(message(&text, 6).contains("hits"));
    let text = with("id = 2", "id = 2\ncolour = 3");
    let unknown = message(&text, 14);
    assert!(unknown.contains("colour") && unknown.contains("position_m"), "{unknown}");
    let text = with("hits_per_dof = 5", "hits_per_dof = \"five\"");
    assert!(message(&text, 25).contains("hits_per_dof"));
}

#[test]
fn a_missing_key_is_named() {
    let error = parse("sensors = []\n").unwrap_err().to_string();
    assert!(error.contains(":1: hits: the layout does not have this key"), "{error}");
}

#[test]
fn a_known_value_without_its_sigma_is_told_how_to_write_it() {
    let error = parse(&format!("{GOOD}\n[prior]\nmass_kg = 1.23")).unwrap_err().to_string();
    assert!(error.contains("stands where a value with its standard deviation"), "{error}");
    assert!(error.contains("{ value = 1.23, sigma = 0.001 }"), "{error}");
}

#[test]
fn a_list_is_never_read_as_a_table() {
    let inner = [
        ("test", "[\"mass-line\", 7]"),
        ("policy", "[\"keep\"]"),
        ("uncertainty", "[0.001]"),
        ("prior", "[[1.23, 0.001]]"),
        ("reference", "[1.23]"),
        ("report", "[\"a bracket\"]"),
        ("target", "[0.01]"),
        ("node", "[[1, [0, 0, 0]]]"),
        ("attached", "[[[0.1, 0.001], [0, 0, 0]]]"),
        ("sensors", "[[1]]"),
        ("hits", "[[\"1:+Y\"]]"),
        ("prior.mass_kg", "[1.23, 0.001]"),
        ("prior.cx_m", "[0.0, 0.001]"),
        ("uncertainty.gain", "[0.01]"),
    ];
    for (key, list) in inner {
        let message = parse(&format!("{key} = {list}")).unwrap_err().to_string();
        assert!(
            message.contains(" stands where ") && message.contains(&format!(": {key}: ")),
            "{message}"
        );
    }
    for (key, list) in [("attached_mass_kg", "[0.004, 0.0002]"), ("uncertainty", "[0.001]")] {
        let message = parse(&format!("sensors = [{{ node = 1, {key} = {list} }}]")).unwrap_err();
        assert!(message.to_string().contains(&format!("{list} stands where ")), "{message}");
    }
}

#[test]
fn a_list_has_the_length_that_is_asked_for() {
    for (key, list) in [
        ("gravity", "[0, 0, -9.81, 0]"),
        ("gravity", "[0, -9.81]"),
        ("reference.center_of_mass_m", "[0, 0]"),
        ("reference.inertia_kg_m2", "[[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]]"),
        ("test.band_hz", "[10]"),
        ("test.band_hz", "[10, 20, 30]"),
        ("test.impulse_ns", "[0.1, 0.2, 0.3]"),
    ] {
        let message = parse(&format!("{key} = {list}")).unwrap_err().to_string();
        assert!(
            message.contains(" stand where ") || message.contains("[lowest, highest]"),
            "{message}"
        );
        assert!(message.contains(&format!(": {key}: ")), "{message}");
    }
}

#[test]
fn no_scale_is_exact() {
    for (key, sigma) in [("mass_kg", 1e-9), ("Jxx_kg_m2", 1e-12)] {
        let text = format!("{GOOD}\n[prior]\n{key} = {{ value = 1.23, sigma = {sigma} }}");
        let message = parse(&text).unwrap_err().to_string();
        assert!(message.contains("a millionth of the value"), "{message}");
    }
    let text = format!("{GOOD}\n[prior]\nmass_kg = {{ value = 1.23, sigma = 2e-6 }}");
    assert!(parse(&text).is_ok());
}

#[test]
fn a_value_of_a_wrong_type_is_answered_without_names_of_the_program() {
    let tables = ["test", "policy", "uncertainty", "prior", "reference", "report"];
    let top = tables.map(|key| format!("{key} = \"a\"\n{GOOD}"));
    let lists = ["node", "attached", "sensors", "hits", "title", "gravity"];
    let alone = lists.map(|key| format!("{key} = [{{ id = true }}, true, 1.5]"));
    let keys = [
        ("test", "band_hz"),
        ("test", "frf_estimator"),
        ("test", "terms"),
        ("test", "hits_per_dof"),
        ("policy", "double_hit"),
        ("uncertainty", "gain"),
        ("prior", "mass_kg"),
        ("reference", "mass_kg"),
        ("reference", "inertia_kg_m2"),
        ("report", "support"),
    ];
    let inner = keys.map(|(table, key)| format!("{GOOD}\n[{table}]\n{key} = true"));
    let sensor = ["axes", "attached_mass_kg", "uncertainty", "calibration"]
        .map(|key| format!("sensors = [{{ node = 1, {key} = true }}]"));
    for text in top.iter().chain(&alone).chain(&inner).chain(&sensor) {
        let error = parse(text).unwrap_err().to_string();
        for word in ["struct", "enum", "Raw", "variant", "tuple"] {
            assert!(!error.contains(word), "{text}\n{error}");
        }
    }
}

#[test]
fn an_unknown_node_is_named() {
    let text = with("\"2:+Z\"", "\"7:+Z\"");
    let unknown = message(&text, 6);
    assert!(unknown.contains("node 7") && unknown.contains("1, 2, 3, 4"), "{unknown}");
    assert_eq!(parse(&text).unwrap_err().code(), Some(Code::UnknownNode));
    assert!(message(&with("sensors = [1, 2, 3]", "sensors = [1, 2, 9]"), 5).contains("node 9"));
}

#[test]
fn bad_axes_are_named() {
    let axes = |axes: &str| {
        let to = format!("position_m = [0.0, 0.0, 0.0]\naxes = {axes}");
        with("position_m = [0.0, 0.0, 0.0]", &to)
    };
    assert!(message(&axes("[[1, 1, 0], [0, 0, 1]]"), 11).contains("length 1.414214"));
    let skew = axes("[[1, 0, 0], [0.6, 0.8, 0]]");
    assert!(message(&skew, 11).contains("not orthogonal"));
    assert_eq!(parse(&skew).unwrap_err().code(), Some(Code::AxesNotOrthonormal));
    assert!(message(&axes("[[nan, 0, 0], [0, 1, 0]]"), 11).contains("NaN"));
}

#[test]
fn doubled_things_are_named() {
    let doubled = with("sensors = [1, 2, 3]", "sensors = [1, 2, 2]");
    assert!(message(&doubled, 5).contains("node 2 carries two sensors"));
    assert_eq!(parse(&doubled).unwrap_err().code(), Some(Code::TwoSensorsOnOneNode));
    assert!(message(&with("id = 2", "id = 1"), 13).contains("first in line 9"));
    assert!(message(&with("\"2:+Z\"", "\"1:+Y\""), 6).contains("1:+Y is there twice"));
}

#[test]
fn too_many_sensors_and_too_many_hits_are_refused() {
    let ids = |n: usize| (1..=n).map(|k| k.to_string()).collect::<Vec<_>>().join(", ");
    let nodes: String =
        (1..=25).map(|k| format!("[[node]]\nid = {k}\nposition_m = [{k}, 0, 0]\n")).collect();
    let text = format!("sensors = [{}]\nhits = [\"1:+X\"]\n{nodes}", ids(9));
    assert!(message(&text, 1).contains("9 sensors are too many; at most 8"));
    let hits: Vec<_> = (1..=25).map(|k| format!("\"{k}:+X\"")).collect();
    let text = format!("sensors = [1]\nhits = [{}]\n{nodes}", hits.join(", "));
    assert!(message(&text, 2).contains("25 hits are too many; at most 24"));
}

#[test]
fn numbers_that_cannot_be_are_named() {
    let nan = with("position_m = [0.0, 0.0, 0.0]", "position_m = [0.0, nan, 0.0]");
    assert!(message(&nan, 10).contains("position_m"));
    assert_eq!(parse(&nan).unwrap_err().code(), Some(Code::LayoutNotFinite));
    assert!(message(&with("-9.80665", "-inf"), 4).contains("gravity"));
    // Gravity in other units, or a slip, would only show as a strange answer.
    for (value, hint) in [
        ("-1.0", "like g"),
        ("-9806.65", "like mm/s²"),
        ("-8.5", "8.5 m/s²"),
        ("0.0", "leave it out"),
    ] {
        assert!(message(&with("-9.80665", value), 4).contains(hint), "{value}");
    }
    assert!(message(&with("[10.0, 120.0]", "[120.0, 10.0]"), 26).contains("band_hz"));
    assert!(message(&with("hits_per_dof = 5", "hits_per_dof = 0"), 25).contains("from 1 to 50"));
    assert!(message(&with("[10.0, 120.0]", "\"wide\""), 26).contains("\"auto\""));
    assert_eq!(parse(&with("[10.0, 120.0]", "\"auto\"")).unwrap().layout.test.band_hz, None);
    let terms = with("hits_per_dof = 5", "terms = \"abcd\"");
    assert!(message(&terms, 25).contains("`a`, `ab` or `abc`"), "{}", message(&terms, 25));
    let text = with("hits_per_dof = 5", "frf_estimator = \"hv\"\nterms = \"ab\"");
    let test = parse(&text).unwrap().layout.test;
    assert_eq!((test.frf_estimator, test.terms), (FrfEstimator::Hv, Terms::Ab));
    assert!(message(&with("id = 4", "id = 70000"), 21).contains("65535"));
    assert!(message(&with("1:+Y", "1:up"), 6).contains("1:up"));
    assert!(message(&with("mass_kg = 1.23", "mass_kg = -1.23"), 30).contains("positive mass"));
    let title = "three-bar \\u001b[31mframe";
    assert!(message(&with("three-bar frame, test 1", title), 3).contains("'\\u{1b}'"));
}

#[test]
fn a_reference_that_is_no_body_is_a_suspicion_and_one_that_is_not_symmetric_is_refused() {
    // The six equal values of the paper's Table 1 (theory, section 11).
    let row = "[0.023029, 0.023029, 0.023029]";
    let text = GOOD.split("inertia_kg_m2").next().unwrap().to_owned()
        + &format!("inertia_kg_m2 = [{row}, {row}, {row}]\n");
    let suspicions = parse(&text).unwrap().suspicions();
    assert!(
        suspicions.iter().any(|suspicion| suspicion.starts_with("[reference]: no body")),
        "{suspicions:?}"
    );
    let text = with("[0.0042529759241209525, 0.006", "[0.0, 0.006");
    assert!(message(&text, 32).contains("not symmetric"));
}

#[test]
fn bytes_that_are_no_text_are_named() {
    let error = LayoutFile::parse_bytes(b"title = \"a\"\nhits = \"\xff\"", "bar.toml").unwrap_err();
    assert!(error.to_string().starts_with("bar.toml:2: this is not UTF-8"));
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let error = LayoutFile::read(Path::new("no/such/layout.toml")).unwrap_err().to_string();
    assert!(error.contains("no/such/layout.toml"), "{error}");
}

#[test]
fn gains_that_the_file_does_not_state_are_those_of_the_calibration() {
    use massline_shared::calibration::{CalibrationMethod, CalibrationRecord, CalibrationSigma};
    let sensors = "sensors = [{ node = 1, uncertainty = { gain = 0.03 } }, 2, 3]";
    let example = include_str!("../../../examples/three-bar-test-1.toml");
    let text = example.replacen("sensors = [1, 2, 3]", sensors, 1);
    let mut file = LayoutFile::parse(&text, "l").unwrap();
    let sigma = CalibrationSigma { gain: 0.25, cross_axis: 0.125, hammer_gain: 0.0 };
    let mut record = CalibrationRecord { sigma, ..CalibrationRecord::default() };
    assert_eq!(record.budget(), None, "data sheets change nothing");
    record.method = CalibrationMethod::Block;
    record.budget().unwrap().apply_to(&mut file.layout);
    let budget = |k: usize| file.layout.sensors[k].uncertainty;
    assert_eq!((budget(0).gain, budget(0).cross_axis), (0.03, 0.125));
    assert_eq!((budget(1).gain, budget(2).gain), (0.25, 0.25));
    assert_eq!(file.layout.apparatus.hammer_gain, 0.0);
    let stated = "[uncertainty]\ngain = 0.5\ncross_axis = 0.25\nhammer_gain = 0.0625\n";
    let mut file = LayoutFile::parse(&format!("{example}\n{stated}"), "l").unwrap();
    let as_written = file.clone();
    record.budget().unwrap().apply_to(&mut file.layout);
    assert_eq!(file, as_written, "what is stated stays");
}

#[test]
fn a_long_title_is_cut_for_the_rig_alone() {
    let title = "ä".repeat(40);
    let file = parse(&with("three-bar frame, test 1", &title)).unwrap();
    assert_eq!((&file.title, file.layout.title.as_str()), (&title, "ä".repeat(24).as_str()));
    assert_eq!(file.rig_layout().unwrap().title, file.layout.title);
}

#[test]
fn statements_for_the_report_are_text_in_one_line() {
    let with = |entry: &str| parse(&format!("{GOOD}\n[report]\n{entry}"));
    let statements = with("support = \"two cords\"").unwrap().statements;
    assert_eq!((statements.support.as_str(), statements.hammer.as_str()), ("two cords", ""));
    let error = with("operator = \"a\\nb\"").unwrap_err().to_string();
    assert!(error.contains("report.operator"), "{error}");
    assert!(with("hamer = \"100 g\"").unwrap_err().to_string().contains("hamer"));
}

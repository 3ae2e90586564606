//! Gross mistakes are made on the bench; the whole chain must identify them.

use massline::support::bench_test::nominal_calibration;
use massline_analysis::monte_carlo::measurement::measure;
use massline_analysis::single_fault::{Examination, Outcome, examine};
use massline_files::layout_file::LayoutFile;
use massline_physics::Bench;
use massline_report::words::corrected_text;
use massline_report::words::{findings_in, single_faults_in};
use massline_tests::campaign::{FIVE_HITS, scans};
use massline_tests::long;
use serde_json::json;

const KNOWN_MASS: &str = "[prior]\nmass_kg = { value = 1.23, sigma = 0.001 }\n";

/// The examination after a campaign on a bench with these faults.
fn examined(text: &str, faults: &[&str], seed: u64) -> (LayoutFile, Examination) {
    let mut bench = Bench::named("default").expect("bundled");
    bench.faults = faults.iter().map(|f| f.parse().expect("a fault")).collect();
    examined_on(&bench, text, seed)
}

/// The examination after a campaign on a bench.
fn examined_on(bench: &Bench, text: &str, seed: u64) -> (LayoutFile, Examination) {
    let file = LayoutFile::parse(text, "five.toml").expect("a good layout");
    let mut source = *scans(bench, &file, seed);
    let layout = file.layout.cast().expect("fits the rig");
    let measured = measure(&mut source, &layout, &nominal_calibration(bench)).expect("lines");
    let nodes: Vec<_> = file.nodes.iter().map(|node| (node.id, node.position)).collect();
    let lines = measured.dofs.iter().map(|(index, lines)| (*index, lines.resized(3)));
    let examination = examine(&file.layout, &nodes, &lines.collect::<Vec<_>>());
    (file, examination)
}

/// What an examination says.
fn messages(examination: &Examination, file: &LayoutFile) -> Vec<String> {
    findings_in(examination, &file.layout).into_iter().map(|finding| finding.message).collect()
}

/// The messages of all suspects, the most likely first.
fn suspected(text: &str, fault: &str, seed: u64) -> Vec<String> {
    let (file, examination) = examined(text, &[fault], seed);
    let json = json!(single_faults_in(&examination, &file.layout));
    let suspects = json["suspects"].as_array().expect("a list");
    suspects.iter().map(|s| s["message"].as_str().expect("text").to_owned()).collect()
}

/// Every kind of mistake from the list at every sensor and hit. When two places have the same line of action, both are
/// named, in either order; so is a size that has the same effect. The messages begin like this.
#[test]
fn every_mistake_is_named() {
    let cases: [(&str, &[&str]); 20] = [
        ("flip:1x", &["sensor 1 (on node 1) has its x axis reversed"]),
        ("flip:1z", &["sensor 1 (on node 1) has its z axis reversed"]),
        ("flip:2y", &["sensor 2 (on node 2) has its y axis reversed"]),
        ("flip:3z", &["sensor 3 (on node 4) has its z axis reversed"]),
        ("swap:1,2", &["the cables of sensors 1 and 2 are swapped"]),
        ("swap:2,3", &["the cables of sensors 2 and 3 are swapped"]),
        ("swap:2x,2z", &["sensor 2 (on node 2) has the wires of x and z swapped"]),
        ("rotate:1:z90", &["sensor 1 (on node 1) is turned about its z axis by +90°"]),
        ("rotate:2:x90", &["sensor 2 (on node 2) is turned about its x axis by +90°"]),
        ("rotate:3:y-90", &["sensor 3 (on node 4) is turned about its y axis by -90°"]),
        ("rotate:3:z180", &["sensor 3 (on node 4) is turned about its z axis by 180°"]),
        ("hit:1:4", &["hit 1 (1:+Y) landed on node 4"]),
        ("hit:2:1", &["hit 2 (2:+Z) landed on node 1"]),
        ("hit:3:2", &["hit 3 (4:+X) landed on node 2"]),
        ("hit:4:3", &["hit 4 (1:+Z) landed on node 3"]),
        // Nothing else is on node 3, so its coordinate may be wrong as well.
        ("hit:5:2", &["hit 5 (3:+X) landed on node 2", "y of node 3 is "]),
        // Nodes 2 and 3 lie on one line along y.
        ("hit:1:3", &["hit 1 (1:+Y) landed on node 3", "hit 1 (1:+Y) landed on node 2"]),
        // Nodes 2 and 4 lie on one line along z.
        ("hit:4:2", &["hit 4 (1:+Z) landed on node 2", "hit 4 (1:+Z) landed on node 4"]),
        ("reverse:1", &["hit 1 (1:+Y) came from the other side"]),
        ("reverse:3", &["hit 3 (4:+X) came from the other side"]),
    ];
    for (seed, (fault, expected)) in (1..).zip(cases) {
        let mut messages = suspected(FIVE_HITS, fault, seed);
        let mut expected = expected.to_vec();
        messages.sort();
        expected.sort_unstable();
        let is_named =
            messages.iter().zip(&expected).all(|(message, start)| message.starts_with(start));
        assert!(messages.len() == expected.len() && is_named, "{fault}: {messages:?}");
    }
}

#[test]
fn all_axes_reversed_are_named_with_the_properties_as_they_would_be() {
    let mut bench = Bench::named("default").expect("bundled");
    bench.faults = ["flip:2x", "flip:2y", "flip:2z"].map(|f| f.parse().expect("a fault")).into();
    let (file, examination) = examined_on(&bench, FIVE_HITS, 22);
    let [only] = examination.suspects() else { panic!("{:?}", messages(&examination, &file)) };
    let corrected = only.corrected.as_ref().expect("an answer");
    // The frame weighs 1.23 kg; the hammer of the bench is exact within 2 %, and that is two standard deviations.
    assert!((corrected.body.mass / 1.23 - 1.0).abs() < 0.04, "{corrected:?}");
    let faults = single_faults_in(&examination, &file.layout);
    let message = &findings_in(&examination, &file.layout)[0].message;
    assert!(
        message.contains("sensor 2 (on node 2) has all three axes reversed: that explains"),
        "{message}"
    );
    let text = corrected_text(&faults, 1);
    assert!(
        text.starts_with("if sensor 2 (on node 2) has all three axes reversed, the ten"),
        "{text}"
    );
}

#[test]
fn a_common_scale_is_named_when_a_mass_is_known() {
    let text = format!("{FIVE_HITS}{KNOWN_MASS}");
    let (file, examination) = examined(&text, &["scale:1.1"], 21);
    let json = json!(single_faults_in(&examination, &file.layout));
    let [only] = &json["suspects"].as_array().expect("a list")[..] else { panic!("{json}") };
    assert_eq!(only["code"], "common_scale");
    // The gains of nine channels, 0.5 % each on the bench, and noise: 0.3 %; four times that is allowed.
    let scale = only["gain"]["value"].as_f64().expect("a number");
    assert!((scale - 1.1).abs() < 0.012, "{json}");
    let findings = json!(findings_in(&examination, &file.layout));
    assert_eq!(
        (&findings[0]["code"], &findings[0]["severity"]),
        (&"common_scale".into(), &"warning".into())
    );

    // No other information determines the mass of the object.
    let (_, examination) = examined(FIVE_HITS, &["scale:1.1"], 21);
    assert_eq!(examination.outcome, Outcome::NothingSuspicious);
}

#[test]
fn a_good_test_is_not_suspicious() {
    for seed in 31..35 {
        for text in [FIVE_HITS.to_owned(), format!("{FIVE_HITS}{KNOWN_MASS}")] {
            let (file, examination) = examined(&text, &[], seed);
            assert_eq!(
                examination.outcome,
                Outcome::NothingSuspicious,
                "{:?}",
                messages(&examination, &file)
            );
        }
    }
}

#[test]
fn what_cannot_be_seen_is_said_and_not_guessed() {
    // Nodes 2 and 4, and 3 and 1, lie on one line along the hit.
    for (seed, fault) in [(41, "hit:2:4"), (42, "hit:5:1")] {
        let (file, examination) = examined(FIVE_HITS, &[fault], seed);
        assert_eq!(examination.outcome, Outcome::NothingSuspicious);
        let json = json!(single_faults_in(&examination, &file.layout));
        let hidden: Vec<_> = json["not_visible"]
            .as_array()
            .expect("a list")
            .iter()
            .map(|fault| fault["message"].as_str().expect("text"))
            .collect();
        assert_eq!(hidden, ["hit 2 (2:+Z) landed on node 4", "hit 5 (3:+X) landed on node 1"]);
    }
}

#[test]
fn two_mistakes_at_once_are_not_blamed_on_one() {
    let (file, examination) = examined(FIVE_HITS, &["flip:1x", "hit:2:1"], 51);
    assert_eq!(examination.outcome, Outcome::Unexplained, "{:?}", messages(&examination, &file));
    let findings = json!(findings_in(&examination, &file.layout));
    assert_eq!(findings[0]["code"], "no_single_fault_explains");
}

/// What the bench does, stated as it is, with marks that are exact.
const BUDGET_OF_THE_BENCH: &str = "
[uncertainty]
hit_position_m = 0.002
hit_direction_rad = 0.030
sensor_position_m = 0.001
sensor_rotation_rad = 0.010
gain = 0.005
cross_axis = 0.01
hammer_gain = 0.0
node_position_m = 0.0
node_direction_rad = 0.0
";

/// The tip lands 5 mm beside the mark, on the same side in all hits of a DOF. With default uncertainties and with a
/// budget that leaves no room for that, nobody is said to have hit another node, though one is 25 mm away.
#[test]
fn hits_that_miss_their_marks_by_five_millimeters_are_not_said_to_be_at_another_node() {
    let neighbor = "    { id = 5, position_m = [0.23285, -0.19902, 0.0] },\n]";
    let close = FIVE_HITS.trim_end().strip_suffix(']').expect("a list").to_owned() + neighbor;
    let tight = format!("{close}\n{BUDGET_OF_THE_BENCH}");
    let runs = if long() { 400 } else { 10 };
    for (name, text) in [("default budget", &close), ("budget of the bench", &tight)] {
        let (mut accused, mut searched) = (Vec::new(), 0);
        for seed in 61..61 + runs {
            let mut bench = Bench::named("default").expect("bundled");
            bench.tap.offset_m = 0.005;
            let (file, examination) = examined_on(&bench, text, seed);
            searched += usize::from(examination.plain.is_none_or(|plain| plain.rejects_budget()));
            let findings = json!(findings_in(&examination, &file.layout));
            if findings.as_array().unwrap().iter().any(|d| d["code"] == "hit_at_wrong_node") {
                accused.push(format!("seed {seed}: {:?}", messages(&examination, &file)));
            }
        }
        assert!(accused.is_empty(), "{name}: {} of {runs}: {accused:#?}", accused.len());
        // The exact marks of the second budget contradict the data, so that a mistake is searched for at all.
        assert!(name == "default budget" || searched > 0, "{name}: no mistake was searched for");
    }
}

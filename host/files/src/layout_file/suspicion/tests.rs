use super::*;

const EXAMPLE: &str = include_str!("../../../../examples/three-bar-test-1.toml");

/// Three nodes this far apart, m, and further tables.
fn nodes(scale: f64, tables: &str) -> String {
    format!(
        "sensors = [1, 2, 3]\nhits = [\"1:+X\"]\n[[node]]\nid = 1\nposition_m = [0.0, 0.0, 0.0]\n[[node]]\nid = \
         2\nposition_m = [{scale}, 0.0, 0.0]\n[[node]]\nid = 3\nposition_m = [0.0, {scale}, 0.0]\n{tables}\n"
    )
}

#[test]
fn millimetres_and_other_units_are_suspected() {
    let suspicions = |text: &str| LayoutFile::parse(text, "l").unwrap().suspicions();
    assert_eq!(suspicions(EXAMPLE), [""; 0]);
    let far = suspicions(&nodes(200.0, ""));
    assert!(far[0].contains("283 m") && far[0].contains("look like millimetres"), "{far:?}");
    // 0.25 m in inches.
    let inches = suspicions(&nodes(9.8, ""));
    assert!(inches[0].contains("14 m") && inches[0].contains("inches or cent"), "{inches:?}");
    let reference = |inertia: f64| {
        let tensor =
            format!("[[{inertia}, 0.0, 0.0], [0.0, {inertia}, 0.0], [0.0, 0.0, {inertia}]]");
        nodes(0.2, &format!("[reference]\nmass_kg = 1.0\ninertia_kg_m2 = {tensor}"))
    };
    assert_eq!(suspicions(&reference(0.01)), [""; 0]);
    // 0.01 kg m² is 10⁴ kg mm², 10⁷ g mm², 100 kg cm², 34 lb in² and 10 g m².
    for inertia in [1e4, 1e7, 100.0, 34.2, 10.0] {
        let messages = suspicions(&reference(inertia));
        assert!(
            messages.len() == 1
                && messages[0].contains("radius of gyration")
                && messages[0].contains("1e-6"),
            "{messages:?}"
        );
    }
}

#[test]
fn lengths_in_inches_and_angles_in_degrees_are_suspected() {
    let suspicions = |scale: f64, tables: &str| {
        LayoutFile::parse(&nodes(scale, tables), "l").unwrap().suspicions()
    };
    let only = |scale: f64, tables: &str, words: &str| {
        let messages = suspicions(scale, tables);
        assert!(messages.len() == 1 && messages[0].contains(words), "{messages:?}");
    };
    // Nodes 0.13 m apart in inches.
    only(
        3.5,
        "[reference]\nmass_kg = 1.0",
        "[reference] describes a body of 1.000 kg on nodes 4.950 m apart",
    );
    only(
        3.5,
        "[prior]\nmass_kg = { value = 1.0, sigma = 0.1 }",
        "[prior] describes a body of 1.000 kg",
    );
    only(3.5, "[reference]\nmass_kg = 1.0", "1 in is 0.0254 m");
    // Nodes as far apart as no object on cords are named alone.
    only(14.0, "[reference]\nmass_kg = 5.0", "inches or centimetres");
    assert_eq!(suspicions(0.2, "[reference]\nmass_kg = 1.0"), [""; 0]);
    // A rod, and a large frame.
    assert_eq!(suspicions(3.0, "[reference]\nmass_kg = 1.5"), [""; 0]);
    only(0.2, "[reference]\ncenter_of_mass_m = [100.0, -30.0, 40.0]", "centre of mass lies 11");
    only(0.2, "[reference]\ncenter_of_mass_m = [10.0, -3.0, 4.0]", "1 mm is 0.001 m");
    assert_eq!(suspicions(0.2, "[reference]\ncenter_of_mass_m = [0.4, -0.3, 0.4]"), [""; 0]);
    only(
        0.2,
        "[uncertainty]\nhit_direction_rad = 1.5",
        "hit_direction_rad = 1.5 is a standard deviation of 86°",
    );
    only(0.2, "[uncertainty]\nsensor_rotation_rad = 2.0", "write 0.035 for 2°");
    only(0.2, "[uncertainty]\nhit_position_m = 2.0", "write 0.0020 for 2 mm");
    assert_eq!(
        suspicions(0.2, "[uncertainty]\nhit_direction_rad = 0.03\nhit_position_m = 0.002"),
        [""; 0]
    );
}

#[test]
fn a_body_lighter_than_air_has_nodes_in_another_unit() {
    // Edges of a box, m, and its density, kg/m³.
    let of_box = |edges: [f64; 3], density: f64, unit: f64| {
        let [a, b, c] = edges.map(|edge| edge / unit);
        let mass = density * edges.iter().product::<f64>();
        let moment = |b: f64, c: f64| mass * (b * b + c * c) / 12.0;
        // Turned by 45° about z.
        let (xx, yy) = (moment(b, c), moment(a, c));
        let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let known = [mass, 0.0, 0.0, 0.0, mean, mean, moment(a, b), half, 0.0, 0.0];
        let positions = [[0.0; 3], [a, 0.0, 0.0], [0.0, b, 0.0]];
        size_suspicions(&positions, "the answer", &known.map(Some))
    };
    let (inch, centimetre) = (0.0254, 0.01);
    let bodies = [
        ([0.05, 0.04, 0.03], 8000.0), // a steel block
        ([0.5, 0.3, 0.08], 60.0),     // a frame of tubes
        ([3.0, 0.02, 0.02], 1200.0),  // a rod
        ([0.3, 0.3, 0.05], 150.0),    // a drone
    ];
    for (edges, density) in bodies {
        assert_eq!(of_box(edges, density, 1.0), [""; 0], "{edges:?}");
        for unit in [inch, centimetre] {
            let messages = of_box(edges, density, unit);
            assert!(messages.iter().any(|m| m.contains("positions are in metres")), "{messages:?}");
        }
    }
}

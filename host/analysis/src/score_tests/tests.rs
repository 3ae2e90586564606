use massline_files::layout_file::LayoutFile;
use massline_shared::body::RigidBody;
use massline_shared::identify::MassLines;
use massline_shared::identify::maximum_likelihood::{ErrorBudget, Start, solve, workspace};
use massline_shared::layout::{AttachedBody, Axis};
use massline_shared::responses::Responses;
use nalgebra::{Matrix3, SVector, Vector3};

use super::*;

/// Three sensors on a frame, six hits, and errors of a tenth of the usual ones, which make small faults plain.
const LAYOUT: &str = r#"
title = "frame"
gravity = [0.0, 0.0, -9.80665]
sensors = [1, 2, 4]
hits = ["1:+Y", "2:+Z", "4:+X", "1:+Z", "3:+X", "2:+Y"]
node = [
    { id = 1, position_m = [0.0, 0.0, 0.0] },
    { id = 2, position_m = [0.2, -0.2, 0.0] },
    { id = 3, position_m = [0.2, 0.0, 0.0] },
    { id = 4, position_m = [0.2, -0.2, 0.15] },
]

[uncertainty]
learn = false
sensor_position_m = 0.00015
sensor_rotation_rad = 0.0015
gain = 0.001
cross_axis = 0.001
hit_position_m = 0.0003
hit_direction_rad = 0.005
node_position_m = 0.0001
node_direction_rad = 0.001
hammer_gain = 0.002
"#;

fn layout() -> HostLayout {
    LayoutFile::parse(LAYOUT, "frame.toml").unwrap().layout
}

fn body() -> RigidBody<f64> {
    RigidBody {
        mass: 1.23,
        center_of_mass: Vector3::new(0.169, -0.089, 0.02),
        inertia: Matrix3::new(
            0.0111, 0.0043, -0.001, 0.0043, 0.0068, 0.0027, -0.001, 0.0027, 0.0139,
        ),
    }
}

/// Exact readings of a layout, each multiplied by a gain that may depend on the place of the hit and the response.
fn lines(
    layout: &HostLayout,
    body: impl Fn(usize) -> RigidBody<f64>,
    gain: impl Fn(usize, usize) -> f64,
) -> Vec<DofMassLines<f64, Unbounded>> {
    let shortened = |hit: usize| {
        let hit = layout.hits[hit].uncertainty;
        1.0 - hit.direction * hit.direction - hit.node_direction * hit.node_direction
    };
    (0..layout.hits.len())
        .map(|hit| {
            let exact = layout.accelerance(&body(hit), hit).unwrap();
            let read = Responses::from_fn(3, |k| exact[k] * shortened(hit) * gain(hit, k));
            let noise = Responses::from_fn(3, |_| 1e-3);
            let mut lines = MassLines::without_scatter(read).with_noise(noise);
            lines.hits = 5;
            (hit, lines)
        })
        .collect()
}

fn tests_of(layout: &HostLayout, lines: &[DofMassLines<f64, Unbounded>]) -> ScoreTests {
    let mut memory = vec![0.0; workspace(layout.sensors.len(), layout.hits.len())];
    let start = Start::At(&body());
    let answer = solve(layout, lines, start, ErrorBudget::Stated, &mut memory).unwrap().estimate;
    ScoreTests::of(layout, lines, &[answer])
}

/// Share of the time of the test at which the hits at a place lie, from −1/2 to 1/2.
fn time(place: usize) -> f64 {
    (place as f64 + 0.5) / 6.0 - 0.5
}

#[test]
fn exact_readings_show_no_fault() {
    let tests = tests_of(&layout(), &lines(&layout(), |_| body(), |_, _| 1.0));
    assert!(tests.shown().is_empty());
    for test in &tests.tests {
        // What is left is rounding of slopes by differences.
        assert!(test.size().value.abs() < 0.01 * test.sigma, "{:?}: {:?}", test.fault, test.sizes);
    }
    // 4 nodes along 3 axes, 9 channels, 6 hits, and four that concern all.
    let most = 12 + 9 + 6 + 4;
    assert!((most / 2..=most).contains(&tests.tests.len()), "{}", tests.tests.len());
}

#[test]
fn each_fault_is_named_with_its_size() {
    let nominal = layout();
    let moved = |act: &dyn Fn(&mut HostLayout)| {
        let mut moved = nominal.clone();
        act(&mut moved);
        lines(&moved, |_| body(), |_, _| 1.0)
    };
    let node = moved(&|layout| {
        layout.sensors.iter_mut().filter(|s| s.node == 2).for_each(|s| s.position[0] += 0.01);
        layout.hits.iter_mut().filter(|h| h.dof.node == 2).for_each(|h| h.position[0] += 0.01);
    });
    let height = moved(&|layout| {
        layout.sensors.iter_mut().for_each(|sensor| sensor.position[2] += 0.004);
    });
    let turned = moved(&|layout| {
        for hit in layout.hits.iter_mut() {
            let turn = Vector3::new(0.0, 0.0, 0.03).cross(&Vector3::from(hit.direction));
            hit.direction = (Vector3::from(hit.direction) + turn).into();
        }
    });
    let leaning = moved(&|layout| layout.hits[4].direction[1] += 0.05);
    let pad = lines(
        &nominal,
        |hit| {
            let pad = AttachedBody::point(0.03, 0.0, nominal.hits[hit].position).phi;
            RigidBody::from_phi(&(body().phi() + SVector::from(pad))).unwrap()
        },
        |_, _| 1.0,
    );
    let hammer = lines(&nominal, |_| body(), |place, _| 1.0 - 0.1 * time(place));
    let channel =
        lines(&nominal, |_| body(), |place, k| if k == 4 { 1.0 + 0.1 * time(place) } else { 1.0 });
    for (fault, size, lines) in [
        (SmallFault::NodeMisplaced { node: 2, axis: Axis::X }, 0.01, node),
        (SmallFault::ChipsAboveMarks, 0.004, height),
        (SmallFault::HitsTurned, 0.03, turned),
        (SmallFault::HitLeans { hit: 4 }, 0.05, leaning),
        (SmallFault::MarksLoaded, 0.03, pad),
        (SmallFault::HammerDrifts, 0.1, hammer),
        (SmallFault::ChannelDrifts { sensor: 1, axis: Axis::Y }, 0.1, channel),
    ] {
        let tests = tests_of(&nominal, &lines);
        let own = tests.tests.iter().find(|test| test.fault == fault).unwrap();
        // To first order of the fault.
        let found_size = own.size().value;
        assert!(
            (found_size / size - 1.0).abs() < 0.15,
            "{fault:?}: {found_size} instead of {size}"
        );
        let shown = tests.shown();
        assert!(shown.iter().any(|test| test.fault == fault), "{fault:?}: {shown:?}");
        let most = tests.tests.iter().map(ScoreTest::significance).fold(0.0, f64::max);
        assert_eq!(own.significance(), most, "{fault:?}");
    }
}

#[test]
fn what_moves_the_answer_by_less_than_half_its_standard_deviation_is_a_note() {
    let warning = |code| Diagnostic::whole(code, Severity::Warning, 4.0);
    let codes = [Code::SuspensionInBand, Code::MovesWithBand, Code::NoPlateau];
    let severities = |band_shift: Option<f64>| {
        let mut diagnostics = codes.map(warning);
        ScoreTests { band_shift, ..ScoreTests::default() }.in_proportion(&mut diagnostics);
        diagnostics.map(|diagnostic| diagnostic.severity)
    };
    let [note, warning] = [Severity::Note, Severity::Warning];
    assert_eq!(severities(Some(0.3)), [note, note, warning]);
    assert_eq!(severities(Some(0.6)), [warning; 3]);
    // Nothing is known of lines that were not compared.
    assert_eq!(severities(Some(0.0)), [warning; 3]);
    assert_eq!(severities(None), [warning; 3]);
}

#[test]
fn the_ends_of_the_band_move_the_answer_by_what_they_move_the_lines() {
    let nominal = layout();
    let mut lines = lines(&nominal, |_| body(), |_, _| 1.0);
    assert_eq!(tests_of(&nominal, &lines).band_shift, Some(0.0));
    // Lines that become those of a body that is 2 % heavier, which the hammer's gain cannot be told from.
    for (_, lines) in &mut lines {
        lines.band_shift = &lines.accelerance * -0.02;
    }
    let shift = tests_of(&nominal, &lines).band_shift.unwrap();
    let mut memory = vec![0.0; workspace(3, 6)];
    let answer = solve(&nominal, &lines, Start::At(&body()), ErrorBudget::Stated, &mut memory);
    let sigma = answer.unwrap().estimate.sigma().unwrap();
    let expected = 0.02 * body().mass / sigma[0];
    // The mass moves more than any other property in its standard deviations; to second order.
    assert!((shift / expected - 1.0).abs() < 0.1, "{shift} instead of {expected}");
}

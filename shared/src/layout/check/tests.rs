//! Every degenerate layout is reported, in both precisions and in any frame.

use super::*;
use crate::capacity::{Rig, Unbounded};
use crate::layout::tests::{bar_body, bar_layout, sensor};
use nalgebra::Rotation3;
use proptest::prelude::*;
use std::vec::Vec;

fn codes(diagnostics: &Diagnostics) -> Vec<Code> {
    assert!(diagnostics.iter().all(Diagnostic::is_error));
    diagnostics.iter().map(|d| d.code).collect()
}

fn check(layout: &Layout<f64, Rig>) -> Vec<Code> {
    let double = codes(&check_geometry(layout, Some(&bar_body())));
    let single: Layout<f32, Rig> = layout.cast().unwrap();
    let body = RigidBody::from_theta(&bar_body().theta().map(|v| v as f32));
    let in_single = codes(&check_geometry(&single, Some(&body)));
    assert_eq!(double, in_single, "single precision sees the same");
    double
}

#[test]
fn a_good_layout_has_nothing_said_about_it() {
    assert_eq!(check(&bar_layout()), []);
}

#[test]
fn two_sensors_are_too_few() {
    let mut layout = bar_layout();
    layout.sensors.truncate(2);
    assert_eq!(check(&layout), [Code::FewerThanThreeSensors, Code::ResponseRankDeficient]);
    layout.sensors.clear();
    assert_eq!(check(&layout), [Code::FewerThanThreeSensors, Code::ResponseRankDeficient]);
}

#[test]
fn sensors_on_a_line_are_named() {
    let mut layout = bar_layout();
    layout.sensors =
        (0..3).map(|i| sensor(i, [0.05 * f64::from(i), 0.02 * f64::from(i), 0.0])).collect();
    assert_eq!(check(&layout), [Code::SensorsCollinear, Code::ResponseRankDeficient]);
    // 1 % off the line: the responses determine six motions, but badly.
    layout.sensors[1].position[2] = 0.0005;
    assert_eq!(check(&layout), [Code::SensorsCollinear]);
}

#[test]
fn two_sensors_on_one_node_are_named() {
    let mut layout = bar_layout();
    layout.sensors[2] = layout.sensors[1];
    assert_eq!(
        check(&layout),
        [Code::TwoSensorsOnOneNode, Code::SensorsCollinear, Code::ResponseRankDeficient]
    );
}

#[test]
fn two_hits_are_too_few() {
    let mut layout = bar_layout();
    layout.hits.truncate(2);
    assert_eq!(check(&layout), [Code::FewerThanThreeHits, Code::TenParametersNotIdentifiable]);
    layout.hits.clear();
    assert_eq!(check(&layout), [Code::FewerThanThreeHits, Code::TenParametersNotIdentifiable]);
}

#[test]
fn parallel_hits_are_named() {
    let mut layout = bar_layout();
    for hit in layout.hits.iter_mut() {
        hit.direction = [0.0, 0.6, 0.8];
    }
    assert_eq!(check(&layout), [Code::HitsAllParallel, Code::TenParametersNotIdentifiable]);
}

#[test]
fn hits_through_one_point_are_named() {
    let mut layout = bar_layout();
    for hit in layout.hits.iter_mut() {
        // All lines of action meet in one corner, 30 cm ahead of the hits.
        hit.position = core::array::from_fn(|k| 0.2 - 0.3 * hit.direction[k]);
    }
    assert_eq!(check(&layout), [Code::HitsConcurrent, Code::TenParametersNotIdentifiable]);
    // 1 mm beside the point is still too near: 2 % of L are 2.7 mm.
    layout.hits[0].position[2] += 0.001;
    assert_eq!(check(&layout), [Code::HitsConcurrent]);
}

#[test]
fn hits_through_the_centre_of_mass_are_named() {
    let mut layout = bar_layout();
    let c = bar_body().center_of_mass;
    for hit in layout.hits.iter_mut() {
        hit.position = core::array::from_fn(|k| c[k] + 0.1 * hit.direction[k]);
    }
    assert_eq!(
        check(&layout),
        [Code::HitsConcurrent, Code::HitsThroughCentreOfMass, Code::TenParametersNotIdentifiable]
    );
}

#[test]
fn axes_that_are_no_axes_are_named() {
    let mut layout = bar_layout();
    layout.sensors[1].axes[0] = [0.0, 1.0, 0.1];
    layout.hits[2].direction = [1.01, 0.0, 0.0];
    let diagnostics = check_geometry(&layout, None);
    assert_eq!(codes(&diagnostics), [Code::AxesNotOrthonormal; 2]);
    assert_eq!(
        (diagnostics[0].subject, diagnostics[1].subject),
        (Subject::Sensor(1), Subject::Hit(2))
    );
}

#[test]
fn a_layout_in_more_room_is_judged_the_same() {
    let mut layout = bar_layout();
    layout.sensors[2].axes[0] = [0.0, 1.0, 0.1];
    layout.hits[1].direction = [1.01, 0.0, 0.0];
    let larger: Layout<f64, Unbounded> = layout.cast().unwrap();
    let diagnostics = check_geometry(&layout, None);
    assert_eq!(diagnostics.len(), 2);
    assert_eq!(check_geometry(&larger, None), diagnostics);
}

#[test]
fn a_number_that_is_not_finite_is_named_and_nothing_else() {
    for spoil in [
        |l: &mut Layout<f64, Rig>| l.gravity = Some([f64::NAN; 3]),
        |l: &mut Layout<f64, Rig>| l.sensors[2].position[1] = f64::INFINITY,
        |l: &mut Layout<f64, Rig>| l.sensors[0].axes[2][2] = f64::NAN,
        |l: &mut Layout<f64, Rig>| l.hits[0].position[0] = f64::NAN,
        |l: &mut Layout<f64, Rig>| l.hits[1].direction[0] = f64::NEG_INFINITY,
    ] {
        let mut layout = bar_layout();
        spoil(&mut layout);
        assert_eq!(check(&layout), [Code::LayoutNotFinite]);
    }
}

#[test]
fn a_body_that_cannot_turn_is_no_body_to_check_with() {
    let mut body = bar_body();
    body.inertia = Matrix3::zeros();
    assert_eq!(
        codes(&check_geometry(&bar_layout(), Some(&body))),
        [Code::TenParametersNotIdentifiable]
    );
}

#[test]
fn the_assumed_body_sits_near_the_mean_of_the_nodes() {
    let nodes = [[0.0_f64, 0.0, 0.0], [1.0, 2.0, 3.0]];
    let body = assumed_body(None, nodes.into_iter());
    // Half the distance of the nodes.
    let length = 14_f64.sqrt() / 2.0;
    let beside = (body.center_of_mass - Vector3::new(0.5, 1.0, 1.5)).norm();
    // A tenth of L within rounding.
    assert!(body.mass == 1.0 && (beside - 0.1 * length).abs() < 1e-14);
    let heavy = assumed_body(Some(2.0), nodes.into_iter());
    assert!((heavy.inertia - Matrix3::from_diagonal_element(7.0)).norm() < 1e-14);
    let point = assumed_body(None, [[1.0, 2.0, 3.0]].into_iter());
    assert_eq!(point.inertia, Matrix3::identity(), "of a metre when nothing has an extent");
}

proptest! {
    #[test]
    fn the_diagnosis_does_not_depend_on_the_frame(
        turn in prop::array::uniform3(-3.0..3.0_f64),
        which in 0..4_usize,
    ) {
        let mut layout = bar_layout();
        match which {
            0 => layout.sensors[1].position = layout.sensors[0].position.map(|v| v + 0.2),
            1 => layout.hits.iter_mut().for_each(|h| h.position = [0.1; 3]),
            2 => layout.hits.iter_mut().for_each(|h| h.direction = [0.0, 0.0, 1.0]),
            _ => {}
        }
        let before = check(&layout);
        let r = Rotation3::new(Vector3::from(turn));
        let turned = |v: [f64; 3]| -> [f64; 3] { (r * Vector3::from(v)).into() };
        for s in layout.sensors.iter_mut() {
            s.position = turned(s.position);
            s.axes = s.axes.map(turned);
        }
        for h in layout.hits.iter_mut() {
            h.position = turned(h.position);
            h.direction = turned(h.direction);
        }
        let b = bar_body();
        let body = RigidBody {
            center_of_mass: r * b.center_of_mass,
            inertia: r * b.inertia * r.transpose(),
            ..b
        };
        prop_assert_eq!(codes(&check_geometry(&layout, Some(&body))), before.clone());
        let single: Layout<f32, Rig> = layout.cast().unwrap();
        let body = RigidBody::from_theta(&body.theta().map(|v| v as f32));
        prop_assert_eq!(codes(&check_geometry(&single, Some(&body))), before);
    }
}

#[test]
fn more_facts_than_fit_are_dropped_without_harm() {
    let mut layout: Layout<f64, Unbounded> = bar_layout().cast().unwrap();
    layout.hits = std::vec![layout.hits[0]; 24];
    layout.hits.iter_mut().for_each(|h| h.direction = [2.0, 0.0, 0.0]);
    assert_eq!(codes(&check_geometry(&layout, None)), [Code::AxesNotOrthonormal; 16]);
}

#[test]
fn the_report_has_the_condition_of_the_theory() {
    let report = LayoutReport::new(&bar_layout(), Some(&bar_body()));
    assert_eq!((report.rank_g, report.rank_f, report.rank_a), (6, 3, Some(10)));
    // Theory, section 8: cond A of test 1 is 21.
    assert!((report.condition_a.unwrap() - 21.0).abs() < 0.5);
}

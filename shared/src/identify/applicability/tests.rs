//! The methods that remain applicable under every degenerate layout, in both precisions.

use super::*;
use crate::capacity::Rig;
use crate::identify::Methods;
use crate::layout::tests::{bar_body, bar_layout, sensor};
use crate::layout::{Hit, Prior, assumed_body};
use std::vec::Vec;

const BOTH: [Method; 2] = [Method::MaximumLikelihood, Method::InertiaRestraint];

fn judge(layout: &Layout<f64, Rig>) -> Applicability<f64> {
    let double = Applicability::new(layout, &bar_body(), &BOTH);
    let single: Layout<f32, Rig> = layout.cast().unwrap();
    let body = RigidBody::from_theta(&bar_body().theta().map(|v| v as f32));
    let in_single = Applicability::new(&single, &body, &BOTH);
    let codes = |diagnostics: &Diagnostics| {
        diagnostics.iter().map(|d| (d.code, d.severity)).collect::<Vec<_>>()
    };
    assert_eq!(codes(&double.diagnostics), codes(&in_single.diagnostics), "single precision too");
    assert_eq!(double.rank, in_single.rank);
    double
}

/// Whether [maximum likelihood, inertia restraint] are applicable.
fn left(layout: &Layout<f64, Rig>) -> [bool; 2] {
    let applicability = judge(layout);
    let stopped = applicability.diagnostics.iter().any(Diagnostic::is_error);
    let left = BOTH.map(|method| applicability.admits(method));
    assert_eq!(stopped, left == [false; 2], "an error is what leaves no method");
    left
}

fn hits_through(layout: &mut Layout<f64, Rig>, point: [f64; 3]) {
    layout.hits.iter_mut().for_each(|hit| hit.position = point);
}

#[test]
fn nodes_in_a_plane_are_no_reason_to_refuse_an_unknown_body() {
    // The paper's test 3: all sensors and hits on nodes 1 to 3.
    let mut layout = bar_layout();
    let corner = layout.sensors[1].position;
    for (hit, (name, position, direction)) in layout.hits.iter_mut().zip([
        ("1:+X", [0.0; 3], [1.0, 0.0, 0.0]),
        ("2:+Z", corner, [0.0, 0.0, 1.0]),
        ("2:+Y", corner, [0.0, 1.0, 0.0]),
    ]) {
        *hit = Hit::new(name.parse().unwrap(), position, direction);
    }
    assert_eq!(left(&layout), [true; 2], "of the frame itself");
    let places = layout.sensors.iter().map(|s| s.position);
    let places = places.chain(layout.hits.iter().map(|h| h.position));
    let body = assumed_body(None, places);
    assert!(Applicability::new(&layout, &body, &BOTH).diagnostics.is_empty());
}

#[test]
fn a_good_layout_leaves_both_methods() {
    let applicability = judge(&bar_layout());
    assert!(applicability.diagnostics.is_empty());
    assert_eq!(applicability.rank, 10);
    assert_eq!(left(&bar_layout()), [true; 2]);
}

#[test]
fn two_sensors_leave_maximum_likelihood() {
    let mut layout = bar_layout();
    layout.sensors.truncate(2);
    assert_eq!(left(&layout), [true, false]);
    let obstacles: Vec<_> = judge(&layout).obstacles(Method::InertiaRestraint).collect();
    assert_eq!(obstacles, [Code::FewerThanThreeSensors, Code::ResponseRankDeficient]);
    assert_eq!(judge(&layout).obstacles(Method::MaximumLikelihood).count(), 0);
}

#[test]
fn sensors_on_a_line_leave_maximum_likelihood() {
    let mut layout = bar_layout();
    layout.sensors = (0..3).map(|i| sensor(i, [0.05 * f64::from(i), 0.0, 0.0])).collect();
    assert_eq!(left(&layout), [true, false]);
    assert_eq!(judge(&layout).rank, 10);
}

#[test]
fn one_sensor_leaves_none_however_many_hits() {
    let mut layout = bar_layout();
    layout.sensors.truncate(1);
    let dof = "2:+X".parse().unwrap();
    layout.hits.push(Hit::new(dof, layout.hits[1].position, [1.0, 0.0, 0.0])).unwrap();
    let applicability = judge(&layout);
    // Theory, section 4: one sensor and five hits give rank nine.
    assert_eq!(applicability.rank, 9);
    assert_eq!(left(&layout), [false; 2]);
    let codes: Vec<_> = applicability.obstacles(Method::MaximumLikelihood).collect();
    assert_eq!(codes, [Code::TenParametersNotIdentifiable]);
}

#[test]
fn concurrent_parallel_and_two_hits_leave_none() {
    let mut concurrent = bar_layout();
    hits_through(&mut concurrent, [0.2, 0.0, 0.0]);
    assert_eq!(judge(&concurrent).rank, 9);
    let mut parallel = bar_layout();
    parallel.hits.iter_mut().for_each(|hit| hit.direction = [0.0, 0.6, 0.8]);
    let mut two = bar_layout();
    two.hits.truncate(2);
    let none = Layout { hits: heapless::Vec::new(), ..bar_layout() };
    let nobody = Layout { sensors: heapless::Vec::new(), ..bar_layout() };
    for layout in [concurrent, parallel, two, none, nobody] {
        assert_eq!(left(&layout), [false; 2]);
    }
}

#[test]
fn a_known_mass_does_not_help_concurrent_hits_but_a_known_moment_does() {
    let mut layout = bar_layout();
    hits_through(&mut layout, [0.2, 0.0, 0.0]);
    let theta = bar_body().theta();
    let prior = |property: u8| Prior {
        property,
        value: theta[usize::from(property)],
        sigma: 1e-3 * theta[0],
    };
    // The rule is in theory, section 4.
    for property in 0..4 {
        layout.priors.push(prior(property)).unwrap();
    }
    assert_eq!(judge(&layout).rank, 9);
    assert_eq!(left(&layout), [false; 2]);
    for property in 4..7 {
        let mut layout = layout.clone();
        layout.priors.push(prior(property)).unwrap();
        assert_eq!(judge(&layout).rank, 10);
        assert_eq!(left(&layout), [true, false]);
    }
}

#[test]
fn what_is_no_number_leaves_none() {
    let mut layout = bar_layout();
    layout.hits[0].direction[1] = f64::NAN;
    assert_eq!(left(&layout), [false; 2]);
    let diagnostics = judge(&layout).diagnostics;
    assert_eq!(diagnostics.iter().map(|d| d.code).collect::<Vec<_>>(), [Code::LayoutNotFinite]);
    let mut layout = bar_layout();
    layout.sensors[2].axes[0] = [1.1, 0.0, 0.0];
    assert_eq!(left(&layout), [false; 2]);
}

#[test]
fn an_obstacle_is_an_error_for_whoever_wants_the_stopped_method_alone() {
    let mut layout = bar_layout();
    layout.sensors.truncate(2);
    let is_refused = |methods: &[Method]| {
        Applicability::new(&layout, &bar_body(), methods).diagnostics[0].is_error()
    };
    assert!(is_refused(&[Method::InertiaRestraint]));
    assert!(!is_refused(&[Method::MaximumLikelihood]));
    assert!(!is_refused(&BOTH));
}

#[test]
fn what_only_mass_lines_need_is_no_finding_in_a_test_of_modes() {
    let mut layout = bar_layout();
    layout.hits.truncate(1);
    let methods: Methods = Method::of_modes().collect();
    let applicability = Applicability::new(&layout, &bar_body(), &methods);
    assert!(applicability.findings(TestProfile::Suspension).is_empty());
    assert!(!applicability.findings(TestProfile::MassLine).is_empty());
    assert!(
        !applicability.admits(Method::ModalConstant)
            && applicability.admits(Method::ToivolaNuutila)
    );
    // What the modes need as well is one.
    layout.sensors.truncate(2);
    let applicability = Applicability::new(&layout, &bar_body(), &methods);
    let codes: Vec<_> =
        applicability.findings(TestProfile::Suspension).iter().map(|d| d.code).collect();
    assert!(codes.contains(&Code::FewerThanThreeSensors), "{codes:?}");
    assert!(!codes.contains(&Code::FewerThanThreeHits), "{codes:?}");
}

//! Faults that are small enough to pass for errors of the budget: a node that lies elsewhere, hits that lean, chips above
//! their marks, gains that drift, a pad on the mark.

use nalgebra::Vector3;

use super::physics::tapped_with;
use super::{exact, scans, tapped, test_one};
use crate::bench::Bench;
use crate::body::{compose, point};
use crate::operator::BenchSource;
use crate::source::ScanSource;
use crate::taps::Tip;
use massline_shared::layout::HostLayout;
use massline_shared::signal::Scan;

/// Without elastic modes, which are known at the nodes only.
fn rigid(faults: &[&str]) -> Bench {
    let mut bench = exact(faults);
    bench.elastic.clear();
    bench
}

fn outputs(bench: &Bench, layout: &HostLayout, dof: usize) -> Vec<[f64; 10]> {
    tapped_with(bench, layout, dof, Tip::default(), 2000)
}

/// The scans of this arming.
fn armed(bench: &Bench, arming: u32, dof: usize) -> Vec<Scan> {
    let mut source = BenchSource::new(bench, &test_one(), 6).unwrap();
    source.armed(arming, dof);
    scans(&mut source, 2400)
}

#[test]
fn a_misplaced_node_takes_its_sensor_and_its_hits_along() {
    let mut moved = test_one();
    let (node, distance) = (test_one().sensors[1].node, 0.01);
    for sensor in moved.sensors.iter_mut().filter(|sensor| sensor.node == node) {
        sensor.position[2] += distance;
    }
    for hit in moved.hits.iter_mut().filter(|hit| hit.dof.node == node) {
        hit.position[2] += distance;
    }
    assert!(moved.hits != test_one().hits, "the node is hit, too");
    let wrong = rigid(&[&format!("node:{node}z:{distance}")]);
    for dof in 0..3 {
        // Hits land where the operator of the source finds the node.
        assert_eq!(tapped(&wrong, &test_one(), dof), tapped(&rigid(&[]), &moved, dof));
    }
    assert_ne!(tapped(&wrong, &test_one(), 0), tapped(&rigid(&[]), &test_one(), 0));
}

#[test]
fn chips_above_their_marks_read_what_sensors_there_read() {
    let mut raised = test_one();
    for sensor in raised.sensors.iter_mut() {
        let above = Vector3::from(sensor.axes[2]) * 0.004;
        sensor.position = (Vector3::from(sensor.position) + above).into();
    }
    for dof in 0..3 {
        assert_eq!(
            outputs(&rigid(&["height:0.004"]), &test_one(), dof),
            outputs(&rigid(&[]), &raised, dof)
        );
    }
}

#[test]
fn hits_lean_by_the_angle_asked_for() {
    let direction = |bench: &Bench, arming: u32, dof: usize| {
        let mut source = BenchSource::new(bench, &test_one(), 6).unwrap();
        source.armed(arming, dof);
        scans(&mut source, 1400);
        source.last_tap().unwrap().direction
    };
    let leaning = exact(&["lean:2:0.08"]);
    let turned = exact(&["turn:0.05"]);
    for dof in 0..3 {
        let along = Vector3::from(test_one().hits[dof].direction);
        let [first, second] = [1, 2].map(|arming| direction(&leaning, arming, dof));
        assert_eq!(first, second);
        let expected = if dof == 1 { 0.08_f64.atan() } else { 0.0 };
        // Rounding of a cosine near one.
        assert!((first.angle(&along) - expected).abs() < 1e-7, "{dof}");
        let axis = BenchSource::new(&turned, &test_one(), 6).unwrap().errors().hits_axis;
        let expected = (along + axis.cross(&along) * 0.05).normalize();
        assert!((direction(&turned, 1, dof) - expected).norm() < 1e-12, "{dof}");
    }
}

#[test]
fn a_gain_drifts_from_the_first_hit_of_the_test_to_the_last() {
    let rest = 2048.0;
    let hits = u32::from(test_one().test.hits_per_dof) * test_one().hits.len() as u32;
    let drifting = rigid(&["drift:2y:0.2"]);
    for (arming, gain) in [(1, 1.0), (1 + (hits - 1) / 2, 1.1), (hits, 1.2), (hits + 7, 1.2)] {
        let (good, bad) = (armed(&rigid(&[]), arming, 0), armed(&drifting, arming, 0));
        for (good, bad) in good.iter().zip(&bad) {
            let expected = rest + gain * (f64::from(good[5]) - rest);
            // Both codes are rounded.
            assert!((f64::from(bad[5]) - expected).abs() <= 1.2, "{arming}: {expected}");
            assert_eq!((bad[0], bad[4], bad[6]), (good[0], good[4], good[6]));
        }
    }
    let hammer = rigid(&["drift:hammer:0.2"]);
    let (good, bad) = (armed(&rigid(&[]), hits, 0), armed(&hammer, hits, 0));
    let zero = f64::from(good[0][0]);
    for (good, bad) in good.iter().zip(&bad) {
        let expected = zero + 1.2 * (f64::from(good[0]) - zero);
        assert!((f64::from(bad[0]) - expected).abs() <= 1.7, "{expected}");
        assert_eq!(bad[1..], good[1..]);
    }
}

#[test]
fn a_pad_is_on_the_mark_that_is_hit() {
    let bench = rigid(&["pad:0.05"]);
    for dof in 0..3 {
        let mark = Vector3::from(test_one().hits[dof].position);
        let mut heavier = rigid(&[]);
        heavier.body = compose(&[heavier.body, point(0.05, mark)]);
        assert_eq!(armed(&bench, 3, dof), armed(&heavier, 3, dof));
        assert_ne!(armed(&bench, 3, dof), armed(&rigid(&[]), 3, dof));
    }
}

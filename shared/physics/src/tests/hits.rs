//! The disturbances of hits: the tip, hits beside the mark, the gain of the hammer.

use nalgebra::Vector3;

use super::physics::{accelerance_to, mass_lines, tapped_with};
use super::{exact, tapped, test_one};
use crate::bench::Bench;
use crate::operator::BenchSource;
use crate::source::ScanSource;
use crate::taps::{Tap, Tip};

/// The tap of an arming.
fn tap(bench: &Bench, arming: u32, dof: usize) -> Tap {
    let mut source = BenchSource::new(bench, &test_one(), 6).unwrap();
    source.armed(arming, dof);
    super::scans(&mut source, 1400);
    source.last_tap().unwrap().clone()
}

#[test]
fn the_forces_of_the_tip_move_the_object_as_they_must() {
    let mut bench = Bench::named("ideal").unwrap();
    bench.elastic.clear();
    let layout = test_one();
    let tip = Tip {
        lateral: Vector3::new(0.1, 0.0, -0.05),
        moment_m: Vector3::new(0.002, -0.004, 0.003),
    };
    let record = tapped_with(&bench, &layout, 0, tip, 6000);
    let hit = &layout.hits[0];
    let force = Vector3::from(hit.direction) + tip.lateral;
    let moment = Vector3::from(hit.position).cross(&force) + tip.moment_m;
    let truth = accelerance_to(&bench.body.mass_matrix(), &layout, force, moment);
    for (line, truth) in mass_lines(&bench, &record, &[0, -1, -2, -3, -4]).iter().zip(truth) {
        // (2.5 Hz/10 Hz)⁵ from the suspension's damping, as without forces of the tip, of accelerances up
        // to 3 (m/s²)/N.
        assert!((line - truth).abs() < 3e-4, "{line} {truth}");
    }
}

#[test]
fn the_tip_pushes_in_the_same_way_in_all_hits_at_a_dof() {
    let mut bench = exact(&[]);
    bench.tap.lateral = 0.05;
    bench.tap.free_moment_m = 0.003;
    let tips = [0, 1, 2].map(|dof| {
        let taps = [1, 2].map(|arming| tap(&bench, arming, dof));
        assert_eq!(taps[0].tip, taps[1].tip);
        let tip = taps[0].tip;
        // Rounding.
        assert!((tip.lateral.norm() - 0.05).abs() < 1e-15);
        assert!((tip.moment_m.norm() - 0.003).abs() < 1e-15);
        assert!(tip.lateral.dot(&Vector3::from(test_one().hits[dof].direction)).abs() < 1e-15);
        tip
    });
    assert!(tips[0].moment_m != tips[1].moment_m && tips[1].moment_m != tips[2].moment_m);
    assert!(tips[0].lateral != tips[2].lateral);
}

#[test]
fn hits_beside_the_mark_are_all_on_the_same_side() {
    let mut offset = exact(&[]);
    offset.tap.offset_m = 0.004;
    for (bench, distances) in [
        (offset.clone(), [0.004; 3]),
        (exact(&["beside:2:0.005"]), [0.0, 0.005, 0.0]),
        (Bench { faults: exact(&["beside:3:0.005"]).faults, ..offset }, [0.004, 0.004, 0.009]),
    ] {
        for (dof, distance) in distances.into_iter().enumerate() {
            let points = [1, 2].map(|arming| tap(&bench, arming, dof).point);
            assert_eq!(points[0], points[1]);
            let hit = &test_one().hits[dof];
            let from_mark = points[0] - Vector3::from(hit.position);
            // Rounding of coordinates of 0.2 m.
            assert!((from_mark.norm() - distance).abs() < 1e-15, "{dof}: {from_mark}");
            assert!(from_mark.dot(&Vector3::from(hit.direction)).abs() < 1e-15);
        }
    }
}

#[test]
fn a_wrong_gain_of_the_hammer_shows_in_the_hammer_alone() {
    let good = tapped(&exact(&[]), &test_one(), 1);
    let mut bench = exact(&["hammer:0.9"]);
    let by_fault = tapped(&bench, &test_one(), 1);
    bench.faults.clear();
    bench.hammer.gain_error = -0.1;
    let by_key = tapped(&bench, &test_one(), 1);
    let source = BenchSource::new(&bench, &test_one(), 6).unwrap();
    assert_eq!(source.errors().hammer_gain, -0.1);
    let rest = 0.1 * 4096.0 / 3.0;
    for ((by_fault, by_key), good) in by_fault.iter().zip(&by_key).zip(&good) {
        assert_eq!(by_fault, by_key);
        assert_eq!(by_fault[1..], good[1..]);
        let expected = rest + 0.9 * (f64::from(good[0]) - rest);
        // Both codes are rounded, to a half each.
        assert!((f64::from(by_fault[0]) - expected).abs() <= 1.0, "{expected}");
    }
}

#[test]
fn marks_are_displaced_and_turned_by_the_deviations_asked_for() {
    let mut bench = exact(&[]);
    bench.tap.mark_position_sigma_m = 0.001;
    bench.tap.mark_direction_sigma_rad = 0.01;
    let count = 400;
    let (mut displaced, mut turned) = (0.0, 0.0);
    for seed in 0..count {
        let mut source = BenchSource::new(&bench, &test_one(), seed).unwrap();
        let taps = [1, 2].map(|arming| {
            source.armed(arming, 0);
            for _ in 0..2000 {
                let _ = source.next_scan();
            }
            source.last_tap().cloned().unwrap()
        });
        assert_eq!((taps[0].point, taps[0].direction), (taps[1].point, taps[1].direction));
        let hit = &test_one().hits[0];
        let (mark, along) = (Vector3::from(hit.position), Vector3::from(hit.direction));
        displaced += (taps[0].point - mark).norm_squared();
        turned += (taps[0].direction - along).norm_squared();
    }
    // Two axes of 400 marks determine a standard deviation to 2.5 %; four times that is allowed.
    let rms = |sum: f64| (sum / (2.0 * count as f64)).sqrt();
    assert!((rms(displaced) / 0.001 - 1.0).abs() < 0.1, "{}", rms(displaced));
    assert!((rms(turned) / 0.01 - 1.0).abs() < 0.1, "{}", rms(turned));
}

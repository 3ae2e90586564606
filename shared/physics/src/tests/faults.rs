//! The effect of setup mistakes on the scans.

use super::{exact, layout, tapped, test_one};
use crate::bench::{Bench, BenchError};
use crate::operator::BenchSource;
use crate::settings::Fault;
use massline_shared::signal::Scan;

/// Deviation of channel `k` from 1.5 V, in codes.
fn reading(scan: &Scan, k: usize) -> i32 {
    i32::from(scan[k]) - 2048
}

#[test]
fn wires_and_mounting_change_readings_as_they_must() {
    let good = tapped(&exact(&[]), &test_one(), 0);
    assert!(good.iter().any(|s| reading(s, 5).abs() > 50), "the hit shows in sensor 2 y");
    // A channel with the sign and the channel that it shows instead. After a turn about z the new x is
    // the old y.
    type ShownChannel = (usize, i32, usize);
    let cases: [(&str, &[ShownChannel]); 5] = [
        ("flip:2y", &[(4, 1, 4), (5, -1, 5), (6, 1, 6)]),
        ("swap:1,2", &[(1, 1, 4), (2, 1, 5), (6, 1, 3), (7, 1, 7)]),
        ("swap:3y,3z", &[(7, 1, 7), (8, 1, 9), (9, 1, 8)]),
        ("rotate:3:z90", &[(7, 1, 8), (8, -1, 7), (9, 1, 9)]),
        ("rotate:1:x180", &[(1, 1, 1), (2, -1, 2), (3, -1, 3)]),
    ];
    for (fault, channels) in cases {
        let bad = tapped(&exact(&[fault]), &test_one(), 0);
        for (bad, good) in bad.iter().zip(&good) {
            for &(k, sign, source) in channels {
                // Each reading is rounded; with opposite signs a half is rounded in opposite directions.
                assert!((reading(bad, k) - sign * reading(good, source)).abs() <= 1, "{fault} {k}");
            }
        }
    }
}

#[test]
fn a_common_scale_shows_in_all_sensors_and_not_in_the_hammer() {
    let good = tapped(&exact(&[]), &test_one(), 1);
    let bad = tapped(&exact(&["scale:1.1"]), &test_one(), 1);
    for (bad, good) in bad.iter().zip(&good) {
        assert_eq!(bad[0], good[0]);
        for k in 1..10 {
            let expected = 1.1 * f64::from(reading(good, k));
            // Both readings are rounded.
            assert!((f64::from(reading(bad, k)) - expected).abs() <= 1.1, "{k}");
        }
    }
}

#[test]
fn a_hit_at_the_wrong_node_is_the_hit_of_a_layout_that_has_it_there() {
    let bench = Bench::named("default").unwrap();
    let wrong = Bench { faults: vec!["hit:2:4".parse().unwrap()], ..bench.clone() };
    let moved_layout = layout([1, 2, 3], ["1:+Y", "4:+Z", "4:+X"]);
    assert_eq!(tapped(&wrong, &test_one(), 1), tapped(&bench, &moved_layout, 1));
    assert_eq!(tapped(&wrong, &test_one(), 0), tapped(&bench, &test_one(), 0));
}

#[test]
fn a_reversed_hit_moves_everything_the_other_way() {
    let good = tapped(&exact(&[]), &test_one(), 2);
    let bad = tapped(&exact(&["reverse:3"]), &test_one(), 2);
    let rest = good[0];
    for (bad, good) in bad.iter().zip(&good) {
        assert_eq!(bad[0], good[0], "a hammer pushes");
        for k in 1..10 {
            let moved = |s: &Scan| i32::from(s[k]) - i32::from(rest[k]);
            // Both readings and the rest value are rounded.
            assert!((moved(bad) + moved(good)).abs() <= 2, "{k}");
        }
    }
}

#[test]
fn a_fault_without_its_subject_is_refused() {
    for (fault, missing) in [
        ("flip:4x", "sensor"),
        ("swap:1,9", "sensor"),
        ("rail:4y:50", "sensor"),
        ("compress:4y", "sensor"),
        ("reverse:4", "hit"),
        ("beside:4:0.005", "hit"),
        ("hit:1:77", "node"),
        ("cable:77:400", "node"),
    ] {
        let bench = exact(&[fault]);
        match BenchSource::new(&bench, &test_one(), 1).unwrap_err() {
            BenchError::FaultWithoutSubject { fault: named, missing: subject } => {
                assert_eq!((named, subject), (fault.parse::<Fault>().unwrap(), missing));
            }
            other => panic!("{other}"),
        }
    }
}

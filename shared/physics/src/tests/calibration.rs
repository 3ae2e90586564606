//! Calibration benches: the sensors of a test held in the six positions and mounted on a block.

use massline_shared::STANDARD_GRAVITY;
use massline_shared::calibration::tumble::Position;

use super::*;
use crate::tumble::TumbleSource;

#[test]
fn the_sensors_of_a_seed_are_the_same_ones_everywhere_and_glued_anew_on_the_block() {
    let layout = test_one();
    let source = |name: &str| {
        let bench = Bench::named(name).unwrap();
        let layout = if bench.elastic.is_empty() { block_layout() } else { layout.clone() };
        BenchSource::new(&bench, &layout, 7).unwrap()
    };
    let (frame, block) = (source("uncalibrated"), source("block"));
    let tumble = TumbleSource::new(&Bench::named("block").unwrap(), 3, 7).unwrap();
    for other in [block.errors(), tumble.errors()] {
        assert_eq!(other.zero_v, frame.errors().zero_v);
        assert_eq!(other.rc, frame.errors().rc);
        assert_eq!(other.hammer_gain, frame.errors().hammer_gain);
        for (a, b) in other.sensors.iter().zip(&frame.errors().sensors) {
            assert_eq!(a.sensitivity, b.sensitivity);
        }
    }
    for (a, b) in block.errors().sensors.iter().zip(&frame.errors().sensors) {
        assert!(a.position != b.position && a.rotation != b.rotation);
    }
}

fn block_layout() -> HostLayout {
    HostLayout {
        sensors: [1, 2, 3].map(|n| sensor(n, [0.02, 0.0, 0.006])).into_iter().collect(),
        ..HostLayout::default()
    }
}

#[test]
fn a_sensor_in_the_hand_reads_gravity_along_the_axis_that_points_up() {
    let bench = Bench::named("ideal").unwrap();
    let mut source = TumbleSource::new(&bench, 3, 3).unwrap();
    let zero_v = source.errors().zero_v;
    let handle = source.handle();
    for position in Position::ALL {
        handle.turn_to(position);
        let up = position.up::<f64>();
        let scans: Vec<Scan> = (0..2000).map(|_| source.next_scan().unwrap()).collect();
        for k in 1..CHANNELS {
            let mean = scans.iter().map(|s| f64::from(s[k])).sum::<f64>() / 2000.0;
            let g = (mean * 3.0 / 4096.0 - 1.5 - zero_v[k]) / bench.sensor.sensitivity_v_per_g;
            // Four times the noise of 8.4 mg averaged over 740 independent scans; on the lateral axes
            // also four times the tilt of 3 mrad.
            let across = if up[(k - 1) % 3] == 0.0 { 0.012 } else { 0.0 };
            assert!((g - up[(k - 1) % 3]).abs() < 0.0013 + across, "{position} {k}: {g}");
        }
        assert!((bench.gravity.norm() - STANDARD_GRAVITY).abs() < 1e-9);
    }
}

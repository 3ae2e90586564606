//! The bench as a whole: what its scans show of the object.

mod calibration;
mod converter;
mod environment;
mod error_sizes;
mod faults;
mod files;
mod hits;
mod loads;
mod physics;
mod response_channels;
mod sensors;
mod small_faults;
mod supply;
mod unchanged;
mod wheel;

use massline_shared::layout::{Dof, Hit, HostLayout, Sensor};
use massline_shared::signal::{CHANNELS, Scan};
use nalgebra::{Matrix3, Vector3};

use crate::bench::{Bench, BenchError};
use crate::operator::BenchSource;
use crate::source::ScanSource;

const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn sensor(node: u16, position: [f64; 3]) -> Sensor<f64> {
    Sensor::new(node, position, IDENTITY)
}

/// One of the paper's tests on the nodes of the default bench.
fn layout(sensors: [u16; 3], hits: [&str; 3]) -> HostLayout {
    let bench = Bench::named("default").unwrap();
    let position = |id: u16| bench.nodes.iter().find(|n| n.id == id).unwrap().position_m;
    let hit = |name: &str| {
        let dof: Dof = name.parse().unwrap();
        let direction = IDENTITY[dof.axis.index()].map(|v| v * dof.sign.factor());
        Hit::new(dof, position(dof.node), direction)
    };
    HostLayout {
        title: "three-bar".try_into().unwrap(),
        gravity: Some(bench.gravity.into()),
        sensors: sensors.iter().map(|&n| sensor(n, position(n))).collect(),
        hits: hits.into_iter().map(hit).collect(),
        ..HostLayout::default()
    }
}

pub(super) fn test_one() -> HostLayout {
    layout([1, 2, 3], ["1:+Y", "2:+Z", "4:+X"])
}

fn scans(source: &mut BenchSource, count: usize) -> Vec<Scan> {
    (0..count).map(|_| source.next_scan().unwrap()).collect()
}

/// A bench on which all channels are identical and only the taps are random.
fn exact(faults: &[&str]) -> Bench {
    let mut bench = Bench::named("ideal").unwrap();
    bench.sensor.zero_sigma_v = 0.0;
    bench.sensor.rc_tolerance = 0.0;
    bench.sensor.noise_g_per_sqrt_hz = 0.0;
    bench.hammer.zero_sigma_v = 0.0;
    bench.hammer.noise_n_per_sqrt_hz = 0.0;
    bench.hammer.rc_tolerance = 0.0;
    bench.adc.channel_delay_s = 0.0;
    bench.faults = faults.iter().map(|f| f.parse().unwrap()).collect();
    bench
}

fn tapped(bench: &Bench, layout: &HostLayout, dof: usize) -> Vec<Scan> {
    let mut source = BenchSource::new(bench, layout, 6).unwrap();
    source.armed(1, dof);
    scans(&mut source, 1400)
}

#[test]
fn taps_come_after_the_delay_and_do_not_clip() {
    let mut bench = Bench::named("default").unwrap();
    bench.operator.too_weak_rate = 0.0;
    bench.operator.too_hard_rate = 0.0;
    for (sensors, hits) in [
        ([1, 2, 3], ["1:+Y", "2:+Z", "4:+X"]),
        ([1, 2, 4], ["1:+Y", "2:+Z", "4:+X"]),
        ([1, 2, 3], ["1:+X", "2:+Z", "2:+Y"]),
        ([1, 2, 4], ["1:+X", "2:+Z", "2:+Y"]),
    ] {
        let layout = layout(sensors, hits);
        let mut source = BenchSource::new(&bench, &layout, 5).unwrap();
        for arming in 0..30 {
            source.armed(arming, arming as usize % 3);
            let record = scans(&mut source, 1500);
            let touched = record.iter().position(|s| s[0] > 137 + 60).unwrap();
            assert!((1200..1215).contains(&touched), "{touched}");
            for (k, zero) in source.errors().zero_v.iter().enumerate().skip(1) {
                for scan in &record {
                    let g = (f64::from(scan[k]) * 3.0 / 4096.0 - 1.5 - zero) / 0.057;
                    assert!(g.abs() < 15.0, "channel {k} reads {g} g");
                }
            }
        }
    }
}

#[test]
fn a_tap_that_is_too_hard_drives_channels_to_their_ends() {
    let mut bench = Bench::named("default").unwrap();
    bench.operator.too_hard_rate = 1.0;
    bench.operator.too_weak_rate = 0.0;
    let mut source = BenchSource::new(&bench, &test_one(), 5).unwrap();
    source.armed(1, 0);
    let record = scans(&mut source, 1500);
    let largest = |k: usize| record.iter().map(|s| s[k]).max().unwrap();
    assert_eq!(largest(0), 4095);
    // Sensor 1 along the hit: 3.06 (m/s²)/N times 150 N is far beyond 16 g.
    let g = (f64::from(largest(2)) * 3.0 / 4096.0 - 1.5 - source.errors().zero_v[2]) / 0.057;
    assert!((15.8..16.1).contains(&g), "{g}");
}

#[test]
fn scans_depend_on_seed_arming_and_dof_alone() {
    let bench = Bench::named("default").unwrap();
    let layout = test_one();
    let run = |seed, earlier: &[(u32, usize)], arming, dof| {
        let mut source = BenchSource::new(&bench, &layout, seed).unwrap();
        for &(arming, dof) in earlier {
            source.armed(arming, dof);
            scans(&mut source, 1300);
        }
        source.armed(arming, dof);
        scans(&mut source, 1400)
    };
    let first = run(3, &[], 4, 1);
    assert_eq!(first, run(3, &[(1, 0), (2, 2)], 4, 1));
    assert_ne!(first, run(4, &[], 4, 1));
    assert_ne!(first, run(3, &[], 5, 1));
    assert_ne!(first, run(3, &[], 4, 2));
}

#[test]
fn ideal_is_the_default_without_placement_and_gain_errors() {
    let default = Bench::named("default").unwrap();
    let ideal = Bench::named("ideal").unwrap();
    assert_eq!(default.body, ideal.body);
    assert_eq!(default.elastic, ideal.elastic);
    let source = BenchSource::new(&ideal, &test_one(), 8).unwrap();
    let other = BenchSource::new(&default, &test_one(), 8).unwrap();
    assert_eq!(source.errors().zero_v, other.errors().zero_v);
    assert_eq!(source.errors().rc, other.errors().rc);
    assert_eq!(source.errors().hammer_gain, 0.0);
    for sensor in &source.errors().sensors {
        assert_eq!(sensor.position, Vector3::zeros());
        assert_eq!(sensor.rotation, Vector3::zeros());
        assert_eq!(sensor.sensitivity, Matrix3::identity());
    }
    assert!(other.errors().sensors.iter().all(|s| s.position.norm() > 0.0));
}

#[test]
fn a_manual_operator_taps_on_request() {
    let bench = Bench::named("default").unwrap();
    let mut source = BenchSource::new(&bench, &test_one(), 8).unwrap();
    let handle = source.manual();
    handle.tap();
    source.armed(1, 0);
    let touched = |record: &[Scan]| record.iter().any(|s| s[0] > 137 + 60);
    assert!(!touched(&scans(&mut source, 4000)), "a key pressed before the arming is forgotten");
    let other = handle.clone();
    std::thread::spawn(move || other.tap()).join().unwrap();
    assert!(touched(&scans(&mut source, 400)));
    assert!(!touched(&scans(&mut source, 400)));
    handle.tap();
    assert!(touched(&scans(&mut source, 400)));
}

#[test]
fn a_manual_operator_also_taps_when_the_rig_only_listens() {
    let bench = Bench::named("default").unwrap();
    let mut source = BenchSource::new(&bench, &test_one(), 8).unwrap();
    let handle = source.manual();
    let touched = |record: &[Scan]| record.iter().any(|s| s[0] > 137 + 60);
    source.started();
    handle.tap();
    assert!(touched(&scans(&mut source, 400)));
    assert_eq!(source.last_tap().unwrap().dof, 0);
    // After a tap at another DOF the next is there too.
    source.armed(7, 2);
    source.started();
    assert!(!touched(&scans(&mut source, 4000)));
    handle.tap();
    assert!(touched(&scans(&mut source, 400)));
    assert_eq!(source.last_tap().unwrap().dof, 2);
}

#[test]
fn an_arming_for_a_dof_that_is_not_there_is_quiet() {
    let bench = Bench::named("default").unwrap();
    let mut source = BenchSource::new(&bench, &test_one(), 8).unwrap();
    source.armed(1, 77);
    assert!(scans(&mut source, 2000).iter().all(|s| s[0] < 160));
    assert!(source.last_tap().is_none());
}

#[test]
fn a_node_without_elastic_shape_is_refused_by_number() {
    let bench = Bench::named("default").unwrap();
    let mut layout = test_one();
    layout.sensors[1].node = 7;
    let error = BenchSource::new(&bench, &layout, 1).unwrap_err();
    assert!(matches!(error, BenchError::NodeWithoutShape(7)), "{error}");
    layout.sensors[1] = sensor(2, [0.0, 0.3, 0.0]);
    let error = BenchSource::new(&bench, &layout, 1).unwrap_err();
    assert!(matches!(error, BenchError::NodeElsewhere { node: 2, .. }), "{error}");
}

#[test]
fn a_fourth_sensor_is_refused() {
    let bench = Bench::named("default").unwrap();
    let mut layout = test_one();
    layout.sensors.push(sensor(4, [0.0; 3]));
    let error = BenchSource::new(&bench, &layout, 1).unwrap_err();
    assert!(matches!(error, BenchError::TooManySensors(4)), "{error}");
}

#[test]
fn channels_of_missing_sensors_are_not_announced() {
    let bench = Bench::named("default").unwrap();
    let mut layout = test_one();
    layout.sensors.pop();
    let source = BenchSource::new(&bench, &layout, 1).unwrap();
    assert_eq!(source.adc().channels, 7);
    assert_eq!(CHANNELS, 10);
}

#[test]
fn an_operator_whose_tap_goes_unheard_taps_again() {
    let mut bench = Bench::named("default").unwrap();
    bench.operator.too_weak_rate = 1.0;
    bench.operator.too_hard_rate = 0.0;
    let mut source = BenchSource::new(&bench, &test_one(), 8).unwrap();
    source.armed(1, 0);
    let record = scans(&mut source, 4 * 4000);
    let begins: Vec<_> = (1..record.len())
        .filter(|&n| record[n][0] > 200 && record[n - 200..n].iter().all(|s| s[0] <= 200))
        .collect();
    assert_eq!(begins.len(), 2, "{begins:?}");
    assert!((11_900..12_100).contains(&(begins[1] - begins[0])), "{begins:?}");
}

#[test]
fn an_operator_who_is_not_heard_gives_up_until_the_next_arming() {
    let mut bench = Bench::named("default").unwrap();
    bench.operator.patience_s = 0.3;
    bench.operator.delay_s = 0.3;
    let mut source = BenchSource::new(&bench, &test_one(), 8).unwrap();
    let last_tap = |source: &BenchSource| source.last_tap().map(|tap| tap.start());
    for arming in 1..=2 {
        source.armed(arming, 0);
        scans(&mut source, 4000 * 10 * 3 / 10 + 400);
        let tenth = last_tap(&source);
        // A tap starts at a random time within a scan: within one scan of ten times the patience.
        assert!(tenth.is_some_and(|start| (start - 3.0).abs() < 1.0 / 4000.0), "{tenth:?}");
        scans(&mut source, 4000);
        assert_eq!(last_tap(&source), tenth);
    }
}

#[test]
fn a_tap_far_beside_the_mark_still_lands() {
    let mut bench = Bench::named("default").unwrap();
    bench.tap.point_sigma_m = 0.05;
    let mut source = BenchSource::new(&bench, &test_one(), 8).unwrap();
    for arming in 0..20 {
        source.armed(arming, 0);
        assert!(scans(&mut source, 1300).iter().any(|s| s[0] > 200));
    }
}

#[test]
fn an_operator_taps_for_an_arming_and_not_while_the_rig_only_streams() {
    let mut bench = Bench::named("default").unwrap();
    bench.operator.too_weak_rate = 0.0;
    let mut source = BenchSource::new(&bench, &test_one(), 5).unwrap();
    let touched =
        |source: &mut BenchSource| scans(source, 20_000).iter().any(|scan| scan[0] > 137 + 60);
    source.armed(1, 0);
    assert!(touched(&mut source));
    source.started();
    // The last tap still rings down, but the hammer is at rest.
    assert!(!touched(&mut source));
    source.armed(2, 1);
    assert!(touched(&mut source));
}

//! How large the errors of a test are: as the bench says, or as the layout's error budget says.

use massline_shared::layout::HostLayout;
use nalgebra::Vector3;

use super::{scans, test_one};
use crate::bench::Bench;
use crate::operator::BenchSource;
use crate::settings::ErrorsFrom;
use crate::source::ScanSource;

/// Seeds over which errors are averaged.
const SEEDS: u64 = 200;

fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}

/// Asserts the standard deviation of draws within four of its own, each 0.71 over the root of their number.
fn assert_sigma(values: &[f64], sigma: f64) {
    let allowed = 4.0 * 0.71 / (values.len() as f64).sqrt();
    let ratio = root_mean_square(values) / sigma;
    assert!((ratio - 1.0).abs() < allowed, "{ratio} with {} draws", values.len());
}

fn from_layout() -> Bench {
    Bench { errors: ErrorsFrom::Layout, ..Bench::named("default").unwrap() }
}

fn sources(bench: &Bench, layout: &HostLayout) -> Vec<BenchSource> {
    (0..SEEDS).map(|seed| BenchSource::new(bench, layout, seed).unwrap()).collect()
}

#[test]
fn with_the_errors_of_the_layout_each_is_as_large_as_its_budget_says() {
    let mut layout = test_one();
    layout.sensors[1].uncertainty.position = 0.01;
    layout.apparatus.hammer_gain = 0.05;
    layout.apparatus.gravity_direction = 0.1;
    let sources = sources(&from_layout(), &layout);
    for (index, sensor) in layout.sensors.iter().enumerate() {
        let sensor_errors = || sources.iter().map(|source| source.errors().sensors[index]);
        let positions: Vec<f64> =
            sensor_errors().flat_map(|e| Vec::from(e.position.as_slice())).collect();
        let rotations: Vec<f64> =
            sensor_errors().flat_map(|e| Vec::from(e.rotation.as_slice())).collect();
        let gains: Vec<f64> = sensor_errors().map(|e| e.sensitivity[(0, 0)] - 1.0).collect();
        let cross: Vec<f64> = sensor_errors().map(|e| e.sensitivity[(0, 2)]).collect();
        assert_sigma(&positions, sensor.uncertainty.position);
        assert_sigma(&rotations, sensor.uncertainty.rotation);
        assert_sigma(&gains, sensor.uncertainty.gain);
        assert_sigma(&cross, sensor.uncertainty.cross_axis);
    }
    let hammer: Vec<f64> = sources.iter().map(|source| source.errors().hammer_gain).collect();
    assert_sigma(&hammer, 0.05);
    let nominal = from_layout();
    let tilts: Vec<f64> = sources
        .iter()
        .flat_map(|source| {
            let gravity = source.errors().hung(&nominal).gravity;
            // Rounding of numbers of ten.
            assert!((gravity.norm() - nominal.gravity.norm()).abs() < 1e-12);
            [gravity.x / gravity.z, gravity.y / gravity.z]
        })
        .collect();
    assert_sigma(&tilts, 0.1);
}

#[test]
fn a_layout_without_uncertainty_has_a_bench_without_errors() {
    let mut layout = test_one();
    layout.set_exact();
    let mut source = BenchSource::new(&from_layout(), &layout, 3).unwrap();
    for sensor in &source.errors().sensors {
        assert_eq!((sensor.position.norm(), sensor.rotation.norm()), (0.0, 0.0));
        assert_eq!(sensor.sensitivity, nalgebra::Matrix3::identity());
    }
    assert_eq!(source.errors().hammer_gain, 0.0);
    source.armed(1, 2);
    scans(&mut source, 1400);
    let tap = source.last_tap().unwrap();
    assert_eq!(tap.point, Vector3::from(layout.hits[2].position));
    assert_eq!((tap.direction, tap.gain_error), (layout.hits[2].direction.into(), 0.0));
}

#[test]
fn the_hammers_gain_is_off_by_the_same_for_all_hits_at_a_dof() {
    let mut bench = Bench::named("default").unwrap();
    bench.hammer.hit_gain_sigma = 0.03;
    let mut gain_errors = Vec::new();
    for seed in 0..20 {
        let mut source = BenchSource::new(&bench, &test_one(), seed).unwrap();
        let mut gain_error = |arming, dof| {
            source.armed(arming, dof);
            scans(&mut source, 1400);
            source.last_tap().unwrap().gain_error
        };
        let errors = [gain_error(1, 0), gain_error(2, 1), gain_error(3, 2)];
        assert_eq!(gain_error(4, 1), errors[1]);
        gain_errors.extend(errors);
    }
    assert_sigma(&gain_errors, 0.03);
}

//! The analogue outputs against closed forms.

use nalgebra::{Complex, DMatrix, Matrix3x6, Matrix6, Vector3, Vector6};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use massline_shared::layout::{HostLayout, Sensor};
use massline_shared::signal::CHANNELS;

use super::{layout, sensor, test_one};
use crate::bench::Bench;
use crate::channels::{Channels, SampledOutputs};
use crate::error_sizes::ErrorSizes;
use crate::errors::TestErrors;
use crate::simulation::Simulation;
use crate::taps::{Contact, Tap, TapKind, Tip};

pub(super) fn no_errors(bench: &Bench) -> TestErrors {
    let mut ideal = bench.clone();
    ideal.sensor.rc_tolerance = 0.0;
    ideal.hammer.rc_tolerance = 0.0;
    ideal.sensor.zero_sigma_v = 0.0;
    ideal.hammer.zero_sigma_v = 0.0;
    TestErrors::draw(&ideal, &ErrorSizes::of_bench(&ideal, 3, 0), &mut ChaCha8Rng::seed_from_u64(1))
}

/// The analogue outputs without noise after a tap of 20 N at a hit of the layout, minus the sensor
/// outputs at rest.
fn tapped(bench: &Bench, layout: &HostLayout, dof: usize, scans: usize) -> Vec<Channels> {
    tapped_with(bench, layout, dof, Tip::default(), scans)
}

/// As [`tapped`], with forces of the tip.
pub(super) fn tapped_with(
    bench: &Bench,
    layout: &HostLayout,
    dof: usize,
    tip: Tip,
    scans: usize,
) -> Vec<Channels> {
    let mut samples = samples(bench, layout, dof, tip, scans + 1).into_iter().map(|s| s.value);
    let rest = samples.next().unwrap();
    samples.map(|values| std::array::from_fn(|k| values[k] - rest[k])).collect()
}

/// The analogue outputs without noise, the first at rest, with a tap of 20 N at a hit of the layout.
pub(super) fn samples(
    bench: &Bench,
    layout: &HostLayout,
    dof: usize,
    tip: Tip,
    scans: usize,
) -> Vec<SampledOutputs> {
    let mut simulation = Simulation::new(bench, layout, &no_errors(bench)).unwrap();
    simulation.reset(&mut ChaCha8Rng::seed_from_u64(2), ChaCha8Rng::seed_from_u64(3));
    let hit = &layout.hits[dof];
    let tap = Tap {
        dof,
        kind: TapKind::Good,
        point: hit.position.into(),
        direction: hit.direction.into(),
        tip,
        gain_error: 0.0,
        contacts: vec![Contact { start: 0.01013, duration: 0.0047, peak: 20.0 }],
    };
    let drives = [simulation.drive(bench, hit.dof.node, tap).unwrap()];
    (0..scans).map(|_| simulation.scan_inputs(&drives)).collect()
}

/// Laplace transform of the sampled record of every channel.
pub(super) fn laplace(record: &[Channels], s: Complex<f64>, rate: f64) -> [Complex<f64>; CHANNELS] {
    let mut sums = [Complex::new(0.0, 0.0); CHANNELS];
    let turn = (s * -rate.recip()).exp();
    let mut kernel = Complex::new(rate.recip(), 0.0);
    for values in record {
        for (sum, value) in sums.iter_mut().zip(values) {
            *sum += kernel * value;
        }
        kernel *= turn;
    }
    sums
}

pub(super) fn lines() -> impl Iterator<Item = Complex<f64>> {
    (5..=60).map(|k| Complex::new(10.0, std::f64::consts::TAU * 2.0 * f64::from(k)))
}

/// Constant terms of a sum of these powers of `s` fitted to the accelerance of every channel, weighted by
/// the force and corrected for the delay of the channels.
pub(super) fn mass_lines(bench: &Bench, record: &[Channels], powers: &[i32]) -> Vec<f64> {
    let (rate, delay) = (bench.adc.rate_hz, bench.adc.channel_delay_s);
    let mut rows = Vec::new();
    let mut right = Vec::new();
    for s in lines() {
        let spectra = laplace(record, s, rate);
        let weight = spectra[0].norm();
        let basis: Vec<_> = powers.iter().map(|&p| (s / 200.0).powi(p) * weight).collect();
        let h: Vec<_> = (1..CHANNELS)
            .map(|k| spectra[k] * (s * -(k as f64 * delay)).exp() / spectra[0] * weight)
            .collect();
        rows.extend(basis.iter().map(|b| b.re));
        rows.extend(basis.iter().map(|b| b.im));
        right.extend(h.iter().map(|h| h.re));
        right.extend(h.iter().map(|h| h.im));
    }
    let a = DMatrix::from_row_slice(rows.len() / powers.len(), powers.len(), &rows);
    let b = DMatrix::from_row_slice(a.nrows(), CHANNELS - 1, &right);
    let fit = a.svd(true, true).solve(&b, 1e-13).unwrap();
    fit.row(0).iter().copied().collect()
}

/// Largest errors of the mass lines over sensors and hits of the paper's tests, relative to the largest
/// accelerance, one for each choice of powers.
fn worst_mass_lines<const N: usize>(bench: &Bench, powers: [&[i32]; N]) -> [f64; N] {
    let tests =
        [layout([1, 2, 4], ["1:+Y", "2:+Z", "4:+X"]), layout([1, 2, 3], ["1:+X", "2:+Z", "2:+Y"])];
    let mut worst = [0.0_f64; N];
    for (layout, dof) in tests.iter().flat_map(|layout| (0..3).map(move |dof| (layout, dof))) {
        let record = tapped(bench, layout, dof, 6000);
        let truth = rigid_accelerance(bench, layout, dof);
        let largest = truth.iter().fold(0.0_f64, |m, h| m.max(h.abs()));
        for (worst, powers) in worst.iter_mut().zip(powers) {
            for (a, h) in mass_lines(bench, &record, powers).iter().zip(&truth) {
                *worst = worst.max((a - h).abs() / largest);
            }
        }
    }
    worst
}

/// Constant accelerances of the rigid body (theory, section 2): `G M⁻¹ F`.
pub(super) fn rigid_accelerance(bench: &Bench, layout: &HostLayout, dof: usize) -> Vec<f64> {
    let hit = &layout.hits[dof];
    let (q, d) = (Vector3::from(hit.position), Vector3::from(hit.direction));
    accelerance_to(&bench.body.mass_matrix(), layout, d, q.cross(&d))
}

/// Constant accelerances to a force and a moment about the origin.
pub(super) fn accelerance_to(
    mass: &Matrix6<f64>,
    layout: &HostLayout,
    force: Vector3<f64>,
    moment: Vector3<f64>,
) -> Vec<f64> {
    let load = Vector6::from_iterator(force.iter().chain(&moment).copied());
    let x0 = mass.try_inverse().unwrap() * load;
    let readings = layout.sensors.iter().flat_map(|s| {
        let a = motion_of(s.position) * x0;
        [a.x, a.y, a.z]
    });
    readings.collect()
}

/// `G` of a point: its translation from the translation of the origin and the rotation.
pub(super) fn motion_of(position: [f64; 3]) -> Matrix3x6<f64> {
    let mut g = Matrix3x6::zeros();
    g.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
    g.fixed_view_mut::<3, 3>(0, 3).copy_from(&-Vector3::from(position).cross_matrix());
    g
}

#[test]
fn mass_lines_of_the_simulated_chain_are_those_of_the_rigid_body() {
    let bench = Bench::named("ideal").unwrap();
    let series = [0, -1, -2, -3, -4, 1, 2, 4];
    let [whole, of_the_rig] = worst_mass_lines(&bench, [&series, &[0, -2, 2]]);
    // Suspension and elastic modes as series in 1/s and s²: the omitted terms are (2.5 Hz/10 Hz)⁶ for the
    // suspension and (120 Hz/314 Hz)⁶ for the elastic modes.
    assert!(whole < 5e-4, "{whole}");
    // A + B/s² + C s² (theory, section 5) omits the damping of the cords and the fourth power of
    // 120 Hz/314 Hz, which is 2 % at the upper end of the band.
    assert!(of_the_rig < 4e-3, "{of_the_rig}");
}

#[test]
fn without_elastic_modes_the_mass_lines_are_exact() {
    let mut bench = Bench::named("ideal").unwrap();
    bench.elastic.clear();
    let [worst] = worst_mass_lines(&bench, [&[0, -1, -2, -3, -4]]);
    // (2.5 Hz/10 Hz)⁵ from the suspension's damping, which is a few hundredths of its force.
    assert!(worst < 1e-4, "{worst}");
}

#[test]
fn a_sensor_in_gravity_seems_to_sit_elsewhere() {
    // Theory, section 2: the sensor's apparent position is p + g/s², which is p − g/ω² on the frequency
    // axis.
    let mut bench = Bench::named("ideal").unwrap();
    bench.adc.channel_delay_s = 0.0;
    bench.elastic.clear();
    let p = Vector3::new(0.1, -0.05, 0.03);
    let blind =
        |position: Vector3<f64>| Sensor { senses_gravity: false, ..sensor(9, position.into()) };
    let mut layout = test_one();
    layout.sensors =
        [sensor(9, p.into()), blind(p), blind(p + bench.gravity * 0.01)].into_iter().collect();
    let record = tapped(&bench, &layout, 2, 6000);
    for s in lines().step_by(7) {
        let spectra = laplace(&record, s, bench.adc.rate_hz);
        for axis in 0..3 {
            let [felt, here, displaced_reading] = [1, 4, 7].map(|k| spectra[k + axis]);
            let expected = here + (displaced_reading - here) * 100.0 / (s * s);
            // Aliasing of the samples: the pulse's spectrum above 3.9 kHz, about 1e-5 of its mean.
            let scale = spectra[0].norm();
            assert!((felt - expected).norm() < 1e-5 * scale, "{s} {axis}: {felt} {expected}");
        }
    }
}

#[test]
fn a_later_channel_reads_what_comes_later() {
    let mut bench = Bench::named("ideal").unwrap();
    let layout = test_one();
    let delayed = tapped(&bench, &layout, 0, 4000);
    let delay = std::mem::take(&mut bench.adc.channel_delay_s);
    let together = tapped(&bench, &layout, 0, 4000);
    for s in lines().step_by(11) {
        let a = laplace(&delayed, s, bench.adc.rate_hz);
        let b = laplace(&together, s, bench.adc.rate_hz);
        for k in 0..CHANNELS {
            let lead = (s * (k as f64 * delay)).exp();
            // Aliased parts of the elastic modes have another phase.
            assert!((a[k] - b[k] * lead).norm() < 1e-4 * b[2].norm(), "{k} {s}");
        }
    }
}

#[test]
fn a_finer_grid_changes_nothing() {
    let mut bench = Bench::named("ideal").unwrap();
    let coarse = tapped(&bench, &test_one(), 2, 600);
    bench.adc.oversampling = 128;
    let fine = tapped(&bench, &test_one(), 2, 600);
    for (a, b) in coarse.iter().zip(&fine) {
        for (a, b) in a.iter().zip(b) {
            // 1e-4 of up to 100 m/s²: the curvature within 1/64 ms, mostly that of the third elastic
            // mode.
            assert!((a - b).abs() < 1e-2, "{a} {b}");
        }
    }
}

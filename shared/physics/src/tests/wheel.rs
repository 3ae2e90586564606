//! The wheel on its mounts, with and without a tyre, under taps of a mallet.

use std::f64::consts::TAU;

use massline_shared::layout::{Dof, Hit, HostLayout};
use massline_shared::signal::Scan;
use nalgebra::{Complex, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::physics::{accelerance_to, laplace, no_errors};
use super::{IDENTITY, scans, sensor};
use crate::bench::Bench;
use crate::channels::Channels;
use crate::loads::loaded_modes;
use crate::operator::BenchSource;
use crate::responses::{ObjectExtras, frequency_responses};
use crate::simulation::Simulation;
use crate::source::ScanSource;
use crate::suspension::{RigidMode, Suspension};
use crate::taps::{Contact, Tap, TapKind, Tip};

/// Three sensors on a circle and four hits, as in the paper.
pub(super) fn wheel_layout() -> HostLayout {
    let hit = |name: &str, position: [f64; 3]| {
        let dof: Dof = name.parse().unwrap();
        Hit::new(dof, position, IDENTITY[dof.axis.index()])
    };
    HostLayout {
        title: "wheel".try_into().unwrap(),
        gravity: Some([0.0, 0.0, -massline_shared::STANDARD_GRAVITY]),
        sensors: [[0.0, 0.19, 0.03], [-0.1645, -0.095, 0.03], [0.1645, -0.095, 0.03]]
            .into_iter()
            .zip(1..)
            .map(|(position, node)| sensor(node, position))
            .collect(),
        hits: [
            hit("101:+X", [-0.20, 0.10, 0.02]),
            hit("102:+Z", [0.16, 0.12, 0.03]),
            hit("104:+Y", [0.18, -0.21, -0.02]),
            hit("105:+X", [-0.29, -0.06, -0.09]),
        ]
        .into_iter()
        .collect(),
        ..HostLayout::default()
    }
}

/// A bench without random errors, noise, and bad taps.
pub(super) fn quiet(name: &str) -> Bench {
    let mut bench = Bench::named(name).unwrap();
    let ideal = Bench::named("ideal").unwrap();
    bench.sensor = ideal.sensor;
    bench.sensor.zero_sigma_v = 0.0;
    bench.sensor.rc_tolerance = 0.0;
    bench.sensor.noise_g_per_sqrt_hz = 0.0;
    bench.hammer.zero_sigma_v = 0.0;
    bench.hammer.rc_tolerance = 0.0;
    bench.hammer.noise_n_per_sqrt_hz = 0.0;
    bench.adc.bits = 16;
    bench.operator.too_weak_rate = 0.0;
    bench.operator.too_hard_rate = 0.0;
    bench
}

fn modes(bench: &Bench) -> Vec<RigidMode> {
    loaded_modes(bench, &wheel_layout(), &no_errors(bench)).unwrap()
}

/// The analogue outputs after a tap of 100 N and 20 ms at a hit of the layout, minus those at rest.
fn tapped(bench: &Bench, layout: &HostLayout, dof: usize, scans: usize) -> (Tap, Vec<Channels>) {
    let mut simulation = Simulation::new(bench, layout, &no_errors(bench)).unwrap();
    simulation.reset(&mut ChaCha8Rng::seed_from_u64(2), ChaCha8Rng::seed_from_u64(3));
    let hit = &layout.hits[dof];
    let tap = Tap {
        dof,
        kind: TapKind::Good,
        point: hit.position.into(),
        direction: hit.direction.into(),
        tip: Tip::default(),
        gain_error: 0.0,
        contacts: vec![Contact { start: 0.01013, duration: 0.020, peak: 100.0 }],
    };
    let drives = [simulation.drive(bench, hit.dof.node, tap.clone()).unwrap()];
    let rest = simulation.scan_inputs(&drives).value;
    let record = (0..scans)
        .map(|_| simulation.scan_inputs(&drives).value)
        .map(|values| std::array::from_fn(|k| values[k] - rest[k]))
        .collect();
    (tap, record)
}

#[test]
fn with_a_tyre_there_are_twelve_modes_and_the_rim_stands_still_at_50_hz() {
    let bare = modes(&Bench::named("wheel").unwrap());
    let bench = Bench::named("wheel-with-tyre").unwrap();
    let part = bench.sprung_part.unwrap();
    let with_tyre = modes(&bench);
    assert_eq!((bare.len(), with_tyre.len()), (6, 12));
    let hz = |mode: &RigidMode| mode.omega / TAU;
    for (bare, mode) in bare.iter().zip(&with_tyre) {
        // Below its frequency the tyre's apparent mass is larger by (f/50)², so that a mode lies lower by half of
        // share (f/50)²; the next term is (f/50)⁴, 6e-4 at 7.7 Hz.
        let lower = 1.0 - 0.5 * part.share * (hz(bare) / 50.0).powi(2);
        assert!((hz(mode) / hz(bare) / lower - 1.0).abs() < 6e-4, "{} {}", hz(mode), hz(bare));
        assert!((mode.damping_ratio / bare.damping_ratio - 1.0).abs() < 0.03, "{mode:?}");
    }
    let against = 50.0 / (1.0 - part.share).sqrt();
    for mode in &with_tyre[6..] {
        // The suspension, softer by at least (7.7/50)², raises them by less than half of that times what the rest
        // has of the mode: (1 − share)⁻¹ − 1 = 1.08.
        let ratio = hz(mode) / against;
        assert!((1.0..1.013).contains(&ratio), "{}", hz(mode));
    }
    // The accelerance of the rim at a hit that is held by the tyre: an antiresonance at 50 Hz.
    let layout = wheel_layout();
    let largest = |hz: f64| {
        let h = frequency_responses(&bench, &layout, &[hz], 0.0, &ObjectExtras::default()).unwrap();
        h.iter().map(|h| h.norm()).fold(0.0, f64::max)
    };
    // 3 % of critical damping leave 2 · 0.03 of the rest's own accelerance at the antiresonance, and the
    // resonance is far above it.
    assert!(largest(50.0) < 0.15 * largest(1000.0), "{} {}", largest(50.0), largest(1000.0));
    assert!(largest(against) > 10.0 * largest(50.0));
}

#[test]
fn the_modes_with_a_tyre_are_mass_normalised() {
    // Over all twelve modes, the shapes of the rest give the inverse of its mass matrix.
    let bench = Bench::named("wheel-with-tyre").unwrap();
    let rest = bench.body.mass_matrix() * (1.0 - bench.sprung_part.unwrap().share);
    let sum: nalgebra::Matrix6<f64> =
        modes(&bench).iter().map(|mode| mode.shape * mode.shape.transpose()).sum();
    // Rounding of a 12 × 12 eigenproblem.
    assert!((rest * sum - nalgebra::Matrix6::identity()).norm() < 1e-10);
}

#[test]
fn scans_after_a_mallet_s_tap_have_the_frequency_responses_of_the_formula() {
    let layout = wheel_layout();
    let hz = [0.5, 2.0, 3.0, 5.0, 7.0, 9.0, 12.5, 30.0];
    // With a tyre the scans have modal damping, the formula a damper between rim and tyre. In a mode on the suspension
    // the two move against each other by at most (7.7/50)², of which 2 · 0.03 are 1.4e-3 in either of two modes that
    // the damper couples.
    for (name, tolerance) in [("wheel", 2e-4), ("wheel-with-tyre", 2.8e-3)] {
        let bench = quiet(name);
        let expected =
            frequency_responses(&bench, &layout, &hz, 0.0, &ObjectExtras::default()).unwrap();
        let expected: Vec<&[Complex<f64>]> = expected.chunks(layout.hits.len()).collect();
        for dof in 0..2 {
            // The lowest mode falls by e^−0.248 in a second: to 1e-5 after 46 s.
            let (_, record) = tapped(&bench, &layout, dof, 46 * 4000);
            for (bin, hz) in hz.into_iter().enumerate() {
                let s = Complex::new(0.0, TAU * hz);
                let spectra = laplace(&record, s, bench.adc.rate_hz);
                let at = |channel: usize| expected[9 * bin + channel][dof];
                let scale = (0..9).map(|k| at(k).norm()).fold(0.0, f64::max);
                for k in 0..9 {
                    let lead = (s * -((k + 1) as f64 * bench.adc.channel_delay_s)).exp();
                    let measured = spectra[k + 1] * lead / spectra[0];
                    let error = (measured - at(k)).norm() / scale;
                    assert!(error < tolerance, "{name} {hz} Hz, channel {k}: {error}");
                }
            }
        }
    }
}

#[test]
fn a_tap_leaves_the_velocity_of_its_impulse() {
    // So soft a suspension that the wheel is free during the 40 ms, and sensors that do not see it turn in gravity.
    let mut bench = quiet("wheel");
    bench.suspension = Suspension::Frequencies { hz: [0.01; 6], damping_ratio: 0.01 };
    let mut layout = wheel_layout();
    layout.sensors.iter_mut().for_each(|sensor| sensor.senses_gravity = false);
    for dof in 0..4 {
        let (tap, record) = tapped(&bench, &layout, dof, 160);
        let interval = bench.adc.rate_hz.recip();
        let sum = |k: usize| record.iter().map(|values| values[k]).sum::<f64>() * interval;
        // ∫ 100 N sin^1.5 over 20 ms.
        assert!((tap.impulse() - 1.112836).abs() < 1e-6);
        // The last scans are 9 ms after the tap: 29 times the low-pass's 0.32 ms.
        assert!((sum(0) / tap.impulse() - 1.0).abs() < 1e-6, "{}", sum(0));
        let moment = tap.point.cross(&tap.direction);
        let mass = bench.body.mass_matrix();
        for (k, velocity) in
            accelerance_to(&mass, &layout, tap.direction, moment).into_iter().enumerate()
        {
            // The damping takes 2 · 0.01 · 0.06/s for 40 ms: 5e-5.
            let error = sum(k + 1) - velocity * tap.impulse();
            assert!(error.abs() < 1e-4 * tap.impulse(), "{dof} {k}: {error}");
        }
        // Through the centre of mass 17.295 kg would move by impulse / mass.
        let center = accelerance_to(
            &mass,
            &layout,
            Vector3::x(),
            bench.body.center_of_mass.cross(&Vector3::x()),
        );
        assert!((center[0] * 17.295 - 1.0).abs() < 1e-12);
    }
}

#[test]
fn a_mallet_s_pulse_needs_no_finer_grid() {
    let layout = wheel_layout();
    let mut bench = quiet("wheel");
    let (_, coarse) = tapped(&bench, &layout, 0, 600);
    bench.adc.oversampling = 128;
    let (_, fine) = tapped(&bench, &layout, 0, 600);
    for (a, b) in coarse.iter().zip(&fine) {
        for (a, b) in a.iter().zip(b) {
            // The curvature of 100 N or 10 m/s² in 20 ms, (π/20 ms)² over 8 of the square of 1/64 ms: 8e-7. At the
            // ends of sin^1.5, where it is unbounded, 100 N (π · 1/64 ms / 20 ms)^1.5 = 0.012 N.
            assert!((a - b).abs() < 0.012, "{a} {b}");
        }
    }
}

/// The tap of an arming, and its scans.
fn tap_of(bench: &Bench, arming: u32, count: usize) -> (Tap, Vec<Scan>) {
    let mut source = BenchSource::new(bench, &wheel_layout(), 6).unwrap();
    source.armed(arming, 0);
    let record = scans(&mut source, count);
    (source.last_tap().unwrap().clone(), record)
}

#[test]
fn taps_of_the_wheel_s_bench_have_the_impulse_of_a_mallet_and_stay_in_range() {
    let mut bench = quiet("wheel");
    bench.operator.delay_s = 0.05;
    for arming in 0..40 {
        let (tap, record) = tap_of(&bench, arming, 600);
        assert!((0.8..1.3).contains(&tap.impulse()), "{}", tap.impulse());
        let per_newton = 0.0225 * 65536.0 / 3.0;
        let newtons = |scan: &Scan| (f64::from(scan[0]) - f64::from(record[0][0])) / per_newton;
        let measured = record.iter().map(newtons).sum::<f64>() / 4000.0;
        // The code at rest and those of the 84 scans of the pulse are rounded, each to half a code of 2 mN.
        assert!((measured - tap.impulse()).abs() < 4.3e-5, "{measured} {}", tap.impulse());
        assert!(record.iter().flatten().all(|code| (1..65535).contains(code)));
    }
}

#[test]
fn a_tap_may_be_too_weak_or_too_hard_by_its_impulse() {
    let mut bench = quiet("wheel");
    bench.operator.delay_s = 0.05;
    bench.operator.too_weak_rate = 0.5;
    bench.operator.too_hard_rate = 0.5;
    bench.operator.too_hard_n = [110.0, 120.0];
    bench.operator.too_hard_s = Some([0.025, 0.030]);
    let mut seen = [0, 0];
    for arming in 0..20 {
        let (tap, _) = tap_of(&bench, arming, 400);
        // 15 N for 4 ms to 25 N for 6 ms, and 110 N for 25 ms to 120 N for 30 ms, times 0.556.
        let (range, count) = match tap.kind {
            TapKind::TooWeak => (0.033..0.084, &mut seen[0]),
            _ => (1.53..2.01, &mut seen[1]),
        };
        assert!(range.contains(&tap.impulse()), "{:?} {}", tap.kind, tap.impulse());
        *count += 1;
    }
    assert!(seen.iter().all(|count| *count > 0), "{seen:?}");
    bench.operator.too_weak_s = None;
    for arming in 0..20 {
        let (tap, _) = tap_of(&bench, arming, 400);
        let [least, most] = bench.tap.duration_s;
        let duration = tap.contacts[0].duration;
        assert!(tap.kind != TapKind::TooWeak || (least..most).contains(&duration));
    }
}

#[test]
fn contacts_of_a_mallet_are_long_and_do_not_overlap() {
    let with = |change: fn(&mut Bench)| {
        let mut bench = quiet("wheel");
        bench.operator.delay_s = 0.05;
        change(&mut bench);
        tap_of(&bench, 1, 400).0
    };
    let good = with(|_| ());
    for change in
        [(|b| b.operator.double_rate = 1.0) as fn(&mut Bench), |b| b.operator.grazing_rate = 1.0]
    {
        let tap = with(change);
        let [first, second] = tap.contacts[..] else { panic!("not two contacts: {tap:?}") };
        assert!(second.start > first.end() && second.start < first.end() + 0.3, "{tap:?}");
    }
    let soft = with(|b| b.operator.soft_rate = 1.0);
    assert_eq!(soft.contacts[0].duration, 5.0 * good.contacts[0].duration);
}

#[test]
fn an_impatient_person_taps_while_the_wheel_still_swings() {
    let mut bench = quiet("wheel");
    let rms = |record: &[Scan]| -> [f64; 9] {
        std::array::from_fn(|k| {
            let mean =
                record.iter().map(|s| f64::from(s[k + 1])).sum::<f64>() / record.len() as f64;
            let square = |s: &Scan| (f64::from(s[k + 1]) - mean).powi(2);
            (record.iter().map(square).sum::<f64>() / record.len() as f64).sqrt()
        })
    };
    let total = |rms: [f64; 9]| rms.iter().map(|v| v * v).sum::<f64>().sqrt();
    bench.operator.delay_s = 4.0;
    let (good, patient) = tap_of(&bench, 3, 8 * 4000);
    // Nothing moves before the tap; 0.05 s after it begins the tap is over.
    assert!(total(rms(&patient[..15_900])) < 1e-9);
    let after = total(rms(&patient[16_200..]));
    bench.operator.impatient_rate = 1.0;
    bench.operator.impatient_share = [0.2, 0.2];
    let (tap, impatient) = tap_of(&bench, 3, 8 * 4000);
    assert_eq!(tap.kind, TapKind::Impatient);
    assert_eq!((tap.contacts, tap.point), (good.contacts, good.point));
    let before = total(rms(&impatient[..15_800]));
    // The modes beat once or twice in 4 s, the pulse of 20 ms moves the highest 3 % less than its impulse would, and
    // the tap is not of mean force: 10 %.
    assert!((before / after / 0.2 - 1.0).abs() < 0.2, "{before} {after}");
    // The second tap after an arming is a tap like all others.
    bench.operator.patience_s = 1.0;
    bench.operator.delay_s = 0.1;
    assert_eq!(tap_of(&bench, 3, 2 * 4000).0.kind, TapKind::Good);
}

#[test]
fn impatience_comes_at_its_rate() {
    let mut bench = quiet("wheel");
    bench.operator.delay_s = 0.01;
    bench.operator.impatient_rate = 0.3;
    let mut source = BenchSource::new(&bench, &wheel_layout(), 6).unwrap();
    let mut count = 0;
    for arming in 0..400 {
        source.armed(arming, 1);
        scans(&mut source, 50);
        count += u32::from(source.last_tap().unwrap().kind == TapKind::Impatient);
    }
    // 120 of 400, of which four standard deviations are 37.
    assert!((83..=157).contains(&count), "{count}");
}

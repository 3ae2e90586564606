//! The disturbances at conversion: drift, mains, nonlinearity, memory, clock and jitter.

use std::f64::consts::TAU;

use massline_shared::signal::Scan;
use nalgebra::Complex;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::physics::{no_errors, samples, tapped_with};
use super::{exact, scans, tapped, test_one};
use crate::bench::Bench;
use crate::chain::Chain;
use crate::channels::UNLIMITED;
use crate::error_sizes::ErrorSizes;
use crate::errors::TestErrors;
use crate::nonlinearity::Nonlinearity;
use crate::operator::BenchSource;
use crate::source::ScanSource;
use crate::taps::Tip;

/// As [`exact`], with 16 bits.
pub(super) fn fine(faults: &[&str]) -> Bench {
    let mut bench = exact(faults);
    bench.adc.bits = 16;
    bench
}

/// Codes of 16 bits per volt.
const PER_VOLT: f64 = 65536.0 / 3.0;

pub(super) fn volts(scan: &Scan) -> [f64; 10] {
    scan.map(|code| f64::from(code) / PER_VOLT)
}

#[test]
fn the_outputs_of_the_sensors_drift_from_the_arming_on() {
    let mut bench = fine(&[]);
    let good = tapped(&bench, &test_one(), 1);
    bench.sensor.drift_v_per_s = -0.2;
    let bad = tapped(&bench, &test_one(), 1);
    for (n, (bad, good)) in bad.iter().zip(&good).enumerate() {
        assert_eq!(bad[0], good[0], "a hammer does not drift");
        for k in 1..10 {
            let expected = -0.2 * n as f64 / 4000.0 * PER_VOLT;
            // Both codes are rounded, to a half each.
            let drifted = f64::from(bad[k]) - f64::from(good[k]);
            assert!((drifted - expected).abs() <= 1.0, "{n} {k}: {drifted} {expected}");
        }
    }
}

/// The hum of a bench: the difference of its scans to those without it, V.
fn hum(bench: &Bench, arming: u32) -> Vec<[f64; 10]> {
    let record = |bench: &Bench| {
        let mut source = BenchSource::new(bench, &test_one(), 6).unwrap();
        source.armed(arming, 1);
        scans(&mut source, 2080)
    };
    let mut still = bench.clone();
    still.mains.amplitude_v = 0.0;
    still.faults.clear();
    let pairs = record(bench).into_iter().zip(record(&still));
    pairs.map(|(bad, good)| std::array::from_fn(|k| volts(&bad)[k] - volts(&good)[k])).collect()
}

/// Amplitude and phase of a channel at a frequency over whole periods.
pub(super) fn component(record: &[[f64; 10]], channel: usize, hz: f64) -> Complex<f64> {
    let turn = |n: usize| Complex::new(0.0, -TAU * hz * n as f64 / 4000.0).exp();
    let sum: Complex<f64> =
        record.iter().enumerate().map(|(n, values)| turn(n) * values[channel]).sum();
    sum * 2.0 / record.len() as f64
}

#[test]
fn the_mains_hum_through_the_whole_record_at_each_channels_own_instant() {
    let mut bench = fine(&[]);
    bench.adc.channel_delay_s = 25e-6;
    bench.mains.amplitude_v = 0.02;
    bench.mains.harmonics = vec![0.0, 0.5];
    let record = hum(&bench, 3);
    // 80 scans are a period. The second half holds the tap and what follows it.
    for half in [&record[..1040], &record[1040..]] {
        let hammer = component(half, 0, 50.0);
        for k in 0..10 {
            let late = Complex::new(0.0, TAU * 50.0 * k as f64 * 25e-6).exp();
            // Rounding to a code of 46 µV repeats in every period of 80 scans: it gives a component an
            // error of 46 µV/√12 · √(2/80) = 2.1 µV, 1 σ; five times that is allowed.
            let tolerance = 1.05e-5;
            let first = component(half, k, 50.0);
            assert!((first.norm() - 0.02).abs() < tolerance, "{k}: {first}");
            assert!((first - hammer * late).norm() < tolerance, "{k}: {first} {hammer}");
            assert!(component(half, k, 100.0).norm() < tolerance);
            assert!((component(half, k, 150.0).norm() - 0.01).abs() < tolerance);
        }
    }
    // The third harmonic is fixed to the fundamental: sin 3a has three times the phase of sin a.
    let (one, three) = (component(&record, 0, 50.0), component(&record, 0, 150.0));
    let i = Complex::new(0.0, 1.0);
    let expected = (one / one.norm() * i).powi(3) / i * 0.01;
    // The error of the phase counts three times.
    assert!((three - expected).norm() < 2e-5, "{three} {expected}");
    // Two phases within 0.01 rad of each other have a chance of 0.3 %, and the seed is fixed.
    let again = component(&hum(&bench, 4), 0, 50.0);
    assert!((again - one).norm() > 0.01 * 0.02, "the phase is that of the arming");
}

#[test]
fn hum_as_a_fault_is_that_of_the_mains() {
    let mut bench = fine(&[]);
    bench.mains.amplitude_v = 0.005;
    let by_key = tapped(&bench, &test_one(), 1);
    assert!(by_key == tapped(&fine(&["hum:0.005"]), &test_one(), 1));
    assert!(by_key != tapped(&fine(&[]), &test_one(), 1));
}

#[test]
fn the_nonlinearity_is_a_sine_and_a_parabola_over_the_codes() {
    let mut bench = exact(&[]);
    let errors = no_errors(&bench);
    let codes = || (0..=4096).map(f64::from);
    let peak = |bench: &Bench| {
        let curve = Nonlinearity::new(bench, &errors);
        codes()
            .map(|code| curve.at(code))
            .fold([0.0_f64; 2], |[low, high], v| [low.min(v), high.max(v)])
    };
    bench.adc.inl_lsb = 4.0;
    let [low, high] = peak(&bench);
    // A code is 1/1365 of a period: the peaks are met to 3e-6 of their height.
    assert!((high - 4.0).abs() < 1e-4 && (low + 4.0).abs() < 1e-4, "{low} {high}");
    bench.adc.inl_lsb = 0.0;
    bench.adc.bow_lsb = -3.0;
    let curve = Nonlinearity::new(&bench, &errors);
    assert_eq!([0.0, 1024.0, 2048.0, 4096.0].map(|c| curve.at(c)), [0.0, -2.25, -3.0, 0.0]);
    assert_eq!([-100.0, 5000.0].map(|c| curve.at(c)), [0.0, 0.0], "beyond the ends there is none");
}

#[test]
fn codes_lie_on_the_curve_of_the_nonlinearity() {
    let mut bench = exact(&[]);
    let good = tapped(&bench, &test_one(), 1);
    bench.adc.inl_lsb = 20.0;
    bench.adc.bow_lsb = 10.0;
    let bad = tapped(&bench, &test_one(), 1);
    let errors = BenchSource::new(&bench, &test_one(), 6).unwrap().errors().clone();
    let curve = Nonlinearity::new(&bench, &errors);
    for (bad, good) in bad.iter().zip(&good) {
        for k in 0..10 {
            let code = f64::from(good[k]);
            // Both codes are rounded, to a half each, and the curve rises by up to
            // 20 · 6π/4096 = 0.09 per code.
            let error = f64::from(bad[k]) - code - curve.at(code);
            assert!(error.abs() <= 1.1, "{k}: {error}");
        }
    }
    let phase = |seed| BenchSource::new(&bench, &test_one(), seed).unwrap().errors().inl_phase;
    assert_ne!(phase(1), phase(2));
}

#[test]
fn each_voltage_keeps_a_share_of_the_one_before() {
    let mut bench = fine(&[]);
    let mut layout = test_one();
    layout.sensors.pop();
    let good = tapped(&bench, &layout, 1);
    bench.adc.memory = 0.03;
    let bad = tapped(&bench, &layout, 1);
    // With two sensors the scan ends with channel 6.
    let mut held = volts(&good[0])[6];
    for (n, (bad, good)) in bad.iter().zip(&good).enumerate() {
        for k in 0..=6 {
            held = 0.97 * volts(good)[k] + 0.03 * held;
            // Both codes are rounded, to a half each; what is kept of the error of others is 3 % more.
            // The rest voltage of channel 6 before the first scan has the memory's error of 3 % of 3 % of
            // 57 mV, one code of 46 µV.
            let tolerance = if n == 0 { 2.1 } else { 1.1 };
            let error = (volts(bad)[k] - held).abs() * PER_VOLT;
            assert!(error <= tolerance, "{n} {k}: {error}");
        }
    }
    // The hammer rests at 0.1 V and keeps 3 % of what channel 6 lies above it, 1.5 V and gravity.
    let leak = volts(&bad[100])[0] - volts(&good[100])[0];
    assert!((leak - 0.03 * (1.5 + 0.057 - 0.1)).abs() < 1e-4, "{leak}");
}

#[test]
fn a_slow_clock_scans_at_a_lower_rate_and_does_not_know_it() {
    let mut slow = exact(&[]);
    slow.adc.channel_delay_s = 10e-6;
    let mut equivalent_bench = slow.clone();
    slow.adc.clock_error = 0.01;
    equivalent_bench.adc.rate_hz /= 1.01;
    equivalent_bench.adc.channel_delay_s *= 1.01;
    let record = |bench: &Bench| tapped_with(bench, &test_one(), 1, Tip::default(), 800);
    for (slow, expected) in record(&slow).iter().zip(record(&equivalent_bench)) {
        for (a, b) in slow.iter().zip(expected) {
            // Rounding over 800 scans of up to 100 m/s².
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }
    let source = BenchSource::new(&slow, &test_one(), 6).unwrap();
    assert_eq!(source.adc().rate.0, 4000.0);
    assert_eq!(source.adc().channel_delay.0, 10e-6);
}

#[test]
fn a_slow_clock_sees_the_mains_and_the_drift_at_true_times() {
    let mut bench = fine(&[]);
    bench.mains.amplitude_v = 0.02;
    bench.adc.clock_error = 0.05;
    let record = hum(&bench, 3);
    // 1600 scans of 262.5 µs are 21 periods of 50 Hz, which seem to be 52.5 Hz.
    let seen = component(&record[..1600], 0, 52.5).norm();
    // Rounding to a code of 46 µV, averaged over 21 periods.
    assert!((seen - 0.02).abs() < 5e-6, "{seen}");
}

#[test]
fn jitter_moves_all_channels_of_a_scan_by_the_same_time() {
    let mut bench = fine(&[]);
    bench.adc.jitter_s = 1e-5;
    let errors = TestErrors::draw(
        &bench,
        &ErrorSizes::of_bench(&bench, 3, 0),
        &mut ChaCha8Rng::seed_from_u64(1),
    );
    let mut chain = Chain::new(&bench, &errors);
    let mut noise = ChaCha8Rng::seed_from_u64(7);
    chain.settle(&[0.0; 10], &mut noise, ChaCha8Rng::seed_from_u64(8));
    let mut sampled = chain.at_rest();
    sampled.value[0] = 20.0;
    // 1 σ is 10 N and 50 m/s².
    sampled.slope = std::array::from_fn(|k| if k == 0 { 1e6 } else { 5e6 });
    let delays: Vec<[f64; 2]> = (0..4000)
        .map(|_| volts(&chain.convert(&sampled, &UNLIMITED, &mut noise)))
        .map(|v| [((v[0] - 0.1) / 0.0225 - 20.0) / 1e6, (v[8] - 1.5) * 9.80665 / 0.057 / 5e6])
        .filter(|[hammer, _]| *hammer > -1.9e-5)
        .collect();
    for [hammer, sensor] in &delays {
        // A code of 46 µV is 2 mN and 8 mm/s².
        assert!((hammer - sensor).abs() < 4e-9, "{hammer} {sensor}");
    }
    let positive: Vec<f64> = delays.iter().map(|d| d[0]).filter(|d| *d > 0.0).collect();
    let sigma = (positive.iter().map(|d| d * d).sum::<f64>() / positive.len() as f64).sqrt();
    // The positive half of 4000 normal numbers determines σ to 1.6 %; four times that is allowed.
    assert!((sigma / 1e-5 - 1.0).abs() < 0.064, "{sigma}");
}

#[test]
fn slopes_are_those_of_the_values() {
    // A channel that is sampled 0.1 µs later reads what its slope says.
    let mut bench = exact(&[]);
    bench.adc.jitter_s = 1e-6;
    bench.adc.channel_delay_s = 10e-6;
    let [early, late] = [0.0, 1e-7].map(|later| {
        let mut bench = bench.clone();
        bench.adc.channel_delay_s += later;
        samples(&bench, &test_one(), 1, Tip::default(), 400)
    });
    let steepest = early.iter().flat_map(|s| s.slope).fold(0.0, |m: f64, v| m.max(v.abs()));
    for (early, late) in early.iter().zip(&late) {
        for k in 1..10 {
            let slope = (late.value[k] - early.value[k]) / (k as f64 * 1e-7);
            // Between two points of the grid the slope changes by the curvature times 0.9 µs: with the
            // third elastic mode of 641 Hz and a filter of 320 µs by less than a hundredth.
            assert!((slope - early.slope[k]).abs() < 0.01 * steepest, "{k}: {slope}");
        }
    }
}

#[test]
fn lost_scans_leave_the_others_as_they_are() {
    let whole = BenchSource::new(&fine(&[]), &test_one(), 4).unwrap();
    let mut bench = fine(&[]);
    bench.adc.lost_rate = 0.02;
    let gaps = BenchSource::new(&bench, &test_one(), 4).unwrap();
    let [whole, gaps] = [whole, gaps].map(|mut source| {
        source.armed(1, 0);
        scans(&mut source, 2000)
    });
    // Each scan that arrives is the next but a few of all.
    let mut remaining_scans = whole.iter();
    let arrived =
        gaps.iter().take_while(|scan| remaining_scans.any(|other| other == *scan)).count();
    let lost = whole.len() - arrived;
    // 40 of 2000, of which four standard deviations are 25.
    assert!((15..=65).contains(&lost), "{lost}");
}

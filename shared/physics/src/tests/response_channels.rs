//! The disturbances of response channels: rails, compression, missing capacitors, flat responses.

use massline_shared::STANDARD_GRAVITY;
use nalgebra::Complex;

use super::physics::{laplace, lines, rigid_accelerance, tapped_with};
use super::{exact, tapped, test_one};
use crate::bench::Bench;
use crate::operator::BenchSource;
use crate::source::ScanSource;
use crate::taps::{TapKind, Tip};

/// As [`exact`], with 16 bits.
fn fine(faults: &[&str]) -> Bench {
    let mut bench = exact(faults);
    bench.adc.bits = 16;
    bench
}

/// Codes of 16 bits per m/s² and per newton.
const PER_UNIT: f64 = 0.057 / STANDARD_GRAVITY * 65536.0 / 3.0;
const PER_NEWTON: f64 = 0.0225 * 65536.0 / 3.0;

#[test]
fn a_buffer_ends_at_its_rail_on_both_sides_of_its_rest_value() {
    // Sensor 2 is hit along z, which carries gravity at rest.
    for (fault, hit, channel, limit) in [
        ("rail:2z:15", "reverse:1", 6, 15.0 * PER_UNIT),
        ("rail:2z:15", "reverse:2", 6, 15.0 * PER_UNIT),
        ("rail:hammer:10", "reverse:2", 0, 10.0 * PER_NEWTON),
    ] {
        let good = tapped(&fine(&[hit]), &test_one(), 1);
        let bad = tapped(&fine(&[hit, fault]), &test_one(), 1);
        let rest = f64::from(good[0][channel]);
        let mut ends = [0, 0];
        for (bad, good) in bad.iter().zip(&good) {
            for k in (0..10).filter(|&k| k != channel) {
                assert_eq!(bad[k], good[k], "{fault} {k}");
            }
            let [bad, good] = [bad, good].map(|scan| f64::from(scan[channel]) - rest);
            // Both codes and the rest value are rounded, to a half each.
            assert!((bad - good.clamp(-limit, limit)).abs() <= 1.5, "{fault}: {bad} {good}");
            ends[0] += usize::from(good < -limit);
            ends[1] += usize::from(good > limit);
        }
        // The pulse of 4 ms is at least half as long above a rail at half its height: 8 scans. A reversed
        // second hit moves the sensor down.
        let down = usize::from(!(channel == 6 && hit == "reverse:2"));
        assert!(ends[down] >= 8, "{fault} {hit}: {ends:?}");
    }
}

#[test]
fn a_channel_that_compresses_reads_the_hyperbolic_tangent_of_its_input() {
    let record = |range_g: f64, faults: &[&str]| {
        let mut bench = fine(faults);
        bench.sensor.rc_cutoff_hz = 1e6;
        bench.sensor.range_g = range_g;
        tapped(&bench, &test_one(), 1)
    };
    // With a range of 3 g gravity alone is compressed by 0.35 m/s², also while the frame rings down.
    let (good, bad) = (record(100.0, &[]), record(3.0, &["compress:2z"]));
    let range = 3.0 * STANDARD_GRAVITY;
    let mut largest = 0.0_f64;
    for (bad, good) in bad.iter().zip(&good) {
        let input = (f64::from(good[6]) - 32768.0) / PER_UNIT;
        let output = (f64::from(bad[6]) - 32768.0) / PER_UNIT;
        // Both codes are rounded; the filter of 1 MHz follows with 0.16 µs, in which even 1e5 m/s³
        // change the input by 2 codes.
        let error = (output - range * (input / range).tanh()).abs() * PER_UNIT;
        assert!(error < 3.0, "{input} {output}");
        largest = largest.max(input);
    }
    assert!(largest > 1.5 * range, "the tap drives it far into compression: {largest}");
}

#[test]
fn compression_and_clipping_come_before_the_filter() {
    // A low cutoff turns the plateaus of the input into ramps.
    let bench = |fault: &[&str]| {
        let mut bench = fine(fault);
        bench.sensor.rc_cutoff_hz = 20.0;
        bench.sensor.range_g = 3.0;
        bench
    };
    let peak = |fault: &[&str]| {
        let record = tapped(&bench(fault), &test_one(), 1);
        record.iter().map(|s| i32::from(s[6]) - i32::from(record[0][6])).max().unwrap()
    };
    let (clipped, compressed) = (peak(&[]), peak(&["compress:2z"]));
    let end = 3.0 * STANDARD_GRAVITY * PER_UNIT;
    // A pulse of 4 to 6 ms through 8 ms reaches at most 1 − e^(−6/8) of the way to the end of the range,
    // which lies 2 g above the rest.
    assert!(f64::from(clipped) < 0.53 * (end * 2.0 / 3.0) && clipped > 0, "{clipped}");
    assert!(compressed < clipped && compressed > 0, "{compressed} {clipped}");
}

#[test]
fn missing_capacitors_give_each_axis_its_own_cutoff() {
    let mut bench = exact(&[]);
    bench.elastic.clear();
    let layout = test_one();
    let filtered = tapped_with(&bench, &layout, 2, Tip::default(), 4000);
    let nominal = bench.sensor.rc_cutoff_hz;
    let own = [1600.0, 1200.0, 550.0];
    bench.sensor.bandwidth_hz = Some(own);
    let open = tapped_with(&bench, &layout, 2, Tip::default(), 4000);
    for s in lines().step_by(9) {
        let a = laplace(&open, s, bench.adc.rate_hz);
        let b = laplace(&filtered, s, bench.adc.rate_hz);
        let pass = |cutoff: f64| (s / (std::f64::consts::TAU * cutoff) + 1.0).inv();
        // Aliasing of the samples: the pulse's spectrum above 3.9 kHz, a few 1e-5 of its mean, of which a
        // filter of 1.6 kHz passes three times as much as one of 497 Hz. The filters differ by 9 % at 64 Hz.
        let tolerance = 1e-4 * b[0].norm();
        assert!((a[0] - b[0]).norm() < 1e-12 * b[0].norm());
        for k in 1..10 {
            let expected: Complex<f64> = b[k] / pass(nominal) * pass(own[(k - 1) % 3]);
            assert!((a[k] - expected).norm() < tolerance, "{k} {s}: {} {expected}", a[k]);
        }
    }
}

#[test]
fn a_flat_tap_limits_the_strongest_channel_at_its_level() {
    let bench = |flat_rate: f64| {
        let mut bench = fine(&[]);
        bench.operator.too_weak_rate = 0.0;
        bench.operator.too_hard_rate = 0.0;
        bench.operator.flat_rate = flat_rate;
        bench.operator.flat_level = 0.6;
        bench
    };
    for dof in 0..3 {
        let good = tapped(&bench(0.0), &test_one(), dof);
        let bad = tapped(&bench(1.0), &test_one(), dof);
        let mut source = BenchSource::new(&bench(1.0), &test_one(), 6).unwrap();
        source.armed(1, dof);
        super::scans(&mut source, 1400);
        let tap = source.last_tap().unwrap();
        assert_eq!(tap.kind, TapKind::Flat);
        let rigid = rigid_accelerance(&bench(1.0), &test_one(), dof);
        let strongest = (0..9).max_by(|&a, &b| rigid[a].abs().total_cmp(&rigid[b].abs())).unwrap();
        let limit = 0.6 * rigid[strongest].abs() * tap.contacts[0].peak * PER_UNIT;
        let mut limited = 0;
        for (bad, good) in bad.iter().zip(&good) {
            for k in (0..10).filter(|&k| k != 1 + strongest) {
                assert_eq!(bad[k], good[k], "{dof} {k}");
            }
            let rest = 32768.0 + if strongest % 3 == 2 { STANDARD_GRAVITY * PER_UNIT } else { 0.0 };
            let [bad, good] = [bad, good].map(|scan| f64::from(scan[1 + strongest]) - rest);
            // Both codes are rounded, to a half each.
            assert!((bad - good.clamp(-limit, limit)).abs() <= 1.0, "{dof}: {bad} {good}");
            limited += usize::from(good.abs() > limit);
        }
        // sin^1.5 is above 0.6 over half of the pulse of at least 4 ms: 8 scans.
        assert!(limited >= 8, "{dof}: {limited}");
    }
}

//! A disturbance changes nothing but itself, and without one the scans are those of before.

use super::{exact, scans, test_one};
use crate::bench::Bench;
use crate::operator::BenchSource;
use crate::source::ScanSource;
use massline_shared::signal::{CHANNELS, Scan};

/// A change of a bench.
type Change = fn(&mut Bench);

fn fault(bench: &mut Bench, text: &str) {
    bench.faults.push(text.parse().unwrap());
}

/// Every disturbance.
const ALL: [(&str, Change); 43] = [
    ("node", |b| fault(b, "node:2x:0.05")),
    ("lean", |b| fault(b, "lean:2:0.2")),
    ("turn", |b| fault(b, "turn:0.2")),
    ("height", |b| fault(b, "height:0.05")),
    ("pad", |b| fault(b, "pad:0.1")),
    ("rail:2z", |b| fault(b, "rail:2z:20")),
    ("rail:hammer", |b| fault(b, "rail:hammer:10")),
    ("hammer", |b| fault(b, "hammer:0.9")),
    ("hit_gain_sigma", |b| b.hammer.hit_gain_sigma = 0.1),
    ("gain_error", |b| b.hammer.gain_error = -0.1),
    ("beside", |b| fault(b, "beside:2:0.02")),
    ("offset_m", |b| b.tap.offset_m = 0.02),
    ("mark_position_sigma_m", |b| b.tap.mark_position_sigma_m = 0.02),
    ("mark_direction_sigma_rad", |b| b.tap.mark_direction_sigma_rad = 0.2),
    ("free_moment_m", |b| b.tap.free_moment_m = 0.02),
    ("lateral", |b| b.tap.lateral = 0.2),
    ("flat_rate", |b| b.operator.flat_rate = 1.0),
    ("boards", |b| fault(b, "boards:0.05")),
    ("board_mass_kg", |b| b.sensor.board_mass_kg = 0.05),
    ("cable", |b| fault(b, "cable:2:4000")),
    ("bandwidth_hz", |b| b.sensor.bandwidth_hz = Some([1600.0, 1600.0, 550.0])),
    ("jitter_s", |b| b.adc.jitter_s = 2e-5),
    ("compress", |b| fault(b, "compress:2z")),
    ("drift_v_per_s", |b| b.sensor.drift_v_per_s = 0.1),
    ("inl_lsb", |b| b.adc.inl_lsb = 5.0),
    ("bow_lsb", |b| b.adc.bow_lsb = 5.0),
    ("memory", |b| b.adc.memory = 0.02),
    ("amplitude_v", |b| b.mains.amplitude_v = 0.02),
    ("hum", |b| fault(b, "hum:0.02")),
    ("ripple_v", |b| b.supply.ripple_v = 0.02),
    ("droop_v", |b| (b.supply.droop_v, b.supply.droop_rate_per_s) = (0.05, 20.0)),
    ("clock_error", |b| b.adc.clock_error = 0.01),
    ("rc_error", |b| b.hammer.rc_error = 0.2),
    ("lost_rate", |b| b.adc.lost_rate = 0.01),
    ("noise_corner_hz", |b| b.sensor.noise_corner_hz = 5.0),
    ("dnl_lsb", |b| b.adc.dnl_lsb = 1.0),
    ("wander_v", |b| b.sensor.wander_v = 0.02),
    ("draught_n", |b| b.environment.draught_n = 0.5),
    ("creak_n_s", |b| (b.environment.creak_rate_per_s, b.environment.creak_n_s) = (20.0, 0.01)),
    ("drift:hammer", |b| fault(b, "drift:hammer:0.5")),
    ("drift:2y", |b| fault(b, "drift:2y:0.5")),
    ("impatient_rate", |b| b.operator.impatient_rate = 1.0),
    ("gravity_tilt_sigma_rad", |b| b.gravity_tilt_sigma_rad = 0.1),
];

/// How many of these, from the first, leave an object at rest without noise alone.
const QUIET_AT_REST: usize = 22;

fn without_bad_taps() -> Bench {
    let mut bench = Bench::named("default").unwrap();
    bench.operator.too_weak_rate = 0.0;
    bench.operator.too_hard_rate = 0.0;
    bench
}

fn record(bench: &Bench, count: usize) -> (BenchSource, Vec<Scan>) {
    let mut source = BenchSource::new(bench, &test_one(), 9).unwrap();
    source.armed(2, 1);
    let record = scans(&mut source, count);
    (source, record)
}

#[test]
fn the_default_bench_gives_the_scans_that_it_gave_before_it_had_disturbances() {
    let bench = Bench::named("default").unwrap();
    let mut source = BenchSource::new(&bench, &test_one(), 3).unwrap();
    source.armed(4, 1);
    let record = scans(&mut source, 2400);
    let sums: Vec<i64> =
        (0..CHANNELS).map(|k| record.iter().map(|s| i64::from(s[k])).sum()).collect();
    // Computed by commit 3513ce2, the last one without disturbances.
    let before =
        [327702, 4869950, 4710540, 5165278, 5114995, 4747415, 5132864, 4713951, 4873398, 5220353];
    for (k, (sum, before)) in sums.iter().zip(before).enumerate() {
        // Another mathematical library may round a few of the 2400 codes differently; other noise would
        // change the sum by some 50.
        assert!((sum - before).abs() <= 5, "{k}: {sum} {before}");
    }
}

#[test]
fn a_disturbance_changes_neither_errors_nor_taps() {
    let bench = without_bad_taps();
    let (good, good_record) = record(&bench, 1400);
    let good_tap = good.last_tap().unwrap();
    for (name, change) in ALL {
        let mut bench = bench.clone();
        change(&mut bench);
        let (bad, bad_record) = record(&bench, 1400);
        assert!(bad_record != good_record, "{name} has no effect");
        let mut errors = bad.errors().clone();
        (errors.hammer_gain, errors.rc[0]) = (good.errors().hammer_gain, good.errors().rc[0]);
        errors.gravity_turn = good.errors().gravity_turn;
        assert_eq!(&errors, good.errors(), "{name}");
        let tap = bad.last_tap().unwrap();
        assert_eq!(tap.contacts, good_tap.contacts, "{name}");
        if name.starts_with("mark_") || ["lean", "turn"].contains(&name) {
            continue;
        }
        assert_eq!(tap.direction, good_tap.direction, "{name}");
        let moved = (tap.point - good_tap.point).norm();
        let expected = match name {
            "beside" | "offset_m" => 0.02,
            "node" => 0.05,
            _ => 0.0,
        };
        // Rounding of coordinates of 0.2 m.
        assert!((moved - expected).abs() < 1e-15, "{name}: {moved}");
    }
}

#[test]
fn a_disturbance_leaves_the_noise_alone() {
    let bench = without_bad_taps();
    // The tap comes after 1200 scans.
    let (_, good) = record(&bench, 1190);
    for (name, change) in ALL.into_iter().take(QUIET_AT_REST) {
        let mut bad = bench.clone();
        change(&mut bad);
        let changed = record(&bad, 1190).1;
        if name == "bandwidth_hz" {
            // More of the noise passes; the hammer has the same filter as before.
            assert!(changed.iter().zip(&good).all(|(a, b)| a[0] == b[0]), "{name}");
        } else {
            assert!(changed == good, "{name}");
        }
    }
}

#[test]
fn what_is_added_at_conversion_is_the_same_with_and_without_noise() {
    let noisy = |noise: f64| {
        let mut bench = exact(&[]);
        // 16 bits resolve the noise.
        bench.adc.bits = 16;
        bench.sensor.noise_g_per_sqrt_hz = noise;
        bench
    };
    for (name, change) in ALL.into_iter().skip(QUIET_AT_REST) {
        // The first four depend on the value, noise included; the noise depends on the others.
        let excepted = [
            "inl_lsb",
            "bow_lsb",
            "dnl_lsb",
            "compress",
            "clock_error",
            "rc_error",
            "lost_rate",
            "noise_corner_hz",
        ];
        if excepted.contains(&name) {
            continue;
        }
        let added = |noise: f64| {
            let (good, mut bad) = (noisy(noise), noisy(noise));
            change(&mut bad);
            let (good, bad) = (record(&good, 1000).1, record(&bad, 1000).1);
            let pairs = bad.into_iter().zip(good);
            pairs.map(|(a, b)| a.map(i32::from)[4] - i32::from(b[4])).collect::<Vec<_>>()
        };
        for (quiet, noisy) in added(0.0).into_iter().zip(added(300e-6)) {
            // Four codes are rounded, to a half each; the memory takes 2 % of the noise of 11 codes, of
            // which 4 σ are one code.
            assert!((quiet - noisy).abs() <= 3, "{name}: {quiet} {noisy}");
        }
    }
}

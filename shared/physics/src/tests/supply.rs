//! Ripple and droops of the supply.

use std::f64::consts::TAU;

use nalgebra::Complex;

use super::converter::{component, fine, volts};
use super::{scans, test_one};
use crate::bench::Bench;
use crate::operator::BenchSource;
use crate::source::ScanSource;

/// Time constant of the sensors' low-passes, s: that of 32 kΩ and 10 nF.
const TAU_S: f64 = 3.2e-4;
/// Interval of the scans, s.
const SCAN_S: f64 = 2.5e-4;

/// A bench with codes of 16 bits on which nobody taps, with a supply of 3 V.
fn still() -> Bench {
    let mut bench = fine(&[]);
    bench.operator.delay_s = 100.0;
    bench.supply.voltage_v = 3.0;
    bench
}

fn record(bench: &Bench, count: usize) -> Vec<[f64; 10]> {
    let mut source = BenchSource::new(bench, &test_one(), 6).unwrap();
    source.armed(3, 1);
    scans(&mut source, count).iter().map(volts).collect()
}

#[test]
fn a_ripple_reads_as_what_a_channel_does_not_follow() {
    let mut bench = still();
    bench.hammer.zero_v = 1.0;
    let rest = record(&bench, 1)[0];
    (bench.supply.ripple_v, bench.supply.ripple_hz) = (0.02, 100.0);
    bench.supply.ripple_harmonics = vec![0.0, 0.5];
    // 40 scans are a period.
    let record = record(&bench, 2080);
    for (hz, amplitude) in [(100.0, 0.02), (200.0, 0.0), (300.0, 0.01)] {
        let hammer = component(&record, 0, hz);
        let expected = rest[0] * amplitude / 3.0;
        // 1/(1 + e) is 1 - e but for e², whose half is 2e-5 of the voltage, at the sums and differences of the
        // frequencies; rounding to a code of 46 µV, which repeats in every period, gives 46 µV/√12 · √(2/40) = 3 µV, 1
        // σ.
        assert!((hammer.norm() - expected).abs() < 5e-5, "{hz} Hz: {hammer} {expected}");
        let turn = Complex::new(0.0, TAU * hz * TAU_S);
        for (k, rest_of) in rest.iter().enumerate().skip(1) {
            // The hammer reads -e, a sensor 1/(1 + iωτ) - 1 of e.
            let expected = hammer * (rest_of / rest[0]) * turn / (turn + 1.0);
            let read = component(&record, k, hz);
            assert!((read - expected).norm() < 5e-5, "{hz} Hz, {k}: {read} {expected}");
        }
    }
    let mut other = bench.clone();
    (other.supply.ripple_hz, other.supply.ripple_harmonics) = (94.0, Vec::new());
    // 47 periods.
    let record = self::record(&other, 2000);
    assert!((component(&record, 0, 94.0).norm() - rest[0] * 0.02 / 3.0).abs() < 5e-5);
    assert!(component(&record, 0, 100.0).norm() < 5e-5);
}

/// `boards/POWER.md`: 10 mA peak to peak in 0.5 Ω are 5 mV, which read as 3.2 mg rms.
#[test]
fn a_screen_on_the_supply_of_the_sensors_reads_as_computed() {
    let mut bench = still();
    (bench.supply.voltage_v, bench.supply.ripple_v) = (3.3, 2.5e-3);
    (bench.sensor.zero_v, bench.adc.reference_v) = (1.65, 3.3);
    // Amplitudes of 0.25 mV are found in codes of 50 µV by their mean over the noise.
    bench.sensor.noise_g_per_sqrt_hz = 300e-6;
    let record = record(&bench, 40_000);
    for k in 1..10 {
        // Volts of `record` are those of a reference of 3.0 V.
        let rms = 1.1 * component(&record, k, 105.0).norm() / 2.0_f64.sqrt() / 0.057;
        // Gravity takes a sensor 57 mV from the middle, which is 3.5 %; noise of 8 mg over 10 s leaves
        // 8 mg · √(2/40000) = 0.06 mg, 1 σ, of the amplitude, its rms 0.04 mg.
        assert!((rms - 3.2e-3).abs() < 0.035 * 3.2e-3 + 1.6e-4, "{k}: {rms}");
    }
}

/// What a sensor reads over its rest at a time after the beginning of a sag, by small steps of the low-pass's equation.
fn sensor_after(since: f64, depth: f64, recovery: f64) -> f64 {
    const STEPS: u32 = 20_000;
    let h = since / f64::from(STEPS);
    let sag = |time: f64| -depth * (-time / recovery).exp();
    let followed = (0..STEPS).fold(0.0, |followed, n| {
        let middle = sag((f64::from(n) + 0.5) * h);
        // The midpoint rule.
        let half = followed + 0.5 * h / TAU_S * (sag(f64::from(n) * h) - followed);
        followed + h / TAU_S * (middle - half)
    });
    (1.0 + followed) / (1.0 + sag(since))
}

#[test]
fn a_droop_recovers_and_reads_until_the_sensor_has_followed() {
    const DEPTH: f64 = 0.1;
    // The last is the low-pass's own time.
    for recovery in [5e-3, 1e-3, TAU_S] {
        let mut bench = still();
        bench.hammer.zero_v = 2.5;
        let rest = record(&bench, 1)[0];
        (bench.supply.droop_v, bench.supply.droop_s) = (3.0 * DEPTH, recovery);
        bench.supply.droop_rate_per_s = 4.0;
        let record = record(&bench, 80_000);
        let sags: Vec<f64> = record.iter().map(|scan| 1.0 - rest[0] / scan[0]).collect();
        let begins: Vec<_> =
            (1..sags.len() - 8).filter(|&n| sags[n] > 0.02 && sags[n - 1] < 3e-5).collect();
        // 80 in 20 s, 1 σ of 9; some come before the last has recovered.
        assert!((40..=115).contains(&begins.len()), "{recovery}: {}", begins.len());
        for &n in &begins {
            // It began within the interval before this scan. Both codes are rounded, by 23 µV of 2.5 V: 2e-5.
            let before = recovery * (DEPTH / sags[n]).ln();
            let uncertain = recovery * 2e-5 / sags[n];
            assert!(before > -uncertain && before < SCAN_S + uncertain, "{before}");
            for later in (0..8).take_while(|&later| sags[n + later] <= sags[n]) {
                let since = before + later as f64 * SCAN_S;
                let expected = DEPTH * (-since / recovery).exp();
                assert!((sags[n + later] - expected).abs() < 4e-5, "{recovery} {n} {later}");
                // A sensor moves by its voltage times the depth in the time of its low-pass; its code and that at
                // rest are rounded, and 3e-5 of the sag before may be left.
                let tolerance = 1.1e-4 + 1.6 * DEPTH / TAU_S * uncertain;
                let over_rest = sensor_after(since.max(0.0), DEPTH, recovery);
                for k in 1..10 {
                    let (read, expected) = (record[n + later][k], rest[k] * over_rest);
                    assert!(
                        (read - expected).abs() < tolerance,
                        "{recovery} {n} {later} {k}: {read} {expected}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_droop_at_a_rate_of_zero_and_a_rate_of_nothing_change_no_code() {
    let good = record(&still(), 400);
    let mut rare = still();
    rare.supply.droop_v = 0.1;
    let mut shallow = still();
    shallow.supply.droop_rate_per_s = 50.0;
    assert!(record(&rare, 400) == good && record(&shallow, 400) == good);
}

#[test]
fn the_phase_of_a_ripple_is_that_of_the_arming() {
    let mut bench = still();
    (bench.supply.ripple_v, bench.supply.ripple_hz) = (0.02, 100.0);
    bench.hammer.zero_v = 1.0;
    let [one, two] = [3, 4].map(|arming| {
        let mut source = BenchSource::new(&bench, &test_one(), 6).unwrap();
        source.armed(arming, 1);
        let record: Vec<_> = scans(&mut source, 2000).iter().map(volts).collect();
        component(&record, 0, 100.0)
    });
    // Two phases within 0.02 rad of each other have a chance of 0.6 %, and the seed is fixed.
    assert!((one - two).norm() > 0.02 * one.norm(), "{one} {two}");
}

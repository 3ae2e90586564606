//! Tests of the spectra of single hits.

use super::*;
use crate::signal::tests::{ADC, code};
use crate::signal::{PRE_TRIGGER_SCANS, RECORD_SCANS, Record, Scan};
use core::f64::consts::PI;
use proptest::prelude::*;
use std::boxed::Box;
use std::vec;
use std::vec::Vec;

const BINS: usize = 128;

fn zeros<R: Real>() -> [Complex<R>; BINS] {
    [Complex::new(R::zero(), R::zero()); BINS]
}

/// A tap of 5 ms and 1 N that begins at 0.02 s: cos⁴ about its middle, smooth enough for sampling at 4
/// kS/s without aliasing (its spectrum is below 1e-6 at 2 kHz).
fn tap(t: f64) -> f64 {
    let from_middle = (t - 0.0225) / 0.005;
    if from_middle.abs() < 0.5 { (PI * from_middle).cos().powi(4) } else { 0.0 }
}

/// The hammer and nine responses `(k+1) · tap`, each sampled `k τ` after the hammer.
fn multiplexed(delay: f64) -> Vec<Vec<f64>> {
    (0..CHANNELS)
        .map(|k| {
            let at = |n| n as f64 / 4000.0 + k as f64 * delay;
            (0..RECORD_SCANS).map(|n| k.max(1) as f64 * tap(at(n))).collect()
        })
        .collect()
}

/// Largest relative error of H over responses and lines up to 120 Hz.
fn worst_error<R: RealFft>(sampled: f64, corrected: f64) -> f64 {
    let signals: Vec<Vec<R>> = multiplexed(sampled)
        .iter()
        .map(|channel| channel.iter().map(|&x| R::of(x)).collect())
        .collect();
    let record: [&[R]; CHANNELS] = core::array::from_fn(|k| signals[k].as_slice());
    let analysis = HitAnalysis::of_signals(
        R::of(4000.0),
        R::of(corrected),
        [Signal::new(R::one(), R::zero()); CHANNELS],
        &TestSettings::default(),
        PRE_TRIGGER_SCANS,
    );
    let mut scratch = vec![R::zero(); RECORD_SCANS];
    let (mut force, mut lines) = (zeros(), zeros());
    analysis.force(&record, &mut scratch, &mut force).unwrap();
    let mut worst = 0.0_f64;
    for response in 0..CHANNELS - 1 {
        analysis.response(&record, response, &mut scratch, &mut lines).unwrap();
        divide_by_force(&mut lines, &force);
        let truth = (response + 1) as f64;
        for line in &lines[..62] {
            let error = Complex::new(line.re.to_f64() - truth, line.im.to_f64()).norm() / truth;
            worst = worst.max(error);
        }
    }
    worst
}

#[test]
fn the_delay_is_taken_out_and_the_other_sign_doubles_it() {
    let delay = 25e-6;
    // Effect of nine delays at line 61, 119 Hz: |e^{skτ} − 1|.
    let turned = Complex::new(10.0, 2.0 * PI * 61.0 * 4000.0 / 2048.0) * (9.0 * delay);
    let uncorrected = worst_error::<f64>(delay, 0.0);
    assert!((uncorrected / turned.norm() - 1.0).abs() < 0.01, "{uncorrected}");
    // Only aliasing of the tap remains in f64, and rounding of the transforms in f32.
    assert!(worst_error::<f64>(delay, delay) < 1e-6);
    assert!(worst_error::<f32>(delay, delay) < 1e-5);
    // With the opposite sign the error is |e^{2skτ} − 1|, twice as large but for the curvature of the
    // exponential.
    let other_sign = worst_error::<f64>(delay, -delay);
    assert!((other_sign / uncorrected - 2.0).abs() < 0.02, "{other_sign}");
}

/// Output of a first-order low-pass with the cutoff `f`, simulated at 64 times the sampling rate with the
/// exact step for an input that is linear between two samples.
fn low_passed(cutoff: f64, signal: impl Fn(f64) -> f64) -> Vec<f64> {
    const FINER: usize = 64;
    let step = 1.0 / (4000.0 * FINER as f64);
    let tau = 1.0 / (2.0 * PI * cutoff);
    let keep = (-step / tau).exp();
    let slope = (step - tau * (1.0 - keep)) / step;
    let (mut out, mut read) = (0.0, Vec::new());
    for n in 0..RECORD_SCANS * FINER {
        if n % FINER == 0 {
            read.push(out);
        }
        let t = n as f64 * step;
        out = keep * out + (1.0 - keep - slope) * signal(t) + slope * signal(t + step);
    }
    read
}

/// Largest relative error of H up to 120 Hz for a response equal to the force, both low-passed.
fn low_pass_error<R: RealFft>(cutoffs: [f64; 2], corrected: [f64; 2]) -> f64 {
    let signals =
        cutoffs.map(|cutoff| low_passed(cutoff, tap).into_iter().map(R::of).collect::<Vec<R>>());
    let record = [&signals[0][..], &signals[1][..]];
    let test = TestSettings { force_window_s: R::of(0.4), ..TestSettings::default() };
    let channels = corrected.map(|cutoff| Signal::new(R::one(), R::of(cutoff)));
    let analysis = HitAnalysis::of_signals(R::of(4000.0), R::zero(), channels, &test, 40);
    let mut scratch = vec![R::zero(); RECORD_SCANS];
    let (mut force, mut lines) = (zeros(), zeros());
    analysis.force(&record, &mut scratch, &mut force).unwrap();
    analysis.response(&record, 0, &mut scratch, &mut lines).unwrap();
    divide_by_force(&mut lines, &force);
    let error = |h: &Complex<R>| Complex::new(h.re.to_f64() - 1.0, h.im.to_f64()).norm();
    lines[..62].iter().map(error).fold(0.0, f64::max)
}

#[test]
fn low_passes_of_different_corners_are_taken_out_in_amplitude_and_phase() {
    let cutoffs = [497.4, 340.0];
    // s/ω of both cutoffs at line 61, 119 Hz, with σ = 10 1/s.
    let s = Complex::new(10.0, 2.0 * PI * 61.0 * 4000.0 / 2048.0);
    let [hammer, sensor] = cutoffs.map(|cutoff| s / (2.0 * PI * cutoff) + 1.0);
    let uncorrected = low_pass_error::<f64>(cutoffs, [0.0, 0.0]);
    assert!((uncorrected / (hammer / sensor - 1.0).norm() - 1.0).abs() < 1e-3, "{uncorrected}");
    // The remaining error in f64 comes from the tap between the fine samples, (π/5 ms · 4 µs)²/12 = 5e-7.
    assert!(low_pass_error::<f64>(cutoffs, cutoffs) < 1e-6);
    assert!(low_pass_error::<f32>(cutoffs, cutoffs) < 1e-5);
    // Swapped cutoffs double the error, as a wrong phase would.
    let wrong = low_pass_error::<f64>(cutoffs, [cutoffs[1], cutoffs[0]]);
    assert!((wrong / uncorrected - 2.0).abs() < 0.2, "{wrong}");
    // Equal low-passes on both cancel.
    assert!(low_pass_error::<f64>([497.4; 2], [0.0; 2]) < 1e-12);
}

/// One line of a channel's spectrum by the definition.
fn by_definition(x: &[f64], rate: f64, decay: f64, line: usize, points: usize) -> Complex<f64> {
    let s = Complex::new(decay, 2.0 * PI * line as f64 * rate / points as f64);
    let sum: Complex<f64> =
        x.iter().enumerate().map(|(n, &x)| (-s * (n as f64 / rate)).exp() * x).sum();
    sum / rate
}

#[test]
fn the_lines_are_those_of_the_definition_also_when_zeros_follow() {
    let signals = multiplexed(0.0);
    let test = TestSettings { force_window_s: 1.0, ..TestSettings::default() };
    let analysis =
        HitAnalysis::of_signals(4000.0, 0.0, [Signal::new(2.0, 0.0); CHANNELS], &test, 80);
    let (mut force, mut lines) = (zeros::<f64>(), zeros());
    for scans in [540, 1024, 2000] {
        let record: [&[f64]; CHANNELS] = core::array::from_fn(|k| &signals[k][..scans]);
        let mut scratch = vec![7.0; 2048];
        analysis.force(&record, &mut scratch, &mut force).unwrap();
        analysis.response(&record, 4, &mut scratch, &mut lines).unwrap();
        for line in [0, 1, 61, 127] {
            let expected = by_definition(record[0], 4000.0, 10.0, line, 2048) * 2.0;
            // The tolerance covers rounding of 2048 terms, the largest of which is one.
            assert!((force[line] - expected).norm() < 1e-15);
            assert!((lines[line] - expected * 5.0).norm() < 5e-15);
        }
    }
}

#[test]
fn a_record_longer_than_the_transform_is_refused() {
    let record = [[0; CHANNELS]; 5];
    let analysis = HitAnalysis::<f64>::new(
        &ADC,
        &Calibration::default(),
        &TestSettings::default(),
        PRE_TRIGGER_SCANS,
    );
    let got = analysis.force(&record[..], &mut [0.0; 4], &mut []);
    assert_eq!(got, Err(FftError::RecordTooLong));
    // A channel that does not exist reads its rest value.
    let mut lines = zeros();
    analysis.response(&record[..], usize::MAX, &mut [1.0; 256], &mut lines).unwrap();
    assert_eq!(lines, zeros());
}

#[test]
fn codes_and_physical_signals_give_the_same_lines() {
    let mut record = Box::new(Record::new());
    let signals = multiplexed(0.0);
    // The strongest response peaks at 180 m/s², within the ADC's range.
    let at = |k: usize, n: usize| 20.0 * signals[k][n] as f32;
    (0..RECORD_SCANS).for_each(|n| record.push(&core::array::from_fn(|k| code(k, at(k, n)))));
    let test = TestSettings::default();
    let analysis = HitAnalysis::<f32>::new(&ADC, &Calibration::default(), &test, 80);
    let mut scratch = [0.0; RECORD_SCANS];
    let (mut force, mut lines) = (zeros(), zeros());
    analysis.force(&*record, &mut scratch, &mut force).unwrap();
    for response in 0..CHANNELS - 1 {
        analysis.response(&*record, response, &mut scratch, &mut lines).unwrap();
        divide_by_force(&mut lines, &force);
        let truth = (response + 1) as f32;
        // A tap has some ten readings, each with an error of a third of a code: 0.033 N of 20 N for the
        // force, 0.13 m/s² of 20 m/s² for the weakest response, over a mean of half the peak.
        let error = (lines[10].re / truth - 1.0).abs();
        assert!(error < 5e-3, "{response}: {error}");
    }
}

fn any_code() -> impl Strategy<Value = u16> {
    prop_oneof![Just(0), Just(4095), Just(u16::MAX), 0_u16..4096]
}

fn all_finite(record: &[Scan]) -> bool {
    let test = TestSettings::default();
    let analysis = HitAnalysis::<f32>::new(&ADC, &Calibration::default(), &test, 80);
    let mut spectra = super::super::Spectra::<f32, 9, BINS>::new();
    let mut scratch = vec![0.0; 2048];
    let (mut force, mut lines) = (zeros(), zeros());
    analysis.force(record, &mut scratch, &mut force).unwrap();
    spectra.add_force(&force);
    let mut finite = true;
    let is_finite = |h: Complex<f32>| h.re.is_finite() && h.im.is_finite();
    for response in 0..9 {
        analysis.response(record, response, &mut scratch, &mut lines).unwrap();
        spectra.add_response(response, &force, &lines);
        divide_by_force(&mut lines, &force);
        finite &= lines.iter().all(|&h| is_finite(h));
        finite &= (0..BINS).all(|line| {
            is_finite(spectra.h1(response, line))
                && (0.0..=1.0).contains(&spectra.coherence(response, line))
        });
    }
    finite
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn nan_never_comes_of_any_codes(
        scans in prop::collection::vec(prop::array::uniform10(any_code()), 0..300),
    ) {
        prop_assert!(all_finite(&scans));
    }
}

#[test]
fn nan_never_comes_of_constant_codes() {
    for (hammer, rest) in [(0, 0), (4095, 4095), (0, 4095), (4095, 0), (137, 2048)] {
        let mut scan = [rest; CHANNELS];
        scan[0] = hammer;
        let mut record = vec![scan; RECORD_SCANS];
        assert!(all_finite(&record));
        // The records differ by one code in one scan.
        record[500][0] ^= 1;
        record[700][3] ^= 1;
        assert!(all_finite(&record));
    }
}

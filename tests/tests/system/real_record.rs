//! The signal chain on hammer data recorded by a third party, against NumPy on the same samples.

use massline_shared::layout::TestSettings;
use massline_shared::signal::{EdgeTrigger, HitAnalysis, Signal, Spectra};
use nalgebra::Complex;

const SEGMENTS: usize = 5;
const SAMPLES: usize = 4608;
const GOOD: [usize; 3] = [1, 3, 4];
const RATE: f64 = 51_200.0;
/// Length of the record of a hit, samples; a segment has 49 samples before the hit.
const POINTS: usize = 2048;
const PRE_TRIGGER: usize = 40;
const LEVEL: f64 = 3.0;
const BINS: usize = 256;

/// Force, N, and response, m/s², of a segment.
struct Segment {
    force: Vec<f64>,
    response: Vec<f64>,
}

fn segments() -> Vec<Segment> {
    let file = include_bytes!("../../data/pyfrf-impact/impact2_response0.npy");
    // NumPy's header is a multiple of 64 bytes that ends with a newline; the values follow.
    let values = &file[file.len() - SEGMENTS * SAMPLES * 2 * 8..];
    assert_eq!((file.len() - values.len()) % 64, 0);
    let values: Vec<f64> =
        values.chunks_exact(8).map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap())).collect();
    values
        .chunks_exact(2 * SAMPLES)
        .map(|segment| Segment {
            force: segment.iter().step_by(2).copied().collect(),
            response: segment.iter().skip(1).step_by(2).copied().collect(),
        })
        .collect()
}

/// Samples at which the hits begin, then `[re H1, im H1, coherence]` for each bin.
fn expected() -> (Vec<usize>, Vec<[f64; 3]>) {
    let mut rows = include_str!("../../data/pyfrf-impact/expected.txt").lines();
    let triggers =
        rows.next().unwrap().split_whitespace().map(|word| word.parse().unwrap()).collect();
    let lines = rows
        .map(|row| {
            let numbers: Vec<f64> =
                row.split_whitespace().map(|word| word.parse().unwrap()).collect();
            numbers.try_into().unwrap()
        })
        .collect();
    (triggers, lines)
}

/// Every sample at which a trigger fires that is armed again when a record is complete.
fn triggers(force: &[f64]) -> Vec<usize> {
    let mut trigger = EdgeTrigger::new(LEVEL, PRE_TRIGGER);
    let mut triggers: Vec<usize> = Vec::new();
    for (n, &sample) in force.iter().enumerate() {
        if triggers.last().is_some_and(|&last| n == last + POINTS - PRE_TRIGGER) {
            trigger.arm();
        }
        if trigger.feed(sample) {
            triggers.push(n);
        }
    }
    triggers
}

/// H1 and coherence over the good hits.
fn spectra(decay: f64) -> Spectra<f64, 1, BINS> {
    let test = TestSettings {
        exponential_decay: decay,
        force_window_s: 51.5 / RATE,
        ..TestSettings::default()
    };
    let analysis = HitAnalysis::of_signals(
        RATE,
        0.0,
        [Signal { scale: 1.0, lag: 0.0 }; 2],
        &test,
        PRE_TRIGGER,
    );
    let mut spectra = Spectra::<f64, 1, BINS>::new();
    let mut scratch = [0.0; POINTS];
    let mut force = [Complex::new(0.0, 0.0); BINS];
    let mut response = force;
    let segments = segments();
    for hit in GOOD {
        let start = triggers(&segments[hit].force)[0] - PRE_TRIGGER;
        let record = [&segments[hit].force, &segments[hit].response].map(|s| &s[start..][..POINTS]);
        analysis.force(&record, &mut scratch, &mut force).unwrap();
        spectra.add_force(&force);
        analysis.response(&record, 0, &mut scratch, &mut response).unwrap();
        spectra.add_response(0, &force, &response);
    }
    spectra
}

/// Largest deviation of H1, relative to its largest value, and largest deviation of the coherence.
fn deviation(got: &Spectra<f64, 1, BINS>, expected: &[[f64; 3]]) -> (f64, f64) {
    let largest = expected.iter().map(|[re, im, _]| re.hypot(*im)).fold(0.0, f64::max);
    let mut worst = (0.0_f64, 0.0_f64);
    for (line, &[re, im, coherence]) in expected.iter().enumerate() {
        worst.0 = worst.0.max((got.h1(0, line) - Complex::new(re, im)).norm_sqr().sqrt() / largest);
        worst.1 = worst.1.max((got.coherence(0, line) - coherence).abs());
    }
    worst
}

#[test]
fn each_good_hit_triggers_once_at_its_edge() {
    let (expected, _) = expected();
    for (segment, &at) in segments().iter().zip(&expected) {
        // This includes the double hit, whose second pulse falls into the record of the first.
        assert_eq!(triggers(&segment.force), [at]);
    }
    assert_eq!(expected.len(), SEGMENTS);
}

#[test]
fn h1_and_coherence_over_the_good_hits_equal_numpy() {
    let (_, expected) = expected();
    assert_eq!(expected.len(), BINS);
    let spectra = spectra(120.0);
    assert_eq!(usize::from(spectra.hits()), GOOD.len());
    let (h1, coherence) = deviation(&spectra, &expected);
    // The required limit is 1e-6. Both results are in double precision; the file has thirteen digits.
    assert!(h1 < 1e-6 && coherence < 1e-6, "{h1:e} {coherence:e}");
}

#[test]
fn another_window_does_not_equal_numpy() {
    // Proves that the comparison can fail: a decay that is 1 % off exceeds the limit.
    let (h1, _) = deviation(&spectra(121.2), &expected().1);
    assert!(h1 > 1e-5, "{h1:e}");
}

use super::*;
use crate::layout::TestProfile;
use crate::signal::tests::ADC;
use crate::signal::{
    CaptureState, LongCapture, RECORD_SCANS, Record, SPECTRUM_BINS, Scan, Trigger,
};
use crate::units::Newtons;
use std::boxed::Box;
use std::vec::Vec;

const INTERVAL: f64 = 1.0 / 4000.0;
/// Start of the push, and its duration, s.
const PUSH: [f64; 2] = [2.5, 0.02];
const PEAK: f64 = 80.0;
/// Standard deviation of the noise of a scan, codes: that of an ADXL326 with 497 Hz at 12 bits.
const NOISE: f64 = 0.65;

/// A mode of the response: frequency, rad/s, decay, 1/s, and residue of the accelerance, 1/kg.
const MODES: [(f64, f64, f64); 3] = [(18.1, 0.18, 0.9), (38.0, 0.31, -0.4), (260.0, 2.0, 0.3)];

/// Half a sine.
fn force(t: f64) -> f64 {
    let since = (t - PUSH[0]) / PUSH[1];
    if (0.0..1.0).contains(&since) { PEAK * (std::f64::consts::PI * since).sin() } else { 0.0 }
}

/// Accelerance whose impulse response is `Σ r e^{−d t} cos(ω t)`.
fn accelerance(s: Complex<f64>) -> Complex<f64> {
    let part = |&(omega, decay, residue): &(f64, f64, f64)| {
        let s = s + decay;
        s * residue / (s * s + omega * omega)
    };
    MODES.iter().map(part).sum()
}

/// Scans of the codes of a push and of the responses to it, each channel sampled after the one before.
fn scans(calibration: &Calibration) -> impl Iterator<Item = Scan> {
    let per_code = |channel: usize| f64::from(calibration.per_code(&ADC, channel));
    let scales: Vec<f64> = (0..CHANNELS).map(per_code).collect();
    // The convolution of the push with a complex exponential, by a fine trapezoid, gives the amplitude after the push.
    const STEPS: usize = 2000;
    let h = PUSH[1] / STEPS as f64;
    let response = move |t: f64| {
        let end = t.min(PUSH[0] + PUSH[1]);
        let count = ((end - PUSH[0]) / h).max(0.0);
        let mut sum = 0.0;
        for &(omega, decay, residue) in &MODES {
            let pole = Complex::new(-decay, omega);
            let mut amplitude = Complex::new(0.0, 0.0);
            let steps = count as usize;
            if steps == STEPS || end == PUSH[0] + PUSH[1] {
                // Closed form: ∫ sin(π u/T) e^{−p u} du over the push.
                let k = std::f64::consts::PI / PUSH[1];
                let at_end = Complex::new((-pole * PUSH[1]).re.exp(), 0.0)
                    * Complex::new(0.0, (-pole * PUSH[1]).im).exp();
                amplitude = (at_end + 1.0) * k / (pole * pole + k * k);
            } else if steps > 0 {
                for step in 0..steps {
                    let u = (step as f64 + 0.5) * h;
                    amplitude += (-pole * u).exp() * (std::f64::consts::PI * u / PUSH[1]).sin() * h;
                }
            }
            sum += residue * PEAK * (amplitude * (pole * (t - PUSH[0])).exp()).re;
        }
        sum
    };
    let mut state = 1_u32;
    let mut noise = move || {
        // A linear congruential generator (Numerical Recipes); the sum of twelve uniform numbers is nearly normal.
        let mut uniform = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24)
        };
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    };
    (0..RECORD_SCANS as u64 * DECIMATION as u64 + 20_000).map(move |n| {
        core::array::from_fn(|channel| {
            let t = n as f64 * INTERVAL + channel as f64 * f64::from(ADC.channel_delay.0);
            let value = if channel == HAMMER {
                force(t) / scales[0] + 140.0
            } else {
                2048.0 + response(t) / scales[channel] + NOISE * noise()
            };
            value.round() as u16
        })
    })
}

#[test]
fn the_accelerance_of_known_modes_is_found_at_every_line() {
    // No low-passes: the signals above have none.
    let mut calibration = Calibration::default();
    calibration.channels.iter_mut().for_each(|channel| channel.cutoff.0 = 0.0);
    let test = TestSettings::<f64>::of_profile(TestProfile::Suspension);
    let mut record = Box::new(Record::new());
    record.begin_wait();
    let trigger = Trigger::new(&ADC, &calibration, Newtons(3.0));
    let mut capture = LongCapture::new(trigger, &ADC);
    let triggered_at = scans(&calibration).zip(0..).find_map(|(scan, n)| {
        match capture.feed(&mut record, &scan, ScanIndex(n)) {
            CaptureState::Complete { trigger_scan } => Some(trigger_scan),
            _ => None,
        }
    });
    let trigger = triggered_at.unwrap();
    assert!(trigger.0.abs_diff((PUSH[0] / INTERVAL) as u64) < 10);
    let analysis = LongRecordAnalysis::<f64>::new(&ADC, &calibration, &test, trigger);
    let mut scratch = std::vec![0.0; RECORD_SCANS];
    let zero = Complex::new(0.0, 0.0);
    let (mut force, mut lines) = ([zero; SPECTRUM_BINS], [zero; SPECTRUM_BINS]);
    analysis.force(&*record, &mut force);
    let impulse = analysis.impulse(&*record);
    assert!((impulse - PEAK * PUSH[1] * 2.0 / std::f64::consts::PI).abs() < 1e-3 * impulse);
    let single = LongRecordAnalysis::<f32>::new(&ADC, &calibration, &test.cast(), trigger);
    let zero = Complex::new(0.0_f32, 0.0);
    let (mut force_32, mut lines_32) = ([zero; SPECTRUM_BINS], [zero; SPECTRUM_BINS]);
    let mut scratch_32 = std::vec![0.0_f32; RECORD_SCANS];
    single.force(&*record, &mut force_32);
    for response in [0, 4, 8] {
        analysis.response(&*record, response, &mut scratch, &mut lines).unwrap();
        single.response(&*record, response, &mut scratch_32, &mut lines_32).unwrap();
        for line in 6..SPECTRUM_BINS {
            let s = analysis.s(line);
            assert!((s.im / std::f64::consts::TAU - line as f64 * 50.0 / 512.0).abs() < 1e-9);
            let estimate = lines[line] / force[line];
            let expected = accelerance(s);
            // Noise of 0.65 and rounding of 0.29 codes of 0.13 m/s², white over 2 kHz, make √(Δt/(2 σ)) times as much
            // in a line: 3.3e-3 (m/s²) s over an impulse of 1 N s. Four times that, for 366 lines.
            assert!(
                (estimate - expected).norm() < 0.013,
                "{response} {line}: {estimate} {expected}"
            );
            let estimate_32 = lines_32[line] / force_32[line];
            let estimate_32 = Complex::new(f64::from(estimate_32.re), f64::from(estimate_32.im));
            // The bound of the force's spectrum, and the window's 1e-5 of the largest line.
            assert!((estimate_32 - estimate).norm() < 1e-4 * (1.0 + estimate.norm()), "{line}");
        }
    }
}

#[test]
fn too_little_memory_and_too_many_lines_are_refused() {
    let test = TestSettings::<f64>::of_profile(TestProfile::Suspension);
    let analysis =
        LongRecordAnalysis::<f64>::new(&ADC, &Calibration::default(), &test, ScanIndex(0));
    let mut record = Box::new(Record::new());
    (0..RECORD_SCANS).for_each(|_| record.push(&[7; CHANNELS]));
    let mut lines = [Complex::new(0.0, 0.0); SPECTRUM_BINS];
    let short = analysis.response(&*record, 0, &mut [0.0; 2000], &mut lines);
    assert_eq!(short, Err(FftError::RecordTooLong));
    let mut many = [Complex::new(0.0, 0.0); 300];
    let refused = analysis.response(&*record, 0, &mut [0.0; RECORD_SCANS], &mut many);
    assert_eq!(refused, Err(FftError::TooManyLines));
}

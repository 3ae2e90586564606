//! Computes the spectra of all channels from the record of one hit.
//!
//! Channels are processed one at a time, so that the caller can do other work in between.

use nalgebra::Complex;

use super::chain::HAMMER;
use super::grade::rest_scans;
use super::spectra::ratio;
use super::{
    AdcProperties, CHANNELS, Calibration, FftError, HitNoise, Hum, HumSearch, RealFft, Samples,
    window,
};
use crate::Real;
use crate::layout::TestSettings;

/// Analysis of the records of one test.
///
/// The spectrum of a channel is `X(s) = Δt Σ (x_n − rest) e^{−s n Δt}` at `s = σ + iω`,
/// `ω = 2π l rate/points`, in N s or (m/s²) s, where `rest` is the mean of its pre-trigger readings. A record
/// shorter than the transform is padded with zeros. The spectra are corrected for the channel's low-pass and
/// for its delay after the hammer.
///
/// ```
/// # use massline_shared::signal::*;
/// # use massline_shared::layout::TestSettings;
/// # use massline_shared::units::*;
/// # use massline_shared::nalgebra::Complex;
/// # let adc = AdcProperties { rate: Hertz(4000.0), channels: 10, bits: 12,
/// #     reference: Volts(3.0), channel_delay: Seconds(0.0) };
/// # let (calibration, test) = (Calibration::default(), TestSettings::default());
/// # let mut spectra = Box::new(Spectra::<f32, RESPONSES, SPECTRUM_BINS>::new());
/// // A push of 800 codes for 4 ms; every response follows it with 200 codes.
/// let mut record = Box::new(Record::new());
/// for n in 0..RECORD_SCANS {
///     let push = u16::from((PRE_TRIGGER_SCANS..PRE_TRIGGER_SCANS + 16).contains(&n));
///     let mut scan = [2048 + 200 * push; CHANNELS];
///     scan[HAMMER] = 137 + 800 * push;
///     record.push(&scan);
/// }
/// let analysis = HitAnalysis::<f32>::new(&adc, &calibration, &test, PRE_TRIGGER_SCANS);
/// let mut scratch = [0.0; RECORD_SCANS];
/// let mut force = [Complex::new(0.0, 0.0); SPECTRUM_BINS];
/// let mut lines = force;
/// analysis.force(&*record, &mut scratch, &mut force)?;
/// spectra.add_force(&force);
/// for response in 0..adc.responses() {
///     analysis.response(&*record, response, &mut scratch, &mut lines)?;
///     spectra.add_response(response, &force, &lines);
///     HitAnalysis::divide(&mut lines, &force); // this hit's own H, with weights |F|²
/// }
/// let expected = 200.0 * calibration.per_code(&adc, 1) / (800.0 * calibration.per_code(&adc, HAMMER));
/// assert!((lines[20].re / expected - 1.0).abs() < 1e-4);
/// assert!((spectra.h1(0, 20).re / expected - 1.0).abs() < 1e-4);
/// # Ok::<(), FftError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct HitAnalysis<R> {
    /// Scans per second.
    rate: R,
    /// Delay between consecutive channels, s.
    channel_delay: R,
    /// Scale of each channel, N or m/s² per reading.
    scale: [R; CHANNELS],
    /// Time constants of the low-passes, s; zero without a low-pass.
    lag: [R; CHANNELS],
    /// σ of the exponential window, 1/s.
    decay: R,
    /// Number of scans on either side of the peak that the force window passes.
    half_width: usize,
    /// Number of readings that are averaged to the rest value.
    rest: usize,
    /// Hum that is taken out of the readings first.
    hum: Option<Hum<R>>,
}

impl<R: RealFft> HitAnalysis<R> {
    /// Analysis for records of codes with `pre_trigger` scans before the hit.
    pub fn new(
        adc: &AdcProperties,
        calibration: &Calibration,
        test: &TestSettings<R>,
        pre_trigger: usize,
    ) -> Self {
        let of = |value: f32| R::of(f64::from(value));
        let scale = core::array::from_fn(|channel| of(calibration.per_code(adc, channel)));
        let cutoffs = calibration.channels.map(|channel| of(channel.cutoff.0));
        Self::of_signals(of(adc.rate.0), of(adc.channel_delay.0), scale, test, pre_trigger)
            .with_cutoffs(cutoffs)
    }

    /// Analysis for any signals, without low-passes: `rate` readings per second, channel `k` sampled
    /// `k · channel_delay` seconds after channel 0, `scale` N or m/s² per reading.
    pub fn of_signals(
        rate: R,
        channel_delay: R,
        scale: [R; CHANNELS],
        test: &TestSettings<R>,
        pre_trigger: usize,
    ) -> Self {
        // The cast turns NaN into 0.
        let half_width = (test.force_window_s * rate).to_f64() as usize;
        let rest = rest_scans(pre_trigger);
        let lag = [R::zero(); CHANNELS];
        Self {
            rate,
            channel_delay,
            scale,
            lag,
            decay: test.exponential_decay,
            half_width,
            rest,
            hum: None,
        }
    }

    /// The same for channels behind first-order low-passes with these cutoff frequencies, Hz; zero where
    /// there is none.
    pub fn with_cutoffs(self, cutoffs: [R; CHANNELS]) -> Self {
        let lag = cutoffs.map(|cutoff| {
            let lag = R::one() / (R::two_pi() * cutoff);
            if lag.finite() { lag } else { R::zero() }
        });
        Self { lag, ..self }
    }

    /// The same for one record with this hum.
    pub fn without_hum(self, hum: Option<Hum<R>>) -> Self {
        Self { hum, ..self }
    }

    /// A search for hum in a record of this many scans.
    pub fn hum_search(&self, scans: usize) -> Option<HumSearch<R>> {
        // The contact is over when the force has passed its window on either side of the peak.
        HumSearch::new(scans, self.rest + self.half_width + self.half_width, self.rate)
    }

    /// Spacing of the bins of a transform of `points` samples, Hz.
    pub fn resolution(&self, points: usize) -> R {
        self.rate / R::of(points as f64)
    }

    /// The spectrum of the force, corrected for its low-pass. `scratch` has the length of the transform.
    ///
    /// # Errors
    /// When the length of `scratch` is not a power of two, or is less than that of the record or twice the
    /// number of lines.
    pub fn force<D: Samples<R> + ?Sized>(
        &self,
        record: &D,
        scratch: &mut [R],
        lines: &mut [Complex<R>],
    ) -> Result<(), FftError> {
        let samples = self.copy(record, HAMMER, scratch)?;
        let rest = mean(samples.get(..self.rest).unwrap_or(samples));
        let sign = self.scale[HAMMER];
        let mut peak = (0, R::zero());
        for (n, sample) in samples.iter_mut().enumerate() {
            *sample -= rest;
            let force = *sample * sign;
            if force > peak.1 {
                peak = (n, force);
            }
        }
        window::force(samples, peak.0, self.half_width);
        self.exponential(samples, R::zero(), HAMMER);
        R::real_fft(scratch, lines)?;
        self.undo_low_pass(HAMMER, scratch.len(), lines);
        Ok(())
    }

    /// The spectrum of a response (the first is 0), corrected for its low-pass and its delay after the
    /// hammer.
    ///
    /// # Errors
    /// As [`Self::force`].
    pub fn response<D: Samples<R> + ?Sized>(
        &self,
        record: &D,
        response: usize,
        scratch: &mut [R],
        lines: &mut [Complex<R>],
    ) -> Result<(), FftError> {
        let channel = response.saturating_add(1);
        let samples = self.copy(record, channel, scratch)?;
        let rest = mean(samples.get(..self.rest).unwrap_or(samples));
        self.exponential(samples, rest, channel);
        R::real_fft(scratch, lines)?;
        self.undo_low_pass(channel, scratch.len(), lines);
        self.undo_delay(channel, scratch.len(), lines);
        Ok(())
    }

    /// Noise and motion of the hit in a record of this many responses.
    pub fn hit_noise<D: Samples<R> + ?Sized>(&self, record: &D, responses: usize) -> HitNoise<R> {
        let scale = self.scale.get(..=responses).unwrap_or(&self.scale);
        // The force passes its window on either side of its peak, which follows the trigger.
        HitNoise::of(record, scale, self.rest, self.half_width + self.half_width)
    }

    /// Variance of the real and of the imaginary part of each bin for readings with a variance of one,
    /// (m/s²)² s²: `½ Δt² Σ e^{−2σnΔt}` over a record of this many scans.
    pub fn bin_variance(&self, scans: usize) -> R {
        let record = R::of(scans as f64) / self.rate;
        let two = R::of(2.0);
        let energy = if self.decay > R::zero() {
            (R::one() - (-two * self.decay * record).exp()) / (two * self.decay)
        } else {
            record
        };
        energy / (two * self.rate)
    }

    /// Frequency response of a single hit: replaces `lines`, the spectrum of a response, by `H = X/F`; 0
    /// where there is no force.
    pub fn divide(lines: &mut [Complex<R>], force: &[Complex<R>]) {
        for (line, f) in lines.iter_mut().zip(force) {
            *line = ratio(*line * f.conj(), f.norm_sqr());
        }
    }

    /// Copies a channel's readings without hum to the front of `scratch` and sets the rest to zero; returns the
    /// readings.
    fn copy<'s, D: Samples<R> + ?Sized>(
        &self,
        record: &D,
        channel: usize,
        scratch: &'s mut [R],
    ) -> Result<&'s mut [R], FftError> {
        let samples = copy(record, channel, scratch)?;
        if let Some(hum) = &self.hum {
            hum.remove(channel, samples);
        }
        Ok(samples)
    }

    fn exponential(&self, samples: &mut [R], rest: R, channel: usize) {
        let scale = self.scale.get(channel).copied().unwrap_or_else(R::zero);
        window::exponential(samples, rest, scale / self.rate, self.decay / self.rate);
    }

    /// A first-order low-pass with the cutoff `f` gives `X(s)/(1 + s/2πf)`. Amplitude and phase are corrected
    /// together, at `s = σ + iω` because the spectra of windowed records are there.
    fn undo_low_pass(&self, channel: usize, points: usize, lines: &mut [Complex<R>]) {
        let lag = self.lag.get(channel).copied().unwrap_or_else(R::zero);
        if lag == R::zero() {
            return;
        }
        let per_line = R::two_pi() * self.resolution(points) * lag;
        let re = R::one() + self.decay * lag;
        for (line, value) in lines.iter_mut().enumerate() {
            *value *= Complex::new(re, per_line * R::of(line as f64));
        }
    }

    /// Channel `k` samples `x(t + kτ)`, whose spectrum is `e^{skτ} X(s)`, so the lines are multiplied by
    /// `e^{−skτ}` (theory, section 9).
    fn undo_delay(&self, channel: usize, points: usize, lines: &mut [Complex<R>]) {
        // A running product over blocks and, within a block, over its lines: at most 24 products deep for 128
        // lines. A sine would cost thousands of instructions on a microcontroller.
        const BLOCK: usize = 16;
        let delay = self.channel_delay * R::of(channel as f64);
        let per_line = -R::two_pi() * self.resolution(points) * delay;
        let turn = |angle: R| {
            let (sin, cos) = angle.sin_cos();
            Complex::new(cos, sin)
        };
        let (step, block_step) = (turn(per_line), turn(per_line * R::of(BLOCK as f64)));
        let mut start = Complex::new((-self.decay * delay).exp(), R::zero());
        for block in lines.chunks_mut(BLOCK) {
            let mut factor = start;
            for line in block {
                *line *= factor;
                factor *= step;
            }
            start *= block_step;
        }
    }
}

/// Copies a channel's readings to the front of `scratch` and sets the rest to zero; returns the readings.
fn copy<'s, R: Real, D: Samples<R> + ?Sized>(
    record: &D,
    channel: usize,
    scratch: &'s mut [R],
) -> Result<&'s mut [R], FftError> {
    let scans = record.scans();
    if scans > scratch.len() {
        return Err(FftError::RecordTooLong);
    }
    let (samples, padding) = scratch.split_at_mut(scans);
    padding.fill(R::zero());
    let copied = record.copy_channel(channel, samples);
    if let Some(missing) = samples.get_mut(copied..) {
        missing.fill(R::zero());
    }
    Ok(samples)
}

fn mean<R: Real>(samples: &[R]) -> R {
    let sum = samples.iter().fold(R::zero(), |sum, &sample| sum + sample);
    sum / R::of(samples.len().max(1) as f64)
}

#[cfg(test)]
mod tests {
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
            [R::one(); CHANNELS],
            &TestSettings::default(),
            PRE_TRIGGER_SCANS,
        );
        let mut scratch = vec![R::zero(); RECORD_SCANS];
        let (mut force, mut lines) = (zeros(), zeros());
        analysis.force(&record, &mut scratch, &mut force).unwrap();
        let mut worst = 0.0_f64;
        for response in 0..CHANNELS - 1 {
            analysis.response(&record, response, &mut scratch, &mut lines).unwrap();
            HitAnalysis::divide(&mut lines, &force);
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
        let signals = cutoffs
            .map(|cutoff| low_passed(cutoff, tap).into_iter().map(R::of).collect::<Vec<R>>());
        let record = [&signals[0][..], &signals[1][..]];
        let test = TestSettings { force_window_s: R::of(0.4), ..TestSettings::default() };
        let mut of_channels = [R::zero(); CHANNELS];
        of_channels[..2].copy_from_slice(&corrected.map(R::of));
        let analysis =
            HitAnalysis::of_signals(R::of(4000.0), R::zero(), [R::one(); CHANNELS], &test, 40)
                .with_cutoffs(of_channels);
        let mut scratch = vec![R::zero(); RECORD_SCANS];
        let (mut force, mut lines) = (zeros(), zeros());
        analysis.force(&record, &mut scratch, &mut force).unwrap();
        analysis.response(&record, 0, &mut scratch, &mut lines).unwrap();
        HitAnalysis::divide(&mut lines, &force);
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
        let analysis = HitAnalysis::of_signals(4000.0, 0.0, [2.0; CHANNELS], &test, 80);
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
            HitAnalysis::divide(&mut lines, &force);
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
            HitAnalysis::divide(&mut lines, &force);
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
}

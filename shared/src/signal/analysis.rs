//! Computes the spectra of all channels from the record of one hit.
//!
//! Channels are processed one at a time, so that the caller can do other work in between.

use nalgebra::Complex;

use super::chain::HAMMER;
use super::hit_noise::mean_cube;
use super::record::rest_scans;
use super::spectra::ratio;
use super::{
    AdcProperties, CHANNELS, Calibration, FftError, HitNoise, Hum, HumSearch, RealFft, Samples,
    Signal, window,
};
use crate::layout::TestSettings;
use crate::real::Real;

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
///     divide_by_force(&mut lines, &force); // this hit's own H, with weights |F|²
/// }
/// let expected = 200.0 * calibration.per_code(&adc, 1) / (800.0 * calibration.per_code(&adc, HAMMER));
/// assert!((lines[20].re / expected - 1.0).abs() < 1e-4);
/// assert!((spectra.h1(0, 20).re / expected - 1.0).abs() < 1e-4);
/// # Ok::<(), FftError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct HitAnalysis<R, S = [Signal<R>; CHANNELS]> {
    /// Scans per second.
    rate: R,
    /// Delay between consecutive channels, s.
    channel_delay: R,
    /// The signals of the channels, the hammer first.
    signals: S,
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
        let real = |value: f32| R::of(f64::from(value));
        let signals = core::array::from_fn(|channel| {
            let cutoff = real(calibration.channels[channel].cutoff.0);
            Signal::new(real(calibration.per_code(adc, channel)), cutoff)
        });
        Self::of_signals(real(adc.rate.0), real(adc.channel_delay.0), signals, test, pre_trigger)
    }
}

/// Frequency response of a single hit: replaces `lines`, the spectrum of a response, by `H = X/F`; 0 where there is no
/// force.
pub fn divide_by_force<R: Real>(lines: &mut [Complex<R>], force: &[Complex<R>]) {
    for (line, f) in lines.iter_mut().zip(force) {
        *line = ratio(*line * f.conj(), f.norm_sqr());
    }
}

impl<R: RealFft, S: AsRef<[Signal<R>]>> HitAnalysis<R, S> {
    /// Analysis for any signals: `rate` readings per second, channel `k` sampled `k · channel_delay` seconds after
    /// channel 0, which is the hammer.
    pub fn of_signals(
        rate: R,
        channel_delay: R,
        signals: S,
        test: &TestSettings<R>,
        pre_trigger: usize,
    ) -> Self {
        // The cast turns NaN into 0.
        let half_width = (test.force_window_s * rate).to_f64() as usize;
        let rest = rest_scans(pre_trigger);
        let decay = test.exponential_decay;
        Self { rate, channel_delay, signals, decay, half_width, rest, hum: None }
    }

    /// The same for one record with this hum.
    pub fn without_hum(self, hum: Option<Hum<R>>) -> Self {
        Self { hum, ..self }
    }

    /// A search for hum in a record of this many scans.
    pub fn hum_search(&self, scans: usize) -> Option<HumSearch<R>> {
        // The contact is over when the force has passed its window on either side of the peak.
        let contact = self.rest..self.rest + self.half_width + self.half_width;
        HumSearch::new(scans, contact, self.rate)
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
        let sign = self.signal(HAMMER).scale;
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
        let signals = self.signals.as_ref();
        let signals = signals.get(..=responses).unwrap_or(signals);
        // The force passes its window on either side of its peak, which follows the trigger.
        HitNoise::of(record, signals, self.rest, self.half_width + self.half_width)
    }

    /// Squared reading of a response (the first is 0) during the contact, (m/s²)², weighted with the reading itself:
    /// what a channel that compresses is wrong by in proportion.
    pub fn squared_reading<D: Samples<R> + ?Sized>(&self, record: &D, response: usize) -> R {
        let channel = response.saturating_add(1);
        let scale = self.signal(channel).scale;
        let contact = self.half_width + self.half_width;
        mean_cube(record, channel, self.rest, contact) * scale * scale
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

    /// The signal of a channel; a scale of zero when the channel does not exist.
    fn signal(&self, channel: usize) -> Signal<R> {
        self.signals.as_ref().get(channel).copied().unwrap_or(Signal::new(R::zero(), R::zero()))
    }

    fn exponential(&self, samples: &mut [R], rest: R, channel: usize) {
        let scale = self.signal(channel).scale;
        window::exponential(samples, rest, scale / self.rate, self.decay / self.rate);
    }

    /// A first-order low-pass with the cutoff `f` gives `X(s)/(1 + s/2πf)`. Amplitude and phase are corrected
    /// together, at `s = σ + iω` because the spectra of windowed records are there.
    fn undo_low_pass(&self, channel: usize, points: usize, lines: &mut [Complex<R>]) {
        let lag = self.signal(channel).lag;
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
mod tests;

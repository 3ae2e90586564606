//! Spectra of a long record: the force at the full rate, the responses decimated.

use nalgebra::Complex;

use super::chain::HAMMER;
use super::decimator::complex_exp;
use super::record::rest_scans;
use super::{
    AdcProperties, CHANNELS, Calibration, DECIMATION, FftError, LONG_POINTS, PRE_TRIGGER_SCANS,
    RealFft, Samples, transfer, window,
};
use crate::layout::TestSettings;
use crate::real::Real;
use crate::units::ScanIndex;

/// Analysis of one long record ([`LongCapture`](super::LongCapture)).
///
/// As with [`HitAnalysis`](super::HitAnalysis), the spectrum of a channel is `Σ (x − rest) e^{−s t}` times the
/// interval, at `s = σ + iω`, `ω = 2π l f/512` with the rate `f` of the rows, in N s or (m/s²) s. The time `t` counts
/// from the trigger: what lies before it is left out. The decimation filter is divided out, as are low-passes, and the
/// delay of each channel.
#[derive(Clone, Copy, Debug)]
pub struct LongRecordAnalysis<R> {
    /// Time between two scans, s.
    interval: R,
    /// Delay between consecutive channels, s.
    channel_delay: R,
    /// Scale of each channel, N or m/s² per code of the record.
    scale: [R; CHANNELS],
    /// Time constants of the low-passes, s; zero without a low-pass.
    lag: [R; CHANNELS],
    /// σ of the exponential window, 1/s.
    decay: R,
    /// Number of scans on either side of the peak that the force window passes.
    half_width: usize,
    /// From the trigger to the end of its row, s.
    first_row: R,
}

impl<R: RealFft> LongRecordAnalysis<R> {
    /// Analysis of the record of the hit that triggered at this scan.
    pub fn new(
        adc: &AdcProperties,
        calibration: &Calibration,
        test: &TestSettings<R>,
        trigger: ScanIndex,
    ) -> Self {
        let real = |value: f32| R::of(f64::from(value));
        let rows = adc.of_rows();
        let interval = R::one() / real(adc.rate.0);
        let into_row = trigger.0 % DECIMATION as u64;
        Self {
            interval,
            channel_delay: real(adc.channel_delay.0),
            scale: core::array::from_fn(|channel| real(calibration.per_code(&rows, channel))),
            lag: core::array::from_fn(|channel| real(calibration.lag(channel))),
            decay: test.exponential_decay,
            // The cast turns NaN into 0.
            half_width: (test.force_window_s / interval).to_f64() as usize,
            first_row: interval * R::of((DECIMATION as u64 - 1 - into_row) as f64),
        }
    }

    /// Laplace variable of a line, 1/s.
    fn s(&self, line: usize) -> Complex<R> {
        let period = self.interval * R::of((DECIMATION * LONG_POINTS) as f64);
        Complex::new(self.decay, R::two_pi() * R::of(line as f64) / period)
    }

    /// The spectrum of the force, corrected for its low-pass.
    ///
    /// In single precision, the recursion of a wave over 400 scans adds an error of at most 400 times its rounding,
    /// 5e-5.
    pub fn force<D: Samples<R> + ?Sized>(&self, record: &D, lines: &mut [Complex<R>]) {
        let (rest, start) = self.contact(record);
        let before = R::of(start as f64) - R::of(PRE_TRIGGER_SCANS as f64);
        let count = 2 * self.half_width + 1;
        for (line, to) in lines.iter_mut().enumerate() {
            let s = self.s(line);
            let step = complex_exp(-(s.scale(self.interval)));
            let mut wave = complex_exp(-(s.scale(self.interval * before)));
            let mut sum = Complex::new(R::zero(), R::zero());
            for reading in record.readings(HAMMER, start).take(count) {
                sum += wave.scale(reading - rest);
                wave *= step;
            }
            let low_pass = Complex::new(R::one(), R::zero()) + s.scale(self.lag[HAMMER]);
            *to = sum.scale(self.scale[HAMMER] * self.interval) * low_pass;
        }
    }

    /// The impulse of the hit, N s: the integral of the force within its window.
    pub fn impulse<D: Samples<R> + ?Sized>(&self, record: &D) -> R {
        let (rest, start) = self.contact(record);
        let readings = record.readings(HAMMER, start).take(2 * self.half_width + 1);
        let sum = readings.fold(R::zero(), |sum, reading| sum + (reading - rest));
        sum * self.scale[HAMMER] * self.interval
    }

    /// Rest value of the hammer, and the first scan of the force window.
    fn contact<D: Samples<R> + ?Sized>(&self, record: &D) -> (R, usize) {
        let rest = mean(record.readings(HAMMER, 0).take(rest_scans(PRE_TRIGGER_SCANS)));
        let extremes = record.extremes(HAMMER).unwrap_or([(0, rest); 2]);
        let [low, high] = extremes.map(|(at, _)| at);
        let peak = if self.scale[HAMMER] < R::zero() { low } else { high };
        (rest, peak.saturating_sub(self.half_width))
    }

    /// The spectrum of a response (the first is 0), corrected for decimation, low-pass and delay. `scratch` has at
    /// least as many places as the record has rows.
    ///
    /// # Errors
    /// When the record is longer than `scratch`, or there are more lines than half of [`LONG_POINTS`].
    pub fn response<D: Samples<R> + ?Sized>(
        &self,
        record: &D,
        response: usize,
        scratch: &mut [R],
        lines: &mut [Complex<R>],
    ) -> Result<(), FftError> {
        let channel = (response + 1).min(CHANNELS - 1);
        let rows = record.scans();
        let samples = scratch.get_mut(..rows.max(LONG_POINTS)).ok_or(FftError::RecordTooLong)?;
        samples.fill(R::zero());
        record.copy_channel(channel, samples);
        let before = samples.get(..rest_scans(PRE_TRIGGER_SCANS)).unwrap_or(samples);
        let rest = mean(before.iter().copied());
        let (quiet, ringing) = samples.split_at_mut(PRE_TRIGGER_SCANS);
        quiet.fill(R::zero());
        let ringing = ringing.get_mut(..rows.saturating_sub(PRE_TRIGGER_SCANS)).unwrap_or(&mut []);
        let interval = self.interval * R::of(DECIMATION as f64);
        window::exponential(ringing, rest, self.scale[channel] * interval, self.decay * interval);
        R::real_fft(fold(samples), lines)?;
        // The transform counts from the first row of the record, the window from that of the trigger.
        let ahead = R::of(PRE_TRIGGER_SCANS as f64) * interval;
        let delay = self.channel_delay * R::of(channel as f64);
        for (line, value) in lines.iter_mut().enumerate() {
            let s = self.s(line);
            let turned = complex_exp(Complex::new(R::zero(), s.im * ahead));
            let late = complex_exp(-(s.scale(self.first_row + delay)));
            let low_pass = Complex::new(R::one(), R::zero()) + s.scale(self.lag[channel]);
            *value = *value * turned * late * low_pass / transfer(s, self.interval);
        }
        Ok(())
    }
}

/// Adds up the pieces of [`LONG_POINTS`] samples, whose transform has every fourth bin of that of all samples.
fn fold<R: Real>(samples: &mut [R]) -> &mut [R] {
    let (first, others) = samples.split_at_mut(LONG_POINTS.min(samples.len()));
    for piece in others.chunks(LONG_POINTS) {
        first.iter_mut().zip(piece).for_each(|(to, sample)| *to += *sample);
    }
    first
}

/// Mean of readings, relative to the first of them because they are large numbers that hardly differ.
fn mean<R: Real>(mut readings: impl Iterator<Item = R>) -> R {
    let Some(first) = readings.next() else { return R::zero() };
    let (mut sum, mut count) = (R::zero(), R::one());
    for reading in readings {
        sum += reading - first;
        count += R::one();
    }
    first + sum / count
}

#[cfg(test)]
mod tests;

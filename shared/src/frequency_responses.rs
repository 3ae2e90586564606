//! Frequency responses of a whole test.

use nalgebra::Complex;

use crate::Real;
use crate::diagnosis::{Code, Diagnostics, fatal};
use crate::layout::{Layout, is_finite};

/// Frequency responses of a whole test.
#[derive(Clone, Copy, Debug)]
pub struct FrequencyResponses<'a, R> {
    /// Frequencies, Hz.
    frequencies: &'a [R],
    /// Accelerances, (m/s²)/N.
    accelerance: &'a [Complex<R>],
    channels: usize,
    hits: usize,
    /// σ of the exponential window on the records, 1/s.
    pub decay: R,
    /// Factor on standard deviations because the window correlates neighbouring bins:
    /// [`window_correlation`](crate::mass_line::window_correlation).
    pub correlation: R,
}

impl<'a, R: Real> FrequencyResponses<'a, R> {
    /// Frequency responses from accelerances `[bin][channel][hit]` in (m/s²)/N and the frequencies of the
    /// bins in Hz, for records without a window. `None` when the number of accelerances is not that of
    /// bins, channels and hits.
    pub fn new(
        frequencies: &'a [R],
        accelerance: &'a [Complex<R>],
        channels: usize,
        hits: usize,
    ) -> Option<Self> {
        let whole = frequencies.len() * channels * hits == accelerance.len();
        let (decay, correlation) = (R::zero(), R::one());
        whole.then_some(Self { frequencies, accelerance, channels, hits, decay, correlation })
    }

    /// The same for records with an exponential window of this decay rate, 1/s, which correlates neighbouring
    /// bins by this factor.
    pub fn windowed(self, decay: R, correlation: R) -> Self {
        Self { decay, correlation, ..self }
    }

    /// Frequencies of the bins, Hz.
    pub fn frequencies(&self) -> &[R] {
        self.frequencies
    }

    /// Number of response channels.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Number of hit DOFs.
    pub fn hits(&self) -> usize {
        self.hits
    }

    /// Laplace variable of a bin, `s = σ + iω`, 1/s.
    pub fn s(&self, bin: usize) -> Complex<R> {
        Complex::new(self.decay, self.frequencies[bin] * R::two_pi())
    }

    /// One accelerance, (m/s²)/N.
    pub fn at(&self, bin: usize, channel: usize, hit: usize) -> Complex<R> {
        self.accelerance[(bin * self.channels + channel) * self.hits + hit]
    }

    /// Refuses a layout or responses that are not finite, and responses that are not those of the layout.
    pub(crate) fn check<const S: usize, const H: usize>(
        &self,
        layout: &Layout<R, S, H>,
    ) -> Result<(), Diagnostics> {
        if !is_finite(layout) {
            return Err(fatal(Code::LayoutNotFinite, 0.0));
        }
        if !self.is_finite() {
            return Err(fatal(Code::DataNotFinite, 0.0));
        }
        if self.channels != 3 * layout.sensors.len() || self.hits != layout.hits.len() {
            return Err(fatal(Code::FrfMissing, 0.0));
        }
        Ok(())
    }

    /// True when no number is NaN or infinite.
    fn is_finite(&self) -> bool {
        self.decay.finite()
            && self.frequencies.iter().all(|f| f.finite())
            && self.accelerance.iter().all(|h| h.re.finite() && h.im.finite())
    }
}

//! Frequency responses of a whole test.

use nalgebra::Complex;

use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostics, fatal};
use crate::layout::{Layout, is_finite};
use crate::real::Real;

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
    /// Precision of each bin; see [`Self::weighted`].
    precision: &'a [R],
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
        let precision = &[];
        let responses =
            Self { frequencies, accelerance, channels, hits, decay, correlation, precision };
        whole.then_some(responses)
    }

    /// The same for records with an exponential window of this decay rate, 1/s, which correlates neighbouring
    /// bins by this factor.
    pub fn windowed(self, decay: R, correlation: R) -> Self {
        Self { decay, correlation, ..self }
    }

    /// The same with noise that is not alike in all bins: the precision of a bin is the reciprocal of its standard
    /// deviation, relative to a noise that all have in common. Bins beyond the slice have that noise.
    pub fn weighted(self, precision: &'a [R]) -> Self {
        Self { precision, ..self }
    }

    /// Precision of a bin relative to the noise that all have in common; one unless the responses are
    /// [`weighted`](Self::weighted).
    pub fn precision(&self, bin: usize) -> R {
        self.precision.get(bin).copied().unwrap_or(R::one())
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
    pub(crate) fn check<C: Capacity>(&self, layout: &Layout<R, C>) -> Result<(), Diagnostics> {
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

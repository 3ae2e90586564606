//! The observations of a test, input of every method.

use nalgebra::Complex;

use super::mass_lines::DofMassLines;
use crate::Real;
use crate::layout::Layout;

/// The observations of a test under a layout.
#[derive(Debug)]
pub struct Observations<'a, R, const S: usize, const H: usize, L = NoSpectrumBins> {
    /// Layout with sensors, hits and error budget.
    pub layout: &'a Layout<R, S, H>,
    /// Mass lines of the measured hit DOFs, with their index in the layout.
    pub mass_lines: &'a [DofMassLines<R, S>],
    /// Spectral bins, where they are stored.
    pub spectrum_bins: L,
}

impl<'a, R, const S: usize, const H: usize> Observations<'a, R, S, H> {
    /// Observations with mass lines and without bins, as on a rig.
    pub fn of_mass_lines(
        layout: &'a Layout<R, S, H>,
        mass_lines: &'a [DofMassLines<R, S>],
    ) -> Self {
        Self { layout, mass_lines, spectrum_bins: NoSpectrumBins }
    }
}

/// Source of bins. A program that uses only [`NoSpectrumBins`] contains no code for fitting them.
pub trait SpectrumBins<R> {
    /// The frequency responses of the test, if there are any.
    fn responses(&self) -> Option<&FrequencyResponses<'_, R>>;
}

/// Source without bins.
#[derive(Clone, Copy, Debug)]
pub struct NoSpectrumBins;

impl<R> SpectrumBins<R> for NoSpectrumBins {
    #[inline]
    fn responses(&self) -> Option<&FrequencyResponses<'_, R>> {
        None
    }
}

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

impl<R> SpectrumBins<R> for FrequencyResponses<'_, R> {
    fn responses(&self) -> Option<&FrequencyResponses<'_, R>> {
        Some(self)
    }
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

    /// One accelerance, (m/s²)/N.
    pub(super) fn at(&self, bin: usize, channel: usize, hit: usize) -> Complex<R> {
        self.accelerance[(bin * self.channels + channel) * self.hits + hit]
    }

    /// True when no number is NaN or infinite.
    pub(super) fn is_finite(&self) -> bool {
        self.decay.finite()
            && self.frequencies.iter().all(|f| f.finite())
            && self.accelerance.iter().all(|h| h.re.finite() && h.im.finite())
    }
}

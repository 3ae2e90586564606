//! What a test has observed: the input of every method.

use nalgebra::Complex;

use super::mass_lines::DofMassLines;
use crate::Real;
use crate::layout::Layout;

/// What a test has observed under a layout.
#[derive(Debug)]
pub struct Observations<'a, R, const S: usize, const H: usize, L = NoSpectrumBins> {
    /// Sensors, hits, error budget.
    pub layout: &'a Layout<R, S, H>,
    /// Mass lines of the hit DOFs that were measured, with their index in the layout.
    pub mass_lines: &'a [DofMassLines<R, S>],
    /// Spectral lines, where they are kept.
    pub spectrum_bins: L,
}

impl<'a, R, const S: usize, const H: usize> Observations<'a, R, S, H> {
    /// Mass lines and no spectral lines: what a rig has.
    pub fn of_mass_lines(
        layout: &'a Layout<R, S, H>,
        mass_lines: &'a [DofMassLines<R, S>],
    ) -> Self {
        Self { layout, mass_lines, spectrum_bins: NoSpectrumBins }
    }
}

/// Where spectral lines come from. A program that only has [`NoSpectrumBins`] carries no code that fits
/// them.
pub trait SpectrumBins<R> {
    /// The frequency responses of the test, where there are any.
    fn responses(&self) -> Option<&FrequencyResponses<'_, R>>;
}

/// No spectral lines are kept.
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
    /// Hz.
    frequencies: &'a [R],
    /// (m/s²)/N.
    accelerance: &'a [Complex<R>],
    channels: usize,
    hits: usize,
    /// σ of the exponential window on the records, 1/s.
    pub decay: R,
    /// What standard deviations are multiplied by because the window correlates neighbouring lines:
    /// [`window_correlation`](crate::mass_line::window_correlation).
    pub correlation: R,
}

impl<R> SpectrumBins<R> for FrequencyResponses<'_, R> {
    fn responses(&self) -> Option<&FrequencyResponses<'_, R>> {
        Some(self)
    }
}

impl<'a, R: Real> FrequencyResponses<'a, R> {
    /// Of accelerances `[line][channel][hit]` in (m/s²)/N at the frequencies of the lines, Hz, from records
    /// without a window. `None` when their number is not that of lines, channels and hits.
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

    /// The same from records with an exponential window of this decay rate, 1/s, which correlates
    /// neighbouring lines by this factor.
    pub fn windowed(self, decay: R, correlation: R) -> Self {
        Self { decay, correlation, ..self }
    }

    /// Frequencies of the lines, Hz.
    pub fn frequencies(&self) -> &[R] {
        self.frequencies
    }

    /// Response channels.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Hit DOFs.
    pub fn hits(&self) -> usize {
        self.hits
    }

    /// One accelerance, (m/s²)/N.
    pub(super) fn at(&self, line: usize, channel: usize, hit: usize) -> Complex<R> {
        self.accelerance[(line * self.channels + channel) * self.hits + hit]
    }

    /// True when no number is NaN or infinite.
    pub(super) fn is_finite(&self) -> bool {
        self.decay.finite()
            && self.frequencies.iter().all(|f| f.finite())
            && self.accelerance.iter().all(|h| h.re.finite() && h.im.finite())
    }
}

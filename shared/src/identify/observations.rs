//! The observations of a test, input of every method.

use super::mass_lines::DofMassLines;
use crate::capacity::Capacity;
use crate::frequency_responses::FrequencyResponses;
use crate::layout::Layout;
use crate::real::Real;

/// The observations of a test under a layout.
#[derive(Debug)]
pub struct Observations<'a, R: Real, C: Capacity, L = NoSpectrumBins> {
    /// Layout with sensors, hits and error budget.
    pub layout: &'a Layout<R, C>,
    /// Mass lines of the measured hit DOFs, with their index in the layout.
    pub mass_lines: &'a [DofMassLines<R, C>],
    /// Spectral bins, where they are stored.
    pub spectrum_bins: L,
}

impl<'a, R: Real, C: Capacity> Observations<'a, R, C> {
    /// Observations with mass lines and without bins, as on a rig.
    pub fn of_mass_lines(layout: &'a Layout<R, C>, mass_lines: &'a [DofMassLines<R, C>]) -> Self {
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

impl<R> SpectrumBins<R> for FrequencyResponses<'_, R> {
    fn responses(&self) -> Option<&FrequencyResponses<'_, R>> {
        Some(self)
    }
}

//! A hit that is being averaged under either profile.

use super::averaging::{DofSpectra, HitAverager, HitMemory};
use super::long_hit::LongHitAverager;
use crate::real::Real;
use crate::signal::{FftError, RealFft, Record};

/// A hit that is being averaged.
#[derive(Clone, Debug)]
pub(super) enum AveragedHit<R: Real> {
    /// With mass lines of its own.
    MassLine(HitAverager<R>),
    /// With a long record.
    Long(LongHitAverager<R>),
}

impl<R: RealFft> AveragedHit<R> {
    /// Adds a response to the spectra, or removes it.
    ///
    /// # Errors
    /// When the slices do not have the lengths given in [`HitMemory`].
    pub fn take_response(
        &mut self,
        response: usize,
        record: &Record,
        memory: HitMemory<'_, R>,
        spectra: &mut DofSpectra<R>,
    ) -> Result<(), FftError> {
        match self {
            Self::MassLine(hit) => hit.take_response(response, record, memory, spectra),
            Self::Long(hit) => hit.take_response(response, record, memory, spectra),
        }
    }

    /// Removes a response of a hit that was added from the spectra again.
    ///
    /// # Errors
    /// As [`Self::take_response`].
    pub fn remove_response(
        &self,
        response: usize,
        record: &Record,
        memory: HitMemory<'_, R>,
        spectra: &mut DofSpectra<R>,
    ) -> Result<(), FftError> {
        match self {
            Self::MassLine(hit) => hit.remove_response(response, record, memory, spectra),
            Self::Long(hit) => hit.remove_response(response, record, memory, spectra),
        }
    }
}

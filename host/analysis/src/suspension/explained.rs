//! Whether a global fit explains the readings.

use massline_shared::FrequencyResponses;
use massline_shared::diagnosis::{Code, Diagnostic};

use super::global::noise_over_modes;
use super::modal_gains::{ModalGains, squares_of};
use super::{GlobalAnswer, HostFit};

/// What the global fit leaves, over the noise that the fit of the modes leaves, from which the body does not fit: that
/// fit assumes nothing of the body. Extra terms of a flexible mode at twice the end of the band leave 1.01.
pub(super) const MISFIT: f64 = 1.05;
/// The same beside gains of single modes, some of which that fit takes up with poles of its own: 1.06 in simulated
/// campaigns of sound wheels. A layout without gravity leaves from 1.09 on, so gravity is compared and not only judged.
const MISFIT_BESIDE_GAINS: f64 = 1.1;
/// Root mean square of the pulls of a sensor or hit, in its standard deviations, from which the body does not fit; of
/// the length of a force alone, seven of its own.
const TOO_FAR: f32 = 4.0;

/// Part of the readings that what is unexplained may make up without doubt about the answers: that of errors which grow
/// with the readings, and of gains that a converter gives single modes.
pub(super) const SMALL: f64 = 0.02;

impl GlobalAnswer {
    /// What is left of the readings besides gains of single modes, over the noise.
    pub(super) fn left_over(&self, fit: &HostFit<'_>) -> f64 {
        let noise = self.gains.as_ref().map_or(self.solution.noise, ModalGains::noise_without);
        noise_over_modes(noise, fit)
    }

    /// True for a fit that leaves little, without errors far beyond those stated.
    pub(super) fn explains(&self, fit: &HostFit<'_>) -> bool {
        self.leaves_little(fit) && !self.is_pulled()
    }

    /// True for a fit that leaves hardly more than noise and small gains of single modes.
    pub(super) fn leaves_little(&self, fit: &HostFit<'_>) -> bool {
        let limit = if self.gains.is_some() { MISFIT_BESIDE_GAINS } else { MISFIT };
        let has_small_gains = self.gains.as_ref().is_none_or(|gains| gains.share < SMALL);
        self.left_over(fit) <= limit && has_small_gains
    }

    /// True for a fit with an error far beyond those stated.
    pub(super) fn is_pulled(&self) -> bool {
        let pulled = |d: &Diagnostic| {
            matches!(d.code, Code::LargeSensorPull | Code::LargeHitPull) && d.value > TOO_FAR
        };
        self.solution.estimate.diagnostics.iter().any(pulled)
    }

    /// Root mean square of what the fit leaves besides noise, over that of the readings.
    pub(super) fn share_left(
        &self,
        fit: &HostFit<'_>,
        readings: &FrequencyResponses<'_, f64>,
    ) -> f64 {
        let besides = (2.0 * self.solution.noise.powi(2) - fit.noise().powi(2)).max(0.0);
        let count = readings.frequencies().len() * readings.channels() * readings.hits();
        let mean = squares_of(readings) / count.max(1) as f64;
        if mean > 0.0 { (besides / mean).sqrt() } else { f64::INFINITY }
    }
}

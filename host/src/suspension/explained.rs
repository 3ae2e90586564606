//! Whether a global fit explains the readings.

use massline_shared::diagnosis::{Code, Diagnostic};
use massline_shared::identify::global_fit::GlobalFitSolution;

use super::HostFit;

/// What the global fit leaves, over the noise that the fit of the modes leaves, from which the body does not fit: that fit
/// assumes nothing of the body. Extra terms of a flexible mode at twice the end of the band leave 1.01.
const MISFIT: f64 = 1.05;
/// Root mean square of the pulls of a sensor or hit, in its standard deviations, from which the body does not fit.
const TOO_FAR: f32 = 4.0;

/// What a global fit leaves, over the noise.
pub(super) fn left(found: &GlobalFitSolution<f64>, fit: &HostFit<'_>) -> f64 {
    // That of the real part, and that of a complex number.
    found.noise * std::f64::consts::SQRT_2 / fit.noise()
}

/// True for a fit that leaves hardly more than noise, without errors far beyond those stated.
pub(super) fn explains(found: &GlobalFitSolution<f64>, fit: &HostFit<'_>) -> bool {
    let pulled = |d: &Diagnostic| {
        matches!(d.code, Code::LargeSensorPull | Code::LargeHitPull) && d.value > TOO_FAR
    };
    left(found, fit) <= MISFIT && !found.estimate.diagnostics.iter().any(pulled)
}

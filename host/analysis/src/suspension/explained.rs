//! Whether a global fit explains the readings.

use massline_shared::FrequencyResponses;
use massline_shared::diagnosis::{Code, Diagnostic};
use massline_shared::identify::global_fit::GlobalFitSolution;

use super::HostFit;

/// What the global fit leaves, over the noise that the fit of the modes leaves, from which the body does not fit: that
/// fit assumes nothing of the body. Extra terms of a flexible mode at twice the end of the band leave 1.01.
const MISFIT: f64 = 1.05;
/// Root mean square of the pulls of a sensor or hit, in its standard deviations, from which the body does not fit; of
/// the length of a force alone, seven of its own.
const TOO_FAR: f32 = 4.0;

/// What a global fit leaves, over the noise.
pub(super) fn left(solution: &GlobalFitSolution<f64>, fit: &HostFit<'_>) -> f64 {
    // That of the real part, and that of a complex number.
    solution.noise * std::f64::consts::SQRT_2 / fit.noise()
}

/// True for a fit that leaves hardly more than noise, without errors far beyond those stated.
pub(super) fn explains(solution: &GlobalFitSolution<f64>, fit: &HostFit<'_>) -> bool {
    left(solution, fit) <= MISFIT && !is_pulled(solution)
}

/// True for a fit with an error far beyond those stated.
pub(super) fn is_pulled(solution: &GlobalFitSolution<f64>) -> bool {
    let pulled = |d: &Diagnostic| {
        matches!(d.code, Code::LargeSensorPull | Code::LargeHitPull) && d.value > TOO_FAR
    };
    solution.estimate.diagnostics.iter().any(pulled)
}

/// Root mean square of what a global fit leaves besides noise, over that of the readings.
pub(super) fn share_left(
    solution: &GlobalFitSolution<f64>,
    fit: &HostFit<'_>,
    readings: &FrequencyResponses<'_, f64>,
) -> f64 {
    let besides = (2.0 * solution.noise.powi(2) - fit.noise().powi(2)).max(0.0);
    let (lines, channels, hits) =
        (readings.frequencies().len(), readings.channels(), readings.hits());
    let places =
        (0..lines).flat_map(|l| (0..channels).flat_map(move |c| (0..hits).map(move |h| (l, c, h))));
    let squares: f64 = places.map(|(l, c, h)| readings.at(l, c, h).norm_sqr()).sum();
    let mean = squares / (lines * channels * hits).max(1) as f64;
    if mean > 0.0 { (besides / mean).sqrt() } else { f64::INFINITY }
}

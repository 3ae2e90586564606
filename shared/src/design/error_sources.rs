//! What limits a layout: how much of the variance comes from each source of error.
//!
//! The bound is `V = (Jᵀ S⁻¹ J)⁻¹` with `S` the sum of the covariances of all error sources (theory, section
//! 4). Raising the variance of one source by a small fraction ε raises `V` by `ε K S_k Kᵀ`, where K maps the
//! readings to the estimate: exactly the part of `V` that this source contributes. The parts add up to `V`
//! when the priors are counted as a source.

use nalgebra::SVector;

use super::Predict;
use super::cost::relative_variance;
use crate::capacity::Capacity;
use crate::layout::{ApparatusUncertainty, ErrorSource, HitUncertainty, Layout, SensorUncertainty};
use crate::real::Real;

/// Fraction by which variances are raised to see the effect on the bound: rounding divided by it and itself are both
/// below a thousandth.
const STEP: f64 = 1e-4;

/// Contribution of one source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part<R> {
    /// The source.
    pub source: ErrorSource,
    /// Share of the sum of the ten relative variances; the shares of all sources add up to one.
    pub share: R,
    /// Share of the variance of each of the ten properties.
    pub shares: SVector<R, 10>,
}

/// The contribution of every source; `None` when the layout does not determine the ten properties.
/// `workspace` as for [`Predict::variances`].
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::design::{Criterion, DEFAULT_NOISE, parts};
/// # use massline_shared::identify::maximum_likelihood::workspace;
/// let layout = frame::layout();
/// let criterion = Criterion::new(frame::body(), 0.14, DEFAULT_NOISE);
/// let mut memory = vec![0.0; workspace(layout.sensors.len(), layout.hits.len())];
/// let parts = parts(&criterion, &layout, &mut memory).unwrap();
/// let sum: f64 = parts.iter().map(|part| part.share).sum();
/// assert!((sum - 1.0).abs() < 1e-3);
/// // Without a calibration, the hammer's gain causes most of the uncertainty of the mass.
/// let of_mass = parts.iter().max_by(|a, b| a.shares[0].total_cmp(&b.shares[0])).unwrap();
/// assert_eq!(of_mass.source.name(), "hammer_gain");
/// ```
pub fn parts<R: Real, C: Capacity>(
    prediction: &impl Predict<R>,
    layout: &Layout<R, C>,
    workspace: &mut [R],
) -> Option<[Part<R>; ErrorSource::ALL.len()]> {
    let whole = prediction.variances(layout, workspace)?;
    let relative = |v: &SVector<R, 10>| relative_variance(v, prediction.scale());
    let mut parts =
        ErrorSource::ALL.map(|source| Part { source, share: R::zero(), shares: SVector::zeros() });
    for part in &mut parts {
        let factor = R::of(1.0 + STEP).sqrt();
        let raised = if part.source == ErrorSource::Noise {
            prediction.with_noise(factor).variances(layout, workspace)
        } else {
            let mut layout = layout.clone();
            scale(part.source, &mut layout, factor);
            prediction.variances(&layout, workspace)
        };
        let slope = (raised? - whole) / R::of(STEP);
        part.share = relative(&slope) / relative(&whole);
        part.shares = slope.component_div(&whole);
    }
    Some(parts)
}

/// Multiplies the standard deviations of a source; that of the noise is not in the layout.
fn scale<R: Real, C: Capacity>(source: ErrorSource, layout: &mut Layout<R, C>, factor: R) {
    for sensor in layout.sensors.iter_mut() {
        let sources = SensorUncertainty::<R>::SOURCES;
        scale_own(source, sensor.uncertainty.values_mut().zip(sources), factor);
    }
    for hit in layout.hits.iter_mut() {
        let sources = HitUncertainty::<R>::SOURCES;
        scale_own(source, hit.uncertainty.values_mut().zip(sources), factor);
    }
    let sources = ApparatusUncertainty::<R>::SOURCES;
    scale_own(source, layout.apparatus.values_mut().zip(sources), factor);
    match source {
        ErrorSource::Attached => {
            layout.attached.iter_mut().for_each(|body| body.relative_sigma *= factor);
        }
        ErrorSource::Priors => layout.priors.iter_mut().for_each(|prior| prior.sigma *= factor),
        _ => {}
    }
}

/// Multiplies those of these standard deviations that are of the source.
fn scale_own<'v, R: Real>(
    source: ErrorSource,
    sigmas: impl Iterator<Item = (&'v mut R, &'v ErrorSource)>,
    factor: R,
) {
    let own = sigmas.filter(|(_, of_sigma)| **of_sigma == source);
    own.for_each(|(sigma, _)| *sigma *= factor);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capacity::Rig;
    use crate::design::Criterion;
    use crate::identify::maximum_likelihood::RIG_WORKSPACE;
    use crate::layout::tests::{bar_body, bar_layout};
    use crate::layout::{AttachedBody, Prior};

    fn bar_parts(layout: &Layout<f64, Rig>) -> [Part<f64>; ErrorSource::ALL.len()] {
        let criterion = Criterion::new(bar_body(), layout.characteristic_length(), 0.005);
        parts(&criterion, layout, &mut [0.0; RIG_WORKSPACE]).unwrap()
    }

    /// What only suspension modes are sensitive to.
    const OF_MODES: [ErrorSource; 3] =
        [ErrorSource::Converter, ErrorSource::HitGain, ErrorSource::GravityDirection];

    #[test]
    fn the_shares_add_up_to_one() {
        let mut layout = bar_layout();
        let prior = Prior { property: 0, value: 1.23, sigma: 0.005 };
        layout.priors.push(prior).unwrap();
        layout.attached.push(AttachedBody::point(0.05, 0.1, [0.1, 0.0, 0.0])).unwrap();
        let parts = bar_parts(&layout);
        let shares: f64 = parts.iter().map(|part| part.share).sum();
        // The error is the step, for each share.
        assert!((shares - 1.0).abs() < 1e-3, "{shares}");
        for k in 0..10 {
            let shares: f64 = parts.iter().map(|part| part.shares[k]).sum();
            assert!((shares - 1.0).abs() < 1e-3, "{k}: {shares}");
        }
        for part in parts {
            assert_eq!(part.share == 0.0, OF_MODES.contains(&part.source), "{part:?}");
        }
    }

    #[test]
    fn an_absent_error_source_has_no_share() {
        let mut layout = bar_layout();
        layout.apparatus.hammer_gain = 0.0;
        layout.sensors.iter_mut().for_each(|s| s.uncertainty.rotation = 0.0);
        for part in bar_parts(&layout) {
            let absent = [
                ErrorSource::HammerGain,
                ErrorSource::SensorRotation,
                ErrorSource::Attached,
                ErrorSource::Priors,
            ];
            let is_absent = absent.contains(&part.source) || OF_MODES.contains(&part.source);
            assert_eq!(part.share == 0.0, is_absent, "{part:?}");
        }
    }

    #[test]
    fn the_hammer_s_gain_is_all_in_the_mass_and_the_moments() {
        // The gain scales all accelerances alike, so the body seems heavier with the same centre of mass.
        let hammer = bar_parts(&bar_layout())
            .into_iter()
            .find(|part| part.source == ErrorSource::HammerGain)
            .unwrap();
        assert!(hammer.shares[0] > 0.5, "{hammer:?}");
        for k in 1..4 {
            // Rounding of the variances over the step.
            assert!(hammer.shares[k].abs() < 1e-6, "{hammer:?}");
        }
    }
}

//! What each method would answer in the suspension profile: a test is computed by formula, with noise, and solved.

use massline_physics::responses::{ObjectExtras, add_noise, frequency_responses};
use massline_physics::suspension::RigidMode;
use massline_shared::design::Predict;
use massline_shared::diagnosis::{Diagnostic, Diagnostics};
use massline_shared::identify::Method;
use massline_shared::layout::{Hit, HostLayout, motion_at};
use massline_shared::modes::norm_indicator_of_shape;
use massline_shared::signal::{SPECTRUM_BINS, resolution};
use nalgebra::Vector6;

use super::assumptions::HangingObject;
use super::{LayoutCriterion, PredictedUncertainty, methods_of};
use crate::Result;
use crate::bench_error::bench_error;
use crate::suspension::{DofLines, ModeRow, TestLines};

/// Seed of the noise: any, because what is read of the answers are their standard deviations.
const SEED: u64 = 1;

/// What each method would answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Forecast {
    /// The methods with an answer, best first, and how uncertain it is.
    pub answers: Vec<(Method, PredictedUncertainty)>,
    /// The methods without one, and why.
    pub refusals: Vec<(Method, Diagnostics)>,
    /// How uncertain the combined answer is.
    pub combined: Option<PredictedUncertainty>,
    /// The modes of the object, and how much of each a hit shows.
    pub modes: Vec<ModeRow>,
}

impl Forecast {
    /// True when a method would answer.
    pub fn has_answer(&self) -> bool {
        !self.answers.is_empty()
    }

    /// Why the first of the methods would not answer, when none of them would.
    pub fn first_reason(&self) -> Option<(Method, Diagnostic)> {
        let (method, reasons) = self.refusals.first().filter(|_| !self.has_answer())?;
        let reason = reasons.iter().find(|reason| reason.is_error()).or(reasons.first())?;
        Some((*method, *reason))
    }
}

/// Computes one test of the assumed object and solves it. `progress` is told how many of all changes are done.
///
/// # Errors
/// When the object cannot hang as described.
pub fn forecast(
    layout: &HostLayout,
    hanging: &HangingObject,
    criterion: &LayoutCriterion,
    progress: impl FnMut(u32, u32) + Send,
) -> Result<Forecast> {
    let lines = computed(layout, hanging, criterion)?;
    let wanted = methods_of(layout.test.profile);
    let predicted = |variances| PredictedUncertainty::new(&variances, criterion.scale());
    let modes = hanging.modes.iter().map(|mode| row(mode, layout)).collect();
    Ok(match lines.solve(hanging.record_s(layout), &wanted, progress) {
        Ok(solution) => {
            let answers = solution.estimates.iter().filter_map(|estimate| {
                Some((estimate.method, predicted(estimate.covariance?.diagonal())))
            });
            let combined = solution.comparison.agreement.as_ref();
            Forecast {
                answers: answers.collect(),
                refusals: solution.not_applicable,
                combined: combined.map(|agreement| predicted(agreement.covariance.diagonal())),
                modes,
            }
        }
        Err(reasons) => Forecast {
            answers: Vec::new(),
            refusals: wanted.into_iter().map(|method| (method, reasons.clone())).collect(),
            combined: None,
            modes,
        },
    })
}

/// A mode as it is, so nothing is uncertain.
fn row(mode: &RigidMode, layout: &HostLayout) -> ModeRow {
    let length = layout.characteristic_length();
    let center = layout.sensor_centroid();
    let motion = motion_at(&mode.shape, &center);
    let indicator =
        |hit: &Hit<f64>| norm_indicator_of_shape(&motion, &hit.unit_force(&center), length);
    ModeRow {
        frequency_hz: [mode.omega / std::f64::consts::TAU, 0.0],
        damping_ratio: [mode.damping_ratio, 0.0],
        shape: mode.shape,
        shape_sigma: Vector6::zeros(),
        complexity: 0.0,
        norm_indicators: layout.hits.iter().map(indicator).collect(),
    }
}

/// The lines of the test.
fn computed(
    layout: &HostLayout,
    HangingObject { bench, .. }: &HangingObject,
    criterion: &LayoutCriterion,
) -> Result<TestLines> {
    let adc = bench.converter(layout.sensors.len());
    let spacing: f64 = resolution(&adc, layout.test.profile);
    let frequencies: Vec<f64> = (0..SPECTRUM_BINS).map(|bin| bin as f64 * spacing).collect();
    let decay = layout.test.exponential_decay;
    let mut responses =
        frequency_responses(bench, layout, &frequencies, decay, &ObjectExtras::default())
            .map_err(bench_error)?;
    let hits_per_dof = f64::from(layout.test.hits_per_dof.max(1));
    add_noise(&mut responses, criterion.noise() / hits_per_dof.sqrt(), SEED, 0);
    let (channels, hits) = (3 * layout.sensors.len(), layout.hits.len());
    let of_dof = |dof: usize| {
        let place = move |channel: usize, bin: usize| (bin * channels + channel) * hits + dof;
        let places = (0..channels)
            .flat_map(|channel| (0..SPECTRUM_BINS).map(move |bin| place(channel, bin)));
        DofLines { dof, lines: places.map(|place| responses[place]).collect() }
    };
    let dofs: Vec<DofLines> = (0..hits).map(of_dof).collect();
    Ok(TestLines::new(layout, &adc, &dofs))
}

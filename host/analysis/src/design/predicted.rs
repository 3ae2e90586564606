//! The predicted uncertainty of a layout, what limits it, and the effect of one sensor or hit more or less.

use massline_shared::design::{Part, Predict, parts, total};
use massline_shared::identify::maximum_likelihood::workspace;
use massline_shared::layout::{Dof, HostLayout};
use nalgebra::SVector;

use super::{Assumptions, Candidates, LayoutCriterion, LayoutFindings};
use massline_files::layout_file::LayoutFile;

/// The predicted uncertainty of a layout.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PredictedUncertainty {
    /// Standard deviations of the ten properties, SI units.
    pub sigma: [f64; 10],
    /// Standard deviations in % of [m, L, L, L, m L² × 6].
    pub percent_of_scale: [f64; 10],
    /// Their root mean square.
    pub total_percent_of_scale: f64,
}

/// The prediction for a layout before any measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct DesignReport {
    /// Which methods are applicable, and what is to be said of the layout.
    pub findings: LayoutFindings,
    /// The predicted uncertainty; `None` when the layout does not determine the ten properties.
    pub predicted: Option<PredictedUncertainty>,
    /// Contribution of each error source to the uncertainty; empty without a prediction.
    pub parts: Vec<Part<f64>>,
    /// The effect of one sensor or hit more or less; `None` without a prediction.
    pub advice: Option<Advice>,
    /// The criterion of the prediction: body, noise and scale.
    pub criterion: LayoutCriterion,
    /// A sentence that names the body of the criterion.
    pub whose: String,
}

/// Total uncertainty, in % of scale, of layouts that differ by one sensor or hit.
#[derive(Clone, Debug, PartialEq)]
pub struct Advice {
    /// The additional hit that helps most, and the total with it.
    pub further_hit: Option<(Dof, f64)>,
    /// The node at which an additional sensor helps most, and the total with it.
    pub further_sensor: Option<(u16, f64)>,
    /// The total without each of the hits; `None` where the rest does not determine the ten properties.
    pub without_hits: Vec<Option<f64>>,
    /// The total without each of the sensors.
    pub without_sensors: Vec<Option<f64>>,
}

impl PredictedUncertainty {
    /// The prediction for a layout; `None` when it does not determine the ten properties.
    pub(super) fn of(criterion: &LayoutCriterion, layout: &HostLayout) -> Option<Self> {
        let mut memory = memory(layout);
        criterion.cost(layout, &mut memory)?;
        let variances = criterion.variances(layout, &mut memory)?;
        let determined = criterion.is_determined(&variances, layout);
        determined.then(|| Self::new(&variances, criterion.scale()))
    }

    /// These variances of `theta`, in SI units, and over these scales.
    pub(super) fn new(variances: &SVector<f64, 10>, scale: &SVector<f64, 10>) -> Self {
        let sigma = variances.map(f64::sqrt);
        let relative = sigma.component_div(scale);
        Self {
            sigma: sigma.into(),
            percent_of_scale: (relative * 100.0).into(),
            total_percent_of_scale: percent(relative.norm_squared()),
        }
    }
}

impl DesignReport {
    /// The prediction for a layout file under these assumptions, with `noise` relative to 1/m.
    pub fn of(file: &LayoutFile, assumed: &Assumptions, noise: f64) -> Self {
        let layout = &file.layout;
        let criterion = assumed.criterion(layout, layout.characteristic_length(), noise);
        Self::with(file, layout, criterion, assumed.whose.clone())
    }

    /// The same of a test that was made: `measured` is its layout, of which `file` states the nodes, and the criterion
    /// is for the body that was found.
    pub fn of_test(file: &LayoutFile, measured: &HostLayout, criterion: LayoutCriterion) -> Self {
        Self::with(file, measured, criterion, "the body that was found".into())
    }

    fn with(
        file: &LayoutFile,
        layout: &HostLayout,
        criterion: LayoutCriterion,
        whose: String,
    ) -> Self {
        let findings = LayoutFindings::new(layout, criterion.body());
        let possible = findings.admits_any();
        let predicted = if possible { PredictedUncertainty::of(&criterion, layout) } else { None };
        let parts = predicted.and_then(|_| parts(&criterion, layout, &mut memory(layout)));
        let candidates = Candidates::of(file).beyond(layout);
        Self {
            findings: if predicted.is_some() { findings } else { findings.without_answer() },
            predicted,
            parts: parts.map_or(Vec::new(), |parts| parts.to_vec()),
            advice: predicted.map(|_| Advice::of(&criterion, layout, candidates)),
            criterion,
            whose,
        }
    }
}

impl Advice {
    fn of(criterion: &LayoutCriterion, layout: &HostLayout, more: Candidates) -> Self {
        let memory = &mut memory(layout);
        let hit = criterion.best_further_hit(layout, more.hits, memory);
        let sensor = criterion.best_further_sensor(layout, more.sensors, memory);
        let percents = |cost: Option<f64>| cost.map(percent);
        let without_hits = criterion.costs_without_hits(layout, memory);
        let without_sensors = criterion.costs_without_sensors(layout, memory);
        Self {
            further_hit: hit.map(|(hit, cost)| (hit.dof, percent(cost))),
            further_sensor: sensor.map(|(sensor, cost)| (sensor.node, percent(cost))),
            without_hits: without_hits.into_iter().map(percents).collect(),
            without_sensors: without_sensors.into_iter().map(percents).collect(),
        }
    }
}

/// Working memory for the bound of a layout, with one more sensor and one more hit.
fn memory(layout: &HostLayout) -> Vec<f64> {
    vec![0.0; workspace(layout.sensors.len() + 1, layout.hits.len() + 1)]
}

/// Converts the sum of relative variances to the total in % that people read.
pub(super) fn percent(cost: f64) -> f64 {
    100.0 * total(cost)
}

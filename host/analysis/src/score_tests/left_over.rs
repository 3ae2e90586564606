//! What a fit leaves of the readings, and its covariance: `P = S⁻¹ − S⁻¹ J (Jᵀ S⁻¹ J)⁻¹ Jᵀ S⁻¹` with S the whole
//! covariance of the readings under the budget that the fit used, and J their slopes with the ten properties (theory,
//! sections 4 and 12). The priors are readings too.

use crate::single_fault::whole;
use massline_shared::body::{RigidBody, scale};
use massline_shared::capacity::Unbounded;
use massline_shared::identify::maximum_likelihood::readings_covariance;
use massline_shared::identify::{Consistency, DofMassLines, Estimate};
use massline_shared::layout::{ApparatusUncertainty, HitUncertainty, HostLayout};
use massline_shared::responses::Responses;
use nalgebra::{DMatrix, DVector};

use super::fault_estimate::{FaultEstimate, FoundSize};

/// Step of the properties over their scale for slopes of the readings, which are nearly linear in them.
const STEP: f64 = 1e-5;
/// Smallest standard deviation of a reading over the largest one of its hit, as in the fit.
const LEAST_NOISE: f64 = 1e-4;
/// Fewest degrees of freedom that a fault leaves where the scale of the errors is learned from them.
const LEAST_FREEDOM: f64 = 5.0;

/// What a fit leaves of the readings.
pub(super) struct LeftOver<'a> {
    /// The layout with the budget that the fit used.
    pub(super) layout: HostLayout,
    pub(super) lines: &'a [DofMassLines<f64, Unbounded>],
    /// The answer, with everything that is attached to it.
    pub(super) whole: RigidBody<f64>,
    inverse: DMatrix<f64>,
    projection: DMatrix<f64>,
    /// `P r`.
    projected: DVector<f64>,
    /// Change of the ten properties over their standard deviations with each reading.
    response: DMatrix<f64>,
    /// Covariance that the sensors alone give the readings: the part that a learned scale is on.
    of_sensors: DMatrix<f64>,
    /// χ² of what is left, and its degrees of freedom.
    consistency: Consistency<f64>,
    /// Degrees of freedom of the learned scale; infinite without one.
    freedom: f64,
}

impl<'a> LeftOver<'a> {
    /// `None` where the answer has no standard deviations, or the readings do not determine it.
    pub(super) fn of(
        layout: HostLayout,
        lines: &'a [DofMassLines<f64, Unbounded>],
        answer: &Estimate<f64>,
        log_variance: Option<f64>,
    ) -> Option<Self> {
        let whole = whole(&layout, &answer.body)?;
        let sigma = answer.sigma()?;
        let of_readings = DVector::from_vec(residuals(&layout, lines, &whole)?);
        let covariance = covariance_of(&layout, &answer.body, lines, true)?;
        let of_sensors = covariance_of(&sensors_alone(&layout), &answer.body, lines, false)?;
        let slopes = slopes(&layout, lines, answer)?;
        // A prior is a reading of one property, whose standard deviation is its unit.
        let count = of_readings.len() + layout.priors.len();
        let mut jacobian = slopes.resize_vertically(count, 0.0);
        let mut residuals = of_readings.resize_vertically(count, 0.0);
        let mut covariance = covariance.resize(count, count, 0.0);
        let theta = answer.theta();
        for (row, prior) in (count - layout.priors.len()..).zip(&layout.priors) {
            let property = usize::from(prior.property);
            jacobian[(row, property)] = prior.sigma.recip();
            residuals[row] = (prior.value - theta.get(property)?) / prior.sigma;
            covariance[(row, row)] = 1.0;
        }
        let inverse = covariance.cholesky()?.inverse();
        let weighted = &inverse * &jacobian;
        let units = DMatrix::from_diagonal(&DVector::from_iterator(10, sigma.iter().copied()));
        // In standard deviations of the properties, which differ by orders of magnitude.
        let information = &units * jacobian.transpose() * &weighted * &units;
        let explained = information.cholesky()?.inverse() * &units * weighted.transpose();
        let projection = &inverse - &weighted * &units * &explained;
        let projected = &projection * &residuals;
        let degrees_of_freedom = count.saturating_sub(10) as u16;
        Some(Self {
            consistency: Consistency { chi_squared: residuals.dot(&projected), degrees_of_freedom },
            projected,
            lines,
            whole,
            inverse,
            projection,
            response: explained,
            of_sensors: of_sensors.resize(count, count, 0.0),
            freedom: log_variance.filter(|v| *v > 0.0).map_or(f64::INFINITY, |v| 0.5 / v),
            layout,
        })
    }

    /// The readings of all hits in one column.
    pub(super) fn column(
        &self,
        of_hit: impl Fn(usize, usize) -> Option<Responses<f64, Unbounded>>,
    ) -> Option<DVector<f64>> {
        let channels = 3 * self.layout.sensors.len();
        let mut column = DVector::zeros(self.projected.len());
        for (place, (hit, _)) in self.lines.iter().enumerate() {
            let readings = of_hit(place, *hit)?;
            for (to, value) in
                column.iter_mut().skip(place * channels).zip(readings.iter().take(channels))
            {
                *to = *value;
            }
        }
        Some(column)
    }

    /// The readings of a layout at the answer.
    pub(super) fn readings(&self, layout: &HostLayout) -> Option<DVector<f64>> {
        self.column(|_, hit| layout.accelerance(&self.whole, hit))
    }

    /// Largest change of a property, in its standard deviations, when the ends of the band are left out.
    pub(super) fn band_shift(&self) -> Option<f64> {
        let channels = 3 * self.layout.sensors.len();
        let shift = |place: usize, _| {
            let of_lines = &self.lines.get(place)?.1.band_shift;
            Some(Responses::from_fn(channels / 3, |k| of_lines[k]))
        };
        Some((&self.response * self.column(shift)?).amax())
    }

    /// What the data show of a fault that makes these changes of the readings, along the directions in which one standard
    /// deviation of its size is not more than `largest`; `None` where there is none.
    pub(super) fn estimate(&self, changes: &DMatrix<f64>, largest: f64) -> Option<FaultEstimate> {
        let own = changes.transpose() * &self.projection * changes;
        let all = changes.transpose() * &self.inverse * changes;
        let scores = changes.transpose() * &self.projected;
        let found = FoundSize::of(&own, &all.diagonal(), &scores, largest)?;
        let (size, squares, degrees) = (&found.size, found.squares(), found.degrees());
        // The change would also explain a part of the errors of the sensors, from whose size the scale is learned.
        let left = &self.projected - &self.projection * (changes * size);
        let pulls = |left: &DVector<f64>| left.dot(&(&self.of_sensors * left));
        let without = pulls(&left) / pulls(&self.projected);
        let freedom = f64::from(self.consistency.degrees_of_freedom) - degrees as f64;
        let chi_squared = if self.freedom.is_finite() {
            // Of a handful of readings a fault may take nearly all errors along, which says nothing.
            if freedom < LEAST_FREEDOM || without.is_nan() || without <= 0.0 {
                return None;
            }
            // As for Student's distribution (Wallace 1959): the scale is an estimate.
            let ratio = squares / without.min(1.0);
            (self.freedom + 0.5 * degrees as f64 - 1.0) * (ratio / self.freedom).ln_1p()
        } else {
            // In units of what the fault leaves.
            let reduced = (self.consistency.chi_squared - squares) / freedom.max(1.0);
            squares / reduced.max(1.0)
        };
        Some(found.estimate(&(&self.response * changes), chi_squared))
    }
}

/// Measured minus modelled readings of all hits. Directions that scatter shorten the force (theory, section 12).
fn residuals(
    layout: &HostLayout,
    lines: &[DofMassLines<f64, Unbounded>],
    whole: &RigidBody<f64>,
) -> Option<Vec<f64>> {
    let channels = 3 * layout.sensors.len();
    let mut residuals = Vec::with_capacity(channels * lines.len());
    for (hit, lines) in lines {
        let HitUncertainty { direction, node_direction, .. } = layout.hits.get(*hit)?.uncertainty;
        let along = 1.0 - direction * direction - node_direction * node_direction;
        let modelled = layout.accelerance(whole, *hit)?;
        let both = lines.accelerance.iter().zip(modelled.iter()).take(channels);
        residuals.extend(both.map(|(measured, modelled)| measured / along.max(0.5) - modelled));
    }
    Some(residuals)
}

/// Slopes of all readings with the ten properties, each over its own unit.
fn slopes(
    layout: &HostLayout,
    lines: &[DofMassLines<f64, Unbounded>],
    answer: &Estimate<f64>,
) -> Option<DMatrix<f64>> {
    let theta = answer.theta();
    let unit = scale(answer.body.mass, layout.characteristic_length());
    let channels = 3 * layout.sensors.len();
    let mut slopes = DMatrix::zeros(channels * lines.len(), 10);
    for property in 0..10 {
        let step = STEP * unit[property];
        let at = |step: f64| {
            let mut moved = theta;
            moved[property] += step;
            whole(layout, &RigidBody::from_theta(&moved))
        };
        let (ahead, behind) = (at(step)?, at(-step)?);
        for (place, (hit, _)) in lines.iter().enumerate() {
            let change = &layout.accelerance(&ahead, *hit)? - &layout.accelerance(&behind, *hit)?;
            for (k, value) in change.iter().take(channels).enumerate() {
                slopes[(place * channels + k, property)] = value / (2.0 * step);
            }
        }
    }
    Some(slopes)
}

/// The layout whose sensors alone have errors.
fn sensors_alone(layout: &HostLayout) -> HostLayout {
    let mut layout = layout.clone();
    layout.hits.iter_mut().for_each(|hit| hit.uncertainty = HitUncertainty::none());
    layout.apparatus = ApparatusUncertainty::none();
    layout.attached.iter_mut().for_each(|body| body.relative_sigma = 0.0);
    layout
}

/// The covariance of all readings, with their noise or without.
fn covariance_of(
    layout: &HostLayout,
    body: &RigidBody<f64>,
    lines: &[DofMassLines<f64, Unbounded>],
    with_noise: bool,
) -> Option<DMatrix<f64>> {
    let channels = 3 * layout.sensors.len();
    let mut covariance = DMatrix::zeros(channels * lines.len(), channels * lines.len());
    for (i, (first, of_first)) in lines.iter().enumerate() {
        let least = if with_noise { of_first.accelerance.largest() * LEAST_NOISE } else { 0.0 };
        let mut own = of_first.clone();
        own.noise = own.noise.map(|sigma| if with_noise { sigma.max(least) } else { 0.0 });
        for (k, (second, _)) in lines.iter().enumerate().skip(i) {
            let block = readings_covariance(layout, body, (*first, &own), *second)?;
            for (row, column) in (0..channels).flat_map(|r| (0..channels).map(move |c| (r, c))) {
                let value = block[(row, column)];
                covariance[(i * channels + row, k * channels + column)] = value;
                covariance[(k * channels + column, i * channels + row)] = value;
            }
        }
    }
    Some(covariance)
}

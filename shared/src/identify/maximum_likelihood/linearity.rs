//! Finds a channel whose readings are not proportional to the force: one that compresses, or a sensor that
//! rattles.
//!
//! Repeat hits differ in force, and a linear chain answers all of them with the same accelerances. What hits that
//! land elsewhere change lies in a space of four dimensions, so the remaining ones compare hits of different force
//! to within their noise (theory, section 12).

use super::fit_problem::FitProblem;
use super::model::{HIT_NUISANCES, Model};
use crate::Real;
use crate::identify::{DofMassLines, Estimate, MassLines};
use crate::layout::Layout;
use crate::responses::Responses;
use crate::signal::HAMMER;

/// A trend is significant beyond this number of standard deviations. Ten channels are tested, so chance exceeds it
/// in one of sixteen hundred tests.
const SIGNIFICANT: f64 = 4.0;
/// Pulses of different length excite elastic modes differently, which changes accelerances by this part of the
/// largest.
const ELASTIC: f64 = 2e-3;

/// A channel that is not proportional to the force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NonlinearChannel<R> {
    /// The channel: 0 is the hammer, then three for each sensor.
    pub channel: usize,
    /// Relative change of its reading at the largest one, which it has at the mean force of a DOF; negative where
    /// it reads too little.
    pub change: R,
    /// That change over its standard deviation.
    pub significance: R,
}

/// Weighted sums over the DOFs for one channel: a change of its accelerances `a` that is proportional to `a³F²`,
/// as that of a channel that compresses.
#[derive(Clone, Copy)]
struct Score<R> {
    score: R,
    information: R,
    /// Scatter of the single hits under the weights, and its expected value.
    scatter: [R; 2],
    /// Largest squared reading at the mean force, (m/s²)² or N².
    largest: R,
}

/// The channel with the most significant trend under the body of an estimate; `None` when there is none or the
/// hits do not differ in force.
///
/// The reading of channel `k` is taken as `a F (1 + c a²F²)`; the score test (Rao 1948) of `c = 0` weighs the
/// trends with the noise and the scatter of single hits.
// Not inlined, for the firmware's deepest stack.
#[inline(never)]
pub fn nonlinear_channel<R: Real, const S: usize, const H: usize>(
    layout: &Layout<R, S, H>,
    dofs: &[DofMassLines<R, S>],
    estimate: &Estimate<R>,
) -> Option<NonlinearChannel<R>> {
    let scales = estimate.learned.map_or_else(Default::default, |learned| learned.scales);
    let problem = FitProblem::new(layout).with_budget(scales, true);
    let object = problem.balance.body(&estimate.body);
    let model = Model::new(layout, &problem.balance, &problem.body_of(&object.phi())?)?;
    let mut worst: Option<NonlinearChannel<R>> = None;
    for channel in HAMMER..=problem.channels {
        let sums = scores(&problem, &model, dofs, channel)?;
        let change = sums.score / sums.information * sums.largest;
        let significance =
            sums.score / (sums.information * sums.scatter[0] / sums.scatter[1]).sqrt();
        // A comparison with NaN is false.
        if significance.abs() > worst.map_or(R::of(SIGNIFICANT), |worst| worst.significance.abs()) {
            worst = Some(NonlinearChannel { channel, change, significance });
        }
    }
    worst
}

fn scores<R: Real, const S: usize, const H: usize>(
    problem: &FitProblem<'_, R, S, H>,
    model: &Model<R, S>,
    dofs: &[DofMassLines<R, S>],
    channel: usize,
) -> Option<Score<R>> {
    let mut sums = Score {
        score: R::zero(),
        information: R::zero(),
        scatter: [R::zero(); 2],
        largest: R::zero(),
    };
    for (index, lines) in dofs {
        let MassLines { accelerance, trend, hits, .. } = lines;
        if trend.squares <= R::zero() {
            continue;
        }
        let noise = R::of(f64::from(*hits)).sqrt();
        let elastic = accelerance.amax() * R::of(ELASTIC);
        let of_one =
            lines.noise.map(|sigma| (sigma * sigma * noise * noise + elastic * elastic).sqrt());
        let hit = problem.layout.hits.get(*index)?;
        let errors = [R::zero(); HIT_NUISANCES];
        let uncertainty = problem.hit_uncertainty(*index)?;
        let weight = model
            .hit(hit, &uncertainty, &problem.balance, 1, &errors)?
            .weight(&of_one, problem.channels)?;
        let mut direction = Responses::<R, S>::zeros();
        let reading = if channel == HAMMER {
            // A hammer that reads too little makes every accelerance too large.
            direction = -accelerance;
            R::one()
        } else {
            let own = accelerance[channel - 1];
            direction[channel - 1] = own * own * own;
            own
        };
        let weighted = weight.times(&direction);
        let freedom = R::of(f64::from(hits.max(&1) - 1));
        for k in 0..problem.channels {
            let row = (0..problem.channels).map(|i| weight[(i, k)] * lines.scatter[(i, k)]);
            sums.scatter[0] += row.fold(R::zero(), |sum, v| sum + v) * freedom;
        }
        sums.scatter[1] += R::of(problem.channels as f64) * freedom;
        sums.score += weighted.dot(&trend.products);
        sums.information += weighted.dot(&direction) * trend.squares;
        sums.largest = sums.largest.max(reading * reading * trend.mean);
    }
    Some(sums)
}

#[cfg(test)]
mod tests;

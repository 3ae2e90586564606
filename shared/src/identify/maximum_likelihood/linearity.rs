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
use crate::responses::ResponseSquare;

/// A trend is significant beyond this number of standard deviations. Ten channels are tested, so chance exceeds it
/// in one of sixteen hundred tests.
const SIGNIFICANT: f64 = 4.0;
/// Pulses of different length excite elastic modes differently, which changes accelerances by this part of the
/// largest.
const ELASTIC: f64 = 2e-3;

/// A channel that is not proportional to the force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NonlinearChannel<R> {
    /// The response, or `None` for the hammer.
    pub response: Option<usize>,
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
    /// Largest squared reading at the mean force, (m/s²)² or N².
    largest: R,
}

/// The sums for all channels.
struct Scores<R, const S: usize> {
    hammer: Score<R>,
    responses: [[Score<R>; 3]; S],
    /// Scatter of the single hits under the weights, and its expected value.
    scatter: [R; 2],
}

/// The channel with the most significant trend under the body of an estimate; `None` when there is none or the
/// hits do not differ in force.
///
/// The reading of a channel is taken as `a F (1 + c a²F²)`; the score test (Rao 1948) of `c = 0` weighs the
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
    let mut sums = Scores::none();
    for (index, lines) in dofs.iter().filter(|(_, lines)| lines.trend.squares > R::zero()) {
        sums.add(&problem, &model, *index, lines)?;
    }
    let found = sums.all().map(|(response, sum)| {
        let information = sum.information * sums.scatter[0] / sums.scatter[1];
        NonlinearChannel {
            response,
            change: sum.score / sum.information * sum.largest,
            significance: sum.score / information.sqrt(),
        }
    });
    // A comparison with NaN is false.
    found
        .filter(|one| one.significance.abs() > R::of(SIGNIFICANT))
        .reduce(|a, b| if b.significance.abs() > a.significance.abs() { b } else { a })
}

impl<R: Real> Score<R> {
    fn none() -> Self {
        Self { score: R::zero(), information: R::zero(), largest: R::zero() }
    }

    /// Adds a DOF.
    fn add(&mut self, score: R, information: R, largest: R) {
        self.score += score;
        self.information += information;
        self.largest = self.largest.max(largest);
    }
}

impl<R: Real, const S: usize> Scores<R, S> {
    fn none() -> Self {
        let (hammer, responses) = (Score::none(), [[Score::none(); 3]; S]);
        Self { hammer, responses, scatter: [R::zero(); 2] }
    }

    /// The hammer, then the responses.
    fn all(&self) -> impl Iterator<Item = (Option<usize>, Score<R>)> + '_ {
        let responses = self.responses.as_flattened().iter().enumerate();
        let responses = responses.map(|(response, sum)| (Some(response), *sum));
        core::iter::once((None, self.hammer)).chain(responses)
    }

    /// Adds a hit DOF; `None` when the model cannot be evaluated.
    fn add<const H: usize>(
        &mut self,
        problem: &FitProblem<'_, R, S, H>,
        model: &Model<R, S>,
        index: usize,
        lines: &MassLines<R, S>,
    ) -> Option<()> {
        let MassLines { accelerance, trend, .. } = lines;
        let weight = weight_of_one(problem, model, index, lines)?;
        let freedom = R::of(f64::from(lines.hits.max(1) - 1));
        let both = weight.as_slice().iter().zip(lines.scatter.as_slice());
        self.scatter[0] += both.fold(R::zero(), |sum, (w, s)| sum + *w * *s) * freedom;
        self.scatter[1] += R::of(problem.channels as f64) * freedom;
        // The weighted trends.
        let trends = weight.times(&trend.products);
        for (k, sum) in self.responses.as_flattened_mut().iter_mut().enumerate() {
            let a = accelerance[k];
            let cubed = a * a * a;
            let information = cubed * cubed * weight[(k, k)] * trend.squares;
            sum.add(cubed * trends[k], information, a * a * trend.mean);
        }
        // A hammer that reads too little makes every accelerance too large.
        let information = accelerance.dot(&weight.times(accelerance)) * trend.squares;
        self.hammer.add(-accelerance.dot(&trends), information, trend.mean);
        Some(())
    }
}

/// Inverse covariance of the accelerances of one hit at a DOF.
fn weight_of_one<R: Real, const S: usize, const H: usize>(
    problem: &FitProblem<'_, R, S, H>,
    model: &Model<R, S>,
    index: usize,
    lines: &MassLines<R, S>,
) -> Option<ResponseSquare<R, S>> {
    let hit = problem.layout.hits.get(index)?;
    let uncertainty = problem.hit_uncertainty(index)?;
    let (none, balance) = ([R::zero(); HIT_NUISANCES], &problem.balance);
    let model = model.hit(hit, &uncertainty, balance, 1, &none)?;
    let largest = lines.accelerance.amax();
    // The scatter has four dimensions to first order only.
    let second_order = lines.scatter.diagonal().sum() / lines.accelerance.norm_squared();
    let common = largest * second_order.max(R::of(ELASTIC));
    let hits = R::of(f64::from(lines.hits));
    let noise = lines.noise.map(|sigma| (sigma * sigma * hits + common * common).sqrt());
    model.weight(&noise, problem.channels)
}

#[cfg(test)]
mod tests;

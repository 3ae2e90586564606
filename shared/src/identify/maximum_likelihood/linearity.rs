//! Finds a channel whose readings are not proportional to the force: one that compresses, or a sensor that
//! rattles.
//!
//! Repeat hits differ in force, and a linear chain answers all of them with the same accelerances. What hits that
//! land elsewhere change lies in a space of four dimensions, so the remaining ones compare hits of different force
//! to within their noise. A response that compresses also reads less where its motion is large than where it is
//! small, which the residuals of the fit show (theory, section 12).

use heapless::Vec;

use super::fit::Fit;
use super::fit_problem::FitProblem;
use super::model::{HIT_NUISANCES, Model};
use super::normal_equations::NormalEquations;
use super::pulls::UnknownValues;
use super::score::{Score, ScoreOutcome, ScoresOfResponses, TOGETHER};
use super::undetermined;
use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity, Subject};
use crate::identify::{DofMassLines, MassLines};
use crate::real::Real;
use crate::responses::{ResponseSquare, Responses};

/// A response that reads too little with increasing force is suspected beyond this number of standard deviations.
/// About two are loud enough to be tested, so chance exceeds it in one of two hundred tests.
const COMPRESSES: f64 = 2.7;
/// The same for a response that reads too much, which is rarer, and for the hammer: one of five thousand tests.
const RARE: f64 = 4.0;
/// Only responses whose largest squared reading is at least this part of the loudest one's are tested, because the
/// others compress less than half as much; of more than [`TOGETHER`], the loudest.
const LOUD: f64 = 0.5;
/// Pulses of different length excite elastic modes differently, which changes accelerances by this part of the
/// largest.
const ELASTIC: f64 = 2e-3;

/// Weighted sums over the repeat hits for one channel: a change of its accelerances `a` that is proportional to
/// `a³F²`, as that of a channel that compresses.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Trend<R> {
    score: R,
    information: R,
    /// Largest squared reading at the mean squared force of a DOF, (m/s²)² or N².
    largest: R,
}

/// The sums for all channels.
struct Trends<R: Real, C: Capacity> {
    hammer: Trend<R>,
    responses: Responses<Trend<R>, C>,
    /// Scatter of the single hits under the weights, and its expected value.
    scatter: [R; 2],
}

impl<R: Real> Fit<R> {
    /// Tests all channels, from completed equations, and reports the most significant one.
    ///
    /// The reading of a channel is taken as `a F (1 + c a²F²)`; the test is of `c = 0`.
    ///
    /// # Errors
    /// When the model cannot be evaluated.
    // Never inlined: this saves 4.3 KB of the firmware's deepest stack.
    #[inline(never)]
    pub(super) fn test_linearity<C: Capacity>(
        &mut self,
        problem: &FitProblem<'_, R, C>,
        dofs: &[DofMassLines<R, C>],
        equations: &mut NormalEquations<'_, R>,
    ) -> Result<(), Diagnostics> {
        if dofs.iter().all(|(_, lines)| lines.trend.squares <= R::zero()) {
            return Ok(());
        }
        let trends = self.trends(problem, dofs).ok_or_else(undetermined)?;
        let sensors = problem.layout.sensors.len();
        let unknowns = UnknownValues::<R, C>::of(sensors, equations.solution());
        let unknowns = unknowns.ok_or_else(undetermined)?;
        let responses = trends.responses.as_slice();
        let mut scores = ScoresOfResponses::new();
        Score::of_responses(&unknowns, loudest(responses).into_iter(), &mut scores);
        self.visit(problem, dofs, equations, &unknowns, |lines, rows, left| {
            for (response, score) in &mut scores {
                let a = lines.accelerance[*response];
                score.add_response(rows, (*response, a * a * a * lines.trend.mean), left);
            }
        })?;
        let mut worst = (R::zero(), None);
        let mut judge = |response: Option<usize>, tested: ScoreOutcome<R>, largest: R| {
            let limit = match response {
                Some(_) if tested.size < R::zero() => COMPRESSES,
                _ => RARE,
            };
            let beyond = tested.significance.abs() / R::of(limit);
            // A comparison with NaN is false.
            if beyond > worst.0 {
                worst = (beyond, Some((response, tested.size * largest)));
            }
        };
        let scale = trends.scatter[1] / trends.scatter[0];
        let hammer = &trends.hammer;
        judge(None, hammer.tested(scale), hammer.largest);
        for (response, score) in &scores {
            let trend = &responses[*response];
            let tested = self.tested(score, &unknowns, equations).and(trend.tested(scale));
            judge(Some(*response), tested, trend.largest);
        }
        if let (beyond, Some((response, change))) = worst
            && beyond > R::one()
        {
            let subject = Subject::channel(response.map_or(0, |response| 1 + response));
            let code = Code::ChannelNotLinear;
            let diagnostic = Diagnostic::about(code, Severity::Warning, subject, change.to_f32());
            // There are only a handful of diagnostics.
            let _ = self.diagnostics.push(diagnostic);
        }
        Ok(())
    }

    /// The trends of the repeat hits of all DOFs; `None` when the model cannot be evaluated.
    fn trends<C: Capacity>(
        &self,
        problem: &FitProblem<'_, R, C>,
        dofs: &[DofMassLines<R, C>],
    ) -> Option<Trends<R, C>> {
        let body = problem.body_of(&self.object()?.phi())?;
        let model = Model::new(problem.layout, &problem.balance, &body)?;
        let mut trends = Trends::none(problem.layout.sensors.len());
        for (index, lines) in dofs.iter().filter(|(_, lines)| lines.trend.squares > R::zero()) {
            trends.add(problem, &model, *index, lines)?;
        }
        Some(trends)
    }
}

/// The numbers of the responses that are loud enough to be tested, the loudest first.
fn loudest<R: Real>(responses: &[Trend<R>]) -> Vec<usize, TOGETHER> {
    let mut numbers = Vec::new();
    let most = responses.iter().fold(R::zero(), |most, trend| most.max(trend.largest));
    while let Some((response, trend)) = responses
        .iter()
        .enumerate()
        .filter(|(response, _)| !numbers.contains(response))
        // A comparison with NaN is false.
        .reduce(|best, next| if next.1.largest > best.1.largest { next } else { best })
        && trend.largest >= most * R::of(LOUD)
        && numbers.push(response).is_ok()
    {}
    numbers
}

impl<R: Real> Trend<R> {
    fn none() -> Self {
        Self { score: R::zero(), information: R::zero(), largest: R::zero() }
    }

    /// Adds a DOF.
    fn add(&mut self, score: R, information: R, largest: R) {
        self.score += score;
        self.information += information;
        self.largest = self.largest.max(largest);
    }

    /// The test of the repeat hits alone.
    fn tested(&self, scale: R) -> ScoreOutcome<R> {
        let significance = self.score * scale / (self.information * scale).sqrt();
        ScoreOutcome { size: self.score / self.information, significance }
    }
}

impl<R: Real, C: Capacity> Trends<R, C> {
    fn none(sensors: usize) -> Self {
        let (hammer, responses) = (Trend::none(), Responses::repeat(sensors, Trend::none()));
        Self { hammer, responses, scatter: [R::zero(); 2] }
    }

    /// Adds a hit DOF; `None` when the model cannot be evaluated.
    fn add(
        &mut self,
        problem: &FitProblem<'_, R, C>,
        model: &Model<R, C>,
        index: usize,
        lines: &MassLines<R, C>,
    ) -> Option<()> {
        let MassLines { accelerance, trend, .. } = lines;
        let weight = weight_of_one(problem, model, index, lines)?;
        let freedom = R::of(f64::from(lines.hits.max(1) - 1));
        let both = weight.as_slice().iter().zip(lines.scatter.as_slice());
        self.scatter[0] += both.fold(R::zero(), |sum, (w, s)| sum + *w * *s) * freedom;
        self.scatter[1] += R::of(problem.channels as f64) * freedom;
        // The weighted trends.
        let trends = weight.times(&trend.products);
        for (k, sum) in self.responses.iter_mut().enumerate() {
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
fn weight_of_one<R: Real, C: Capacity>(
    problem: &FitProblem<'_, R, C>,
    model: &Model<R, C>,
    index: usize,
    lines: &MassLines<R, C>,
) -> Option<ResponseSquare<R, C>> {
    let hit = problem.layout.hits.get(index)?;
    let uncertainty = problem.hit_uncertainty(index)?;
    let (none, balance) = ([R::zero(); HIT_NUISANCES], &problem.balance);
    let model = model.hit(hit, &uncertainty, balance, 1, &none)?;
    let largest = lines.accelerance.largest();
    // The scatter has four dimensions to first order only.
    let second_order = lines.scatter.trace() / lines.accelerance.norm_squared();
    let common = largest * second_order.max(R::of(ELASTIC));
    let hits = R::of(f64::from(lines.hits));
    let noise = lines.noise.map(|sigma| (sigma * sigma * hits + common * common).sqrt());
    model.weight(&noise, problem.channels)
}

#[cfg(test)]
mod tests;

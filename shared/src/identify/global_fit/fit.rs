//! Levenberg-Marquardt steps with a noise that is estimated on the way.
//!
//! The cost is `Σ r²/w + Σ u² + priors` with the weight `w = σ² correlation²`. The variance σ² of a reading
//! comes from the residuals of the present step, over the degrees of freedom; the number of nuisance
//! parameters that the data determine counts among the parameters: `Σ (1 − P_kk)`.

use super::memory::Memory;
use super::problem::Problem;
use super::unknowns::Unknowns;
use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostics, fatal};
use crate::linalg::dot;
use crate::real::Real;

/// The fit ends with a step that lowers the cost by less than this: it changes no unknown by more than
/// 1e-4 of its standard deviation.
const CLOSE: f64 = 1e-8;
/// Decrease relative to the cost that its rounding hides.
const ROUNDING: f64 = 1e-11;
/// When the steps end before that, a decrease below this is close enough: a thirtieth of a standard deviation.
/// Directions of K that the data hardly determine can take many short steps.
const NEARLY: f64 = 1e-3;
/// Largest number of steps; five to fifteen are usual.
const MOST_STEPS: usize = 60;
/// Dampings tried before the fit concludes that no step lowers the cost.
const MOST_TRIALS: usize = 16;
/// First damping, relative to the diagonal.
const FIRST_DAMPING: f64 = 1e-3;
/// Smallest damping. Without it, rounding would decide about directions that the data do not determine; a larger one
/// would compete with the prior of the hammer, of which lightly damped modes say 1e-14 of what they say about the mass.
pub(super) const LEAST_DAMPING: f64 = 1e-15;
/// The noise has settled when the estimate changes by less than this fraction.
const SETTLED: f64 = 1e-2;
/// Rounds of estimating how many nuisance parameters the data determine.
const MOST_ROUNDS: usize = 3;
/// Smallest standard deviation relative to the root mean square of the readings, with a budget: the priors
/// must not drown in the rounding of the equations, and no sensor is better than a tenth of this.
const LEAST_NOISE: f64 = 5e-4;
/// The same without a budget, where only rounding counts.
const LEAST_ROUNDING: f64 = 1e-12;

/// The fit of one model at its present unknowns, which are in the memory.
pub(super) struct Fit<'p, 'a, 'w, R: Real, C: Capacity> {
    pub(super) problem: &'p Problem<'a, R, C>,
    pub(super) memory: Memory<'w, R>,
    pub(super) unknowns: Unknowns,
    /// Variance of a real reading.
    pub(super) variance: R,
    /// Smallest variance.
    least: R,
    /// Number of nuisance parameters that the data determine.
    determined: R,
    pub(super) damping: R,
}

impl<'p, 'a, 'w, R: Real, C: Capacity> Fit<'p, 'a, 'w, R, C> {
    pub(super) fn new(problem: &'p Problem<'a, R, C>, memory: Memory<'w, R>) -> Self {
        let least = if problem.settings.budget { LEAST_NOISE } else { LEAST_ROUNDING };
        let least = problem.size() * R::of(least).max(R::default_epsilon());
        Self {
            unknowns: problem.unknowns(0),
            problem,
            memory,
            variance: R::one(),
            least: least * least,
            determined: R::zero(),
            damping: R::of(FIRST_DAMPING),
        }
    }

    /// Variance of a reading with the correlation of neighbouring bins.
    pub(super) fn weight(&self) -> R {
        self.variance * self.problem.responses.correlation.powi(2)
    }

    /// Independent readings minus parameters; not positive when there are too few readings.
    pub(super) fn degrees_of_freedom(&self) -> R {
        let count = |n: usize| R::of(n as f64);
        let elastic = self.memory.equations.elastic.parts.len();
        let parameters = self.unknowns.len() - self.unknowns.nuisances() + elastic;
        count(self.problem.readings()) / self.problem.responses.correlation.powi(2)
            - count(parameters)
            - self.determined
    }

    /// Steps to the minimum from the present unknowns, and leaves the equations and the factor there.
    pub(super) fn descend(&mut self) -> Result<(), Diagnostics> {
        let refused = || fatal(Code::NotConverged, MOST_STEPS as f32);
        let mut rounds = 0;
        self.damping = R::of(FIRST_DAMPING);
        for step in 1..=MOST_STEPS {
            self.linearise().ok_or_else(refused)?;
            let gain = self.step().ok_or_else(refused)?;
            let going = if step < MOST_STEPS { CLOSE } else { NEARLY };
            if gain >= R::of(going) {
                continue;
            }
            if gain > R::zero() {
                self.linearise().ok_or_else(refused)?;
            }
            let before = self.variance;
            self.count_determined().ok_or_else(refused)?;
            rounds += 1;
            let change = (self.variance / before - R::one()).abs();
            if change < R::of(SETTLED) || rounds == MOST_ROUNDS {
                return self.complete().ok_or_else(refused);
            }
        }
        Err(refused())
    }

    /// Equations and noise at the present unknowns.
    pub(super) fn linearise(&mut self) -> Option<()> {
        let Self { problem, memory, unknowns, .. } = self;
        let len = unknowns.len();
        memory.equations.linearise(problem, unknowns, &memory.x[..len])?;
        self.estimate_noise();
        Some(())
    }

    fn estimate_noise(&mut self) {
        let correlation = self.problem.responses.correlation.powi(2);
        let squares = self.memory.equations.squares.max(R::zero());
        let freedom = (self.degrees_of_freedom() * correlation).max(R::one());
        self.variance = (squares / freedom).max(self.least);
    }

    /// One step; returns the decrease of the cost that was expected of it. A step that is not worth taking is
    /// not taken.
    fn step(&mut self) -> Option<R> {
        let cost = self.memory.equations.squares / self.weight() + self.penalty(false)?;
        for _trial in 0..MOST_TRIALS {
            if let Some(gain) = self.propose() {
                if gain.abs() < R::of(CLOSE) {
                    return Some(R::zero());
                }
                let lower = self.trial_cost().filter(|lower| *lower < cost);
                if lower.is_some() {
                    let len = self.unknowns.len();
                    let Memory { x, trial, .. } = &mut self.memory;
                    x[..len].copy_from_slice(&trial[..len]);
                    self.damping = (self.damping * R::of(0.1)).max(R::of(LEAST_DAMPING));
                    return Some(gain);
                }
                // Rounding of the cost hides what such a step gains.
                if gain < cost * R::of(ROUNDING) {
                    return Some(R::zero());
                }
            }
            self.damping *= R::of(10.0);
        }
        None
    }

    /// Computes the unknowns of a trial; returns the decrease of the cost that the linear equations expect.
    fn propose(&mut self) -> Option<R> {
        self.factorise(self.damping)?;
        let len = self.unknowns.len();
        let Memory { factor, x, trial, step, scale, scratch, .. } = &mut self.memory;
        for k in 0..len {
            scratch[k] = step[k] * scale[k];
        }
        trial[..len].copy_from_slice(&scratch[..len]);
        factor.solve(&mut trial[..len]);
        let gain = dot(&scratch[..len], &trial[..len]);
        for k in 0..len {
            trial[k] = x[k] + trial[k] * scale[k];
        }
        gain.finite().then_some(gain)
    }

    /// The decrease of the cost that the linear equations expect of a step.
    pub(super) fn expected_decrease(&mut self) -> Option<R> {
        self.damping = R::of(LEAST_DAMPING);
        self.propose()
    }

    fn trial_cost(&mut self) -> Option<R> {
        let penalty = self.penalty(true)?;
        let cost = self.squares_of_trial()? / self.weight() + penalty;
        cost.finite().then_some(cost)
    }

    /// Estimates the noise with the number of nuisance parameters that the data determine.
    fn count_determined(&mut self) -> Option<()> {
        let nuisances = self.unknowns.nuisances();
        if nuisances == 0 {
            return Some(());
        }
        self.factorise(R::of(LEAST_DAMPING))?;
        let len = self.unknowns.len();
        let Memory { factor, scale, scratch, trial, .. } = &mut self.memory;
        trial[..nuisances].fill(R::zero());
        factor.invert(len, scratch);
        for k in 0..len {
            // The diagonal of the inverse, from the inverse factor.
            for (variance, value) in trial[..nuisances].iter_mut().zip(factor.row(k)) {
                *variance += *value * *value;
            }
        }
        self.determined = R::zero();
        for (variance, scale) in trial[..nuisances].iter().zip(scale.iter()) {
            self.determined += (R::one() - *variance * *scale * *scale).max(R::zero());
        }
        self.estimate_noise();
        Some(())
    }

    /// The factor at the minimum, for covariances.
    pub(super) fn complete(&mut self) -> Option<()> {
        self.factorise(R::of(LEAST_DAMPING))
    }
}

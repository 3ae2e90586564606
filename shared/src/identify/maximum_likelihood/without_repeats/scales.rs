//! The three scales and what the residuals say about them: restricted maximum likelihood with a log-normal prior
//! (theory, section 12).

use nalgebra::{SMatrix, SVector};

use super::super::fit::Fit;
use super::super::fit_problem::FitProblem;
use super::super::intervals::WIDENING;
use super::super::learning::{LOG_SCALE_SIGMA, LONGEST_STEP, SHORT_STEP};
use super::super::model::{HIT_NUISANCES, Model, SENSOR_NUISANCES};
use super::super::normal_equations::NormalEquations;
use super::super::pulls::{HitPull, UnknownValues};
use super::super::undetermined;
use crate::capacity::{Capacity, List};
use crate::diagnosis::Diagnostics;
use crate::identify::budget::{BudgetScales, LearnedBudget, LearnedFrom};
use crate::identify::{DofMassLines, Progress};
use crate::linalg::{back_substitute_transposed, cholesky, dot, forward_substitute};
use crate::real::Real;

/// Number of groups of errors that have a scale.
pub const GROUPS: usize = 3;
/// The group of the positions of hits and marks.
pub const POSITION: usize = 0;
/// The group of the directions of hits and marks.
pub const DIRECTION: usize = 1;
/// The group of the errors of the sensors.
pub const SENSORS: usize = 2;
/// Largest number of steps. Readings without any error take the scales down to their rounding, by at most
/// [`LONGEST_STEP`] each time.
const MOST_STEPS: u8 = 30;

/// The group of a nuisance parameter of a hit.
pub(super) fn group_of_hit(nuisance: usize) -> usize {
    if nuisance < HIT_NUISANCES / 2 { POSITION } else { DIRECTION }
}

/// What the residuals say: with the pulls u of a group, their posterior covariance P and `H = I − P`.
#[derive(Clone, Debug, PartialEq)]
pub struct Evidence<R> {
    /// `Σ u²` of each group.
    pub pulls: SVector<R, GROUPS>,
    /// `tr H` of each group, which is what the squares of its pulls are expected to be.
    pub traces: SVector<R, GROUPS>,
    /// `|H|²`, Frobenius, of each block.
    pub squares: SMatrix<R, GROUPS, GROUPS>,
}

/// The logarithms of the learned over the stated standard deviations.
#[derive(Clone, Debug, PartialEq)]
pub struct Scales<R> {
    logarithms: SVector<R, GROUPS>,
    /// Their covariance.
    covariance: SMatrix<R, GROUPS, GROUPS>,
    /// False for a group without any stated error.
    informed: [bool; GROUPS],
    steps: u8,
}

impl<R: Real> Scales<R> {
    /// The stated budget, as certain as the prior.
    pub fn stated() -> Self {
        Self {
            logarithms: SVector::zeros(),
            covariance: SMatrix::identity() * R::of(LOG_SCALE_SIGMA * LOG_SCALE_SIGMA),
            informed: [false; GROUPS],
            steps: 0,
        }
    }

    /// Takes one step of Fisher's scoring; `None` when it is not finite.
    pub fn improve(&mut self, evidence: &Evidence<R>) -> Option<Progress> {
        let prior = R::of(1.0 / (LOG_SCALE_SIGMA * LOG_SCALE_SIGMA));
        let information = evidence.squares * R::of(2.0) + SMatrix::identity() * prior;
        let score = evidence.pulls - evidence.traces - self.logarithms * prior;
        let factor = cholesky(&information)?;
        let solved = |mut right: SVector<R, GROUPS>| {
            forward_substitute(&factor, &mut right);
            back_substitute_transposed(&factor, &mut right);
            right
        };
        let mut step = solved(score);
        let longest = R::of(LONGEST_STEP);
        step *= longest / step.amax().max(longest);
        for k in 0..GROUPS {
            let mut unit = SVector::zeros();
            unit[k] = R::one();
            self.covariance.set_column(k, &solved(unit));
            self.informed[k] = evidence.squares[(k, k)] > R::zero();
        }
        self.logarithms += step;
        self.steps += 1;
        let size = step.dot(&(information * step));
        let short = size < R::of(SHORT_STEP * SHORT_STEP);
        size.finite().then_some(match short || self.steps >= MOST_STEPS {
            true => Progress::Done,
            false => Progress::Going,
        })
    }

    /// The budget so far; nothing is known of its intervals.
    pub fn learned(&self) -> LearnedBudget<R> {
        let scale = |group: usize| R::of(libm::exp(self.logarithms[group].to_f64()));
        let variance = if self.informed[SENSORS] { self.variance(SENSORS) } else { R::zero() };
        LearnedBudget {
            scales: BudgetScales {
                hit_position: scale(POSITION),
                hit_direction: scale(DIRECTION),
                constant: scale(SENSORS),
            },
            scatter_degrees_of_freedom: 0,
            learned_from: LearnedFrom::Residuals,
            constant_log_variance: variance,
            widening: [R::one(); 10],
        }
    }

    fn variance(&self, group: usize) -> R {
        self.covariance[(group, group)]
    }

    /// True when a scale is significantly more than twice what is stated, as
    /// [`LearnedBudget::exceeds_statement`] has it.
    pub(super) fn exceed_statement(&self) -> bool {
        (0..GROUPS).any(|group| {
            let deviation = self.variance(group).to_f64();
            self.logarithms[group].to_f64() - 2.0 * libm::sqrt(deviation) > core::f64::consts::LN_2
        })
    }

    /// Factors on the half widths of the intervals, from the groups' shares in the variances.
    pub(super) fn widening(&self, shares: &[SVector<R, 10>; GROUPS]) -> SVector<R, 10> {
        SVector::from_fn(|k, _| {
            let of_groups = SVector::<R, GROUPS>::from_fn(|group, _| shares[group][k]);
            R::one() + of_groups.dot(&(self.covariance * of_groups)) * R::of(WIDENING)
        })
    }
}

impl<R: Real> Fit<R> {
    /// What the evaluated equations say about the scales. `products` has room for one column of all unknowns for each
    /// nuisance parameter of a hit. Afterwards the equations cannot be used.
    pub(super) fn evidence<C: Capacity>(
        &self,
        problem: &FitProblem<'_, R, C>,
        dofs: &[DofMassLines<R, C>],
        equations: &mut NormalEquations<'_, R>,
        products: &mut [R],
    ) -> Result<Evidence<R>, Diagnostics> {
        let of_sensors = SENSOR_NUISANCES * problem.layout.sensors.len();
        equations.complete().ok_or_else(undetermined)?;
        let solution = equations.solution();
        let unknowns = UnknownValues::<R, C>::of(problem.layout.sensors.len(), solution);
        let unknowns = unknowns.ok_or_else(undetermined)?;
        let mut pulls = SVector::<R, GROUPS>::zeros();
        pulls[SENSORS] = squared(&solution[..of_sensors]);
        let mut squares = SMatrix::<R, GROUPS, GROUPS>::zeros();
        let count = solution.len();
        let body = problem.body_of(&self.parameters.phi()).ok_or_else(undetermined)?;
        let model = Model::new(problem.layout, &problem.balance, &body).ok_or_else(undetermined)?;
        // Zᵀ W Z of each DOF, with the readings Z for one standard deviation of each nuisance parameter.
        let mut own = C::Hits::<[[R; HIT_NUISANCES]; HIT_NUISANCES]>::default();
        let mut columns = products.chunks_exact_mut(count);
        for (place, (index, lines)) in dofs.iter().enumerate() {
            let errors = equations.hit_errors(place);
            let terms = problem.terms(&model, *index, lines, &errors).ok_or_else(undetermined)?;
            let spread = &terms.model.spread.0;
            let weighted = spread.each_ref().map(|column| terms.weight.times(column));
            let products =
                weighted.each_ref().map(|column| spread.each_ref().map(|other| other.dot(column)));
            own.push(products).ok().ok_or_else(undetermined)?;
            let room = problem.with_rows(&model, &terms, |rows| {
                let left = unknowns.left(rows);
                let values = HitPull::of(&terms, &left, problem.channels).values;
                for (k, (weighted, value)) in weighted.iter().zip(values).enumerate() {
                    let group = group_of_hit(k);
                    pulls[group] += value * value;
                    let column = columns.next()?;
                    equations.project_readings(rows, weighted, column);
                    let with_sensors = squared(&equations.solve_projected(column)[..of_sensors]);
                    squares[(group, SENSORS)] += with_sensors;
                    squares[(SENSORS, group)] += with_sensors;
                }
                Some(())
            });
            room.ok_or_else(undetermined)?;
        }
        let mut traces = SVector::<R, GROUPS>::zeros();
        let columns = products.chunks_exact(count).take(HIT_NUISANCES * own.len());
        for (a, column) in columns.clone().enumerate() {
            let (place, k) = (a / HIT_NUISANCES, a % HIT_NUISANCES);
            for (b, other) in columns.clone().enumerate() {
                let same = b / HIT_NUISANCES == place;
                let alone = if same { own[place][k][b % HIT_NUISANCES] } else { R::zero() };
                let element = alone - dot(column, other);
                let groups = (group_of_hit(k), group_of_hit(b % HIT_NUISANCES));
                squares[groups] += element * element;
                if a == b {
                    traces[groups.0] += element;
                }
            }
        }
        (traces[SENSORS], squares[(SENSORS, SENSORS)]) = equations.shrinkage(of_sensors);
        Ok(Evidence { pulls, traces, squares })
    }
}

fn squared<R: Real>(values: &[R]) -> R {
    dot(values, values)
}

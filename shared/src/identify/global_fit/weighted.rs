//! The equations with noise and priors, their factor, and the cost of a trial.

use super::apparatus::Apparatus;
use super::elastic::ROOM;
use super::fit::Fit;
use super::memory::Memory;
use super::unknowns::{SYMMETRIC, along};
use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostics, fatal};
use crate::linalg::{dot, triangle};
use crate::real::Real;

/// Smallest pivot of the matrix with unit columns.
const LEAST_PIVOT: f64 = 1e-16;
/// Smallest part of a column of K that no other column explains; a smaller one is rounding and damping.
const LEAST_OWN_PART: f64 = 1e-5;

impl<R: Real, C: Capacity> Fit<'_, '_, '_, R, C> {
    /// Factors the equations with noise, priors and damping, with unit columns. The right side is in `step`,
    /// the scale of the columns in `scale`.
    pub(super) fn factorise(&mut self, damping: R) -> Option<()> {
        let weight = self.weight().recip();
        let len = self.unknowns.len();
        {
            let Memory { equations, factor, step, .. } = &mut self.memory;
            for (to, from) in factor.0[..triangle(len)].iter_mut().zip(&*equations.matrix.0) {
                *to = *from * weight;
            }
            for (to, from) in step[..len].iter_mut().zip(&*equations.right) {
                *to = *from * weight;
            }
        }
        self.add_priors()?;
        let Memory { factor, scale, .. } = &mut self.memory;
        for k in 0..len {
            let diagonal = factor.at(k, k);
            let used = *diagonal > R::zero();
            scale[k] = if used { diagonal.sqrt().recip() } else { R::one() };
            if !used {
                *diagonal = R::one();
            }
        }
        for k in 0..len {
            let own = scale[k];
            let cells = factor.row_mut(k);
            for (cell, other) in cells.iter_mut().zip(scale.iter()) {
                *cell *= own * *other;
            }
            cells[k] += damping;
        }
        factor.factorise(0..len, len, R::of(LEAST_PIVOT).min(damping * R::of(0.1)))
    }

    /// Adds the priors of nuisance parameters and properties to `factor` and `step`.
    fn add_priors(&mut self) -> Option<()> {
        let object = self.problem.object(&self.unknowns, self.memory.x)?;
        let Memory { factor, x, step, .. } = &mut self.memory;
        for k in 0..self.unknowns.nuisances() {
            *factor.at(k, k) += R::one();
            step[k] -= x[k];
        }
        let slopes = object.dtheta_dphi();
        let first = self.unknowns.phi();
        for (k, left, sigma) in self.problem.priors(&object) {
            let row = slopes.row(k) / sigma;
            for i in 0..10 {
                let cells = &mut factor.row_mut(first + i)[first..];
                for (cell, other) in cells.iter_mut().zip(row.iter()) {
                    *cell += row[i] * *other;
                }
                step[first + i] += row[i] * left / sigma;
            }
        }
        Some(())
    }

    /// What the priors add to the cost at the present unknowns, or at those of the trial.
    pub(super) fn penalty(&self, trial: bool) -> Option<R> {
        let x = if trial { &*self.memory.trial } else { &*self.memory.x };
        let object = self.problem.object(&self.unknowns, x)?;
        let u = &x[..self.unknowns.nuisances()];
        let priors = self.problem.priors(&object);
        Some(priors.fold(dot(u, u), |sum, (_, left, sigma)| sum + (left / sigma).powi(2)))
    }

    /// Sum of the squared residuals at the unknowns of the trial.
    pub(super) fn squares_of_trial(&mut self) -> Option<R> {
        let Self { problem, memory, unknowns, .. } = self;
        let x = &memory.trial[..unknowns.len()];
        let object = problem.object(unknowns, x)?;
        if object.mass <= R::zero() {
            return None;
        }
        let apparatus = Apparatus::new(problem, unknowns, x);
        let dynamics = problem.dynamics(unknowns, x)?;
        let elastic = &mut memory.equations.elastic;
        elastic.parts.iter_mut().for_each(|part| part[ROOM - 1] = R::zero());
        let (mut squares, mut norm) = (R::zero(), R::zero());
        for bin in 0..problem.bins() {
            let s = problem.s(bin);
            let column = s * s;
            norm += column.norm_sqr();
            let residuals = problem.residuals_at(unknowns, &apparatus, &dynamics, bin)?;
            let used = 3 * apparatus.sensors.len();
            let readings = residuals.iter().flat_map(|of_hit| of_hit.iter().take(used));
            let mut parts = elastic.parts.iter_mut();
            for left in readings {
                squares += left.norm_sqr();
                if let Some(part) = parts.next() {
                    part[ROOM - 1] += along(column, *left);
                }
            }
        }
        for part in elastic.parts.iter() {
            squares -= part[ROOM - 1] * part[ROOM - 1] / norm;
        }
        Some(squares)
    }

    /// Refuses equations that do not determine the stiffness, from the factor: a column of K that the columns
    /// before it explain. Without a suspension mode in the band, a few hits leave parts of K undetermined.
    pub(super) fn check_stiffness(&mut self) -> Result<(), Diagnostics> {
        let first = self.unknowns.block(0);
        let pivots = (first..first + SYMMETRIC).map(|k| self.memory.factor.row(k)[k]);
        let rank = pivots.filter(|pivot| *pivot > R::of(LEAST_OWN_PART)).count();
        if rank < SYMMETRIC {
            return Err(fatal(Code::TenParametersNotIdentifiable, rank as f32));
        }
        Ok(())
    }
}

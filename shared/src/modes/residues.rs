//! Residues of all accelerances at known poles, in steps.

use nalgebra::{Complex, Vector6};

use super::MOST_FORCES;
use super::origin_responses::OriginResponses;
use super::vector_fitting::{Basis, MOST_OWN, Poles, SEARCH_MEMORY, top};
use crate::linalg::Elimination;
use crate::{Progress, Real};

/// What the fit of the accelerances `[a; α]` says, in the memory of its steps.
#[derive(Clone, Copy, Debug)]
pub struct Residues<'a, R> {
    memory: &'a [R],
    poles: &'a Poles<R>,
    top: R,
    length: R,
    forces: usize,
}

impl<'a, R: Real> Residues<'a, R> {
    /// What a [`ResidueFit`] of these responses has found, when it is done; the memory is that of its steps. `None` when it is
    /// too small.
    pub fn new(
        responses: &OriginResponses<'_, R>,
        poles: &'a Poles<R>,
        memory: &'a [R],
    ) -> Option<Self> {
        let memory = memory.get(..SOLUTION + LEFT)?;
        let forces = responses.forces.len().min(MOST_FORCES);
        Some(Self { memory, poles, top: top(responses), length: responses.length, forces })
    }

    /// The poles.
    pub fn poles(&self) -> &'a Poles<R> {
        self.poles
    }

    /// Number of forces.
    pub fn forces(&self) -> usize {
        self.forces
    }

    /// Residue of the displacement under a force at the pole with this place, `[x; θ]` per newton.
    pub fn of_pole(&self, force: usize, pole: usize) -> Vector6<Complex<R>> {
        let Some(value) = self.poles.get(pole) else {
            return Vector6::from_element(Complex::new(R::zero(), R::zero()));
        };
        Vector6::from_fn(|component, _| {
            let solved = self.solved(force, component);
            let of_acceleration = Complex::new(solved[2 * pole], solved[2 * pole + 1]);
            (of_acceleration.scale(self.top) / (value * value)).unscale(self.unit(component))
        })
    }

    /// The constant of the accelerances under a force, `[a; α]` per newton: the mass line, far above the poles and far below
    /// what the term in s² stands for.
    pub fn constant(&self, force: usize) -> Vector6<R> {
        Vector6::from_fn(|component, _| {
            self.solved(force, component)[2 * self.poles.len()] / self.unit(component)
        })
    }

    /// Sum of the squared residuals of the fit, relative to the noise of a reading.
    pub fn left(&self) -> R {
        self.memory[SOLUTION..].iter().fold(R::zero(), |sum, left| sum + *left)
    }

    fn solved(&self, force: usize, component: usize) -> &'a [R] {
        &self.memory[place(force, component)..][..MOST_OWN]
    }

    fn unit(&self, component: usize) -> R {
        if component < 3 { R::one() } else { self.length }
    }
}

/// Runs a whole fit of the residues of the motions under all forces, given the poles, in this memory of [`SEARCH_MEMORY`]
/// numbers. `None` when the equations have no solution.
pub fn fit_residues<'a, R: Real>(
    responses: &OriginResponses<'_, R>,
    poles: &'a Poles<R>,
    memory: &'a mut [R],
) -> Option<Residues<'a, R>> {
    let mut fit = ResidueFit::default();
    while fit.step(responses, poles, memory)? == Progress::Going {}
    Residues::new(responses, poles, memory)
}

/// Numbers of the solution: those of every accelerance.
const SOLUTION: usize = MOST_FORCES * 6 * MOST_OWN;
/// What the fit leaves of the accelerances under each force.
const LEFT: usize = MOST_FORCES;

// The rest of the memory is for the equations of one component.
const _: () = assert!(
    SOLUTION + LEFT + Elimination::<f32>::memory(MOST_OWN, MOST_OWN + MOST_FORCES) <= SEARCH_MEMORY
);

/// Lines of one step.
const LINES_OF_A_STEP: usize = 64;

/// A fit of the residues, in steps between which other work can be done: component by component, because the accelerances
/// of one component under all forces have the same matrix. A step is at most 1.6 million instructions on a rig.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ResidueFit {
    component: usize,
    line: usize,
}

impl ResidueFit {
    /// Runs one step. Responses, poles and memory, of [`SEARCH_MEMORY`] numbers, must be the same in every step. `None` when
    /// the equations have no solution.
    pub fn step<R: Real>(
        &mut self,
        responses: &OriginResponses<'_, R>,
        poles: &Poles<R>,
        memory: &mut [R],
    ) -> Option<Progress> {
        let (forces, own) = (responses.forces.len(), 2 * poles.len() + 2);
        let (solution, rest) = memory.split_at_mut_checked(SOLUTION)?;
        let (left, equations) = rest.split_at_mut_checked(LEFT)?;
        if self.line == 0 {
            equations.fill(R::zero());
        }
        if *self == Self::default() {
            left.fill(R::zero());
        }
        let mut equations = Elimination::of(equations, own, own + forces)?;
        let top = top(responses);
        let start = self.line;
        self.line = (start + LINES_OF_A_STEP).min(responses.s.len());
        for line in start..self.line {
            let basis = Basis::at(responses.s[line], poles, top).0;
            let factor = responses.factor(line, self.component);
            // Real and imaginary part of the equation, column by column.
            let mut rows = [[R::zero(); 2]; MOST_OWN + MOST_FORCES];
            for (to, z) in rows.iter_mut().zip(&basis).take(own) {
                *to = [z.re * factor, z.im * factor];
            }
            for (force, to) in rows[own..].iter_mut().enumerate().take(forces) {
                let (value, factor) = responses.weighted(line, force, self.component);
                *to = [value.re * factor, value.im * factor];
            }
            equations.push(&mut rows[..own + forces]);
            for (sum, [re, im]) in left.iter_mut().zip(&rows[own..own + forces]) {
                *sum += *re * *re + *im * *im;
            }
        }
        if self.line < responses.s.len() {
            return Some(Progress::Going);
        }
        for force in 0..forces {
            let to = solution.get_mut(place(force, self.component)..)?.get_mut(..own)?;
            if !equations.solve(own + force, to) {
                return None;
            }
        }
        *self = Self { component: self.component + 1, line: 0 };
        Some(if self.component == 6 { Progress::Done } else { Progress::Going })
    }
}

/// Where the solution of an accelerance begins.
fn place(force: usize, component: usize) -> usize {
    (force * 6 + component) * MOST_OWN
}

//! Residues of all accelerances at known poles.

use nalgebra::{Complex, Vector6};

use super::MOST_FORCES;
use super::origin_responses::OriginResponses;
use super::vector_fitting::{Basis, FIT_MEMORY, MOST_OWN, Poles, top};
use crate::linalg::Elimination;
use crate::real::Real;

/// What the fit of the accelerances `[a; α]` says, in its memory.
#[derive(Clone, Copy, Debug)]
pub struct Residues<'a, R> {
    memory: &'a [R],
    poles: &'a Poles<R>,
    top: R,
    length: R,
    forces: usize,
}

impl<'a, R: Real> Residues<'a, R> {
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

    /// The constant of the accelerances under a force, `[a; α]` per newton: the mass line, far above the poles and far
    /// below what the term in s² stands for.
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

/// Fits the residues of the motions under all forces, given the poles, in this memory of [`FIT_MEMORY`] numbers:
/// component by component, because the accelerances of one component under all forces have the same matrix. `None` when
/// the equations have no solution.
pub fn fit_residues<'a, R: Real>(
    responses: &OriginResponses<'_, R>,
    poles: &'a Poles<R>,
    memory: &'a mut [R],
) -> Option<Residues<'a, R>> {
    let (forces, own) = (responses.forces.len(), 2 * poles.len() + 2);
    let top = top(responses);
    let (solution, rest) = memory.split_at_mut_checked(SOLUTION)?;
    let (left, equations) = rest.split_at_mut_checked(LEFT)?;
    left.fill(R::zero());
    for component in 0..6 {
        equations.fill(R::zero());
        let mut equations = Elimination::of(equations, own, own + forces)?;
        for line in 0..responses.s.len() {
            let basis = Basis::at(responses.s[line], poles, top).0;
            let factor = responses.factor(line, component);
            // Real and imaginary part of the equation.
            let mut rows = [[R::zero(); MOST_OWN + MOST_FORCES]; 2];
            let mut set = |column: usize, value: Complex<R>, factor: R| {
                rows[0][column] = value.re * factor;
                rows[1][column] = value.im * factor;
            };
            (0..own).for_each(|k| set(k, basis[k], factor));
            for force in 0..forces {
                let (value, factor) = responses.weighted(line, force, component);
                set(own + force, value, factor);
            }
            equations.push(&mut rows);
            for (force, sum) in left.iter_mut().enumerate().take(forces) {
                let [re, im] = rows.map(|row| row[own + force]);
                *sum += re * re + im * im;
            }
        }
        for force in 0..forces {
            let to = solution.get_mut(place(force, component)..)?.get_mut(..own)?;
            if !equations.solve(own + force, to) {
                return None;
            }
        }
    }
    let (memory, forces) = (memory.get(..SOLUTION + LEFT)?, forces.min(MOST_FORCES));
    Some(Residues { memory, poles, top, length: responses.length, forces })
}

/// Numbers of the solution: those of every accelerance.
const SOLUTION: usize = MOST_FORCES * 6 * MOST_OWN;
/// What the fit leaves of the accelerances under each force.
const LEFT: usize = MOST_FORCES;

// The rest of the memory is for the equations of one component.
const _: () = assert!(
    SOLUTION + LEFT + Elimination::<f32>::memory(MOST_OWN, MOST_OWN + MOST_FORCES) <= FIT_MEMORY
);

/// Where the solution of an accelerance begins.
fn place(force: usize, component: usize) -> usize {
    (force * 6 + component) * MOST_OWN
}

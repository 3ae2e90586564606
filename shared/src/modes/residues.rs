//! Residues of all accelerances at known poles, in steps.

use heapless::Vec;
use nalgebra::{Complex, Vector6};

use super::MOST_FORCES;
use super::origin_responses::OriginResponses;
use super::vector_fitting::{Basis, MOST_OWN, MOST_PAIRS, Poles, SEARCH_MEMORY, top};
use crate::linalg::Elimination;
use crate::{Progress, Real};

/// What the fit says about the accelerances `[a; α]` under one force.
#[derive(Clone, Debug, PartialEq)]
pub struct Residues<R> {
    /// Residues of the displacement at every pole, `[x; θ]` per newton.
    pub of_poles: Vec<Vector6<Complex<R>>, MOST_PAIRS>,
    /// The constant of the accelerances, `[a; α]` per newton: the mass line, far above the poles and far below what
    /// the term in s² stands for.
    pub constant: Vector6<R>,
    /// Sum of the squared residuals of the fit, relative to the noise of a reading.
    pub left: R,
}

/// The residues under every force.
pub type ResiduesOfForces<R> = Vec<Residues<R>, MOST_FORCES>;

/// The residues of the motions under all forces, given the poles. `None` when the equations have no solution.
pub fn residues_of_forces<R: Real>(
    responses: &OriginResponses<'_, R>,
    poles: &Poles<R>,
) -> Option<ResiduesOfForces<R>> {
    let mut memory = [R::zero(); SEARCH_MEMORY];
    let mut fit = ResidueFit::default();
    while fit.step(responses, poles, &mut memory)? == Progress::Going {}
    Some(ResidueFit::residues(responses, poles, &memory))
}

/// Numbers of the solution: those of every accelerance.
const SOLUTION: usize = MOST_FORCES * 6 * MOST_OWN;
/// What the fit leaves of the accelerances under each force.
const LEFT: usize = MOST_FORCES;

// The rest of the memory is for the equations of one component.
const _: () = assert!(
    SOLUTION + LEFT + Elimination::<f32>::memory(MOST_OWN, MOST_OWN + MOST_FORCES) <= SEARCH_MEMORY
);

/// A fit of the residues, in steps between which other work can be done: component by component, because the accelerances
/// of one component under all forces have the same matrix. A step is at most a million instructions on a rig.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ResidueFit {
    component: usize,
}

impl ResidueFit {
    /// Part of the fit that is done.
    pub fn progress(&self) -> f32 {
        self.component as f32 / 6.0
    }

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
        equations.fill(R::zero());
        if self.component == 0 {
            left.fill(R::zero());
        }
        let mut equations = Elimination::of(equations, own, own + forces)?;
        let top = top(responses);
        for (line, &s) in responses.s.iter().enumerate() {
            let basis = Basis::at(s, poles, top).0;
            for part in [|z: Complex<R>| z.re, |z: Complex<R>| z.im] {
                let mut row = [R::zero(); MOST_OWN + MOST_FORCES];
                for (force, to) in row[own..].iter_mut().enumerate().take(forces) {
                    let (value, factor) = responses.weighted(line, force, self.component);
                    *to = part(value) * factor;
                }
                let factor = responses.sigma[line][self.component].recip();
                row.iter_mut().zip(&basis).take(own).for_each(|(to, z)| *to = part(*z) * factor);
                equations.push(&mut row[..own + forces]);
                left.iter_mut().zip(&row[own..]).for_each(|(sum, rest)| *sum += *rest * *rest);
            }
        }
        for force in 0..forces {
            let to = solution.get_mut(place(force, self.component)..)?.get_mut(..own)?;
            if !equations.solve(own + force, to) {
                return None;
            }
        }
        self.component += 1;
        Some(if self.component == 6 { Progress::Done } else { Progress::Going })
    }

    /// The residues, when the fit is done, from the memory of its steps.
    pub fn residues<R: Real>(
        responses: &OriginResponses<'_, R>,
        poles: &Poles<R>,
        memory: &[R],
    ) -> ResiduesOfForces<R> {
        let top = top(responses);
        let zero = Vector6::from_element(Complex::new(R::zero(), R::zero()));
        let of_force = |force: usize| {
            let mut found = Residues {
                of_poles: poles.iter().map(|_| zero).collect(),
                constant: Vector6::zeros(),
                left: memory[SOLUTION + force],
            };
            for component in 0..6 {
                let solved = &memory[place(force, component)..][..MOST_OWN];
                let unit = if component < 3 { R::one() } else { responses.length };
                found.constant[component] = solved[2 * poles.len()] / unit;
                for (k, (to, pole)) in found.of_poles.iter_mut().zip(poles).enumerate() {
                    let of_acceleration = Complex::new(solved[2 * k], solved[2 * k + 1]).scale(top);
                    let of_displacement = of_acceleration / (pole * pole);
                    to[component] = of_displacement.unscale(unit);
                }
            }
            found
        };
        (0..responses.forces.len().min(MOST_FORCES)).map(of_force).collect()
    }

    /// Sum of the squared residuals of the accelerances under all forces, when the fit is done.
    pub fn left<R: Real>(memory: &[R]) -> R {
        memory[SOLUTION..][..LEFT].iter().fold(R::zero(), |sum, left| sum + *left)
    }
}

/// Where the solution of an accelerance begins.
fn place(force: usize, component: usize) -> usize {
    (force * 6 + component) * MOST_OWN
}

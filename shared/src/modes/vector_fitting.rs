//! Poles and residues of the suspension modes by vector fitting (Gustavsen and Semlyen 1999, relaxed as by Gustavsen
//! 2006): all responses to all forces share the poles.
//!
//! An accelerance is a sum of partial fractions, a constant and a term in s²: the fractions are the modes, the rest
//! belongs to the rigid body and to what lies above the band. With trial poles `q` for every accelerance
//! `σ(s) H(s) = Σ r/(s − q) + d + e s²`, `σ(s) = Σ c/(s − q) + 1`, is linear in all unknowns, and the zeros of σ are better
//! poles. The unknowns of one accelerance are eliminated as soon as its rows have been added (theory, section 7).

use nalgebra::Complex;

use super::origin_responses::OriginResponses;
use super::{MOST_FORCES, MOST_LINES};
use crate::linalg::{Elimination, eigenvalues};
use crate::sorting::sort_short;
use crate::{Progress, Real};

/// Most pairs of poles.
pub const MOST_PAIRS: usize = 8;
/// Real states of that many pairs.
const MOST_STATES: usize = 2 * MOST_PAIRS;
/// Unknowns of one accelerance with that many pairs: its residues, the constant and the term in s².
pub(super) const MOST_OWN: usize = MOST_STATES + 2;
/// Unknowns of σ with that many pairs.
const MOST_SHARED: usize = MOST_STATES + 1;
/// Most columns of a row: the unknowns of one accelerance under each force, and those of σ for every force.
const MOST_COLUMNS: usize = MOST_OWN + MOST_FORCES * MOST_SHARED;
/// Number of modes of a body on its suspension.
pub const SUSPENSION_MODES: usize = 6;
/// Largest number of relocations; five are usual, and the poles of an order that is too high never settle.
const MOST_STEPS: usize = 12;
/// The poles have settled when none moves by more than this share of its magnitude.
const SETTLED: f64 = 1e-9;
/// Damping ratio of the first trial poles.
const FIRST_DAMPING: f64 = 0.01;
/// Damping ratio of the pair of poles in place of two real ones.
const OVERDAMPED: f64 = 0.7;
/// Numbers of memory that a search needs between its steps.
pub const SEARCH_MEMORY: usize = 2048;
/// Lines whose equations are added together.
const TOGETHER: usize = 2;
/// Pairs of numbers that one step rotates, with ten instructions each.
const ROTATIONS: usize = 60_000;

/// Poles with a positive imaginary part, 1/s, ascending in magnitude.
pub type Poles<R> = heapless::Vec<Complex<R>, MOST_PAIRS>;

/// Poles that all accelerances share.
#[derive(Clone, Debug, PartialEq)]
pub struct VectorFit<R> {
    /// The poles.
    pub poles: Poles<R>,
    /// Number of relocations.
    pub steps: usize,
    /// False when the poles still moved in the last one.
    pub settled: bool,
}

/// Finds this many pairs of poles, from trial poles spread evenly over the band. `None` for a number of pairs that is not
/// between 1 and [`MOST_PAIRS`], fewer than two lines for each pole, responses that are not finite, or equations that
/// have no solution.
pub fn find_poles<R: Real>(
    responses: &OriginResponses<'_, R>,
    pairs: usize,
) -> Option<VectorFit<R>> {
    let mut memory = [R::zero(); SEARCH_MEMORY];
    let mut search = PoleSearch::new(responses, pairs)?;
    while search.step(responses, &mut memory)? == Progress::Going {}
    Some(search.fit)
}

/// One relocation.
pub fn relocate_once<R: Real>(
    responses: &OriginResponses<'_, R>,
    poles: &Poles<R>,
) -> Option<Poles<R>> {
    let mut memory = [R::zero(); SEARCH_MEMORY];
    let mut search = PoleSearch::once(poles.clone());
    while search.step(responses, &mut memory)? == Progress::Going {}
    Some(search.fit.poles)
}

/// A search for poles, in steps between which other work can be done. A step is at most 1.6 million instructions on a rig.
#[derive(Clone, Debug, PartialEq)]
pub struct PoleSearch<R> {
    fit: VectorFit<R>,
    most_steps: usize,
    next: Place,
    /// Sum of the squared accelerances of this relocation, in their noise.
    weight: R,
}

/// Where a relocation goes on: component by component, some forces at a time, line by line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Place {
    component: usize,
    force: usize,
    line: usize,
}

impl<R: Real> PoleSearch<R> {
    /// A search from trial poles spread evenly over the band; `None` as [`find_poles`].
    pub fn new(responses: &OriginResponses<'_, R>, pairs: usize) -> Option<Self> {
        let enough = responses.s.len() >= 2 * (2 * pairs + 2);
        if !enough || !responses.is_sound() {
            return None;
        }
        Some(Self::from_poles(first_poles(responses.s, pairs)?, MOST_STEPS))
    }

    /// A single relocation of these poles.
    pub fn once(poles: Poles<R>) -> Self {
        Self::from_poles(poles, 1)
    }

    fn from_poles(poles: Poles<R>, most_steps: usize) -> Self {
        let fit = VectorFit { poles, steps: 0, settled: false };
        Self { fit, most_steps, next: Place::default(), weight: R::zero() }
    }

    /// What the search has found when it is done.
    pub fn found(&self) -> &VectorFit<R> {
        &self.fit
    }

    /// Part of the search that is done, if it needs all its relocations.
    pub fn progress(&self) -> f32 {
        let Place { component, force, line } = self.next;
        let of_forces = (force as f32 + line as f32 / MOST_LINES as f32) / MOST_FORCES as f32;
        let of_step = (component as f32 + of_forces) / 6.0;
        (self.fit.steps as f32 + of_step) / self.most_steps as f32
    }

    /// Runs one step. The responses and the memory, of [`SEARCH_MEMORY`] numbers, must be the same in every step. `None` when
    /// the equations have no solution.
    pub fn step(
        &mut self,
        responses: &OriginResponses<'_, R>,
        memory: &mut [R],
    ) -> Option<Progress> {
        if self.next.component == 6 {
            return self.relocate(responses, memory);
        }
        let sizes = Sizes::of(self.fit.poles.len(), responses.forces.len());
        let (of_sigma, of_forces) = memory.split_at_mut_checked(sizes.of_sigma())?;
        if self.next == Place::default() {
            of_sigma.fill(R::zero());
            self.weight = R::zero();
        }
        if self.next.line == 0 {
            of_forces.fill(R::zero());
        }
        let (own, shared) = (sizes.own, sizes.shared);
        let first = self.next.force;
        let together = sizes.together.min(responses.forces.len() - first);
        let mut sigma = Elimination::of(of_sigma, shared, shared + 1)?;
        let mut eliminated = Elimination::of(of_forces, own, own + together * shared)?;
        let top = top(responses);
        let end = (self.next.line + sizes.lines_of_a_step(together)).min(responses.s.len());
        let columns = own + together * shared;
        for start in (self.next.line..end).step_by(TOGETHER) {
            // Real and imaginary part of the equations of some lines, column by column.
            let mut rows = [[R::zero(); 2 * TOGETHER]; MOST_COLUMNS];
            for (place, line) in (start..end).take(TOGETHER).enumerate() {
                let basis = Basis::at(responses.s[line], &self.fit.poles, top);
                let mut set = |column: usize, value: Complex<R>| {
                    rows[column][2 * place] = value.re;
                    rows[column][2 * place + 1] = value.im;
                };
                let factor = responses.factor(line, self.next.component);
                for k in 0..own {
                    set(k, basis.0[k].scale(factor));
                }
                for of_force in 0..together {
                    let (value, factor) =
                        responses.weighted(line, first + of_force, self.next.component);
                    let value = value.scale(factor);
                    self.weight += value.norm_sqr();
                    let start = own + of_force * shared;
                    for k in 0..shared {
                        set(start + k, -(basis.0[k] * value));
                    }
                }
            }
            eliminated.push(&mut rows[..columns]);
            for of_force in rows[own..columns].chunks_exact(shared) {
                let mut left = [[R::zero(); 2 * TOGETHER]; MOST_SHARED + 1];
                left[..shared].copy_from_slice(of_force);
                sigma.push(&mut left[..=shared]);
            }
        }
        self.go_on(end, together, responses);
        Some(Progress::Going)
    }

    /// The place after these lines.
    fn go_on(&mut self, end: usize, together: usize, responses: &OriginResponses<'_, R>) {
        self.next.line = end;
        if end == responses.s.len() {
            self.next.line = 0;
            self.next.force += together;
        }
        if self.next.force == responses.forces.len() {
            self.next = Place { component: self.next.component + 1, ..Place::default() };
        }
    }

    /// The end of a relocation: the zeros of σ.
    // Not inlined, since its working memory is not needed in the other steps.
    #[inline(never)]
    fn relocate(
        &mut self,
        responses: &OriginResponses<'_, R>,
        memory: &mut [R],
    ) -> Option<Progress> {
        let poles = &self.fit.poles;
        let Sizes { shared, .. } = Sizes::of(poles.len(), responses.forces.len());
        let mut sigma = Elimination::of(memory, shared, shared + 1)?;
        // The relaxed condition that keeps σ from vanishing, as heavy as the other equations: its mean real part is one.
        let top = top(responses);
        let mut mean = [R::zero(); MOST_SHARED + 1];
        let count = R::of(responses.s.len() as f64);
        for &s in responses.s {
            let basis = Basis::at(s, poles, top);
            (0..shared).for_each(|k| mean[k] += basis.0[k].re / count);
        }
        let weight = self.weight.sqrt();
        mean.iter_mut().for_each(|v| *v *= weight);
        mean[shared] = weight;
        sigma.push(&mut mean.map(|v| [v])[..=shared]);
        let mut solved = [R::zero(); MOST_SHARED];
        if !sigma.solve(shared, &mut solved) {
            return None;
        }
        let next = zeros(poles, top, &solved[..shared - 1], solved[shared - 1])?;
        let close = R::of(SETTLED).max(R::default_epsilon() * R::of(100.0));
        let moved =
            |(a, b): (&Complex<R>, &Complex<R>)| (a - b).norm_sqr() > close * close * a.norm_sqr();
        self.fit.settled = !next.iter().zip(poles).any(moved);
        self.fit.poles = next;
        self.fit.steps += 1;
        self.next = Place::default();
        let done = self.fit.settled || self.fit.steps == self.most_steps;
        Some(if done { Progress::Done } else { Progress::Going })
    }
}

/// Sizes of the equations of a relocation.
struct Sizes {
    /// Unknowns of one accelerance.
    own: usize,
    /// Unknowns of σ.
    shared: usize,
    /// Forces whose equations are eliminated at the same time, since the memory is limited.
    together: usize,
}

impl Sizes {
    fn of(pairs: usize, forces: usize) -> Self {
        let (own, shared) = (2 * pairs + 2, 2 * pairs + 1);
        let fits = |together: &usize| {
            let of_forces = Elimination::<f32>::memory(own, own + together * shared);
            of_forces + Elimination::<f32>::memory(shared, shared + 1) <= SEARCH_MEMORY
        };
        let together = (1..=forces.max(1)).rev().find(fits).unwrap_or(1);
        Self { own, shared, together }
    }

    fn of_sigma(&self) -> usize {
        Elimination::<f32>::memory(self.shared, self.shared + 1)
    }

    fn lines_of_a_step(&self, together: usize) -> usize {
        let of_own = self.own * (self.own - 1) / 2;
        let of_force = self.own * self.shared + self.shared * (self.shared + 1) / 2;
        let lines = ROTATIONS / (2 * (of_own + together * of_force));
        (lines / TOGETHER).max(1) * TOGETHER
    }
}

/// The end of the band, rad/s, with which frequencies are made of the order of one.
pub(super) fn top<R: Real>(responses: &OriginResponses<'_, R>) -> R {
    responses.s.iter().fold(R::zero(), |top, s| top.max(s.im))
}

/// Poles spread evenly over the band of the lines.
fn first_poles<R: Real>(s: &[Complex<R>], pairs: usize) -> Option<Poles<R>> {
    if pairs == 0 || pairs > MOST_PAIRS {
        return None;
    }
    let first = s.first()?.im;
    let (low, high) = s.iter().fold((first, first), |(l, h), s| (l.min(s.im), h.max(s.im)));
    let part = |k: usize| R::of((k as f64 + 0.5) / pairs as f64);
    let pole = |k: usize| {
        let omega = low + (high - low) * part(k);
        Complex::new(-omega * R::of(FIRST_DAMPING), omega)
    };
    (low > R::zero() && high > low).then(|| (0..pairs).map(pole).collect())
}

/// Partial fractions of the pairs of poles, each with a real and an imaginary residue, then 1 and s²; σ has all but the last. Frequencies are
/// relative to the top of the band, so that all of them are of the order of one.
pub(super) struct Basis<R>(pub(super) [Complex<R>; MOST_OWN]);

impl<R: Real> Basis<R> {
    pub(super) fn at(s: Complex<R>, poles: &Poles<R>, top: R) -> Self {
        let one = Complex::new(R::one(), R::zero());
        let s = s.unscale(top);
        let mut basis = [one; MOST_OWN];
        for (pair, pole) in basis.chunks_exact_mut(2).zip(poles) {
            let pole = pole.unscale(top);
            let (a, b) = (one / (s - pole), one / (s - pole.conj()));
            let difference = a - b;
            // Real and imaginary part of the residue.
            pair.copy_from_slice(&[a + b, Complex::new(-difference.im, difference.re)]);
        }
        basis[2 * poles.len() + 1] = s * s;
        Self(basis)
    }
}

/// The zeros of `σ = Σ c/(s − q) + d`: the eigenvalues of `A − b cᵀ/d` of its real state space. Those in the right half
/// plane are reflected, and two real ones become a pair with much damping.
fn zeros<R: Real>(poles: &Poles<R>, top: R, residues: &[R], constant: R) -> Option<Poles<R>> {
    let mut state = [[R::zero(); MOST_STATES]; MOST_STATES];
    for (k, pole) in poles.iter().enumerate() {
        let (pole, k) = (pole.unscale(top), 2 * k);
        (state[k][k], state[k + 1][k + 1]) = (pole.re, pole.re);
        (state[k][k + 1], state[k + 1][k]) = (pole.im, -pole.im);
        for (value, residue) in state[k].iter_mut().zip(residues) {
            *value -= R::of(2.0) * *residue / constant;
        }
    }
    let states = 2 * poles.len();
    let eigenvalues = eigenvalues(&mut state, states)?;
    let mut found = Poles::new();
    let mut real: Option<R> = None;
    for value in &eigenvalues[..states] {
        if value.im > R::zero() {
            found.push(Complex::new(-value.re.abs(), value.im).scale(top)).ok()?;
        } else if value.im == R::zero() {
            match real.take() {
                None => real = Some(value.re.abs()),
                Some(other) => {
                    let size = (other * value.re.abs()).sqrt();
                    let damping = R::of(OVERDAMPED);
                    let swing = (R::one() - damping * damping).sqrt();
                    found.push(Complex::new(-size * damping, size * swing).scale(top)).ok()?;
                }
            }
        }
    }
    sort_short(&mut found, |a, b| a.norm_sqr() < b.norm_sqr());
    let usable = |pole: &Complex<R>| pole.im > R::zero() && pole.re.finite() && pole.im.finite();
    (found.len() == poles.len() && found.iter().all(usable)).then_some(found)
}

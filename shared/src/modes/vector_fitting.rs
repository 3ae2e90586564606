//! Poles and residues of the suspension modes by vector fitting (Gustavsen and Semlyen 1999, relaxed as by Gustavsen
//! 2006): all responses to all forces share the poles.
//!
//! An accelerance is a sum of partial fractions, a constant and a term in s²: the fractions are the modes, the rest
//! belongs to the rigid body and to what lies above the band. With trial poles `q` for every accelerance
//! `σ(s) H(s) = Σ r/(s − q) + d + e s²`, `σ(s) = Σ c/(s − q) + 1`, is linear in all unknowns, and the zeros of σ are
//! better poles. The unknowns of one accelerance are eliminated as soon as its rows have been added (theory, section
//! 7).

use core::ops::Range;

use nalgebra::Complex;

use super::MOST_FORCES;
use super::origin_responses::OriginResponses;
use crate::linalg::{Elimination, eigenvalues};
use crate::real::Real;
use crate::sorting::sort_short;

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
/// Numbers of memory for the equations of a fit.
pub const FIT_MEMORY: usize = 2048;
/// Lines whose equations are added together.
const TOGETHER: usize = 2;

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

/// Finds this many pairs of poles, from trial poles spread evenly over the band. `None` for a number of pairs that is
/// not between 1 and [`MOST_PAIRS`], fewer than two lines for each pole, responses that are not finite, or equations
/// that have no solution.
pub fn find_poles<R: Real>(
    responses: &OriginResponses<'_, R>,
    pairs: usize,
) -> Option<VectorFit<R>> {
    let enough = responses.s.len() >= 2 * (2 * pairs + 2);
    if !enough || !responses.is_sound() {
        return None;
    }
    let mut fit = VectorFit { poles: first_poles(responses.s, pairs)?, steps: 0, settled: false };
    let close = R::of(SETTLED).max(R::default_epsilon() * R::of(100.0));
    while !fit.settled && fit.steps < MOST_STEPS {
        let next = relocate_once(responses, &fit.poles)?;
        let moved =
            |(a, b): (&Complex<R>, &Complex<R>)| (a - b).norm_sqr() > close * close * a.norm_sqr();
        fit.settled = !next.iter().zip(&fit.poles).any(moved);
        fit.poles = next;
        fit.steps += 1;
    }
    Some(fit)
}

/// One relocation: the zeros of σ.
pub fn relocate_once<R: Real>(
    responses: &OriginResponses<'_, R>,
    poles: &Poles<R>,
) -> Option<Poles<R>> {
    let forces = responses.forces.len();
    let Sizes { shared, together, .. } = Sizes::of(poles.len(), forces);
    let mut memory = [R::zero(); FIT_MEMORY];
    let (of_sigma, of_forces) =
        memory.split_at_mut_checked(Elimination::<R>::memory(shared, shared + 1))?;
    let mut sigma = Elimination::of(of_sigma, shared, shared + 1)?;
    // Sum of the squared accelerances, in their noise.
    let mut weight = R::zero();
    for component in 0..6 {
        for first in (0..forces).step_by(together) {
            let some = first..forces.min(first + together);
            weight = eliminate(responses, poles, (component, some), of_forces, &mut sigma, weight)?;
        }
    }
    // The relaxed condition that keeps σ from vanishing, as heavy as the other equations: its mean real part is one.
    let top = top(responses);
    let mut mean = [R::zero(); MOST_SHARED + 1];
    let count = R::of(responses.s.len() as f64);
    for &s in responses.s {
        let basis = Basis::at(s, poles, top);
        (0..shared).for_each(|k| mean[k] += basis.0[k].re / count);
    }
    let weight = weight.sqrt();
    mean.iter_mut().for_each(|v| *v *= weight);
    mean[shared] = weight;
    sigma.push(&mut [mean]);
    let mut solved = [R::zero(); MOST_SHARED];
    if !sigma.solve(shared, &mut solved) {
        return None;
    }
    zeros(poles, top, &solved[..shared - 1], solved[shared - 1])
}

/// Adds the equations of one component of the motions under some forces, whose own unknowns are eliminated in this
/// memory, to those of σ; returns the weight with their accelerances.
fn eliminate<R: Real>(
    responses: &OriginResponses<'_, R>,
    poles: &Poles<R>,
    (component, forces): (usize, Range<usize>),
    memory: &mut [R],
    sigma: &mut Elimination<'_, R>,
    mut weight: R,
) -> Option<R> {
    let Sizes { own, shared, .. } = Sizes::of(poles.len(), responses.forces.len());
    let columns = own + forces.len() * shared;
    memory.fill(R::zero());
    let mut eliminated = Elimination::of(memory, own, columns)?;
    let top = top(responses);
    for start in (0..responses.s.len()).step_by(TOGETHER) {
        // Real and imaginary part of the equations of some lines.
        let mut rows = [[R::zero(); MOST_COLUMNS]; 2 * TOGETHER];
        for (place, line) in (start..responses.s.len()).take(TOGETHER).enumerate() {
            let basis = Basis::at(responses.s[line], poles, top);
            let mut set = |column: usize, value: Complex<R>| {
                rows[2 * place][column] = value.re;
                rows[2 * place + 1][column] = value.im;
            };
            let factor = responses.factor(line, component);
            for k in 0..own {
                set(k, basis.0[k].scale(factor));
            }
            for (of_force, force) in forces.clone().enumerate() {
                let (value, factor) = responses.weighted(line, force, component);
                let value = value.scale(factor);
                weight += value.norm_sqr();
                let start = own + of_force * shared;
                for k in 0..shared {
                    set(start + k, -(basis.0[k] * value));
                }
            }
        }
        eliminated.push(&mut rows);
        for start in (own..columns).step_by(shared) {
            let mut left = [[R::zero(); MOST_SHARED + 1]; 2 * TOGETHER];
            for (left, row) in left.iter_mut().zip(&rows) {
                left[..shared].copy_from_slice(&row[start..start + shared]);
            }
            sigma.push(&mut left);
        }
    }
    Some(weight)
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
            of_forces + Elimination::<f32>::memory(shared, shared + 1) <= FIT_MEMORY
        };
        let together = (1..=forces.max(1)).rev().find(fits).unwrap_or(1);
        Self { own, shared, together }
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

/// Partial fractions of the pairs of poles, each with a real and an imaginary residue, then 1 and s²; σ has all but the
/// last. Frequencies are relative to the top of the band, so that all of them are of the order of one.
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
    let mut zeros = Poles::new();
    let mut real: Option<R> = None;
    for value in &eigenvalues[..states] {
        if value.im > R::zero() {
            zeros.push(Complex::new(-value.re.abs(), value.im).scale(top)).ok()?;
        } else if value.im == R::zero() {
            match real.take() {
                None => real = Some(value.re.abs()),
                Some(other) => {
                    let size = (other * value.re.abs()).sqrt();
                    let damping = R::of(OVERDAMPED);
                    let swing = (R::one() - damping * damping).sqrt();
                    zeros.push(Complex::new(-size * damping, size * swing).scale(top)).ok()?;
                }
            }
        }
    }
    sort_short(&mut zeros, |a, b| a.norm_sqr() < b.norm_sqr());
    let usable = |pole: &Complex<R>| pole.im > R::zero() && pole.re.finite() && pole.im.finite();
    (zeros.len() == poles.len() && zeros.iter().all(usable)).then_some(zeros)
}

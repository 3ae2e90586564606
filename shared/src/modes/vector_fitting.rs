//! Poles and residues of the suspension modes by vector fitting (Gustavsen and Semlyen 1999, relaxed as by Gustavsen
//! 2006): all responses to all forces share the poles.
//!
//! An accelerance is a sum of partial fractions, a constant and a term in s²: the fractions are the modes, the rest
//! belongs to the rigid body and to what lies above the band. With trial poles `q` for every accelerance
//! `σ(s) H(s) = Σ r/(s − q) + d + e s²`, `σ(s) = Σ c/(s − q) + 1`, is linear in all unknowns, and the zeros of σ are better
//! poles. The unknowns of one accelerance are eliminated as soon as its rows have been added (theory, section 7).

use nalgebra::{Complex, SMatrix, Schur, Vector6};

use super::origin_responses::OriginResponses;
use crate::Real;
use crate::linalg::LeastSquares;

/// Most pairs of poles.
pub const MOST_PAIRS: usize = 8;
/// Real states of that many pairs.
const MOST_STATES: usize = 2 * MOST_PAIRS;
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
/// Iterations of the eigenvalue decomposition.
const MOST_ITERATIONS: usize = 300;

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
    let enough = responses.s.len() >= 2 * (2 * pairs + 2);
    if !enough || !responses.is_sound() {
        return None;
    }
    let mut poles = first_poles(responses.s, pairs)?;
    let top = responses.s.iter().fold(R::zero(), |top, s| top.max(s.im));
    let close = R::of(SETTLED).max(R::default_epsilon() * R::of(100.0));
    for step in 1..=MOST_STEPS {
        let next = relocated(responses, &poles, top)?;
        let moved =
            |(a, b): (&Complex<R>, &Complex<R>)| (a - b).norm_sqr() > close * close * a.norm_sqr();
        let settled = !next.iter().zip(&poles).any(moved);
        poles = next;
        if settled {
            return Some(VectorFit { poles, steps: step, settled: true });
        }
    }
    Some(VectorFit { poles, steps: MOST_STEPS, settled: false })
}

/// One relocation.
pub fn relocate_once<R: Real>(
    responses: &OriginResponses<'_, R>,
    poles: &Poles<R>,
) -> Option<Poles<R>> {
    let top = responses.s.iter().fold(R::zero(), |top, s| top.max(s.im));
    relocated(responses, poles, top)
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

/// The zeros of σ for these trial poles.
fn relocated<R: Real>(
    responses: &OriginResponses<'_, R>,
    poles: &Poles<R>,
    top: R,
) -> Option<Poles<R>> {
    match poles.len() {
        1 => relocate::<R, 2, 4, 3, 7>(responses, poles, top),
        2 => relocate::<R, 4, 6, 5, 11>(responses, poles, top),
        3 => relocate::<R, 6, 8, 7, 15>(responses, poles, top),
        4 => relocate::<R, 8, 10, 9, 19>(responses, poles, top),
        5 => relocate::<R, 10, 12, 11, 23>(responses, poles, top),
        6 => relocate::<R, 12, 14, 13, 27>(responses, poles, top),
        7 => relocate::<R, 14, 16, 15, 31>(responses, poles, top),
        8 => relocate::<R, 16, 18, 17, 35>(responses, poles, top),
        _ => None,
    }
}

/// One relocation: `STATES` real unknowns of the poles, `OWN` of one accelerance, `SHARED` of σ, `ALL` together.
fn relocate<
    R: Real,
    const STATES: usize,
    const OWN: usize,
    const SHARED: usize,
    const ALL: usize,
>(
    responses: &OriginResponses<'_, R>,
    poles: &Poles<R>,
    top: R,
) -> Option<Poles<R>> {
    let mut sigma = LeastSquares::<R, SHARED>::new();
    // The relaxed condition that keeps σ from vanishing, as heavy as the other equations: its mean real part is one.
    let mut mean = [R::zero(); SHARED];
    let count = R::of(responses.s.len() as f64);
    for &s in responses.s {
        let basis = Basis::<R, OWN>::at(s, poles, top);
        (0..STATES).for_each(|k| mean[k] += basis.0[k].re / count);
        mean[STATES] += count.recip();
    }
    let mut weight = R::zero();
    for force in 0..responses.forces.len() {
        for component in 0..6 {
            let mut equations = LeastSquares::<R, ALL>::new();
            for (line, &s) in responses.s.iter().enumerate() {
                let (value, factor) = responses.weighted(line, force, component);
                let value = value.scale(factor);
                weight += value.norm_sqr();
                let basis = Basis::<R, OWN>::at(s, poles, top);
                let shared = |k: usize| if k < STATES { -(basis.0[k] * value) } else { -value };
                let row = |part: fn(Complex<R>) -> R| {
                    core::array::from_fn(|k| {
                        if k < OWN { part(basis.0[k]) * factor } else { part(shared(k - OWN)) }
                    })
                };
                equations.push(row(|z| z.re), R::zero());
                equations.push(row(|z| z.im), R::zero());
            }
            let rest = equations.last::<SHARED>();
            sigma.append(&rest);
        }
    }
    let weight = weight.sqrt();
    sigma.push(mean.map(|v| v * weight), weight);
    let solved = sigma.solve()?;
    zeros(poles, top, &solved.as_slice()[..STATES], solved[STATES])
}

/// Partial fractions of the pairs of poles, each with a real and an imaginary residue, then 1 and s². Frequencies are
/// relative to the top of the band, so that all of them are of the order of one.
struct Basis<R, const OWN: usize>([Complex<R>; OWN]);

impl<R: Real, const OWN: usize> Basis<R, OWN> {
    fn at(s: Complex<R>, poles: &Poles<R>, top: R) -> Self {
        let one = Complex::new(R::one(), R::zero());
        let s = s.unscale(top);
        let mut basis = [one; OWN];
        for (pair, pole) in basis.chunks_exact_mut(2).zip(poles) {
            let pole = pole.unscale(top);
            let (a, b) = (one / (s - pole), one / (s - pole.conj()));
            let difference = a - b;
            // Real and imaginary part of the residue.
            pair.copy_from_slice(&[a + b, Complex::new(-difference.im, difference.re)]);
        }
        basis[OWN - 1] = s * s;
        Self(basis)
    }
}

/// The zeros of `σ = Σ c/(s − q) + d`: the eigenvalues of `A − b cᵀ/d` of its real state space. Those in the right half
/// plane are reflected, and two real ones become a pair with much damping. Unused states have the eigenvalue zero.
fn zeros<R: Real>(poles: &Poles<R>, top: R, residues: &[R], constant: R) -> Option<Poles<R>> {
    let mut state = SMatrix::<R, MOST_STATES, MOST_STATES>::zeros();
    for (k, pole) in poles.iter().enumerate() {
        let (pole, k) = (pole.unscale(top), 2 * k);
        (state[(k, k)], state[(k + 1, k + 1)]) = (pole.re, pole.re);
        (state[(k, k + 1)], state[(k + 1, k)]) = (pole.im, -pole.im);
        for (column, residue) in residues.iter().enumerate() {
            state[(k, column)] -= R::of(2.0) * *residue / constant;
        }
    }
    if !crate::linalg::all_finite(&state) {
        return None;
    }
    let schur = Schur::try_new(state, R::default_epsilon(), MOST_ITERATIONS)?;
    let mut found = Poles::new();
    let mut real: Option<R> = None;
    for value in schur.complex_eigenvalues().iter() {
        if value.im > R::zero() {
            found.push(Complex::new(-value.re.abs(), value.im).scale(top)).ok()?;
        } else if value.im == R::zero() && value.re != R::zero() {
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
    found.sort_unstable_by(|a, b| {
        a.norm_sqr().partial_cmp(&b.norm_sqr()).unwrap_or(core::cmp::Ordering::Equal)
    });
    let usable = |pole: &Complex<R>| pole.im > R::zero() && pole.re.finite() && pole.im.finite();
    (found.len() == poles.len() && found.iter().all(usable)).then_some(found)
}

/// What vector fitting says about the accelerances `[a; α]` under one force.
#[derive(Clone, Debug, PartialEq)]
pub struct Residues<R> {
    /// Residues of the displacement at every pole, `[x; θ]` per newton.
    pub of_poles: heapless::Vec<Vector6<Complex<R>>, MOST_PAIRS>,
    /// The constant of the accelerances, `[a; α]` per newton: the mass line, far above the poles and far below what
    /// the term in s² stands for.
    pub constant: Vector6<R>,
    /// Sum of the squared residuals of the fit, relative to the noise of a reading.
    pub left: R,
}

/// Residues of the motion under one force, given the poles. `None` when the equations have no solution.
pub fn residues_of_force<R: Real>(
    responses: &OriginResponses<'_, R>,
    poles: &Poles<R>,
    force: usize,
) -> Option<Residues<R>> {
    let top = responses.s.iter().fold(R::zero(), |top, s| top.max(s.im));
    match poles.len() {
        1 => residues::<R, 4>(responses, poles, force, top),
        2 => residues::<R, 6>(responses, poles, force, top),
        3 => residues::<R, 8>(responses, poles, force, top),
        4 => residues::<R, 10>(responses, poles, force, top),
        5 => residues::<R, 12>(responses, poles, force, top),
        6 => residues::<R, 14>(responses, poles, force, top),
        7 => residues::<R, 16>(responses, poles, force, top),
        8 => residues::<R, 18>(responses, poles, force, top),
        _ => None,
    }
}

fn residues<R: Real, const OWN: usize>(
    responses: &OriginResponses<'_, R>,
    poles: &Poles<R>,
    force: usize,
    top: R,
) -> Option<Residues<R>> {
    let zero = Complex::new(R::zero(), R::zero());
    let mut of_poles: heapless::Vec<Vector6<Complex<R>>, MOST_PAIRS> =
        poles.iter().map(|_| Vector6::from_element(zero)).collect();
    let (mut left, mut constant) = (R::zero(), Vector6::zeros());
    for component in 0..6 {
        let mut equations = LeastSquares::<R, OWN>::new();
        for (line, &s) in responses.s.iter().enumerate() {
            let basis = Basis::<R, OWN>::at(s, poles, top).0;
            let (value, factor) = responses.weighted(line, force, component);
            equations.push(basis.map(|z| z.re * factor), value.re * factor);
            equations.push(basis.map(|z| z.im * factor), value.im * factor);
        }
        left += equations.residual();
        let solved = equations.solve()?;
        let unit = if component < 3 { R::one() } else { responses.length };
        constant[component] = solved[OWN - 2] / unit;
        for (k, (to, pole)) in of_poles.iter_mut().zip(poles).enumerate() {
            let of_acceleration = Complex::new(solved[2 * k], solved[2 * k + 1]).scale(top);
            let of_displacement = of_acceleration / (pole * pole);
            to[component] = of_displacement.unscale(unit);
        }
    }
    Some(Residues { of_poles, constant, left })
}

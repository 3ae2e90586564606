//! Where the fit starts: suspensions from the linear equations of motion.
//!
//! `(M + C/s + K/s² ) x = f` is linear in M, C and K, with the motions x that the readings give (theory,
//! section 6.3). Noise of x makes the answer biased, and how much depends on the weights of the bins and on
//! whether M is known or fitted as well. So several answers are found, and the one that fits the readings best
//! is taken; a body without suspension is among them.

use nalgebra::{Complex, Matrix6, Vector6};

use super::apparatus::{Apparatus, Rows, SensorModel};
use super::fit::Fit;
use super::memory::Memory;
use super::problem::Problem;
use super::unknowns::{
    ELEMENTS, PLACES, SYMMETRIC, Unknowns, along, of_properties, powers_of, real,
};
use crate::body::RigidBody;
use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostics, fatal};
use crate::linalg::{PackedMatrix, triangle};
use crate::real::Real;

/// Powers of |s| by which the equations of a bin are weighted.
const WEIGHTS: [i32; 3] = [0, 1, 2];
/// Most suspensions that are found: for a known and for a fitted body.
const CANDIDATES: usize = 2 * WEIGHTS.len();
/// Most unknowns of a start: C, K and the ten properties.
const MOST: usize = SYMMETRIC + ELEMENTS;
/// One system of equations, with its right side.
const SYSTEM: usize = triangle(MOST) + MOST;
/// A pivot below this fraction of its column's square counts as zero, and damping by which all are raised.
const RIDGE: f64 = 1e-10;

/// Linear systems, one for each weight.
pub(super) struct Start<'w, R> {
    systems: &'w mut [[R; SYSTEM]],
    factor: PackedMatrix<'w, R>,
    solution: &'w mut [R],
}

impl<R: Real, C: Capacity> Fit<'_, '_, '_, R, C> {
    /// Sets the unknowns to the best start from this object.
    pub(super) fn begin(&mut self, object: &RigidBody<R>) -> Result<(), Diagnostics> {
        let Self { problem, memory, unknowns, .. } = self;
        let (len, first) = (unknowns.len(), unknowns.nuisances());
        let phi = problem.balance.body(object).phi();
        memory.x[..len].fill(R::zero());
        memory.x[unknowns.phi()..len].copy_from_slice(phi.as_slice());
        memory.trial[..len].copy_from_slice(&memory.x[..len]);
        let mut best = self.squares_of_trial();
        let Self { problem, memory, unknowns, .. } = self;
        let attached = problem.attached.iter().fold(phi * R::zero(), |sum, (phi, _)| sum + phi);
        let mut candidates = [[R::zero(); 2 * SYMMETRIC + 10]; CANDIDATES];
        let mut count = 0;
        if let Some(mut start) = memory.start() {
            start.fill(problem, unknowns);
            start.candidates(unknowns, (phi + attached).as_slice(), |candidate| {
                candidates[count][..candidate.len()].copy_from_slice(candidate);
                count += 1;
            });
        }
        for candidate in &mut candidates[..count] {
            let own = self.unknowns.len() - first;
            for (value, of_attached) in candidate[own - 10..own].iter_mut().zip(&attached) {
                *value -= *of_attached;
            }
            self.memory.trial[first..first + own].copy_from_slice(&candidate[..own]);
            let squares = self.squares_of_trial();
            if squares.is_some_and(|squares| best.is_none_or(|best| squares < best)) {
                best = squares;
                let Memory { x, trial, .. } = &mut self.memory;
                x[..len].copy_from_slice(&trial[..len]);
            }
        }
        best.map(|_| ()).ok_or_else(|| fatal(Code::NotConverged, 0.0))
    }
}

impl<R: Real> Memory<'_, R> {
    /// Room for the equations of the start, which nothing else uses at that time.
    fn start(&mut self) -> Option<Start<'_, R>> {
        Start::new(self.equations.matrix.0, self.factor.reborrow(), self.step)
    }
}

impl<'w, R: Real> Start<'w, R> {
    pub(super) fn new(
        systems: &'w mut [R],
        factor: PackedMatrix<'w, R>,
        solution: &'w mut [R],
    ) -> Option<Self> {
        let systems = systems.as_chunks_mut().0.get_mut(..WEIGHTS.len())?;
        Some(Self {
            systems,
            factor: PackedMatrix(factor.0.get_mut(..triangle(MOST))?),
            solution: solution.get_mut(..MOST)?,
        })
    }

    /// Adds all bins; unknowns are those of `unknowns` without nuisance parameters and extra terms.
    pub(super) fn fill<C: Capacity>(&mut self, problem: &Problem<'_, R, C>, unknowns: &Unknowns) {
        self.systems.as_flattened_mut().fill(R::zero());
        let apparatus = Apparatus::nominal(problem, unknowns);
        for bin in 0..problem.bins() {
            let s = problem.s(bin);
            let rows = |sensor: &SensorModel<R>| sensor.plain_rows(s);
            let rows: C::Sensors<Rows<R>> = apparatus.sensors.iter().map(rows).collect();
            let Some(inverse) = normal(&rows).try_inverse() else { continue };
            let powers = powers_of(s, unknowns);
            for (j, hit) in apparatus.hits.iter().enumerate() {
                let mut right = Vector6::from_element(real(R::zero()));
                for (channel, row) in rows.iter().flatten().enumerate() {
                    let reading = problem.responses.at(bin, channel, j);
                    right += row.map(|g| g.conj() * reading);
                }
                self.add(&(inverse * right), &hit.force, &powers, s.norm_sqr());
            }
        }
    }

    /// Adds the six equations of one motion.
    fn add(
        &mut self,
        motion: &Vector6<Complex<R>>,
        force: &Vector6<R>,
        powers: &[Complex<R>],
        square: R,
    ) {
        for i in 0..6 {
            let mut elements = [real(R::zero()); SYMMETRIC];
            for (element, (m, n)) in elements.iter_mut().zip(PLACES) {
                if m == i {
                    *element = motion[n];
                } else if n == i {
                    *element = motion[m];
                }
            }
            let properties = of_properties(&elements);
            let mut columns = heapless::Vec::<(usize, Complex<R>), MOST>::new();
            for (b, power) in powers.iter().enumerate() {
                let of_mass = b + 1 == powers.len();
                let values: &[_] = if of_mass { &properties } else { &elements };
                for (k, value) in values.iter().enumerate() {
                    if *value != real(R::zero()) {
                        // There is room for all columns.
                        let _ = columns.push((SYMMETRIC * b + k, *power * *value));
                    }
                }
            }
            for (system, weight) in self.systems.iter_mut().zip(WEIGHTS) {
                let weight = square.powi(weight);
                let (matrix, right) = system.split_at_mut(triangle(MOST));
                let mut matrix = PackedMatrix(matrix);
                for (n, (k, value)) in columns.iter().enumerate() {
                    right[*k] += value.re * force[i] * weight;
                    for (l, other) in &columns[..=n] {
                        matrix.row_mut(*k)[*l] += along(*other, *value) * weight;
                    }
                }
            }
        }
    }

    /// Calls `candidate` with every suspension found, with the elements of its matrices and phi of its body,
    /// which is `body` or a fitted one.
    pub(super) fn candidates(
        &mut self,
        unknowns: &Unknowns,
        body: &[R],
        mut candidate: impl FnMut(&[R]),
    ) {
        let blocks = SYMMETRIC * unknowns.powers.len();
        for system in 0..WEIGHTS.len() {
            for count in [blocks, blocks + 10] {
                if self.solve(system, count, blocks, body).is_some() {
                    candidate(&self.solution[..blocks + 10]);
                }
            }
        }
    }

    /// Solves for the first unknowns; when these are not all, for a known body.
    fn solve(&mut self, system: usize, count: usize, blocks: usize, body: &[R]) -> Option<()> {
        let (matrix, right) = self.systems[system].split_at(triangle(MOST));
        let solution = &mut *self.solution;
        solution[..blocks + 10].copy_from_slice(&right[..blocks + 10]);
        self.factor.0.copy_from_slice(matrix);
        if count == blocks {
            for (p, value) in body.iter().enumerate() {
                let row = self.factor.row(blocks + p);
                for (to, cell) in solution[..blocks].iter_mut().zip(row) {
                    *to -= *cell * *value;
                }
            }
        }
        for k in 0..count {
            let diagonal = self.factor.at(k, k);
            *diagonal += *diagonal * R::of(RIDGE);
        }
        self.factor.factorise(0..count, count, R::zero())?;
        self.factor.solve(&mut solution[..count]);
        if count == blocks {
            solution[blocks..blocks + 10].copy_from_slice(body);
        }
        let phi = nalgebra::SVector::<R, 10>::from_column_slice(&solution[blocks..blocks + 10]);
        let fitted_body = RigidBody::from_phi(&phi).filter(|body| body.mass > R::zero())?;
        (fitted_body.is_finite() && solution[..blocks].iter().all(|v| v.finite())).then_some(())
    }
}

/// `Σ ḡ gᵀ` of all readings.
fn normal<R: Real>(rows: &[Rows<R>]) -> Matrix6<Complex<R>> {
    let mut sum = Matrix6::from_element(real(R::zero()));
    for row in rows.iter().flatten() {
        for n in 0..6 {
            for m in 0..6 {
                sum[(m, n)] += row[m].conj() * row[n];
            }
        }
    }
    sum
}

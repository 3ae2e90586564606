//! The normal equations of all bins.
//!
//! A reading `ĝ D⁻¹ f̂` changes by `−sᵖ aᵢ xⱼ` with the element (i, j) of a matrix, `a = D⁻¹ ĝᵀ` and
//! `x = D⁻¹ f̂`. Summed over the readings of all sensors under all hits, products of such changes are products
//! of the sums over sensors and over hits,
//! `Σ āᵢ xⱼ* aₘ xₙ = (Σ āᵢ aₘ)(Σ x̄ⱼ xₙ)`, so the work for a bin grows with sensors plus hits, except for the
//! pairs of a sensor's and a hit's errors.

use nalgebra::{Complex, Matrix6, Vector6};

use super::apparatus::Apparatus;
use super::bin_model::BinModel;
use super::elastic::Elastic;
use super::problem::Problem;
use super::unknowns::{
    ELEMENTS, ROW_SLOPES, SYMMETRIC, Unknowns, along, block_of, dot, dot_real, of_properties,
    place_of_hit, place_of_row, real, symmetrized, with_properties,
};
use crate::capacity::Capacity;
use crate::linalg::PackedMatrix;
use crate::real::Real;
use crate::responses::Responses;

/// Matrix and right side of the linearised fit, for a noise of one in every real reading and without priors.
pub(super) struct Equations<'w, R> {
    pub(super) matrix: PackedMatrix<'w, R>,
    pub(super) right: &'w mut [R],
    pub(super) elastic: Elastic<'w, R>,
    /// Sum of the squared residuals.
    pub(super) squares: R,
}

/// Sums over the readings of all sensors and hits at one bin.
struct Sums<R> {
    /// `Σ ā aᵀ` over all channels.
    adjoints: Matrix6<Complex<R>>,
    /// `Σ x̄ xᵀ` over all hits.
    motions: Matrix6<Complex<R>>,
}

impl<R: Real> Equations<'_, R> {
    /// Fills the equations at these unknowns; `None` when the model has no value.
    pub(super) fn linearise<C: Capacity>(
        &mut self,
        problem: &Problem<'_, R, C>,
        unknowns: &Unknowns,
        x: &[R],
    ) -> Option<()> {
        self.matrix.0.fill(R::zero());
        self.right.fill(R::zero());
        self.elastic.clear();
        self.squares = R::zero();
        let apparatus = Apparatus::new(problem, unknowns, x);
        let dynamics = problem.dynamics(unknowns, x)?;
        for bin in 0..problem.bins() {
            let model = problem.bin(unknowns, &apparatus, &dynamics, bin)?;
            self.add(unknowns, &apparatus, &model);
            self.elastic.add(unknowns, &apparatus, &model, problem.s(bin));
        }
        self.squares -= self.elastic.remove(unknowns, &mut self.matrix, self.right);
        self.add_attached(problem, unknowns);
        self.squares.finite().then_some(())
    }

    fn add<C: Capacity>(
        &mut self,
        unknowns: &Unknowns,
        apparatus: &Apparatus<R, C>,
        model: &BinModel<R, C>,
    ) {
        let sums = Sums::of(model);
        self.add_shared(unknowns, model, &sums);
        if unknowns.budget {
            self.add_hits(unknowns, apparatus, model, &sums);
            self.add_sensors(unknowns, apparatus, model, &sums);
        }
        let readings = model.residuals.iter().flatten();
        self.squares += readings.fold(R::zero(), |sum, left| sum + left.norm_sqr());
    }

    /// Products of the matrices and the ten properties among themselves and with the residuals.
    fn add_shared<C: Capacity>(
        &mut self,
        unknowns: &Unknowns,
        model: &BinModel<R, C>,
        sums: &Sums<R>,
    ) {
        let products = sums.products();
        let mass = model.powers.len() - 1;
        for (b, power) in model.powers.iter().enumerate() {
            let (first, rows) = block_of(unknowns, b, mass);
            for (c, other) in model.powers.iter().enumerate().take(b + 1) {
                let factor = other.conj() * *power;
                let (start, columns) = block_of(unknowns, c, mass);
                for (row, l) in rows.clone().enumerate() {
                    let count = if b == c { row + 1 } else { columns.len() };
                    let cells = &mut self.matrix.row_mut(first + row)[start..start + count];
                    // The products are Hermitian: this is `Re(factor · products[k][l])`.
                    for (cell, product) in cells.iter_mut().zip(&products[l][columns.clone()]) {
                        *cell += factor.re * product.re + factor.im * product.im;
                    }
                }
            }
        }
        let mut left = Matrix6::from_element(real(R::zero()));
        for (motion, residuals) in model.motions.iter().zip(model.residuals.iter()) {
            let adjoint = weighted_adjoint(model, residuals);
            for (m, n) in all_places() {
                left[(m, n)] += adjoint[m] * motion[n].conj();
            }
        }
        let left = with_properties(symmetrized(|m, n| left[(m, n)]));
        for (b, power) in model.powers.iter().enumerate() {
            let (first, elements) = block_of(unknowns, b, mass);
            for (right, k) in self.right[first..].iter_mut().zip(elements) {
                *right -= along(*power, left[k]);
            }
        }
    }

    /// Products of the hits' errors and the hammer's gain among themselves, with what all hits share and with
    /// the residuals.
    fn add_hits<C: Capacity>(
        &mut self,
        unknowns: &Unknowns,
        apparatus: &Apparatus<R, C>,
        model: &BinModel<R, C>,
        sums: &Sums<R>,
    ) {
        for (j, hit) in apparatus.hits.iter().enumerate() {
            let motion = &model.motions[j];
            let left = weighted_adjoint(model, &model.residuals[j]);
            for (u, slope) in hit.slopes.iter().enumerate() {
                let place = place_of_hit(unknowns, j, u);
                let adjoint = sums.adjoints.tr_mul(&slope.map(real));
                for (v, other) in hit.slopes.iter().enumerate().take(u + 1) {
                    let column = place_of_hit(unknowns, j, v);
                    self.matrix.row_mut(place)[column] += dot_real(&adjoint, other).re;
                }
                self.right[place] += dot_real(&left, slope).re;
                self.add_with_shared(unknowns, model, place, |m, n| adjoint[m] * motion[n]);
            }
        }
    }

    /// Products of the errors of the sensors and of gravity with everything.
    fn add_sensors<C: Capacity>(
        &mut self,
        unknowns: &Unknowns,
        apparatus: &Apparatus<R, C>,
        model: &BinModel<R, C>,
        sums: &Sums<R>,
    ) {
        for (i, sensor) in apparatus.sensors.iter().enumerate() {
            let adjoints = &model.adjoints[i];
            let place = |u: usize| place_of_row(unknowns, i, u);
            let mut of_all = [Matrix6::from_element(real(R::zero())); ROW_SLOPES];
            for (axis, adjoint) in adjoints.iter().enumerate() {
                let left = model
                    .motions
                    .iter()
                    .zip(model.residuals.iter())
                    .fold(Vector6::from_element(real(R::zero())), |sum, (motion, left)| {
                        sum + motion.map(|x| x.conj() * left[3 * i + axis])
                    });
                let slopes: [_; ROW_SLOPES] =
                    core::array::from_fn(|u| model.slope_of_row(sensor, [i, axis], u));
                let changing =
                    slopes.iter().enumerate().filter_map(|(u, slope)| Some((u, slope.as_ref()?)));
                for (u, slope) in changing.clone() {
                    let conjugate = slope.map(|v| v.conj());
                    let weighted = sums.motions.tr_mul(&conjugate);
                    for (v, other) in changing.clone().take_while(|(v, _)| *v <= u) {
                        self.matrix.row_mut(place(u))[place(v)] += dot(&weighted, other).re;
                    }
                    self.right[place(u)] += dot(&conjugate, &left).re;
                    for (m, n) in all_places() {
                        of_all[u][(m, n)] += adjoint[m] * weighted[n];
                    }
                    self.add_with_hits(unknowns, apparatus, model, place(u), slope, adjoint);
                }
            }
            for (u, of_all) in of_all.iter().enumerate() {
                self.add_with_shared(unknowns, model, place(u), |m, n| of_all[(m, n)]);
            }
        }
    }

    /// Products of one sensor error, which changes a row of readings, with all hits' errors.
    fn add_with_hits<C: Capacity>(
        &mut self,
        unknowns: &Unknowns,
        apparatus: &Apparatus<R, C>,
        model: &BinModel<R, C>,
        place: usize,
        slope: &Vector6<Complex<R>>,
        adjoint: &Vector6<Complex<R>>,
    ) {
        for (j, hit) in apparatus.hits.iter().enumerate() {
            let change = dot(slope, &model.motions[j]);
            // `Re(conj(change) a)`, with the real slopes of the force applied last.
            let turned = adjoint.map(|a| along(change, a));
            for (v, force) in hit.slopes.iter().enumerate() {
                self.matrix.row_mut(place_of_hit(unknowns, j, v))[place] += turned.dot(force);
            }
        }
    }

    /// Products of one nuisance parameter with the matrices and the ten properties, from
    /// `Σ conj(change) aₘ xₙ`.
    fn add_with_shared<C: Capacity>(
        &mut self,
        unknowns: &Unknowns,
        model: &BinModel<R, C>,
        place: usize,
        product: impl Fn(usize, usize) -> Complex<R>,
    ) {
        let products = with_properties(symmetrized(product));
        let mass = model.powers.len() - 1;
        for (b, power) in model.powers.iter().enumerate() {
            let (first, elements) = block_of(unknowns, b, mass);
            for (row, k) in elements.enumerate() {
                let value = power.re * products[k].re - power.im * products[k].im;
                self.matrix.row_mut(first + row)[place] -= value;
            }
        }
    }

    /// Adds the columns of the attached bodies: combinations of those of the ten properties.
    fn add_attached<C: Capacity>(&mut self, problem: &Problem<'_, R, C>, unknowns: &Unknowns) {
        if !unknowns.budget {
            return;
        }
        let (phi, len) = (unknowns.phi(), unknowns.len());
        for (k, (body, sigma)) in problem.attached.iter().enumerate() {
            let place = unknowns.attached(k);
            let others = (0..len).filter(|other| *other != place);
            for other in others {
                let sum = body.iter().enumerate().fold(R::zero(), |sum, (p, value)| {
                    sum + *self.matrix.at(other, phi + p) * *value
                });
                *self.matrix.at(other, place) = sum * *sigma;
            }
            let (mut own, mut right) = (R::zero(), R::zero());
            for (p, value) in body.iter().enumerate() {
                own += *self.matrix.at(place, phi + p) * *value;
                right += self.right[phi + p] * *value;
            }
            *self.matrix.at(place, place) = own * *sigma;
            self.right[place] = right * *sigma;
        }
    }
}

impl<R: Real> Sums<R> {
    fn of<C: Capacity>(model: &BinModel<R, C>) -> Self {
        Self {
            adjoints: gram(model.adjoints.iter().flatten()),
            motions: gram(model.motions.iter()),
        }
    }

    /// `Σ conj(change with k) (change with l)` over all readings, without the powers of s.
    fn products(&self) -> [[Complex<R>; ELEMENTS]; ELEMENTS] {
        let zero = real(R::zero());
        let mut products = [[zero; ELEMENTS]; ELEMENTS];
        let of_elements: [_; SYMMETRIC] = core::array::from_fn(|k| {
            let (i, j) = super::unknowns::PLACES[k];
            with_properties(symmetrized(|m, n| {
                let product = self.adjoints[(i, m)] * self.motions[(j, n)];
                if i == j {
                    product
                } else {
                    product + self.adjoints[(j, m)] * self.motions[(i, n)]
                }
            }))
        });
        products[..SYMMETRIC].copy_from_slice(&of_elements);
        for l in 0..ELEMENTS {
            let column: [_; SYMMETRIC] = core::array::from_fn(|k| of_elements[k][l]);
            for (k, value) in of_properties(&column).into_iter().enumerate() {
                products[SYMMETRIC + k][l] = value;
            }
        }
        products
    }
}

/// `Σ v̄ vᵀ`.
fn gram<'v, R: Real>(
    vectors: impl Iterator<Item = &'v Vector6<Complex<R>>>,
) -> Matrix6<Complex<R>> {
    let mut sum = Matrix6::from_element(real(R::zero()));
    for v in vectors {
        for (m, n) in all_places() {
            sum[(m, n)] += v[m].conj() * v[n];
        }
    }
    sum
}

/// `Σ ā r` over the readings under one hit.
fn weighted_adjoint<R: Real, C: Capacity>(
    model: &BinModel<R, C>,
    residuals: &Responses<Complex<R>, C>,
) -> Vector6<Complex<R>> {
    let mut sum = Vector6::from_element(real(R::zero()));
    for (adjoint, left) in model.adjoints.iter().flatten().zip(residuals.iter()) {
        sum += adjoint.map(|a| a.conj() * *left);
    }
    sum
}

fn all_places() -> impl Iterator<Item = (usize, usize)> {
    (0..6).flat_map(|n| (0..6).map(move |m| (m, n)))
}

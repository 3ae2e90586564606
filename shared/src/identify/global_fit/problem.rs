//! The nonlinear least-squares problem of the global fit, and its Levenberg-Marquardt steps.

use nalgebra::{Complex, Matrix6, SMatrix, SVector, Vector3, Vector6};

use super::{GlobalFitSettings, GlobalFitSolution, INVERSE};
use crate::Real;
use crate::body::{RigidBody, regressor};
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity, fatal};
use crate::identify::mass_lines::lower_places;
use crate::identify::observations::FrequencyResponses;
use crate::identify::{Estimate, Method, symmetric};
use crate::layout::Layout;
use crate::linalg::{LeastSquares, Spectrum, all_finite, congruence};

/// Elements of a symmetric 6 × 6 matrix.
const SYMMETRIC: usize = 21;
/// Number of unknowns with the stiffness of the suspension.
pub(super) const WITH_STIFFNESS: usize = SYMMETRIC + 10;
/// Number of unknowns with the damping of the suspension as well.
pub(super) const WITH_DAMPING: usize = 2 * SYMMETRIC + 10;
/// The fit ends with a step that lowers the cost by less than this fraction of the cost per degree of
/// freedom: such a step changes the inertial parameters by less than 1e-5 of their standard deviations.
const CLOSE: f64 = 1e-10;
/// Largest number of steps. From the answer of the mass lines the fit takes ten to forty, most of them for
/// the parts of K₀ that the hits hardly excite.
const MOST_STEPS: usize = 100;
/// Number of dampings tried before the fit concludes that no step lowers the cost.
const MOST_TRIALS: usize = 20;
/// First damping, relative to the diagonal of the information. Three hits leave parts of K₀ nearly
/// undetermined, and a long first step would carry them far away, to another minimum.
const FIRST_DAMPING: f64 = 1e-1;
/// Smallest damping; it no longer shortens a step.
const LEAST_DAMPING: f64 = 1e-14;

/// The fit problem. The unknowns are the lower triangle of K₀ row by row, likewise that of C₀, and phi.
pub(super) struct GlobalFitProblem<'a, R, const S: usize, const H: usize> {
    pub(super) layout: &'a Layout<R, S, H>,
    pub(super) responses: &'a FrequencyResponses<'a, R>,
    pub(super) settings: &'a GlobalFitSettings,
}

impl<R: Real, const S: usize, const H: usize> GlobalFitProblem<'_, R, S, H> {
    pub(super) fn fit<const N: usize>(
        &self,
        start: &RigidBody<R>,
        inverses: &mut [[R; INVERSE]],
    ) -> Result<GlobalFitSolution<R>, Diagnostics> {
        let not_converged = || fatal(Code::NotConverged, MOST_STEPS as f32);
        let freedom = self
            .degrees_of_freedom::<N>()
            .ok_or_else(|| fatal(Code::BandTooNarrow, self.responses.frequencies().len() as f32))?;
        let mut unknowns = SVector::<R, N>::zeros();
        unknowns.fixed_rows_mut::<10>(N - 10).copy_from(&start.phi());
        let (mut equations, mut cost) =
            self.linearised(&unknowns, inverses).ok_or_else(not_converged)?;
        let mut damping = R::of(FIRST_DAMPING);
        let mut settled = false;
        for _step in 0..MOST_STEPS {
            let better = self.step(&unknowns, &equations, cost, &mut damping, inverses);
            let Some((next, lower)) = better else {
                settled = true;
                break;
            };
            unknowns = next;
            let close = R::of(CLOSE) * lower / R::of(freedom as f64);
            settled = cost - lower <= close;
            (equations, cost) = self.linearised(&unknowns, inverses).ok_or_else(not_converged)?;
            if settled {
                break;
            }
        }
        if !settled {
            return Err(not_converged());
        }
        self.answer(&unknowns, &equations, cost / R::of(freedom as f64))
    }

    /// Equations minus unknowns; `None` unless it is positive.
    fn degrees_of_freedom<const N: usize>(&self) -> Option<usize> {
        let channels = self.responses.channels() * self.responses.hits();
        let a_line = if self.complex() { 2 } else { 1 };
        let equations = self.responses.frequencies().len() * channels * a_line;
        let residuals = if self.settings.elastic { channels } else { 0 };
        equations.checked_sub(N + residuals).filter(|&freedom| freedom > 0)
    }

    /// True when the imaginary parts contain information.
    fn complex(&self) -> bool {
        self.settings.damping || self.responses.decay != R::zero()
    }

    /// A point of lower cost and its cost, found by raising the damping; `None` when there is none.
    fn step<const N: usize>(
        &self,
        unknowns: &SVector<R, N>,
        equations: &LeastSquares<R, N>,
        cost: R,
        damping: &mut R,
        inverses: &mut [[R; INVERSE]],
    ) -> Option<(SVector<R, N>, R)> {
        let ten = R::of(10.0);
        for _trial in 0..MOST_TRIALS {
            let mut damped = equations.clone();
            for (k, norm) in equations.column_norms().into_iter().enumerate() {
                let mut row = [R::zero(); N];
                row[k] = norm * damping.sqrt();
                damped.push(row, R::zero());
            }
            let next = damped.solve().map(|step| unknowns + step);
            let lower = next.and_then(|next| self.evaluate(&next, inverses, |_: [R; N], _| ()));
            if let Some(found) = next.zip(lower).filter(|(_, lower)| *lower < cost) {
                *damping = (*damping / ten).max(R::of(LEAST_DAMPING));
                return Some(found);
            }
            *damping *= ten;
        }
        None
    }

    /// The linearised equations and the cost.
    fn linearised<const N: usize>(
        &self,
        unknowns: &SVector<R, N>,
        inverses: &mut [[R; INVERSE]],
    ) -> Option<(LeastSquares<R, N>, R)> {
        let mut equations = LeastSquares::new();
        let cost = self.evaluate(unknowns, inverses, |row, left| equations.push(row, left))?;
        Some((equations, cost))
    }

    /// Calls `equation` with the derivatives and the residual of every real reading; returns the sum of the
    /// squared residuals, or `None` when the model has no value.
    fn evaluate<const N: usize>(
        &self,
        unknowns: &SVector<R, N>,
        inverses: &mut [[R; INVERSE]],
        mut equation: impl FnMut([R; N], R),
    ) -> Option<R> {
        self.invert(unknowns, inverses)?;
        let mut cost = R::zero();
        for (hit, dof) in self.layout.hits.iter().enumerate() {
            let force = dof.unit_force(&Vector3::zeros()).map(real);
            for channel in 0..self.responses.channels() {
                let reading = |bin: usize| {
                    self.reading::<N>(bin, channel, hit, &force, &inverse_in(&inverses[bin]))
                };
                let bins = 0..inverses.len();
                let elastic = self.elastic(bins.clone(), reading);
                for bin in bins {
                    let (mut slopes, mut left) = reading(bin);
                    if let Some(elastic) = &elastic {
                        elastic.remove(self.s(bin), &mut slopes, &mut left);
                    }
                    cost += left.re * left.re;
                    equation(slopes.map(|v| v.re), left.re);
                    if self.complex() {
                        cost += left.im * left.im;
                        equation(slopes.map(|v| v.im), left.im);
                    }
                }
            }
        }
        cost.finite().then_some(cost)
    }

    /// Computes `(M₀ + C₀/s + K₀/s²)⁻¹` for every bin.
    fn invert<const N: usize>(
        &self,
        unknowns: &SVector<R, N>,
        inverses: &mut [[R; INVERSE]],
    ) -> Option<()> {
        let mass = body_of(unknowns)?.mass_matrix();
        let stiffness = symmetric_of(unknowns, 0);
        let damping = (N == WITH_DAMPING).then(|| symmetric_of(unknowns, SYMMETRIC));
        for (bin, inverse) in inverses.iter_mut().enumerate() {
            let over = real(R::one()) / self.s(bin);
            let mut dynamic =
                Matrix6::from_fn(|i, j| real(mass[(i, j)]) + over * over * real(stiffness[(i, j)]));
            if let Some(damping) = &damping {
                dynamic += damping.map(|c| over * real(c));
            }
            let (to, _) = inverse.as_chunks_mut::<2>();
            for (to, v) in to.iter_mut().zip(&dynamic.try_inverse()?) {
                *to = [v.re, v.im];
            }
        }
        Some(())
    }

    /// Derivatives of one reading with respect to the unknowns, and its residual.
    fn reading<const N: usize>(
        &self,
        bin: usize,
        channel: usize,
        hit: usize,
        force: &Vector6<Complex<R>>,
        inverse: &Matrix6<Complex<R>>,
    ) -> ([Complex<R>; N], Complex<R>) {
        let s = self.s(bin);
        let response = self.layout.response_row_at(channel, s);
        let motion = inverse * force;
        // D is symmetric, so `g D⁻¹` is the transpose of this.
        let adjoint = inverse * response;
        let left = self.responses.at(bin, channel, hit) - response.dot(&motion);
        (slopes(&adjoint, &motion, real(R::one()) / s), left)
    }

    fn s(&self, bin: usize) -> Complex<R> {
        Complex::new(self.responses.decay, self.responses.frequencies()[bin] * R::two_pi())
    }

    /// The component of a channel's derivatives and residuals along `s²`.
    fn elastic<const N: usize>(
        &self,
        bins: core::ops::Range<usize>,
        reading: impl Fn(usize) -> ([Complex<R>; N], Complex<R>),
    ) -> Option<Elastic<R, N>> {
        if !self.settings.elastic {
            return None;
        }
        let complex = self.complex();
        let along = |column: Complex<R>, v: Complex<R>| {
            column.re * v.re + if complex { column.im * v.im } else { R::zero() }
        };
        let mut part = Elastic { slopes: [R::zero(); N], left: R::zero() };
        let mut norm = R::zero();
        for bin in bins {
            let s = self.s(bin);
            let column = s * s;
            let (slopes, left) = reading(bin);
            for (sum, slope) in part.slopes.iter_mut().zip(slopes) {
                *sum += along(column, slope);
            }
            part.left += along(column, left);
            norm += along(column, column);
        }
        part.slopes.iter_mut().for_each(|sum| *sum /= norm);
        part.left /= norm;
        Some(part)
    }

    /// The ten properties and the suspension at the minimum; `variance` is that of a reading.
    fn answer<const N: usize>(
        &self,
        unknowns: &SVector<R, N>,
        equations: &LeastSquares<R, N>,
        variance: R,
    ) -> Result<GlobalFitSolution<R>, Diagnostics> {
        let body = body_of(unknowns).ok_or_else(|| fatal(Code::DataNotFinite, 0.0))?;
        // K₀ and C₀ are eliminated here.
        let of_the_ten = equations.last::<10>();
        let Some(Spectrum { rank, condition }) = of_the_ten.spectrum_of_unit_columns() else {
            return Err(fatal(Code::DataNotFinite, 0.0));
        };
        let mut inverse = SMatrix::<R, 10, 10>::identity().data.0;
        if rank < 10 || !of_the_ten.solve_normal(&mut inverse) {
            return Err(fatal(Code::TenParametersNotIdentifiable, rank as f32));
        }
        let spread = variance * self.responses.correlation * self.responses.correlation;
        let mut covariance = SMatrix::<R, 10, 10>::from_fn(|i, j| inverse[i][j] * spread);
        congruence(&body.dtheta_dphi(), &mut covariance);
        let mut diagnostics = Diagnostics::new();
        if !body.is_physically_consistent() {
            let margin = body.physical_margin().unwrap_or(R::zero()).to_f32();
            let code = Code::NotPhysicallyConsistent;
            let _ = diagnostics.push(Diagnostic::whole(code, Severity::Warning, margin));
        }
        let estimate = Estimate {
            method: Method::GlobalFit,
            body,
            covariance: all_finite(&covariance).then_some(covariance),
            condition,
            consistency: None,
            learned: None,
            diagnostics,
        };
        let damping = (N == WITH_DAMPING).then(|| symmetric_of(unknowns, SYMMETRIC));
        Ok(GlobalFitSolution { estimate, stiffness: symmetric_of(unknowns, 0), damping })
    }
}

/// The matrix of a bin in the workspace, column by column.
fn inverse_in<R: Real>(numbers: &[R; INVERSE]) -> Matrix6<Complex<R>> {
    let (pairs, _) = numbers.as_chunks::<2>();
    Matrix6::from_iterator(pairs.iter().map(|[re, im]| Complex::new(*re, *im)))
}

/// The component of a channel along `s²`, per unit of `s²`.
struct Elastic<R, const N: usize> {
    slopes: [R; N],
    left: R,
}

impl<R: Real, const N: usize> Elastic<R, N> {
    fn remove(&self, s: Complex<R>, slopes: &mut [Complex<R>; N], left: &mut Complex<R>) {
        let column = s * s;
        for (slope, part) in slopes.iter_mut().zip(self.slopes) {
            *slope -= column.scale(part);
        }
        *left -= column.scale(self.left);
    }
}

/// `∂(g D⁻¹ f)/∂unknowns` from `D⁻¹ gᵀ`, `D⁻¹ f` and `1/s`.
fn slopes<R: Real, const N: usize>(
    adjoint: &Vector6<Complex<R>>,
    motion: &Vector6<Complex<R>>,
    over: Complex<R>,
) -> [Complex<R>; N] {
    let mut slopes = [real(R::zero()); N];
    for (k, (i, j)) in lower_places().take(SYMMETRIC).enumerate() {
        let mut product = adjoint[i] * motion[j];
        if i != j {
            product += adjoint[j] * motion[i];
        }
        slopes[k] = -(over * over * product);
        if N == WITH_DAMPING {
            slopes[SYMMETRIC + k] = -(over * product);
        }
    }
    let [re, im] = [motion.map(|v| v.re), motion.map(|v| v.im)].map(|part| regressor(&part));
    for (k, slope) in slopes.iter_mut().skip(N - 10).enumerate() {
        for i in 0..6 {
            *slope -= adjoint[i] * Complex::new(re[i][k], im[i][k]);
        }
    }
    slopes
}

/// The symmetric matrix whose lower triangle, row by row, starts at the unknown `first`.
fn symmetric_of<R: Real, const N: usize>(unknowns: &SVector<R, N>, first: usize) -> Matrix6<R> {
    let lower = unknowns.as_slice().get(first..first + SYMMETRIC);
    lower.and_then(symmetric).unwrap_or_else(Matrix6::zeros)
}

fn body_of<R: Real, const N: usize>(unknowns: &SVector<R, N>) -> Option<RigidBody<R>> {
    RigidBody::from_phi(&unknowns.fixed_rows::<10>(N - 10).into_owned())
}

pub(super) fn real<R: Real>(value: R) -> Complex<R> {
    Complex::new(value, R::zero())
}

//! The answer at the minimum: properties, covariance, suspension, and what joint covariances need.

use nalgebra::{Complex, Matrix3, Matrix6, SMatrix, SVector};

use super::apparatus::Apparatus;
use super::elastic::{each_slope, first_own, own_count, unknown_of};
use super::fit::Fit;
use super::memory::Memory;
use super::unknowns::{SYMMETRIC, matrix_of};
use super::{Damping, GlobalFitSolution, Sensitivities};
use crate::body::RigidBody;
use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity, fatal};
use crate::identify::{Estimate, Method};
use crate::linalg::{Spectrum, all_finite, skew, spectrum};
use crate::real::Real;

impl<R: Real, C: Capacity> Fit<'_, '_, '_, R, C> {
    /// The answer; the fit must have descended.
    pub(super) fn answer(&mut self) -> Result<GlobalFitSolution<R>, Diagnostics> {
        let problem = self.problem;
        let undetermined = || fatal(Code::DataNotFinite, 0.0);
        let object = problem.object(&self.unknowns, self.memory.x).ok_or_else(undetermined)?;
        if object.mass <= R::zero() {
            let attached = !problem.attached.is_empty();
            let code = if attached { Code::AttachedTooHeavy } else { Code::MassNotPositive };
            return Err(fatal(code, object.mass.to_f32()));
        }
        let Spectrum { rank, condition } =
            self.spectrum_of_properties().ok_or_else(undetermined)?;
        if rank < 10 {
            return Err(fatal(Code::TenParametersNotIdentifiable, rank as f32));
        }
        self.respond(&object);
        let len = self.unknowns.len();
        let first = self.unknowns.phi();
        let slopes = object.dtheta_dphi();
        // Covariance of theta with phi, times the slopes once more.
        let with_phi =
            SMatrix::<R, 10, 10>::from_fn(|i, j| self.memory.response[i * len + first + j]);
        let covariance = problem.balance.covariance_back(&(with_phi * slopes.transpose()));
        let body = problem.balance.body_back(&object);
        let (diagnostics, gravity) = (self.diagnostics_of(&body), self.fitted_gravity());
        let block = |b: usize| matrix_of(&self.memory.x[self.unknowns.block(b)..][..SYMMETRIC]);
        let unit = match problem.settings.damping {
            Damping::None => None,
            Damping::Viscous => Some(problem.top),
            Damping::Structural => Some(problem.top * problem.top),
        };
        let damping = unit.map(|unit| self.about_origin(&block(1)) * unit);
        Ok(GlobalFitSolution {
            estimate: Estimate {
                method: Method::GlobalFit,
                body,
                covariance: all_finite(&covariance).then_some(covariance),
                condition,
                consistency: None,
                learned: None,
                diagnostics,
            },
            stiffness: self.about_origin(&block(0)) * (problem.top * problem.top),
            damping,
            extra_terms: 0,
            extra_terms_z: [None; 2],
            gravity,
            noise: self.variance.sqrt(),
        })
    }

    /// Rank and condition of the information about the properties under all other unknowns, with unit columns.
    fn spectrum_of_properties(&self) -> Option<Spectrum<R>> {
        let first = self.unknowns.phi();
        let mut columns = [[R::zero(); 10]; 10];
        for (i, column) in columns.iter_mut().enumerate() {
            let own = self.memory.factor.row(first + i);
            column[..=i].copy_from_slice(&own[first..]);
            let norm = column.iter().fold(R::zero(), |sum, v| sum + *v * *v).sqrt();
            column.iter_mut().for_each(|v| *v /= norm);
        }
        spectrum(&columns)
    }

    /// Fills `response` with `∂theta/∂right` of the weighted equations: ten vectors over the unknowns.
    fn respond(&mut self, object: &RigidBody<R>) {
        let len = self.unknowns.len();
        let first = self.unknowns.phi();
        let slopes = object.dtheta_dphi();
        let Memory { factor, scale, response, .. } = &mut self.memory;
        for (i, column) in response[..10 * len].chunks_exact_mut(len).enumerate() {
            column.fill(R::zero());
            for k in 0..10 {
                column[first + k] = slopes[(i, k)] * scale[first + k];
            }
            factor.solve(column);
            for (value, scale) in column.iter_mut().zip(&**scale) {
                *value *= *scale;
            }
        }
    }

    /// A balanced matrix about the origin in SI units of the motion, the time still balanced.
    fn about_origin(&self, balanced: &Matrix6<R>) -> Matrix6<R> {
        let balance = &self.problem.balance;
        let mut motion = Matrix6::identity();
        motion.fixed_view_mut::<3, 3>(0, 3).copy_from(&-skew(&balance.origin));
        let turn = Matrix3::from_diagonal_element(balance.length);
        motion.fixed_view_mut::<3, 3>(3, 3).copy_from(&turn);
        motion.transpose() * balanced * motion
    }

    /// Writes what the fit leaves of every reading.
    fn write_left(&self, to: &mut [Complex<R>]) -> Option<()> {
        let (problem, unknowns) = (self.problem, &self.unknowns);
        let x = &self.memory.x[..unknowns.len()];
        let apparatus = Apparatus::new(problem, unknowns, x);
        let dynamics = problem.dynamics(unknowns, x)?;
        let mut to = to.iter_mut();
        for bin in 0..problem.bins() {
            let residuals = problem.residuals_at(unknowns, &apparatus, &dynamics, bin)?;
            let precision = problem.precision(bin);
            for channel in 0..3 * apparatus.sensors.len() {
                for of_hit in residuals.iter() {
                    *to.next()? = of_hit[channel].unscale(precision);
                }
            }
        }
        Some(())
    }

    /// Writes the sensitivities of theta; [`Self::answer`] must have been called.
    pub(super) fn write_sensitivities(&mut self, to: &mut Sensitivities<'_, R>) -> Option<()> {
        let scale = self.problem.balance.theta_scale();
        let len = self.unknowns.len();
        for (k, change) in to.nuisances.iter_mut().enumerate() {
            *change = SVector::from_fn(|i, _| self.memory.response[i * len + k] * scale[i]);
        }
        self.write_left(to.left)?;
        self.write_gain(&scale, to.gain)?;
        self.write_posterior(to.pulls, to.posterior)
    }

    /// Writes the nuisance parameters and their covariance.
    fn write_posterior(&mut self, pulls: &mut [R], posterior: &mut [R]) -> Option<()> {
        let (count, len) = (pulls.len().min(self.unknowns.nuisances()), self.unknowns.len());
        pulls[..count].copy_from_slice(&self.memory.x[..count]);
        if posterior.len() < count * count {
            return None;
        }
        for (place, row) in posterior.chunks_exact_mut(count.max(1)).take(count).enumerate() {
            row.copy_from_slice(&self.covariances_with(place, len)[..count]);
        }
        Some(())
    }

    fn write_gain(
        &self,
        scale: &SVector<R, 10>,
        gain: &mut [SVector<Complex<R>, 10>],
    ) -> Option<()> {
        let (problem, unknowns) = (self.problem, &self.unknowns);
        let len = unknowns.len();
        let x = &self.memory.x[..len];
        let apparatus = Apparatus::new(problem, unknowns, x);
        let dynamics = problem.dynamics(unknowns, x)?;
        let weight = self.weight();
        let elastic = &self.memory.equations.elastic;
        let sensors = apparatus.sensors.len();
        let mut gain = gain.iter_mut();
        let responses = |k: usize| {
            SVector::<R, 10>::from_fn(|i, _| self.memory.response[i * len + k] * scale[i] / weight)
        };
        for bin in 0..problem.bins() {
            let model = problem.bin(unknowns, &apparatus, &dynamics, bin)?;
            let s = problem.s(bin);
            for channel in 0..3 * sensors {
                for hit in 0..apparatus.hits.len() {
                    let to = gain.next()?;
                    let (sensor, axis) = (channel / 3, channel % 3);
                    to.fill(Complex::new(R::zero(), R::zero()));
                    let at = [sensor, axis, hit];
                    each_slope(unknowns, &apparatus, &model, at, |own, slope| {
                        let response = responses(unknown_of(unknowns, sensor, hit, own));
                        *to += response.map(|r| slope.scale(r * model.precision));
                    });
                    if let Some(part) = elastic.parts.get((hit * sensors + sensor) * 3 + axis) {
                        for own in first_own(unknowns)..own_count(unknowns) {
                            let response = responses(unknown_of(unknowns, sensor, hit, own));
                            let along = (s * s).scale(part[own] / elastic.norm);
                            *to -= response.map(|r| along.scale(r));
                        }
                    }
                }
            }
        }
        Some(())
    }

    /// Covariances of all unknowns, of this many, with one of them.
    pub(super) fn covariances_with(&mut self, place: usize, len: usize) -> &[R] {
        let Memory { factor, scale, scratch, .. } = &mut self.memory;
        let column = &mut scratch[..len];
        column.fill(R::zero());
        column[place] = scale[place];
        factor.solve(column);
        for (value, scale) in column.iter_mut().zip(&**scale) {
            *value *= *scale;
        }
        column
    }

    fn diagnostics_of(&mut self, object: &RigidBody<R>) -> Diagnostics {
        let mut diagnostics = Diagnostics::new();
        if !object.is_physically_consistent() {
            let margin = object.physical_margin().unwrap_or(R::zero()).to_f32();
            let code = Code::NotPhysicallyConsistent;
            let _ = diagnostics.push(Diagnostic::whole(code, Severity::Warning, margin));
        }
        diagnostics.extend(self.suspect());
        diagnostics
    }
}

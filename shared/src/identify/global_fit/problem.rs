//! The fit problem: layout and responses in balanced variables.
//!
//! Lengths are in units of L about the sensors' centroid and frequencies in units of the highest one, so that
//! mass, stiffness, damping and extra terms have the same units.

use heapless::Vec;
use nalgebra::{Complex, SVector, Vector3};

use super::unknowns::Unknowns;
use super::{Damping, GlobalFitSettings};
use crate::body::RigidBody;
use crate::capacity::Capacity;
use crate::frequency_responses::FrequencyResponses;
use crate::identify::maximum_likelihood::balance::Balance;
use crate::layout::{GRAVITY_QUANTITIES, Layout, MAX_ATTACHED};
use crate::real::Real;

pub(super) struct Problem<'a, R: Real, C: Capacity> {
    pub(super) layout: &'a Layout<R, C>,
    pub(super) responses: &'a FrequencyResponses<'a, R>,
    pub(super) settings: &'a GlobalFitSettings,
    pub(super) balance: Balance<R>,
    /// The largest magnitude of s, 1/s.
    pub(super) top: R,
    /// Gravity over `L top²`.
    pub(super) gravity: Vector3<R>,
    /// Changes of that with its direction.
    pub(super) gravity_slopes: [Vector3<R>; GRAVITY_QUANTITIES],
    /// phi of each attached body and the relative standard deviation of its mass.
    pub(super) attached: Vec<(SVector<R, 10>, R), MAX_ATTACHED>,
}

impl<'a, R: Real, C: Capacity> Problem<'a, R, C> {
    pub(super) fn new(
        layout: &'a Layout<R, C>,
        responses: &'a FrequencyResponses<'a, R>,
        settings: &'a GlobalFitSettings,
    ) -> Self {
        let balance = Balance::of(layout);
        let bins = 0..responses.frequencies().len();
        let square = bins.fold(R::zero(), |top, bin| top.max(responses.s(bin).norm_sqr()));
        let gravity = Vector3::from(layout.gravity.unwrap_or([R::zero(); 3]));
        let unit = balance.length * square;
        let attached = layout.attached.iter();
        let attached = attached.filter_map(|a| Some((balance.attached(a)?, a.relative_sigma)));
        Self {
            layout,
            responses,
            settings,
            top: square.sqrt(),
            gravity: gravity / unit,
            gravity_slopes: layout.gravity_slopes().map(|change| change / unit),
            attached: attached.collect(),
            balance,
        }
    }

    pub(super) fn unknowns(&self, extra: usize) -> Unknowns {
        let counts = [self.layout.sensors.len(), self.layout.hits.len(), self.attached.len()];
        Unknowns::new(counts, self.settings.budget, self.settings.damping, extra)
    }

    pub(super) fn bins(&self) -> usize {
        self.responses.frequencies().len()
    }

    /// Laplace variable of a bin relative to the highest.
    pub(super) fn s(&self, bin: usize) -> Complex<R> {
        self.responses.s(bin).unscale(self.top)
    }

    /// Factor of the readings and the model at a bin that makes their noise that of all. Elastic residuals are
    /// eliminated from bins that are all alike.
    pub(super) fn precision(&self, bin: usize) -> R {
        if self.settings.elastic { R::one() } else { self.responses.precision(bin) }
    }

    /// Gravity with these errors of its direction, as [`Self::gravity`].
    pub(super) fn gravity_at(&self, u: &[R]) -> Vector3<R> {
        let changes = self.gravity_slopes.iter().zip(u);
        changes.fold(self.gravity, |sum, (change, u)| sum + change * *u)
    }

    /// True when the imaginary parts contain information.
    pub(super) fn complex(&self) -> bool {
        self.settings.damping != Damping::None || self.responses.decay != R::zero()
    }

    /// Number of channels times hits.
    pub(super) fn accelerances(&self) -> usize {
        3 * self.layout.sensors.len() * self.layout.hits.len()
    }

    /// Number of real readings.
    pub(super) fn readings(&self) -> usize {
        self.bins() * self.accelerances() * if self.complex() { 2 } else { 1 }
    }

    /// The object with these unknowns.
    pub(super) fn object(&self, unknowns: &Unknowns, x: &[R]) -> Option<RigidBody<R>> {
        RigidBody::from_phi(&SVector::from_column_slice(&x[unknowns.phi()..unknowns.len()]))
    }

    /// Property, prior minus present value, and standard deviation, all balanced.
    pub(super) fn priors(&self, object: &RigidBody<R>) -> impl Iterator<Item = (usize, R, R)> {
        let theta = object.theta();
        self.layout.priors.iter().filter_map(move |prior| {
            let (k, value, sigma) = self.balance.prior(prior)?;
            Some((k, value - theta[k], sigma))
        })
    }

    /// Root mean square of the accelerances.
    pub(super) fn size(&self) -> R {
        let mut sum = R::zero();
        for bin in 0..self.bins() {
            for channel in 0..self.responses.channels() {
                for hit in 0..self.responses.hits() {
                    sum += self.responses.at(bin, channel, hit).norm_sqr();
                }
            }
        }
        (sum / R::of((self.bins() * self.accelerances()).max(1) as f64)).sqrt()
    }
}

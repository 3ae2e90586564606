//! The equations of a fit from layout and mass lines.

use core::borrow::Borrow;

use heapless::Vec;
use nalgebra::{SVector, Vector3};

use super::balance::Balance;
use super::model::{HitErrors, HitModel, Model, SENSOR_NUISANCES};
use super::normal_equations::{NormalEquations, Rows};
use crate::body::RigidBody;
use crate::capacity::{Capacity, List};
use crate::identify::MassLines;
use crate::identify::budget::BudgetScales;
use crate::layout::{AttachedBody, HitUncertainty, Layout, MAX_ATTACHED, SensorUncertainty};
use crate::real::Real;
use crate::responses::{ResponseSquare, Responses};

/// Largest number of columns that all sensors share: the hammer's gain, the attached bodies, the ten
/// properties.
pub(super) const MOST_SHARED: usize = 1 + MAX_ATTACHED + 10;
/// Smallest standard deviation relative to the largest reading of a hit; a smaller one is raised to it. Fits
/// of exact numbers leave only rounding, and no sensor of this rig is nearly as good.
const LEAST_NOISE: f64 = 1e-4;

/// A layout in balanced variables, with the error budget in use.
#[derive(Clone, Debug)]
pub(super) struct FitProblem<'l, R: Real, C: Capacity> {
    pub(super) layout: &'l Layout<R, C>,
    pub(super) scales: BudgetScales<R>,
    /// The mean direction of hits that scatter is shorter than one.
    second_order: bool,
    pub(super) balance: Balance<R>,
    /// Number of readings in use.
    pub(super) channels: usize,
    /// phi of each attached body, and the standard deviation of its mass relative to the mass.
    attached: Vec<(SVector<R, 10>, R), MAX_ATTACHED>,
}

/// One hit DOF: model, weights and residual.
pub(super) struct Terms<R: Real, C: Capacity> {
    pub(super) model: HitModel<R, C>,
    pub(super) weight: ResponseSquare<R, C>,
    pub(super) residual: Responses<R, C>,
}

/// The columns of one hit DOF: those of each sensor, and those that all sensors share.
struct Columns<R: Real, C: Capacity> {
    sensors: C::Sensors<[Vector3<R>; SENSOR_NUISANCES]>,
    shared: Vec<Responses<R, C>, MOST_SHARED>,
}

impl<'l, R: Real, C: Capacity> FitProblem<'l, R, C> {
    /// The problem with the stated budget and terms of first order.
    pub(super) fn new(layout: &'l Layout<R, C>) -> Self {
        let balance = Balance::of(layout);
        let body = |a: &AttachedBody<R>| Some((balance.attached(a)?, a.relative_sigma));
        let attached = layout.attached.iter().filter_map(body).collect();
        let (scales, channels) = (BudgetScales::default(), 3 * layout.sensors.len());
        Self { layout, scales, second_order: false, balance, channels, attached }
    }

    /// The same with this budget.
    pub(super) fn with_budget(self, scales: BudgetScales<R>, second_order: bool) -> Self {
        Self { scales, second_order, ..self }
    }

    /// Number of nuisance parameters that stay the same over the test.
    pub(super) fn nuisances(&self) -> usize {
        SENSOR_NUISANCES * self.layout.sensors.len() + 1 + self.attached.len()
    }

    pub(super) fn attached_sum(&self) -> SVector<R, 10> {
        self.attached.iter().fold(SVector::zeros(), |sum, (phi, _)| sum + phi)
    }

    /// The object together with the attached bodies.
    pub(super) fn body_of(&self, object: &SVector<R, 10>) -> Option<RigidBody<R>> {
        RigidBody::from_phi(&(object + self.attached_sum()))
    }

    /// Adds every hit DOF to the equations at a body; returns the weighted square of the residuals.
    pub(super) fn assemble(
        &self,
        body: &RigidBody<R>,
        dofs: impl Iterator<Item = (usize, impl Borrow<MassLines<R, C>>)>,
        equations: &mut NormalEquations<'_, R>,
    ) -> Option<R> {
        equations.clear();
        let model = Model::new(self.layout, &self.balance, body)?;
        let mut squares = R::zero();
        for (place, (index, lines)) in dofs.enumerate() {
            let terms = self.terms(&model, index, lines.borrow(), &equations.hit_errors(place))?;
            squares += self.with_rows(&model, &terms, |rows| equations.add(rows));
        }
        Some(squares)
    }

    /// As [`Self::assemble`], for the second right side: the residuals are those of another body.
    pub(super) fn assemble_second(
        &self,
        present: &RigidBody<R>,
        other: &RigidBody<R>,
        dofs: impl Iterator<Item = (usize, impl Borrow<MassLines<R, C>>)>,
        equations: &mut NormalEquations<'_, R>,
    ) -> Option<R> {
        equations.begin_second();
        let model = Model::new(self.layout, &self.balance, present)?;
        let moved = Model::<R, C>::new(self.layout, &self.balance, other)?;
        let mut squares = R::zero();
        for (place, (index, lines)) in dofs.enumerate() {
            let lines = lines.borrow();
            let errors = equations.hit_errors(place);
            let mut terms = self.terms(&model, index, lines, &errors)?;
            let reading = moved.reading(self.layout.hits.get(index)?, &self.balance)?;
            terms.residual = self.residual(&reading, index, lines)?;
            squares += self.with_rows(&model, &terms, |rows| equations.add_second(rows));
        }
        Some(squares)
    }

    /// Model, weights and residual of one hit DOF, whose hits have these errors.
    pub(super) fn terms(
        &self,
        model: &Model<R, C>,
        index: usize,
        lines: &MassLines<R, C>,
        errors: &HitErrors<R>,
    ) -> Option<Terms<R, C>> {
        let hit = self.hit(model, index, lines.hits, errors)?;
        let least = lines.accelerance.largest() * R::of(LEAST_NOISE);
        let weight = hit.weight(&lines.noise.map(|sigma| sigma.max(least)), self.channels)?;
        let residual = self.residual(&hit.reading, index, lines)?;
        Some(Terms { model: hit, weight, residual })
    }

    /// The budget in use for the hits on a DOF.
    pub(super) fn hit_uncertainty(&self, index: usize) -> Option<HitUncertainty<R>> {
        Some(self.scales.of_hit(&self.layout.hits.get(index)?.uncertainty))
    }

    /// The budget in use for a sensor.
    pub(super) fn sensor_uncertainty(&self, sensor: usize) -> Option<SensorUncertainty<R>> {
        Some(self.scales.of_sensor(&self.layout.sensors.get(sensor)?.uncertainty))
    }

    fn hit(
        &self,
        model: &Model<R, C>,
        index: usize,
        hits: u16,
        errors: &HitErrors<R>,
    ) -> Option<HitModel<R, C>> {
        let uncertainty = self.hit_uncertainty(index)?;
        model.hit(self.layout.hits.get(index)?, &uncertainty, &self.balance, hits, errors)
    }

    /// Measured minus modelled readings. Directions that scatter by `s` about each of two axes have a mean of
    /// length `1 − s²` along the nominal direction, and so has the force (theory, section 12).
    fn residual(
        &self,
        reading: &Responses<R, C>,
        index: usize,
        lines: &MassLines<R, C>,
    ) -> Option<Responses<R, C>> {
        let mut along = R::one();
        if self.second_order {
            let HitUncertainty { direction, node_direction, .. } = self.hit_uncertainty(index)?;
            along -= direction * direction + node_direction * node_direction;
        }
        // Half a radian is no direction any more.
        let scale = along.max(R::of(0.5)).recip();
        let mut residual =
            lines.accelerance.zip_map(reading, |measured, modelled| measured * scale - modelled);
        residual.iter_mut().skip(self.channels).for_each(|left| *left = R::zero());
        Some(residual)
    }

    /// Passes the columns of one hit DOF to `act`.
    pub(super) fn with_rows<T>(
        &self,
        model: &Model<R, C>,
        terms: &Terms<R, C>,
        act: impl FnOnce(&Rows<'_, R, C>) -> T,
    ) -> T {
        let mut columns = Columns { sensors: C::Sensors::default(), shared: Vec::new() };
        self.fill(&mut columns, model, terms);
        act(&Rows {
            weight: &terms.weight,
            sensors: &columns.sensors,
            shared: &columns.shared,
            residual: &terms.residual,
        })
    }

    fn fill(&self, columns: &mut Columns<R, C>, model: &Model<R, C>, terms: &Terms<R, C>) {
        let Columns { sensors, shared } = columns;
        for (i, sensor) in self.layout.sensors.iter().enumerate() {
            let (axes, length) = (sensor.axes_matrix(), self.balance.length);
            let uncertainty = self.scales.of_sensor(&sensor.uncertainty);
            // There is room for all sensors of the layout.
            let _ = sensors.push(terms.model.sensor_nuisances(i, &axes, &uncertainty, length));
        }
        let slope = model.slope(&terms.model.motion);
        // A hammer that reads too much makes every accelerance too small.
        let _ = shared.push(&terms.model.corrected * -self.layout.apparatus.hammer_gain);
        for (phi, relative_sigma) in &self.attached {
            let _ = shared.push(&slope.times(phi) * *relative_sigma);
        }
        // There is room for the ten properties.
        let _ = shared.extend_from_slice(&slope.0);
    }

    /// Adds the priors on the object; returns the weighted square of their residuals.
    pub(super) fn add_priors(
        &self,
        object: &RigidBody<R>,
        equations: &mut NormalEquations<'_, R>,
    ) -> R {
        if self.layout.priors.is_empty() {
            return R::zero();
        }
        let slopes = object.dtheta_dphi();
        let mut squares = R::zero();
        for (k, residual, sigma) in self.priors(object) {
            let slope = slopes.row(k).transpose() / sigma;
            equations.add_prior(&slope, residual / sigma);
            squares += (residual / sigma) * (residual / sigma);
        }
        squares
    }

    /// Weighted square of the residuals of the priors.
    pub(super) fn cost_of_priors(&self, object: &RigidBody<R>) -> R {
        self.priors(object).fold(R::zero(), |sum, (_, residual, sigma)| {
            let r = residual / sigma;
            sum + r * r
        })
    }

    /// Property, prior value minus present value, standard deviation.
    pub(super) fn priors(&self, object: &RigidBody<R>) -> impl Iterator<Item = (usize, R, R)> + '_ {
        let theta = object.theta();
        self.layout.priors.iter().filter_map(move |prior| {
            let (k, value, sigma) = self.balance.prior(prior)?;
            Some((k, value - theta[k], sigma))
        })
    }
}

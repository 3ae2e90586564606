//! The readings that a body gives under every hit, and their derivatives with respect to every error source.
//!
//! `h = G M₀⁻¹ f₀` and `∂h/∂phiₖ = −G M₀⁻¹ Eₖ M₀⁻¹ f` (theory, section 4), balanced. The force `f` of the
//! derivatives is the nominal one `f₀`, or the one with the estimated errors of the hit (theory, section 12).

use core::array::from_fn;

use nalgebra::{Matrix3, Vector3, Vector6};

use super::balance::Balance;
use crate::body::{RigidBody, regressor};
use crate::capacity::Capacity;
use crate::layout::{Hit, HitUncertainty, Layout, SensorUncertainty, across};
use crate::linalg::skew;
use crate::real::Real;
use crate::responses::{ResponseRows, ResponseSquare, Responses};

/// Nuisance parameters of one sensor: the nine elements of its sensitivity, three rotations, three
/// displacements.
pub(in crate::identify) const SENSOR_NUISANCES: usize = 15;
/// Number of sensitivities, the first nuisance parameters of a sensor: three change only its first reading,
/// three its second, three its third.
pub(in crate::identify) const SENSITIVITIES: usize = 9;
/// Nuisance parameters of one hit: two displacements and two rotations across its direction.
pub(in crate::identify) const HIT_NUISANCES: usize = 4;
/// Estimated nuisance parameters of one hit DOF, in standard deviations of the budget.
pub(super) type HitErrors<R> = [R; HIT_NUISANCES];

/// A body on the sensors of a layout.
#[derive(Clone, Debug)]
pub(super) struct Model<R: Real, C: Capacity> {
    body: RigidBody<R>,
    response: ResponseRows<R, C, 6>,
    /// `G M₀⁻¹`.
    readings: ResponseRows<R, C, 6>,
}

/// The readings of the hits on one DOF, and the effect of the hits' own errors.
#[derive(Clone, Debug)]
pub(super) struct HitModel<R: Real, C: Capacity> {
    /// Motion [a; α] of the centroid under the force of the derivatives.
    pub(super) motion: Vector6<R>,
    /// The readings h under the nominal unit force.
    pub(super) reading: Responses<R, C>,
    /// The readings under the force of the derivatives.
    pub(super) corrected: Responses<R, C>,
    /// Change of the readings for one standard deviation of each of the hit's own nuisance parameters.
    pub(super) spread: ResponseRows<R, C, HIT_NUISANCES>,
    /// Directions of the first two nuisance parameters: unit vectors perpendicular to the hit.
    pub(super) across: [Vector3<R>; 2],
}

impl<R: Real, C: Capacity> Model<R, C> {
    /// Model of a balanced body; `None` when it has no mass or its inertia is singular.
    pub(super) fn new(
        layout: &Layout<R, C>,
        balance: &Balance<R>,
        body: &RigidBody<R>,
    ) -> Option<Self> {
        let mut response = ResponseRows::<R, C, 6>::zeros(layout.sensors.len());
        for (i, sensor) in layout.sensors.iter().enumerate() {
            let axes = sensor.axes_matrix();
            let turning = -(axes * skew(&balance.point(&sensor.position)));
            for k in 0..3 {
                response.0[k].set_sensor(i, axes.column(k).into_owned().into());
                response.0[3 + k].set_sensor(i, turning.column(k).into_owned().into());
            }
        }
        let readings = response.times_matrix(&body.inverse_mass_matrix()?);
        Some(Self { body: *body, response, readings })
    }

    /// The readings under the nominal unit force of a hit.
    pub(super) fn reading(&self, hit: &Hit<R>, balance: &Balance<R>) -> Option<Responses<R, C>> {
        let motion = self.body.acceleration(&nominal_force(hit, balance))?;
        Some(self.response.times(&motion))
    }

    /// Model of the mean of `n` hits on one DOF, which has these errors.
    pub(super) fn hit(
        &self,
        hit: &Hit<R>,
        uncertainty: &HitUncertainty<R>,
        balance: &Balance<R>,
        n: u16,
        errors: &HitErrors<R>,
    ) -> Option<HitModel<R, C>> {
        let direction = Vector3::from(hit.direction);
        let point = balance.point(&hit.position);
        let mut force = nominal_force(hit, balance);
        let across = across(&direction);
        let (position_error, direction_error) = uncertainty.of_mean(n);
        let position_error = position_error / balance.length;
        let mut spread = ResponseRows::<R, C, HIT_NUISANCES>::zeros(self.readings.sensors());
        for (k, t) in across.iter().enumerate() {
            let displaced = wrench(&Vector3::zeros(), &(t.cross(&direction) * position_error));
            let turned = wrench(&(t * direction_error), &(point.cross(t) * direction_error));
            spread.0[k] = self.readings.times(&displaced);
            spread.0[2 + k] = self.readings.times(&turned);
            force += displaced * errors[k] + turned * errors[2 + k];
        }
        let reading = self.reading(hit, balance)?;
        let motion = self.body.acceleration(&force)?;
        let corrected = self.response.times(&motion);
        Some(HitModel { motion, reading, corrected, spread, across })
    }

    /// `∂h/∂phi` under a motion.
    pub(super) fn slope(&self, motion: &Vector6<R>) -> ResponseRows<R, C, 10> {
        let mut slope = ResponseRows::<R, C, 10>::zeros(self.readings.sensors());
        for (j, row) in regressor(motion).iter().enumerate() {
            for (k, factor) in row.iter().enumerate() {
                if *factor != R::zero() {
                    slope.0[k].add_multiple(&self.readings.0[j], -*factor);
                }
            }
        }
        slope
    }
}

impl<R: Real, C: Capacity> HitModel<R, C> {
    /// Inverse covariance of the readings, from noise and the hit's own errors; zero beyond `channels`.
    /// `None` when the covariance is not positive definite.
    pub(super) fn weight(
        &self,
        noise: &Responses<R, C>,
        channels: usize,
    ) -> Option<ResponseSquare<R, C>> {
        let mut weight = ResponseSquare::<R, C>::zeros(noise.sensors());
        for of_nuisance in &self.spread.0 {
            weight.add_square(of_nuisance);
        }
        for (k, sigma) in noise.iter().enumerate() {
            weight[(k, k)] += *sigma * *sigma;
        }
        weight.invert(channels)?;
        Some(weight)
    }

    /// Change of a sensor's three readings for one standard deviation of each of its error sources:
    /// sensitivity row by row, rotation, displacement (theory, section 4).
    pub(super) fn sensor_nuisances(
        &self,
        index: usize,
        axes: &Matrix3<R>,
        uncertainty: &SensorUncertainty<R>,
        length: R,
    ) -> [Vector3<R>; SENSOR_NUISANCES] {
        let reading = Vector3::from(self.corrected.of_sensor(index));
        let turning: Vector3<R> = self.motion.fixed_rows::<3>(3).into_owned();
        let displacement = uncertainty.position / length;
        from_fn(|cause| match cause {
            0..SENSITIVITIES => {
                let (to, from) = (cause / 3, cause % 3);
                let sigma = if to == from { uncertainty.gain } else { uncertainty.cross_axis };
                let mut column = Vector3::zeros();
                column[to] = reading[from] * sigma;
                column
            }
            9..12 => reading.cross(&unit(cause - SENSITIVITIES)) * uncertainty.rotation,
            _ => axes * turning.cross(&unit(cause - 12)) * displacement,
        })
    }
}

fn nominal_force<R: Real>(hit: &Hit<R>, balance: &Balance<R>) -> Vector6<R> {
    let direction = Vector3::from(hit.direction);
    wrench(&direction, &balance.point(&hit.position).cross(&direction))
}

fn wrench<R: Real>(force: &Vector3<R>, torque: &Vector3<R>) -> Vector6<R> {
    Vector6::new(force.x, force.y, force.z, torque.x, torque.y, torque.z)
}

fn unit<R: Real>(axis: usize) -> Vector3<R> {
    let mut v = Vector3::zeros();
    v[axis] = R::one();
    v
}

//! Sensors and hits with their errors, as the nuisance parameters describe them.
//!
//! The readings are bilinear: `h = ĝ(s) D(s)⁻¹ f̂`. A sensor's errors change only its three rows `ĝ`, the direction of
//! gravity those of all sensors, a hit's errors only its force `f̂`, with the definitions of maximum likelihood
//! (theory, section 4):
//!
//! ```text
//! ĝ = (1 − σ_h u_h) (I + S(u)) Rᵀ [I, −[p + δ(u)]ₓ − [g(u)]ₓ/s²]        f̂ = f₀ + Σ wₖ uₖ
//! ```

use core::array::from_fn;

use nalgebra::{Complex, Matrix3, Vector3, Vector6};

use super::problem::Problem;
use super::unknowns::{FORCE_SLOPES, Unknowns, real};
use crate::capacity::Capacity;
use crate::identify::maximum_likelihood::model::{SENSITIVITIES, SENSOR_NUISANCES};
use crate::layout::{GRAVITY_QUANTITIES, HIT_QUANTITIES, Hit, Sensor, SensorUncertainty, across};
use crate::linalg::skew;
use crate::real::Real;

/// The three rows of a sensor at one bin.
pub(super) type Rows<R> = [Vector6<Complex<R>>; 3];

/// A sensor in balanced variables.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SensorModel<R> {
    axes: Matrix3<R>,
    /// `−Rᵀ [p + δ]ₓ`.
    turning: Matrix3<R>,
    /// `−Rᵀ [g]ₓ`.
    tilt: Matrix3<R>,
    /// Changes of g with its direction.
    gravity_slopes: [Vector3<R>; GRAVITY_QUANTITIES],
    /// `(1 − σ_h u_h) (I + S)`.
    mixing: Matrix3<R>,
    /// `1 − σ_h u_h`.
    hammer: R,
    /// Standard deviations; the position over L.
    uncertainty: SensorUncertainty<R>,
}

impl<R: Real> SensorModel<R> {
    /// A sensor with its errors `u` under this gravity; no errors without a budget.
    pub(super) fn new<C: Capacity>(
        problem: &Problem<'_, R, C>,
        sensor: &Sensor<R>,
        gravity: Vector3<R>,
        hammer: R,
        u: &[R],
    ) -> Self {
        let axes = sensor.axes_matrix();
        let mut uncertainty = sensor.uncertainty;
        uncertainty.position /= problem.balance.length;
        let at = |k: usize| u.get(k).copied().unwrap_or_else(R::zero);
        let shift = Vector3::from_fn(|k, _| at(12 + k) * uncertainty.position);
        let rotation = Vector3::from_fn(|k, _| at(SENSITIVITIES + k) * uncertainty.rotation);
        // h × ρ = −[ρ]ₓ h.
        let mut mixing = Matrix3::identity() - skew(&rotation);
        for k in 0..SENSITIVITIES {
            mixing[(k / 3, k % 3)] += at(k) * sensitivity_sigma(&uncertainty, k);
        }
        let [gravity, first, second] = match sensor.senses_gravity {
            true => [gravity, problem.gravity_slopes[0], problem.gravity_slopes[1]],
            false => [Vector3::zeros(); 1 + GRAVITY_QUANTITIES],
        };
        let position = problem.balance.point(&sensor.position) + shift;
        Self {
            axes,
            turning: -(axes * skew(&position)),
            tilt: -(axes * skew(&gravity)),
            gravity_slopes: [first, second],
            mixing: mixing * hammer,
            hammer,
            uncertainty,
        }
    }

    /// The rows without sensitivities and rotation.
    pub(super) fn plain_rows(&self, s: Complex<R>) -> Rows<R> {
        let inverse = real(R::one()) / (s * s);
        from_fn(|axis| {
            Vector6::from_fn(|j, _| {
                if j < 3 {
                    return real(self.axes[(axis, j)]);
                }
                inverse.scale(self.tilt[(axis, j - 3)]) + real(self.turning[(axis, j - 3)])
            })
        })
    }

    /// The rows `ĝ`.
    pub(super) fn rows(&self, plain: &Rows<R>) -> Rows<R> {
        from_fn(|axis| {
            Vector6::from_fn(|j, _| {
                let part = |k: usize| plain[k][j].scale(self.mixing[(axis, k)]);
                part(0) + part(1) + part(2)
            })
        })
    }

    /// Change of one row at a bin with a nuisance parameter: one of the sensor's own, then those of gravity; `None`
    /// when it does not change.
    pub(super) fn slope(
        &self,
        plain: &Rows<R>,
        inverse_square: Complex<R>,
        axis: usize,
        parameter: usize,
    ) -> Option<Vector6<Complex<R>>> {
        let unit = |from: usize, factor: R| {
            (factor != R::zero()).then(|| plain[from].map(|v| v.scale(factor * self.hammer)))
        };
        match parameter {
            0..SENSITIVITIES if parameter / 3 != axis => None,
            0..SENSITIVITIES => {
                unit(parameter % 3, sensitivity_sigma(&self.uncertainty, parameter))
            }
            9..12 => {
                // The reading `h × e` of this axis: one of the two others, with its sign.
                let about = parameter - SENSITIVITIES;
                let rotation = self.uncertainty.rotation;
                match (3 + axis - about) % 3 {
                    1 => unit((axis + 1) % 3, rotation),
                    2 => unit((axis + 2) % 3, -rotation),
                    _ => None,
                }
            }
            12..SENSOR_NUISANCES => {
                let mut along = Vector3::zeros();
                along[parameter - 12] = self.uncertainty.position;
                self.turned(along, axis, real(R::one()))
            }
            _ => {
                let along = self.gravity_slopes[parameter - SENSOR_NUISANCES];
                self.turned(along, axis, inverse_square)
            }
        }
    }

    /// Change of a row with `p` in `−[p]ₓ` times a factor.
    fn turned(
        &self,
        along: Vector3<R>,
        axis: usize,
        factor: Complex<R>,
    ) -> Option<Vector6<Complex<R>>> {
        let own = (self.mixing * self.axes).row(axis).transpose();
        let turning = along.cross(&own);
        let row = |j: usize| if j < 3 { real(R::zero()) } else { factor.scale(turning[j - 3]) };
        (along != Vector3::zeros()).then(|| Vector6::from_fn(|j, _| row(j)))
    }
}

fn sensitivity_sigma<R: Real>(uncertainty: &SensorUncertainty<R>, parameter: usize) -> R {
    if parameter / 3 == parameter % 3 { uncertainty.gain } else { uncertainty.cross_axis }
}

/// The mean of the hits on a DOF, in balanced variables.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct HitModel<R> {
    /// `f̂`.
    pub(super) force: Vector6<R>,
    /// Change of `f̂` with the hit's own nuisance parameters, with the hammer's gain, and with the torque.
    pub(super) slopes: [Vector6<R>; FORCE_SLOPES],
}

impl<R: Real> HitModel<R> {
    /// A hit with its own errors and that of its torque; none without a budget.
    pub(super) fn new<C: Capacity>(
        problem: &Problem<'_, R, C>,
        hit: &Hit<R>,
        hammer: R,
        u: Option<(&[R], R)>,
    ) -> Self {
        let hits = u16::from(problem.layout.test.hits_per_dof);
        let length = problem.balance.length;
        let direction = Vector3::from(hit.direction);
        let point = problem.balance.point(&hit.position);
        let (position, turn) = hit.uncertainty.of_mean(hits);
        let wrench = |f: Vector3<R>, t: Vector3<R>| Vector6::new(f.x, f.y, f.z, t.x, t.y, t.z);
        let mut slopes = [Vector6::zeros(); FORCE_SLOPES];
        for (k, t) in across(&direction).into_iter().enumerate() {
            slopes[k] = wrench(Vector3::zeros(), t.cross(&direction) * (position / length));
            slopes[2 + k] = wrench(t * turn, point.cross(&t) * turn);
        }
        let mut force = wrench(direction, point.cross(&direction));
        let (shorter, torque) = hit.uncertainty.second_order(hits);
        slopes[HIT_QUANTITIES - 1] = force * shorter.hypot(problem.layout.apparatus.hit_gain);
        slopes[HIT_QUANTITIES + 1] = wrench(Vector3::zeros(), direction * (torque / length));
        if let Some((own, torque)) = u {
            // Directions that scatter have a mean shorter than one (theory, section 12).
            let square = |sigma: R| sigma * sigma;
            let scale = R::of(problem.settings.direction_scale);
            let shorter = square(scale * hit.uncertainty.direction)
                + square(scale * hit.uncertainty.node_direction);
            force *= (R::one() - shorter).max(R::of(0.5));
            for (slope, u) in slopes.iter().zip(own) {
                force += slope * *u;
            }
            force += slopes[HIT_QUANTITIES + 1] * torque;
        }
        slopes[HIT_QUANTITIES] = force * (-problem.layout.force_gain() / hammer);
        Self { force, slopes }
    }
}

/// All sensors and hits of a layout with the errors of these unknowns.
#[derive(Clone, Debug)]
pub(super) struct Apparatus<R: Real, C: Capacity> {
    pub(super) sensors: C::Sensors<SensorModel<R>>,
    pub(super) hits: C::Hits<HitModel<R>>,
}

impl<R: Real, C: Capacity> Apparatus<R, C> {
    /// Without errors.
    pub(super) fn nominal(problem: &Problem<'_, R, C>, unknowns: &Unknowns) -> Self {
        Self::new(problem, unknowns, &[])
    }

    pub(super) fn new(problem: &Problem<'_, R, C>, unknowns: &Unknowns, x: &[R]) -> Self {
        let layout = problem.layout;
        let errors = |first: usize, count: usize| {
            x.get(first..first + count).filter(|_| unknowns.budget).unwrap_or(&[])
        };
        let one = |place: usize| errors(place, 1).first().copied().unwrap_or_else(R::zero);
        // A gain of less than a tenth is none.
        let hammer = (R::one() - layout.force_gain() * one(unknowns.hammer())).max(R::of(0.1));
        let gravity = problem.gravity_at(errors(unknowns.gravity(), GRAVITY_QUANTITIES));
        let sensor = |(i, sensor): (usize, &Sensor<R>)| {
            let u = errors(unknowns.sensor(i), SENSOR_NUISANCES);
            SensorModel::new(problem, sensor, gravity, hammer, u)
        };
        let hit = |(j, hit): (usize, &Hit<R>)| {
            let own = errors(unknowns.hit(j), HIT_QUANTITIES);
            HitModel::new(
                problem,
                hit,
                hammer,
                unknowns.budget.then_some((own, one(unknowns.torque(j)))),
            )
        };
        Self {
            sensors: layout.sensors.iter().enumerate().map(sensor).collect(),
            hits: layout.hits.iter().enumerate().map(hit).collect(),
        }
    }
}

//! Estimated errors of the rig: the nuisance parameters that explain the residuals best.

use nalgebra::Vector3;

use super::fit_problem::{FitProblem, Terms};
use super::model::{HIT_NUISANCES, Model, SENSOR_NUISANCES};
use super::normal_equations::NormalEquations;
use super::pulls::{HitPull, UnknownValues, root_mean_square};
use crate::body::RigidBody;
use crate::capacity::{Capacity, List};
use crate::estimated::EstimatedValue;
use crate::identify::{DofMassLines, MassLines};
use crate::real::Real;
use crate::responses::Responses;

/// Estimated nuisance parameters of one sensor, each with the standard deviation after the test (that of the
/// budget when the test does not determine it).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorNuisances<R> {
    /// Relative errors `[reading axis][motion axis]`: true over nominal sensitivity minus one on the
    /// diagonal, cross-axis sensitivities off it.
    pub sensitivity: [[EstimatedValue<R>; 3]; 3],
    /// Rotation vector from the nominal to the true axes, in sensor axes, rad.
    pub rotation: [EstimatedValue<R>; 3],
    /// True minus nominal position, body frame, m.
    pub position: [EstimatedValue<R>; 3],
    /// Root mean square of the fifteen pulls: each parameter over its standard deviation in the budget.
    pub pull: R,
}

/// Estimated nuisance parameters of the mean hit on one DOF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HitNuisances<R> {
    /// Index of the DOF in the layout.
    pub index: usize,
    /// True minus nominal point of action, body frame, m.
    pub position: [EstimatedValue<R>; 3],
    /// True minus nominal direction, body frame, rad.
    pub direction: [EstimatedValue<R>; 3],
    /// Root mean square of the four pulls: each parameter over its standard deviation in the budget.
    pub pull: R,
    /// Root mean square of the residuals of the readings over their noise.
    pub normalized_residual: R,
}

/// Estimated nuisance parameters of the whole test.
#[derive(Clone, Debug, PartialEq)]
pub struct NuisanceEstimates<R: Real, C: Capacity> {
    /// Nuisance parameters of each sensor.
    pub sensors: C::Sensors<SensorNuisances<R>>,
    /// Nuisance parameters of each hit DOF, in the order of the data.
    pub hits: C::Hits<HitNuisances<R>>,
    /// Relative error of the hammer's gain against that of the sensors.
    pub hammer_gain: EstimatedValue<R>,
}

/// Estimates the nuisance parameters at the minimum. The equations cannot be used afterwards.
pub(super) fn estimate_nuisances<R: Real, C: Capacity>(
    problem: &FitProblem<'_, R, C>,
    dofs: &[DofMassLines<R, C>],
    body: &RigidBody<R>,
    equations: &mut NormalEquations<'_, R>,
) -> Option<NuisanceEstimates<R, C>> {
    let layout = problem.layout;
    let nuisances = UnknownValues::<R, C>::of(layout.sensors.len(), equations.nuisances())?;
    equations.complete()?;
    let mut sensors = C::Sensors::default();
    for (i, values) in nuisances.sensors.iter().enumerate() {
        let sigmas: [R; SENSOR_NUISANCES] =
            core::array::from_fn(|k| sigma_of(equations, SENSOR_NUISANCES * i + k));
        sensors.push(sensor(&problem.sensor_uncertainty(i)?, values, &sigmas)).ok()?;
    }
    let hammer = SENSOR_NUISANCES * layout.sensors.len();
    let hammer_gain = EstimatedValue {
        value: *nuisances.shared.first()? * layout.apparatus.hammer_gain,
        sigma: sigma_of(equations, hammer) * layout.apparatus.hammer_gain,
    };
    let model = Model::new(layout, &problem.balance, body)?;
    let mut hits = C::Hits::default();
    for (place, (index, lines)) in dofs.iter().enumerate() {
        let terms = problem.terms(&model, *index, lines, &equations.hit_errors(place))?;
        let left = nuisances.residual(problem, &model, &terms);
        let spread_covariance = covariance_of_hit(problem, &model, &terms, equations);
        hits.push(hit(problem, *index, lines, &terms, &left, &spread_covariance)?).ok()?;
    }
    Some(NuisanceEstimates { sensors, hits, hammer_gain })
}

/// Standard deviation of one unknown, relative to its standard deviation in the budget.
fn sigma_of<R: Real>(equations: &mut NormalEquations<'_, R>, unknown: usize) -> R {
    let solved = equations.solve(|right| right[unknown] = R::one());
    solved[unknown].max(R::zero()).sqrt()
}

fn sensor<R: Real>(
    uncertainty: &crate::layout::SensorUncertainty<R>,
    values: &[R; SENSOR_NUISANCES],
    sigmas: &[R; SENSOR_NUISANCES],
) -> SensorNuisances<R> {
    let estimated =
        |k: usize, unit: R| EstimatedValue { value: values[k] * unit, sigma: sigmas[k] * unit };
    SensorNuisances {
        sensitivity: core::array::from_fn(|to| {
            core::array::from_fn(|from| {
                let gain = if to == from { uncertainty.gain } else { uncertainty.cross_axis };
                estimated(3 * to + from, gain)
            })
        }),
        rotation: core::array::from_fn(|k| estimated(9 + k, uncertainty.rotation)),
        position: core::array::from_fn(|k| estimated(12 + k, uncertainty.position)),
        pull: root_mean_square(values),
    }
}

type HitCovariance<R> = [[R; HIT_NUISANCES]; HIT_NUISANCES];

/// Covariance of the hit's own nuisance parameters after the test:
/// `I − sᵀ D⁻¹ s + (Xᵀ D⁻¹ s)ᵀ N⁻¹ (Xᵀ D⁻¹ s)` with `s` the readings for one standard deviation of each and
/// `N` the normal matrix.
fn covariance_of_hit<R: Real, C: Capacity>(
    problem: &FitProblem<'_, R, C>,
    model: &Model<R, C>,
    terms: &Terms<R, C>,
    equations: &mut NormalEquations<'_, R>,
) -> HitCovariance<R> {
    let spread = &terms.model.spread;
    let weighted = spread.0.each_ref().map(|column| terms.weight.times(column));
    let mut covariance: HitCovariance<R> = core::array::from_fn(|i| {
        core::array::from_fn(|j| {
            let unit = if i == j { R::one() } else { R::zero() };
            unit - spread.0[i].dot(&weighted[j])
        })
    });
    problem.with_rows(model, terms, |rows| {
        for (j, column) in weighted.iter().enumerate() {
            let solved = equations.solve_readings(rows, column);
            let Some(unknowns) = UnknownValues::<R, C>::of(rows.sensors.len(), solved) else {
                return;
            };
            let explained = rows.residual - &unknowns.left(rows);
            for (i, row) in covariance.iter_mut().enumerate() {
                row[j] += weighted[i].dot(&explained);
            }
        }
    });
    covariance
}

fn hit<R: Real, C: Capacity>(
    problem: &FitProblem<'_, R, C>,
    index: usize,
    lines: &MassLines<R, C>,
    terms: &Terms<R, C>,
    left: &Responses<R, C>,
    covariance: &HitCovariance<R>,
) -> Option<HitNuisances<R>> {
    let (position_error, direction_error) = problem.hit_uncertainty(index)?.of_mean(lines.hits);
    let HitPull { values, pull, normalized_residual } = HitPull::of(terms, left, problem.channels);
    let vector = |first: usize, unit: R| -> [EstimatedValue<R>; 3] {
        let [t, u]: &[Vector3<R>; 2] = &terms.model.across;
        core::array::from_fn(|axis| {
            let (a, b) = (t[axis], u[axis]);
            let variance = a * a * covariance[first][first]
                + b * b * covariance[first + 1][first + 1]
                + R::of(2.0) * a * b * covariance[first][first + 1];
            EstimatedValue {
                value: (a * values[first] + b * values[first + 1]) * unit,
                sigma: variance.max(R::zero()).sqrt() * unit,
            }
        })
    };
    Some(HitNuisances {
        index,
        position: vector(0, position_error),
        direction: vector(2, direction_error),
        pull,
        normalized_residual,
    })
}

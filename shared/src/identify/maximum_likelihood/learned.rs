//! What the fit found out about the rig: the causes of error that explain the residuals best.

use heapless::Vec;
use nalgebra::Vector3;

use super::model::{HIT_CAUSES, Model, SENSOR_CAUSES};
use super::normal_equations::NormalEquations;
use super::problem::{Problem, Terms};
use super::strain::{Causes, HitStrain, root_mean_square};
use crate::Real;
use crate::body::RigidBody;
use crate::identify::{DofMassLines, MassLines};
use crate::responses::Responses;

/// An estimated cause of error and the standard deviation that is left of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Learnt<R> {
    /// The value, in the unit of its uncertainty.
    pub value: R,
    /// Its standard deviation after the test; that of the budget when the test says nothing.
    pub sigma: R,
}

/// Of one sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LearnedSensor<R> {
    /// True over nominal sensitivity minus one on the diagonal, cross-axis sensitivity beside it;
    /// relative, `[reading axis][motion axis]`.
    pub sensitivity: [[Learnt<R>; 3]; 3],
    /// Rotation vector of the true against the nominal axes, in sensor axes, rad.
    pub rotation: [Learnt<R>; 3],
    /// True minus nominal place, body frame, m.
    pub position: [Learnt<R>; 3],
    /// Root mean square of the fifteen over their standard deviations in the budget.
    pub strain: R,
}

/// Of the mean hit on one DOF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LearnedHit<R> {
    /// Its index in the layout.
    pub index: usize,
    /// True minus nominal point of action, body frame, m.
    pub position: [Learnt<R>; 3],
    /// True minus nominal direction, body frame, rad.
    pub direction: [Learnt<R>; 3],
    /// Root mean square of the four over their standard deviations in the budget.
    pub strain: R,
    /// Root mean square of what is left of the readings over their noise.
    pub misfit: R,
}

/// Of the whole test.
#[derive(Clone, Debug, PartialEq)]
pub struct Learned<R, const S: usize, const H: usize> {
    /// Sensor by sensor.
    pub sensors: Vec<LearnedSensor<R>, S>,
    /// Hit DOF by hit DOF, as they were given.
    pub hits: Vec<LearnedHit<R>, H>,
    /// The hammer's gain against the sensors', minus one, relative.
    pub hammer_gain: Learnt<R>,
}

/// The causes at the minimum. Ends the use of the equations.
pub(super) fn learn<R: Real, const S: usize, const H: usize>(
    problem: &Problem<'_, R, S, H>,
    dofs: &[DofMassLines<R, S>],
    body: &RigidBody<R>,
    equations: &mut NormalEquations<'_, R>,
) -> Option<Learned<R, S, H>> {
    let layout = problem.layout;
    let causes = Causes::<R, S>::of(layout.sensors.len(), equations)?;
    equations.complete()?;
    let mut sensors = Vec::new();
    for (i, values) in causes.sensors.iter().enumerate() {
        let sigmas: [R; SENSOR_CAUSES] =
            core::array::from_fn(|k| sigma_of(equations, SENSOR_CAUSES * i + k));
        sensors.push(sensor(&layout.sensors.get(i)?.uncertainty, values, &sigmas)).ok()?;
    }
    let hammer = SENSOR_CAUSES * layout.sensors.len();
    let hammer_gain = Learnt {
        value: *causes.shared.first()? * layout.hammer_gain,
        sigma: sigma_of(equations, hammer) * layout.hammer_gain,
    };
    let model = Model::new(layout, &problem.balance, body)?;
    let mut hits = Vec::new();
    for (index, lines) in dofs {
        let terms = problem.terms(&model, *index, lines)?;
        let left = causes.residual(problem, &model, &terms);
        let spread_covariance = covariance_of_hit(problem, &model, &terms, equations);
        hits.push(hit(problem, *index, lines, &terms, &left, &spread_covariance)?).ok()?;
    }
    Some(Learned { sensors, hits, hammer_gain })
}

/// Standard deviation of one unknown, in units of its own in the budget.
fn sigma_of<R: Real>(equations: &mut NormalEquations<'_, R>, unknown: usize) -> R {
    let solved = equations.solve(|right| right[unknown] = R::one());
    solved[unknown].max(R::zero()).sqrt()
}

fn sensor<R: Real>(
    uncertainty: &crate::layout::SensorUncertainty<R>,
    values: &[R; SENSOR_CAUSES],
    sigmas: &[R; SENSOR_CAUSES],
) -> LearnedSensor<R> {
    let learnt = |k: usize, unit: R| Learnt { value: values[k] * unit, sigma: sigmas[k] * unit };
    LearnedSensor {
        sensitivity: core::array::from_fn(|to| {
            core::array::from_fn(|from| {
                let gain = if to == from { uncertainty.gain } else { uncertainty.cross_axis };
                learnt(3 * to + from, gain)
            })
        }),
        rotation: core::array::from_fn(|k| learnt(9 + k, uncertainty.rotation)),
        position: core::array::from_fn(|k| learnt(12 + k, uncertainty.position)),
        strain: root_mean_square(values),
    }
}

type HitCovariance<R> = [[R; HIT_CAUSES]; HIT_CAUSES];

/// Covariance of the hit's own causes after the test: `I − sᵀ D⁻¹ s + (Xᵀ D⁻¹ s)ᵀ N⁻¹ (Xᵀ D⁻¹ s)`
/// with `s` the readings of one standard deviation each and `N` the normal matrix.
fn covariance_of_hit<R: Real, const S: usize, const H: usize>(
    problem: &Problem<'_, R, S, H>,
    model: &Model<R, S>,
    terms: &Terms<R, S>,
    equations: &mut NormalEquations<'_, R>,
) -> HitCovariance<R> {
    let spread = &terms.model.spread;
    let weighted = spread.0.map(|column| terms.weight.times(&column));
    let mut covariance: HitCovariance<R> = core::array::from_fn(|i| {
        core::array::from_fn(|j| {
            let unit = if i == j { R::one() } else { R::zero() };
            unit - spread.0[i].dot(&weighted[j])
        })
    });
    for j in 0..HIT_CAUSES {
        let as_residual =
            Terms { model: terms.model.clone(), weight: terms.weight, residual: spread.0[j] };
        equations.begin_second();
        problem.with_rows(model, &as_residual, |rows| equations.add_second(rows));
        equations.solve_second();
        // The readings that the unknowns would explain of it.
        let mut explained = Responses::<R, S>::zeros();
        problem.with_rows(model, terms, |rows| {
            let mut solved = equations.second().iter();
            for (i, columns) in rows.sensors.iter().enumerate() {
                for (column, value) in columns.iter().zip(&mut solved) {
                    let mut part = explained.column_mut(i);
                    part += column * *value;
                }
            }
            for (column, value) in rows.shared.iter().zip(solved) {
                explained += column * *value;
            }
        });
        for (i, row) in covariance.iter_mut().enumerate() {
            row[j] += weighted[i].dot(&explained);
        }
    }
    covariance
}

fn hit<R: Real, const S: usize, const H: usize>(
    problem: &Problem<'_, R, S, H>,
    index: usize,
    lines: &MassLines<R, S>,
    terms: &Terms<R, S>,
    left: &Responses<R, S>,
    covariance: &HitCovariance<R>,
) -> Option<LearnedHit<R>> {
    let (miss, lean) = problem.layout.hits.get(index)?.uncertainty.of_mean(lines.hits);
    let HitStrain { values, strain, misfit } = HitStrain::of(terms, left, problem.channels);
    let vector = |first: usize, unit: R| -> [Learnt<R>; 3] {
        let [t, u]: &[Vector3<R>; 2] = &terms.model.across;
        core::array::from_fn(|axis| {
            let (a, b) = (t[axis], u[axis]);
            let variance = a * a * covariance[first][first]
                + b * b * covariance[first + 1][first + 1]
                + R::of(2.0) * a * b * covariance[first][first + 1];
            Learnt {
                value: (a * values[first] + b * values[first + 1]) * unit,
                sigma: variance.max(R::zero()).sqrt() * unit,
            }
        })
    };
    Some(LearnedHit {
        index,
        position: vector(0, miss),
        direction: vector(2, lean),
        strain,
        misfit,
    })
}

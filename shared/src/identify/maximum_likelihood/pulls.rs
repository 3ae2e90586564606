//! The pulls: how far the nuisance parameters must have moved to explain the readings, and which sensor or
//! hit is the first suspect.

use super::fit_problem::{FitProblem, MOST_SHARED, Terms};
use super::model::{HIT_NUISANCES, Model, SENSOR_NUISANCES};
use super::normal_equations::{NormalEquations, Rows};
use crate::body::RigidBody;
use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostic, Severity, Subject};
use crate::identify::DofMassLines;
use crate::real::Real;
use crate::responses::Responses;
use heapless::Vec;
use nalgebra::Vector3;

/// A sensor or hit is suspect when its root mean square pull exceeds this number of standard deviations.
pub const SUSPICIOUS: f64 = 2.0;

/// Values of the unknowns: of the nuisance parameters that stay the same over the test, in standard deviations
/// of the budget, and perhaps of the ten properties.
pub(super) struct UnknownValues<R: Real, C: Capacity> {
    pub(super) sensors: C::Sensors<[R; SENSOR_NUISANCES]>,
    /// The hammer's gain, then the attached bodies, then, if they are known, steps of the ten properties.
    pub(super) shared: Vec<R, MOST_SHARED>,
}

/// The nuisance parameters of the mean hit on one DOF, in standard deviations of the budget.
pub(super) struct HitPull<R> {
    pub(super) values: [R; HIT_NUISANCES],
    /// Root mean square of the values.
    pub(super) pull: R,
    /// Root mean square of the residuals of the readings over their noise.
    pub(super) normalized_residual: R,
}

impl<R: Real, C: Capacity> UnknownValues<R, C> {
    /// From the unknowns in the order of the equations.
    pub(super) fn of(sensors: usize, unknowns: &[R]) -> Option<Self> {
        let (of_sensors, of_all) = unknowns.split_at_checked(SENSOR_NUISANCES * sensors)?;
        let (values, _) = of_sensors.as_chunks::<SENSOR_NUISANCES>();
        let sensors = values.iter().copied().collect();
        Some(Self { sensors, shared: Vec::from_slice(of_all).ok()? })
    }

    /// The residual of a hit DOF that these values leave unexplained.
    pub(super) fn residual(
        &self,
        problem: &FitProblem<'_, R, C>,
        model: &Model<R, C>,
        terms: &Terms<R, C>,
    ) -> Responses<R, C> {
        problem.with_rows(model, terms, |rows| self.left(rows))
    }

    /// The residual of these rows that the values leave unexplained.
    pub(super) fn left(&self, rows: &Rows<'_, R, C>) -> Responses<R, C> {
        let mut left = rows.residual.clone();
        for (i, (columns, values)) in rows.sensors.iter().zip(self.sensors.iter()).enumerate() {
            let mut part = Vector3::from(left.of_sensor(i));
            for (column, value) in columns.iter().zip(values) {
                part -= column * *value;
            }
            left.set_sensor(i, part.into());
        }
        for (column, value) in rows.shared.iter().zip(&self.shared) {
            left.add_multiple(column, -*value);
        }
        left
    }

    /// As many zeros.
    pub(super) fn zeros(&self) -> Self {
        let sensors = self.sensors.iter().map(|_| [R::zero(); SENSOR_NUISANCES]).collect();
        Self { sensors, shared: self.shared.iter().map(|_| R::zero()).collect() }
    }

    /// All values, in the order of the equations.
    pub(super) fn iter(&self) -> impl Iterator<Item = R> + '_ {
        self.sensors.iter().flatten().chain(&self.shared).copied()
    }
}

impl<R: Real> HitPull<R> {
    /// From the residual that [`UnknownValues::residual`] returns.
    pub(super) fn of<C: Capacity>(
        terms: &Terms<R, C>,
        left: &Responses<R, C>,
        channels: usize,
    ) -> Self {
        let weighted = terms.weight.times(left);
        let values: [R; HIT_NUISANCES] =
            core::array::from_fn(|k| terms.model.spread.0[k].dot(&weighted));
        // The residual that the hit's own nuisance parameters leave is noise.
        let noise = left.dot(&weighted) - sum_of_squares(&values);
        let normalized_residual = (noise.max(R::zero()) / R::of(channels.max(1) as f64)).sqrt();
        Self { values, pull: root_mean_square(&values), normalized_residual }
    }
}

/// Root mean square of pulls.
pub(in crate::identify) fn root_mean_square<R: Real>(values: &[R]) -> R {
    (sum_of_squares(values) / R::of(values.len().max(1) as f64)).sqrt()
}

fn sum_of_squares<R: Real>(values: &[R]) -> R {
    values.iter().fold(R::zero(), |sum, v| sum + *v * *v)
}

/// The sensor or hit with the largest pull; `None` when no pull is large enough.
pub(super) fn suspect<R: Real, C: Capacity>(
    problem: &FitProblem<'_, R, C>,
    dofs: &[DofMassLines<R, C>],
    body: &RigidBody<R>,
    equations: &mut NormalEquations<'_, R>,
) -> Option<Diagnostic> {
    let nuisances = UnknownValues::<R, C>::of(problem.layout.sensors.len(), equations.nuisances())?;
    let mut largest = (R::of(SUSPICIOUS), None);
    // Pulls are in units of the budget in use, the statement in those of the stated one.
    let scale = problem.scales.constant;
    let mut look_at = |pull: R, code: Code, subject: Subject| {
        let pull = pull * scale;
        if pull > largest.0 {
            let value = pull.to_f32();
            let diagnostic = Diagnostic::about(code, Severity::Warning, subject, value);
            largest = (pull, Some(diagnostic));
        }
    };
    for (i, values) in nuisances.sensors.iter().enumerate() {
        look_at(root_mean_square(values), Code::LargeSensorPull, Subject::sensor(i));
    }
    let model = Model::new(problem.layout, &problem.balance, body)?;
    for (place, (index, lines)) in dofs.iter().enumerate() {
        let terms = problem.terms(&model, *index, lines, &equations.hit_errors(place))?;
        let left = nuisances.residual(problem, &model, &terms);
        let hit = HitPull::of(&terms, &left, problem.channels);
        look_at(hit.pull.max(hit.normalized_residual), Code::LargeHitPull, Subject::hit(*index));
    }
    largest.1
}

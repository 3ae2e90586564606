//! Gravity that is not what the layout says of it.

use massline_shared::STANDARD_GRAVITY;
use massline_shared::diagnosis::{Code, Diagnostic, Severity};
use massline_shared::layout::HostLayout;
use nalgebra::Vector3;

use super::GlobalAnswer;
use super::alternatives::UnexplainedTest;

/// Standard deviation of the direction of gravity, rad, with which the readings decide about it.
const ANY_DIRECTION: f64 = 1.0;
/// Most fits until the direction settles: it is changed across gravity, so a large tilt needs a second one.
const MOST_FITS: usize = 6;
/// Change of the direction, rad, below which it has settled: the next is its square.
const SETTLED: f64 = 5e-3;
/// Largest tilt that is looked for, rad; gravity further off is another axis.
const LARGEST_TILT: f64 = 0.8;
/// A tilt over its standard deviation from which it is more than noise: chance gives it once in 20 000 tests.
const SIGNIFICANT: f64 = 4.5;
/// A tilt over that of an object that hangs as the layout says, from which it is named: one in a hundred hangs so.
const BEYOND_BUDGET: f64 = 3.0;

/// Gravity as the readings have it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct GravityTilt {
    /// The vector, m/s².
    pub(super) gravity: [f64; 3],
    /// Its angle to that of the layout, rad.
    angle: f64,
    /// Standard deviation of its direction about each axis across it, rad.
    sigma: f64,
    /// What the global fit leaves under it, over the noise.
    pub(super) left: f64,
}

/// A direction of gravity that does not change when the readings are fitted once more.
struct SettledGravity {
    answer: GlobalAnswer,
    /// m/s².
    gravity: Vector3<f64>,
    /// Standard deviation of its direction about each axis across it, rad.
    sigma: f64,
}

impl GravityTilt {
    /// What is said of it.
    pub(super) fn warning(&self) -> Diagnostic {
        let degrees = self.angle.to_degrees() as f32;
        Diagnostic::whole(Code::GravityTilted, Severity::Warning, degrees)
    }

    /// The layout under it. The prior is twice as wide as what the readings say, so that they decide once more.
    pub(super) fn upright(&self, layout: &HostLayout) -> HostLayout {
        let mut layout = HostLayout { gravity: Some(self.gravity), ..layout.clone() };
        layout.apparatus.gravity_direction = 2.0 * self.sigma;
        layout
    }
}

impl UnexplainedTest<'_, '_> {
    /// The finding about gravity with which the readings are explained; `None` where gravity as stated explains them
    /// about as well from the same start.
    pub(super) fn gravity(&self) -> Option<Diagnostic> {
        let left_under = |layout: &HostLayout| {
            let answer = self.solved(layout, self.readings, 0)?;
            answer.explains(self.fit).then(|| answer.left_over(self.fit))
        };
        let as_stated = left_under(self.layout);
        let senses = |layout: &mut HostLayout, senses: bool| {
            layout.sensors.iter_mut().for_each(|sensor| sensor.senses_gravity = senses);
        };
        let flags = [false, true].map(|of_all| {
            let mut changed = self.layout.clone();
            senses(&mut changed, of_all);
            let finding = Diagnostic::whole(Code::SensesGravitySuspect, Severity::Error, 0.0);
            (changed, finding)
        });
        let directions = [-3_i8, -2, -1, 1, 2, 3].map(|axis| {
            let mut changed = self.layout.clone();
            let mut gravity = [0.0; 3];
            gravity[usize::from(axis.unsigned_abs()) - 1] =
                STANDARD_GRAVITY * f64::from(axis.signum());
            changed.gravity = Some(gravity);
            let code = Code::GravitySuspect;
            (changed, Diagnostic::whole(code, Severity::Error, f32::from(axis)))
        });
        let opposite = self.layout.gravity.map(|gravity| {
            let mut changed = self.layout.clone();
            changed.gravity = Some(gravity.map(|g| -g));
            (changed, Diagnostic::whole(Code::GravityReversed, Severity::Error, 0.0))
        });
        // Without gravity in the layout, that no sensor senses it changes nothing.
        let flags = flags.into_iter().filter(|_| self.layout.gravity.is_some());
        let tried = opposite.into_iter().chain(directions).chain(flags);
        let explaining =
            tried.filter_map(|(layout, finding)| Some((left_under(&layout)?, finding)));
        let (left, finding) = explaining.min_by(|a, b| a.0.total_cmp(&b.0))?;
        as_stated.is_none_or(|stated| self.is_much_less(left, stated)).then_some(finding)
    }

    /// Gravity with the direction that the readings give it, where they are explained with it and without extra terms,
    /// and where that is further from the layout's than noise and the budget make likely.
    pub(super) fn tilted(&self) -> Option<GravityTilt> {
        let stated = Vector3::from(self.layout.gravity?);
        let SettledGravity { answer, gravity, sigma } = self.settled(&stated)?;
        let angle = gravity.angle(&stated);
        let of_hanging = sigma.hypot(self.layout.apparatus.gravity_direction);
        let is_tilted = self.is_whole(&answer)
            && angle > SIGNIFICANT * sigma
            && angle > BEYOND_BUDGET * of_hanging;
        let (gravity, left) = (gravity.into(), answer.left_over(self.fit));
        is_tilted.then_some(GravityTilt { gravity, angle, sigma, left })
    }

    /// The direction of gravity that the readings give; `None` when it does not settle near the stated one.
    fn settled(&self, stated: &Vector3<f64>) -> Option<SettledGravity> {
        let mut layout = self.layout.clone();
        layout.apparatus.gravity_direction = ANY_DIRECTION;
        let mut start = *self.start;
        for _fit in 0..MOST_FITS {
            let answer =
                UnexplainedTest { start: &start, ..*self }.solved(&layout, self.readings, 0)?;
            let fitted = answer.solution.gravity?;
            let gravity = Vector3::from(fitted.components.map(|component| component.value));
            let gravity = gravity.normalize() * stated.norm();
            if gravity.angle(stated) > LARGEST_TILT {
                return None;
            }
            if fitted.angle < SETTLED {
                let sigmas = Vector3::from(fitted.components.map(|component| component.sigma));
                // Of two rotations.
                let sigma = sigmas.norm() / (stated.norm() * 2_f64.sqrt());
                return Some(SettledGravity { answer, gravity, sigma });
            }
            layout.gravity = Some(gravity.into());
            start = answer.solution.estimate.body;
        }
        None
    }

    /// Number of independent real readings.
    pub(super) fn independent_readings(&self) -> f64 {
        let readings = self.readings;
        let complex = readings.frequencies().len() * readings.channels() * readings.hits();
        2.0 * complex as f64 / readings.correlation.powi(2)
    }
}

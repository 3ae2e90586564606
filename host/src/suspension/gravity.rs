//! Gravity that is not what the layout says of it.

use massline_shared::STANDARD_GRAVITY;
use massline_shared::diagnosis::{Code, Diagnostic, Severity};
use massline_shared::layout::HostLayout;
use nalgebra::{Matrix2, Rotation3, Vector2, Vector3};

use super::alternatives::Unexplained;
use super::explained::{explains, left};

/// Steps of the search for a tilt, rad: the first are about the size of what is looked for, the last of what those miss.
const STEPS: [f64; 4] = [0.05, 0.05, 0.02, 0.005];
/// Largest tilt that is looked for, rad; gravity further off is another axis.
const LARGEST_TILT: f64 = 0.8;
/// Decrease of χ² from which a tilt is more than noise: two more unknowns lower it by so much once in 20 000 tests.
const SIGNIFICANT: f64 = 20.0;

/// Gravity as the readings have it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tilted {
    /// The vector, m/s².
    pub(super) gravity: [f64; 3],
    /// Its angle to that of the layout, rad.
    angle: f64,
    /// What the global fit leaves under it, over the noise.
    pub(super) left: f64,
}

impl Tilted {
    /// What is said of it.
    pub(super) fn warning(&self) -> Diagnostic {
        let degrees = self.angle.to_degrees() as f32;
        Diagnostic::whole(Code::GravityTilted, Severity::Warning, degrees)
    }
}

impl Unexplained<'_, '_> {
    /// The finding about gravity with which the readings are explained.
    pub(super) fn gravity(&self) -> Option<Diagnostic> {
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
        let explaining = tried.filter_map(|(layout, finding)| {
            let found = self.solved(&layout, self.readings, 0)?;
            explains(&found, self.fit).then_some((found.noise, finding))
        });
        explaining.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, finding)| finding)
    }

    /// Gravity with a direction of its own, where the readings are explained with it and without extra terms. The squares that
    /// the fit leaves are nearly a quadratic of the two tilts, so six fits tell where the least are.
    pub(super) fn tilted(&self) -> Option<Tilted> {
        let stated = Vector3::from(self.layout.gravity?);
        if !self.layout.sensors.iter().any(|sensor| sensor.senses_gravity) {
            return None;
        }
        let first = stated.cross(&Vector3::ith(stated.iamin(), 1.0)).try_normalize(0.0)?;
        let second = stated.cross(&first).try_normalize(0.0)?;
        let tilted = |tilt: Vector2<f64>| {
            let rotation = Rotation3::new(first * tilt.x + second * tilt.y);
            let gravity: [f64; 3] = (rotation * stated).into();
            let layout = HostLayout { gravity: Some(gravity), ..self.layout.clone() };
            self.solved(&layout, self.readings, 0).map(|found| (found, gravity))
        };
        let mut tilt = Vector2::zeros();
        let (level, _) = tilted(tilt)?;
        for step in STEPS {
            let squares = |at: Vector2<f64>| tilted(at).map(|(found, _)| found.noise.powi(2));
            tilt = least(squares, tilt, step)?;
            if tilt.norm() > LARGEST_TILT {
                return None;
            }
        }
        let (found, gravity) = tilted(tilt)?;
        let decrease = (level.noise / found.noise).powi(2) - 1.0;
        let is_tilted =
            self.is_whole(&found) && decrease * self.independent_readings() > SIGNIFICANT;
        is_tilted.then(|| Tilted { gravity, angle: tilt.norm(), left: left(&found, self.fit) })
    }

    /// Number of independent real readings.
    pub(super) fn independent_readings(&self) -> f64 {
        let readings = self.readings;
        let complex = readings.frequencies().len() * readings.channels() * readings.hits();
        2.0 * complex as f64 / readings.correlation.powi(2)
    }
}

/// Where a quadratic through six points about `centre`, at this distance, is least; `None` where a value is missing or the
/// quadratic has no minimum.
fn least(
    value: impl Fn(Vector2<f64>) -> Option<f64>,
    centre: Vector2<f64>,
    step: f64,
) -> Option<Vector2<f64>> {
    let at = |x: f64, y: f64| value(centre + Vector2::new(x, y) * step);
    let (here, both) = (at(0.0, 0.0)?, at(1.0, 1.0)?);
    let (right, left) = (at(1.0, 0.0)?, at(-1.0, 0.0)?);
    let (up, down) = (at(0.0, 1.0)?, at(0.0, -1.0)?);
    let slope = Vector2::new(right - left, up - down) / 2.0;
    let mixed = both - right - up + here;
    let curvature = Matrix2::new(right - 2.0 * here + left, mixed, mixed, up - 2.0 * here + down);
    let descent = curvature.cholesky()?.solve(&slope);
    Some(centre - descent * step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quadratic_is_least_where_it_is() {
        let value = |at: Vector2<f64>| {
            let (x, y) = (at.x - 0.3, at.y + 0.2);
            Some(7.0 + 2.0 * x * x + x * y + 3.0 * y * y)
        };
        let found = least(value, Vector2::new(0.1, 0.1), 0.05).unwrap();
        // Rounding of squares of 7 over squares of steps of 0.05.
        assert!((found - Vector2::new(0.3, -0.2)).norm() < 1e-10, "{found}");
        assert_eq!(least(|_| None, Vector2::zeros(), 0.1), None);
        assert_eq!(least(|at| Some(-at.norm_squared()), Vector2::zeros(), 0.1), None);
    }
}

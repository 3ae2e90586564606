//! Uncertainties as standard deviations (1 σ): the error budget of a test, priors, and the bodies attached to
//! the object.

use crate::Real;
/// Largest number of attached bodies.
pub const MAX_ATTACHED: usize = 3;

/// Relative standard deviation of the hammer's gain against the sensors' when the ratio is not calibrated
/// (theory, section 9).
pub const DEFAULT_HAMMER_GAIN: f64 = 0.02;

/// The same after a calibration with a block of known mass (theory, section 9: 0.27 to 0.35 % with five hits along each axis).
pub const CALIBRATED_HAMMER_GAIN: f64 = 0.003;

/// Relative standard deviation of a gain that the sensor channels have in common because the converter is not linear, for
/// responses of a few codes: a sine of ±1.5 LSB (data sheet of the STM32F407) and three periods over 4096 codes has slopes of
/// 0.5 %, root mean square. Large signals pass over many codes and average it.
pub const DEFAULT_CONVERTER_GAIN: f64 = 0.005;

/// Relative standard deviation of a mean force from hit DOF to hit DOF: half of the linearity in the data sheets of
/// instrumented hammers, 1 %.
pub const DEFAULT_HIT_GAIN: f64 = 0.005;

/// Standard deviation of the direction of gravity about each axis across it, rad: one degree, as objects hang by eye.
pub const DEFAULT_GRAVITY_DIRECTION: f64 = 0.02;

/// Uncertainty of mounting and calibration of a sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SensorUncertainty<R> {
    /// Position along each axis, m.
    pub position: R,
    /// Rotation about each axis, rad.
    pub rotation: R,
    /// Sensitivity of each axis, relative.
    pub gain: R,
    /// Cross-axis sensitivity of each axis to each other, relative.
    pub cross_axis: R,
}

/// Uncertainty of a hit against its mark, and of the mark itself.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HitUncertainty<R> {
    /// Position across the direction, varying from hit to hit, m.
    pub position: R,
    /// Direction about each axis across it, varying from hit to hit, rad.
    pub direction: R,
    /// Position of the mark, the same for all hits on it, m.
    pub node_position: R,
    /// Direction at the mark, the same for all hits on it, rad.
    pub node_direction: R,
}

/// A property that is known before the test.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Prior<R> {
    /// Index in `theta`, 0 to 9: the mass is 0.
    pub property: u8,
    /// Value for the object without [`Layout::attached`](super::Layout::attached); SI units.
    pub value: R,
    /// Standard deviation of the value.
    pub sigma: R,
}

/// A body that moves with the object but does not belong to it: sensors, cables, an adapter.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Attached<R> {
    /// [m, m c, J about the origin] in the body frame of the layout.
    pub phi: [R; 10],
    /// Relative standard deviation of its mass; its shape is taken as exact.
    pub relative_sigma: R,
}

impl<R: Real> Default for SensorUncertainty<R> {
    /// Values of theory, section 9.
    fn default() -> Self {
        Self {
            position: R::of(0.0015),
            rotation: R::of(0.015),
            gain: R::of(0.01),
            cross_axis: R::of(0.01),
        }
    }
}

impl<R: Real> Default for HitUncertainty<R> {
    /// Values of theory, section 9; those of the marks from theory, section 4.
    fn default() -> Self {
        Self {
            position: R::of(0.003),
            direction: R::of(0.05),
            node_position: R::of(0.001),
            node_direction: R::of(0.01),
        }
    }
}

impl<R: Real> SensorUncertainty<R> {
    /// A perfect sensor.
    pub fn none() -> Self {
        let zero = R::zero();
        Self { position: zero, rotation: zero, gain: zero, cross_axis: zero }
    }

    /// The same with every standard deviation multiplied.
    pub fn scaled(&self, factor: R) -> Self {
        Self {
            position: self.position * factor,
            rotation: self.rotation * factor,
            gain: self.gain * factor,
            cross_axis: self.cross_axis * factor,
        }
    }

    pub(super) fn cast<Q: Real>(&self) -> SensorUncertainty<Q> {
        let to = |v: R| Q::of(v.to_f64());
        SensorUncertainty {
            position: to(self.position),
            rotation: to(self.rotation),
            gain: to(self.gain),
            cross_axis: to(self.cross_axis),
        }
    }
}

impl<R: Real> HitUncertainty<R> {
    /// A perfect hammer on a perfect mark.
    pub fn none() -> Self {
        let zero = R::zero();
        Self { position: zero, direction: zero, node_position: zero, node_direction: zero }
    }

    /// Standard deviations of position (m) and direction (rad) of the mean of `hits` hits: the scatter
    /// averages out, the error of the mark does not.
    pub fn of_mean(&self, hits: u16) -> (R, R) {
        let hits = R::of(f64::from(hits.max(1)));
        let mean = |scatter: R, mark: R| (scatter * scatter / hits + mark * mark).sqrt();
        (mean(self.position, self.node_position), mean(self.direction, self.node_direction))
    }

    /// Standard deviations of second order of the mean of `hits` hits: of its length, relative, which varies with the
    /// squares of the angles `1 − |t + s|²/2`, and of the torque about its direction, m, which comes from
    /// displacements times angles. Scatter s and error of the mark t are independent in two directions.
    pub(crate) fn second_order(&self, hits: u16) -> (R, R) {
        let n = R::of(f64::from(hits.max(1)));
        let HitUncertainty { position, direction, node_position, node_direction } = *self;
        let two = R::of(2.0);
        let square = |a: R, b: R| (a * b) * (a * b);
        let length = square(node_direction, node_direction)
            + (two * square(node_direction, direction) + square(direction, direction)) / n;
        let mixed = square(position, node_direction) + square(node_position, direction);
        let torque =
            square(node_position, node_direction) + (square(position, direction) + mixed) / n;
        (length.sqrt(), (two * torque).sqrt())
    }

    /// Root mean square deviation of a hit's accelerances, relative to their size, for sensors at this
    /// distance (m): two turns and two displacements across the direction.
    pub fn relative_scatter(&self, distance: R) -> R {
        let displaced = self.position / distance;
        let scatter = self.direction * self.direction + displaced * displaced;
        let scatter = (scatter * R::of(2.0)).sqrt();
        if scatter.finite() { scatter } else { R::zero() }
    }

    pub(super) fn cast<Q: Real>(&self) -> HitUncertainty<Q> {
        let to = |v: R| Q::of(v.to_f64());
        HitUncertainty {
            position: to(self.position),
            direction: to(self.direction),
            node_position: to(self.node_position),
            node_direction: to(self.node_direction),
        }
    }
}

impl<R: Real> Prior<R> {
    /// True when the prior can compensate for missing hits. A known mass or centre of mass cannot, as the
    /// missing quantity is the inertia about the axis that no hit turns the body about (theory, section 4).
    pub fn is_of_inertia(&self) -> bool {
        (4..10).contains(&self.property)
    }

    pub(super) fn cast<Q: Real>(&self) -> Prior<Q> {
        let to = |v: R| Q::of(v.to_f64());
        Prior { property: self.property, value: to(self.value), sigma: to(self.sigma) }
    }
}

impl<R: Real> Attached<R> {
    /// A point mass, kg, at a position in the body frame, m.
    pub fn point(mass: R, relative_sigma: R, position: [R; 3]) -> Self {
        let [x, y, z] = position;
        let phi = [
            mass,
            mass * x,
            mass * y,
            mass * z,
            mass * (y * y + z * z),
            mass * (x * x + z * z),
            mass * (x * x + y * y),
            -mass * x * y,
            -mass * x * z,
            -mass * y * z,
        ];
        Self { phi, relative_sigma }
    }

    pub(super) fn cast<Q: Real>(&self) -> Attached<Q> {
        let to = |v: R| Q::of(v.to_f64());
        Attached { phi: self.phi.map(to), relative_sigma: to(self.relative_sigma) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::RigidBody;
    use nalgebra::{Matrix3, Vector3};

    #[test]
    fn a_point_mass_has_the_phi_of_a_body_without_extent() {
        let body = RigidBody {
            mass: 0.004_f64,
            center_of_mass: Vector3::new(0.1, -0.2, 0.05),
            inertia: Matrix3::zeros(),
        };
        let point = Attached::point(0.004, 0.1, [0.1, -0.2, 0.05]);
        for (got, expected) in point.phi.iter().zip(body.phi().iter()) {
            // The tolerance covers rounding of products of order 1e-4.
            assert!((got - expected).abs() < 1e-18);
        }
    }

    #[test]
    fn hits_average_the_scatter_but_not_the_mark() {
        let hit = HitUncertainty {
            position: 3.0,
            direction: 0.0,
            node_position: 4.0,
            node_direction: 2.0,
        };
        assert_eq!(hit.of_mean(1), (5.0, 2.0));
        assert_eq!(hit.of_mean(9), (17.0_f64.sqrt(), 2.0));
    }
}

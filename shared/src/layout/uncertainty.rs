//! Uncertainties as standard deviations (1 σ): the error budget of a test, priors, and the bodies attached to
//! the object.

use super::{ErrorSource, Layout};
use crate::capacity::Capacity;
use crate::real::Real;

/// Largest number of attached bodies.
pub const MAX_ATTACHED: usize = 3;

/// Relative standard deviation of the hammer's gain against the sensors' when the ratio is not calibrated
/// (theory, section 9).
pub const DEFAULT_HAMMER_GAIN: f64 = 0.02;

/// The same after a calibration with a block of known mass (theory, section 9: 0.27 to 0.35 % with five hits along each
/// axis).
pub const CALIBRATED_HAMMER_GAIN: f64 = 0.003;

/// A key of `[uncertainty]`: one standard deviation of what is not exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UncertaintyKey {
    /// As a layout file writes it.
    pub name: &'static str,
    /// What varies.
    pub meaning: &'static str,
    /// Its unit.
    pub unit: UncertaintyUnit,
    /// The standard deviation where none is stated, in its unit.
    pub default: f64,
    /// True for what mass lines do not count: only the methods that use the suspension modes do.
    pub only_modes: bool,
}

/// Unit of an uncertainty.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UncertaintyUnit {
    /// m.
    Meters,
    /// rad.
    Radians,
    /// Of the value itself.
    Relative,
}

impl UncertaintyUnit {
    /// The unit as it is written; `relative` without one.
    pub fn name(self) -> &'static str {
        match self {
            Self::Meters => "m",
            Self::Radians => "rad",
            Self::Relative => "relative",
        }
    }
}

/// Generates a struct of standard deviations from its rows: field, key, unit, default, error source, what varies. A row
/// is all that a key of `[uncertainty]` needs: layout files, their template and schema, the wire, the error sources and
/// the report follow from it.
macro_rules! uncertainties {
    (
        $(#[$doc:meta])*
        $name:ident {
            $(
                $field:ident: $key:literal, $unit:ident, $default:expr, $source:ident $(, $only_modes:ident)?;
                $meaning:literal
            )*
        }
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        pub struct $name<R> {
            $(#[doc = concat!("`", $key, "`: ", $meaning, ".")] pub $field: R,)*
        }

        impl<R: Real> Default for $name<R> {
            fn default() -> Self {
                Self { $($field: R::of($default)),* }
            }
        }

        impl<R> $name<R> {
            /// The keys, in the order of the fields.
            pub const KEYS: &'static [UncertaintyKey] = &[$(UncertaintyKey {
                name: $key,
                meaning: $meaning,
                unit: UncertaintyUnit::$unit,
                default: $default,
                only_modes: uncertainties!(@flag $($only_modes)?),
            }),*];

            /// The error source of each field.
            pub const SOURCES: &'static [ErrorSource] = &[$(ErrorSource::$source),*];

            /// The standard deviations, in the order of the fields.
            pub fn values(&self) -> impl Iterator<Item = &R> {
                [$(&self.$field),*].into_iter()
            }

            /// Each key with its standard deviation, in the order of the fields.
            pub fn rows(&self) -> impl Iterator<Item = (&'static UncertaintyKey, &R)> {
                Self::KEYS.iter().zip(self.values())
            }

            /// The standard deviations, in the order of the fields.
            pub fn values_mut(&mut self) -> impl Iterator<Item = &mut R> {
                [$(&mut self.$field),*].into_iter()
            }
        }

        impl<R: Real> $name<R> {
            /// Everything is exact.
            pub fn none() -> Self {
                Self { $($field: R::zero()),* }
            }

            /// The same with every standard deviation multiplied.
            pub fn scaled(&self, factor: R) -> Self {
                Self { $($field: self.$field * factor),* }
            }

            pub(super) fn cast<Q: Real>(&self) -> $name<Q> {
                $name { $($field: Q::of(self.$field.to_f64())),* }
            }
        }
    };
    (@flag) => { false };
    (@flag only_modes) => { true };
}

uncertainties! {
    /// Uncertainty of mounting and calibration of a sensor. The defaults are those of theory, section 9.
    SensorUncertainty {
        position: "sensor_position_m", Meters, 0.0015, SensorPosition;
            "position of each sensor along each axis"
        rotation: "sensor_rotation_rad", Radians, 0.015, SensorRotation;
            "rotation of each sensor about each axis"
        gain: "gain", Relative, 0.01, Gain;
            "gain of each axis of a sensor"
        cross_axis: "cross_axis", Relative, 0.01, CrossAxis;
            "cross-axis sensitivity of each sensor"
    }
}

uncertainties! {
    /// Uncertainty of a hit against its mark, and of the mark itself. The defaults are those of theory, section 9;
    /// those of the marks are from theory, section 4.
    HitUncertainty {
        position: "hit_position_m", Meters, 0.003, HitPosition;
            "where a hit lands across its direction, from hit to hit"
        direction: "hit_direction_rad", Radians, 0.05, HitDirection;
            "direction of a hit about each axis across it, from hit to hit"
        node_position: "node_position_m", Meters, 0.001, Marks;
            "position of the mark, the same for all hits on it"
        node_direction: "node_direction_rad", Radians, 0.01, Marks;
            "direction at the mark, the same for all hits on it"
    }
}

uncertainties! {
    /// Uncertainty of what all sensors and hits share. A gain of the hits of 0.5 % is half of the linearity in the data
    /// sheets of instrumented hammers. That of the converter is for responses of a few codes: a sine of ±1.5 LSB (data
    /// sheet of the STM32F407) and three periods over 4096 codes has slopes of 0.5 %, root mean square; large signals
    /// pass over many codes and average it. Objects hang by eye within a degree.
    ApparatusUncertainty {
        hammer_gain: "hammer_gain", Relative, DEFAULT_HAMMER_GAIN, HammerGain;
            "gain of the hammer against the sensors"
        hit_gain: "hit_gain", Relative, 0.005, HitGain, only_modes;
            "gain of the hammer from mark to mark: its linearity"
        converter_gain: "converter_gain", Relative, 0.005, Converter, only_modes;
            "gain of a nonlinear converter for small responses"
        gravity_direction: "gravity_direction_rad", Radians, 0.02, GravityDirection, only_modes;
            "direction of gravity about each axis across it"
    }
}

impl<R: Real, C: Capacity> Layout<R, C> {
    /// States that sensors, hits, hammer, converter and gravity are exact.
    pub fn set_exact(&mut self) {
        self.sensors.iter_mut().for_each(|sensor| sensor.uncertainty = SensorUncertainty::none());
        self.hits.iter_mut().for_each(|hit| hit.uncertainty = HitUncertainty::none());
        self.apparatus = ApparatusUncertainty::none();
    }
}

/// Every key of `[uncertainty]`.
pub fn uncertainty_keys() -> impl Iterator<Item = &'static UncertaintyKey> {
    let of_sensors = SensorUncertainty::<f64>::KEYS.iter();
    of_sensors.chain(HitUncertainty::<f64>::KEYS).chain(ApparatusUncertainty::<f64>::KEYS)
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
pub struct AttachedBody<R> {
    /// [m, m c, J about the origin] in the body frame of the layout.
    pub phi: [R; 10],
    /// Relative standard deviation of its mass; its shape is taken as exact.
    pub relative_sigma: R,
}

impl<R: Real> HitUncertainty<R> {
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

impl<R: Real> AttachedBody<R> {
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

    pub(super) fn cast<Q: Real>(&self) -> AttachedBody<Q> {
        let to = |v: R| Q::of(v.to_f64());
        AttachedBody { phi: self.phi.map(to), relative_sigma: to(self.relative_sigma) }
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
        let point = AttachedBody::point(0.004, 0.1, [0.1, -0.2, 0.05]);
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

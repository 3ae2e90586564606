//! The ten inertial parameters of a rigid body: symbols, units, and the scales for their errors.

use nalgebra::SVector;

use crate::real::Real;

/// One of the ten inertial parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InertialParameter {
    /// Its one name: in tables, pictures, results and files.
    pub symbol: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Unit used in tables.
    pub table_unit: &'static str,
    /// Factor from the SI unit to that of tables.
    pub table_factor: f64,
}

/// The ten inertial parameters, in the order of [`RigidBody::theta`](super::RigidBody::theta).
pub const INERTIAL_PARAMETERS: [InertialParameter; 10] = [
    InertialParameter { symbol: "m", unit: "kg", table_unit: "kg", table_factor: 1.0 },
    center_of_mass("c_x"),
    center_of_mass("c_y"),
    center_of_mass("c_z"),
    inertia("J_xx"),
    inertia("J_yy"),
    inertia("J_zz"),
    inertia("J_xy"),
    inertia("J_xz"),
    inertia("J_yz"),
];

const fn center_of_mass(symbol: &'static str) -> InertialParameter {
    InertialParameter { symbol, unit: "m", table_unit: "mm", table_factor: 1e3 }
}

const fn inertia(symbol: &'static str) -> InertialParameter {
    InertialParameter { symbol, unit: "kg m²", table_unit: "g m²", table_factor: 1e3 }
}

/// [m, L, L, L, m L² × 6]: scales for the errors of the inertial parameters of a body of mass m (kg) and size
/// L (m). The values themselves cannot serve as scales, since centre coordinates and products of inertia may
/// be zero.
///
/// ```
/// # use massline_shared::body::{INERTIAL_PARAMETERS, scale};
/// let scale = scale(1.23, 0.14);
/// let [mass, .., yz] = INERTIAL_PARAMETERS;
/// assert_eq!((mass.symbol, scale[0]), ("m", 1.23));
/// assert_eq!((yz.symbol, scale[9]), ("J_yz", 1.23 * 0.14 * 0.14));
/// ```
pub fn scale<R: Real>(mass: R, length: R) -> SVector<R, 10> {
    SVector::from_fn(|k, _| match k {
        0 => mass,
        1..4 => length,
        _ => mass * length * length,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_is_mass_length_and_mass_times_length_squared() {
        let scale = scale(1.23, 0.5);
        assert_eq!((scale[0], scale[3], scale[9]), (1.23, 0.5, 1.23 * 0.25));
    }

    #[test]
    fn units_follow_from_the_place_in_the_order() {
        let units = INERTIAL_PARAMETERS.map(|p| p.unit);
        assert_eq!(units[..4], ["kg", "m", "m", "m"]);
        assert!(units[4..].iter().all(|&unit| unit == "kg m²"));
    }
}

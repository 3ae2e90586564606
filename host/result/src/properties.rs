//! The ten properties of a body.

use massline_shared::EstimatedValue;
use serde::{Deserialize, Serialize};

/// A number, or several, with the standard deviation; `null` where that is not known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(rename = "spread_of_{T}"))]
pub struct Spread<T> {
    /// The value.
    pub value: T,
    /// Its standard deviation, in the same unit.
    pub sigma: Option<T>,
}

impl From<EstimatedValue<f64>> for Spread<f64> {
    fn from(EstimatedValue { value, sigma }: EstimatedValue<f64>) -> Self {
        Self { value, sigma: Some(sigma) }
    }
}

/// The same thing for each of the ten properties. Masses are in kg, distances in m, moments and products of inertia in
/// kg m²; `J_xy` is the element of the tensor, `−∫ x y dm`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(
    feature = "schema",
    derive(schemars::JsonSchema),
    schemars(rename = "properties_of_{T}")
)]
pub struct Properties<T> {
    /// The mass.
    pub m: T,
    /// Coordinate x of the centre of mass.
    pub c_x: T,
    /// Coordinate y of the centre of mass.
    pub c_y: T,
    /// Coordinate z of the centre of mass.
    pub c_z: T,
    /// Moment of inertia about x.
    #[serde(rename = "J_xx")]
    pub j_xx: T,
    /// Moment of inertia about y.
    #[serde(rename = "J_yy")]
    pub j_yy: T,
    /// Moment of inertia about z.
    #[serde(rename = "J_zz")]
    pub j_zz: T,
    /// Product of inertia.
    #[serde(rename = "J_xy")]
    pub j_xy: T,
    /// Product of inertia.
    #[serde(rename = "J_xz")]
    pub j_xz: T,
    /// Product of inertia.
    #[serde(rename = "J_yz")]
    pub j_yz: T,
}

impl<T: Copy> From<[T; 10]> for Properties<T> {
    fn from(values: [T; 10]) -> Self {
        Self::of(values)
    }
}

impl<T: Copy> Properties<T> {
    /// Ten things in the order m, c_x, c_y, c_z, J_xx, J_yy, J_zz, J_xy, J_xz, J_yz.
    pub fn of(values: [T; 10]) -> Self {
        let [m, c_x, c_y, c_z, j_xx, j_yy, j_zz, j_xy, j_xz, j_yz] = values;
        Self { m, c_x, c_y, c_z, j_xx, j_yy, j_zz, j_xy, j_xz, j_yz }
    }

    /// The ten in the same order.
    pub fn in_order(&self) -> [T; 10] {
        let Self { m, c_x, c_y, c_z, j_xx, j_yy, j_zz, j_xy, j_xz, j_yz } = *self;
        [m, c_x, c_y, c_z, j_xx, j_yy, j_zz, j_xy, j_xz, j_yz]
    }
}

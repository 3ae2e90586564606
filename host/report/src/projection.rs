//! How a body is drawn on a plane: seen from one side and a little from above, without perspective.

use nalgebra::Matrix2x3;

/// Where a picture looks from: azimuth about z, and elevation, rad.
const AZIMUTH: f64 = 0.6;
const ELEVATION: f64 = 0.45;

/// Takes a point of the body to the plane: to the right, and up. Lengths across the view are kept.
pub fn across() -> Matrix2x3<f64> {
    let (sin, cos) = AZIMUTH.sin_cos();
    let (up, flat) = ELEVATION.sin_cos();
    Matrix2x3::new(-sin, cos, 0.0, -up * cos, -up * sin, flat)
}

//! The scalar type of every solver.

use nalgebra::RealField;

/// `f32` on the rig; `f64` on the host and as the reference for the rig.
pub trait Real: RealField + Copy {
    /// The nearest value of this type to `value`.
    fn of(value: f64) -> Self;
    /// This value as `f64`, exact.
    fn to_f64(self) -> f64;
    /// This value as `f32`, rounded.
    fn to_f32(self) -> f32;

    /// True when the value is neither infinite nor NaN.
    ///
    /// Decompositions loop or return nonsense on NaN, so every solver checks this first.
    fn finite(self) -> bool {
        self.to_f64().is_finite()
    }
}

impl Real for f32 {
    fn of(value: f64) -> Self {
        value as f32
    }
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
    fn to_f32(self) -> f32 {
        self
    }
    fn finite(self) -> bool {
        self.is_finite()
    }
}

impl Real for f64 {
    fn of(value: f64) -> Self {
        value
    }
    fn to_f64(self) -> f64 {
        self
    }
    fn to_f32(self) -> f32 {
        self as f32
    }
}

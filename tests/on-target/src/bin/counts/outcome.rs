//! What a measurement prints, and the check that the work was done right.

use core::fmt;

use massline_on_target::{Cost, print};
use nalgebra::SVector;

pub fn close<const N: usize>(
    name: &str,
    got: &SVector<f32, N>,
    truth: &SVector<f32, N>,
    part: f32,
) {
    let error = (got - truth).amax();
    assert!(error <= part * truth.amax(), "{name}: {got} instead of {truth}");
}

pub fn report(name: impl fmt::Display, measured: Cost) {
    print(format_args!("{name}_instructions {}", measured.instructions));
    print(format_args!("{name}_stack {}", measured.stack));
}

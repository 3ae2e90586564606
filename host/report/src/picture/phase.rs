//! Phases, and their axis.

use std::ops::Range;

use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use plotters::coord::types::RangedCoordf64;

/// Lower and upper end of the axis, degrees: the range of [`phase_of`] and some room.
pub(super) const RANGE: [f64; 2] = [-110.0, 290.0];
/// Numbers beside the axis, degrees: where the responses of a rigid body lie, and the quarters between.
const QUARTERS: [f64; 5] = [-90.0, 0.0, 90.0, 180.0, 270.0];
/// A larger step from one bin to the next, degrees, is one to the other end of the range: no line joins them.
pub(super) const LARGEST_STEP: f64 = 180.0;

/// A phase in degrees from −90 to 270, so that noise does not throw a response against the force from one end to the
/// other.
pub(super) fn phase_of(radians: f64) -> f64 {
    let degrees = radians.to_degrees();
    if degrees < -90.0 { degrees + 360.0 } else { degrees }
}

/// The axis of a phase, with a number at every quarter of a turn.
pub(super) struct PhaseAxis(RangedCoordf64);

impl PhaseAxis {
    /// The axis of all pictures.
    pub fn new() -> Self {
        Self((RANGE[0]..RANGE[1]).into())
    }
}

impl Ranged for PhaseAxis {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        self.0.map(value, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        QUARTERS.to_vec()
    }

    fn range(&self) -> Range<f64> {
        self.0.range()
    }
}

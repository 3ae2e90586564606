//! Names the capacitor of a breakout board that was left in place, by the low cutoff that it causes.
//!
//! Behind the 32 kΩ in each output of an ADXL326 the 10 nF of the rig make 497 Hz. Breakout boards bring a
//! capacitor of their own for each axis, often 100 nF, which alone makes 50 Hz: the upper half of the usual band is
//! then mostly lost, and the tolerance of the 32 kΩ turns the rest.

use std::f64::consts::TAU;

use massline_shared::signal::Calibration;
use massline_shared::signal::self_test::LEAST_CUTOFF_HZ;

use super::cutoffs::{FoundCutoff, RcCutoff};

/// An axis whose cutoff is too low.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExtraCapacitor {
    /// Sensor, 0-based.
    pub sensor: usize,
    /// Axis: 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// The cutoff that was measured, Hz.
    pub cutoff_hz: f64,
    /// False when the calibration in force has this cutoff already.
    pub is_new: bool,
}

impl ExtraCapacitor {
    /// All capacitance behind the output, F.
    pub fn farad(&self) -> f64 {
        (TAU * Calibration::ADXL326_OUTPUT_OHM * self.cutoff_hz).recip()
    }
}

/// The axes whose cutoff is too low.
pub fn extra_capacitors(cutoffs: &[RcCutoff]) -> Vec<ExtraCapacitor> {
    let low = |cutoff: &RcCutoff| {
        let FoundCutoff { cutoff_hz, changed, .. } = cutoff.found.ok()?;
        let RcCutoff { sensor, axis, .. } = *cutoff;
        (cutoff_hz < f64::from(LEAST_CUTOFF_HZ)).then_some(ExtraCapacitor {
            sensor,
            axis,
            cutoff_hz,
            is_new: changed,
        })
    };
    cutoffs.iter().filter_map(low).collect()
}

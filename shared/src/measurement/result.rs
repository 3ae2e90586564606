//! Result of a campaign.

use super::stored_lines::StoredLines;
use crate::calibration::CalibrationSigma;
use crate::calibration::block::{BlockError, ForceRatio};
use crate::capacity::Rig;
use crate::diagnosis::Diagnostics;
use crate::identify::{DofMassLines, Estimate, Method};
use crate::layout::Dof;
use crate::real::Real;
use crate::signal::RESPONSES;

/// Data of a measured DOF besides its mass lines.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredDof<R: Real> {
    /// Name of the DOF.
    pub dof: Dof,
    /// Lower and upper end of the band of its mass lines, Hz.
    pub band_hz: [R; 2],
    /// Mean coherence over the band for each response; `None` for a single hit, whose coherence carries no
    /// information.
    pub coherence: Option<[R; RESPONSES]>,
}

/// The hammer's gain from a campaign on a block of known mass, or why there is none.
pub type BlockResult = Result<ForceRatio<f32>, BlockError>;

/// Measured data and estimates of a campaign, borrowed from the measurement.
#[derive(Clone, Copy, Debug)]
pub struct TestResult<'m, R: Real> {
    /// Data of each measured DOF.
    pub dofs: &'m [MeasuredDof<R>],
    /// Their mass lines, in the same order.
    pub mass_lines: &'m [DofMassLines<R, Rig>],
    /// In their place in the suspension profile: what is known of the stored lines of the DOFs, in the same order.
    pub lines: &'m [StoredLines<R>],
    /// Estimates, one per method, best first; empty for a block.
    pub estimates: &'m [Estimate<R>],
    /// The methods without an answer, and why.
    pub refusals: &'m [(Method, Diagnostics)],
    /// The hammer's gain, for a block of known mass.
    pub block: Option<BlockResult>,
    /// Standard deviations that the calibration has contributed to the error budget; `None` without a
    /// calibration of one's own.
    pub gains: Option<CalibrationSigma>,
    /// Diagnostics of the campaign.
    pub diagnostics: &'m Diagnostics,
}

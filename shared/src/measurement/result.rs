//! What a campaign has measured and identified.

use crate::calibration::block::{BlockError, ForceRatio};
use crate::diagnosis::Diagnostics;
use crate::identify::{DofMassLines, Estimate, Method};
use crate::layout::{Dof, RIG_SENSORS};
use crate::signal::RESPONSES;

/// What is known of a measured DOF besides its mass lines.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredDof<R> {
    /// Its name.
    pub dof: Dof,
    /// Lower and upper end of the band of its mass lines, Hz.
    pub band_hz: [R; 2],
    /// Mean coherence over the band, response by response; none of a single hit, where it says nothing.
    pub coherence: Option<[R; RESPONSES]>,
}

/// What a campaign says of the hammer, when it was one on a block of known mass.
pub type BlockResult = Result<ForceRatio<f32>, BlockError>;

/// What a campaign has measured and identified; borrowed from the measurement.
#[derive(Clone, Copy, Debug)]
pub struct TestResult<'m, R> {
    /// DOF by DOF.
    pub dofs: &'m [MeasuredDof<R>],
    /// Their mass lines, in the same order.
    pub mass_lines: &'m [DofMassLines<R, RIG_SENSORS>],
    /// The answers, one a method, the best first; none of a block.
    pub estimates: &'m [Estimate<R>],
    /// The methods without an answer, and why.
    pub refusals: &'m [(Method, Diagnostics)],
    /// The hammer's gain, of a block of known mass.
    pub block: Option<BlockResult>,
    /// What is to be said about the campaign.
    pub diagnostics: &'m Diagnostics,
}

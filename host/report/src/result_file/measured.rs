//! What a result says about the measurement, with what its archive and its layout know of it.

use massline_shared::calibration::CalibrationSigma;
use massline_shared::layout::HostLayout;

use super::ResultFile;
use massline_analysis::identification::with_gains;

impl ResultFile {
    /// The standard deviations that the calibration has contributed to the error budget, as old as it was during the
    /// test; `None` where it has contributed none.
    pub fn gains(&self) -> Option<CalibrationSigma> {
        match &self.archive {
            Some(archive) => archive.result.head.gains,
            None => self.result.calibration_sigma.map(Into::into),
        }
    }

    /// The layout as the answers were found with: its budget has what the calibration has contributed.
    pub fn layout_in_force(&self) -> Option<HostLayout> {
        self.layout().map(|layout| with_gains(layout, self.gains()))
    }
}

//! Closes a DOF in the suspension profile: its lines are stored by the driver, not kept in memory.

use nalgebra::Complex;

use super::closing::coherences;
use super::hits::Task;
use super::long_hit::LineScatter;
use super::stored_lines::StoredLines;
use super::{Activity, MeasuredDof, Measurement, NextAction, note};
use crate::diagnosis::{Code, Diagnostic, Severity, Subject};
use crate::signal::{RealFft, bins_of_band, resolution};

impl<R: RealFft> Measurement<'_, R> {
    /// One step of closing a DOF: what is said about it besides its lines; then the driver stores these.
    pub(super) fn close_lines(&mut self, dof: usize, task: Task<R>) -> Task<R> {
        if let Task::StoreLines = task {
            return task;
        }
        let name = self.layout.as_ref().and_then(|layout| layout.hits.get(dof)).map(|hit| hit.dof);
        let Some(name) = name else { return Task::StoreLines };
        let (test, adc) = (self.test(), self.adc_in_use());
        let band = test.expected_band();
        let bins = bins_of_band(band, resolution(&adc, test.profile));
        let spectra = &self.memory.spectra;
        let coherence = coherences(spectra, adc.responses(), bins.clone());
        let details = MeasuredDof { dof: name, band_hz: band, coherence };
        let scatter = LineScatter::of(spectra, adc.responses(), bins);
        let stored = StoredLines { dof: dof as u8, hits: spectra.hits(), scatter };
        self.memory.keep_lines(details, stored);
        Task::StoreLines
    }

    /// A line of the DOF that is being closed, (m/s²)/N: H1, or what the layout asks for, corrected for the cross-axis
    /// sensitivities of the sensors. To be called for [`NextAction::StoreLines`] only.
    pub fn line(&self, response: usize, line: usize) -> Complex<R> {
        let estimator = self.test().frf_estimator;
        let first = response - response % 3;
        let mut axes =
            core::array::from_fn(|axis| self.memory.spectra.frf(estimator, first + axis, line));
        self.calibration.to_own_axes(response / 3, &mut axes);
        axes[response % 3]
    }

    /// Reports that the lines of the DOF are stored.
    pub fn lines_stored(&mut self) {
        if let NextAction::StoreLines { .. } = self.next_action()
            && let Activity::Measuring(campaign, task) = &mut self.activity
        {
            *task = Task::None;
            campaign.dof_closed();
        }
    }

    /// Reports that the lines of the DOF could not be stored: the campaign is interrupted, and `Resume` tries again.
    pub fn lines_not_stored(&mut self) {
        if let NextAction::StoreLines { dof } = self.next_action()
            && let Activity::Measuring(campaign, _) = &mut self.activity
        {
            campaign.interrupted();
            let subject = Subject::hit(dof);
            let diagnostic = Diagnostic::about(Code::LinesNotStored, Severity::Error, subject, 0.0);
            note(&mut self.diagnostics, diagnostic);
        }
    }
}

#[cfg(test)]
mod tests;

//! The result of a measurement as the bytes that are stored. Domain values are converted to the wire's
//! objects one at a time.

use massline_protocol::calibration_checksum;
use massline_protocol::diagnostic::DiagnosticList;
use massline_protocol::lines_head::LinesHead;
use massline_protocol::object::{DofResult, ResultHead, StoredEstimate};

use crate::deadline::Deadline;
use crate::encoded::{self, Bytes};
use crate::rig::{Rig, cut};
use crate::store::Source;

/// The result of a measurement, encoded as a [`MeasurementResult`].
///
/// [`MeasurementResult`]: massline_protocol::object::MeasurementResult
pub(crate) struct StoredResult<'a, 'm> {
    rig: &'a Rig<'m>,
    number: u32,
    length: usize,
    checksum: u32,
}

impl<'a, 'm> StoredResult<'a, 'm> {
    /// The result to be stored under this number. Deadline: [`crate::deadline::DEADLINE`].
    pub fn new(rig: &'a Rig<'m>, number: u32) -> Self {
        let _deadline = Deadline::begin(&rig.stats);
        let counted = Self { rig, number, length: 0, checksum: 0 };
        let (length, checksum) = encoded::measured(&|bytes| counted.write(bytes));
        Self { length, checksum, ..counted }
    }

    /// Appends all values.
    fn write(&self, bytes: &mut Bytes<'_>) {
        let measurement = self.rig.measurement.borrow();
        let result = measurement.result();
        let layout = measurement.layout();
        let test = layout.map(|layout| layout.test).unwrap_or_default();
        bytes.put(&ResultHead {
            number: self.number,
            layout_hash: self.rig.layout_hash.get(),
            title: layout.map(|layout| layout.title.clone()).unwrap_or_default(),
            started_unix_s: measurement
                .campaign()
                .map_or(0, |campaign| campaign.started().started_unix_s),
            calibration: calibration_checksum(measurement.calibration()),
            gains: result.gains,
            firmware: cut(self.rig.info.firmware),
            frf_estimator: test.frf_estimator,
            terms: test.terms,
            band_automatic: test.band_hz.is_none(),
        });
        bytes.put(&(result.mass_lines.len() as u32));
        for (details, lines) in result.dofs.iter().zip(result.mass_lines) {
            bytes.put(&DofResult::of(details, lines));
        }
        bytes.put(&(result.lines.len() as u32));
        for (details, lines) in result.dofs.iter().zip(result.lines) {
            bytes.put(&LinesHead::of(details, lines));
        }
        bytes.put(&(result.estimates.len() as u32));
        for estimate in result.estimates {
            bytes.put(&StoredEstimate::from(estimate));
        }
        bytes.put(&DiagnosticList(result.diagnostics.clone()));
    }
}

impl Source for StoredResult<'_, '_> {
    fn length(&self) -> usize {
        self.length
    }

    fn checksum(&self) -> u32 {
        self.checksum
    }

    /// Deadline: [`crate::deadline::DEADLINE`].
    fn read(&self, offset: usize, out: &mut [u8]) {
        let _deadline = Deadline::begin(&self.rig.stats);
        encoded::read(&|bytes| self.write(bytes), offset, out);
    }
}

//! Goes on with a calibration: readings of the tumble test, the hammer's gain from a block, what is kept.

use embedded_storage_async::nor_flash::NorFlash;
use massline_shared::calibration::CalibrationRecord;
use massline_shared::measurement::{Measurement, RecordContent};
use massline_shared::signal::{AdcProperties, RestStatistics};

use super::PanelController;
use crate::panel::calibration_wizard::{self, WizardProblem};
use crate::panel::menu::Screen;
use crate::panel::modal::ModalState;
use crate::panel::refused::RefusalReason;
use crate::panel::summary::PIECE;

impl<F: NorFlash> PanelController<'_, '_, F> {
    pub(super) fn read_position(&mut self) -> Result<(), RefusalReason> {
        if !self.rig.measurement.borrow().is_idle() {
            return Err(RefusalReason::WrongPhase);
        }
        let readings = match &*self.modal {
            ModalState::Tumble(readings, _) | ModalState::Retry(readings, _) => readings.clone(),
            _ => return Err(RefusalReason::NotFound),
        };
        // If the request is refused, the record still holds an older reading, not one of this position.
        self.rig.take_reading()?;
        *self.modal = ModalState::Tumble(readings, true);
        Ok(())
    }

    /// Adds a finished reading to the tumble test, and solves the test after the last one.
    pub(super) fn take_reading(&mut self) {
        let ModalState::Tumble(readings, true) = &mut *self.modal else { return };
        let measurement = self.rig.measurement.borrow();
        let adc = calibrated(&measurement);
        let taken = match measurement.recorded() {
            _ if measurement.reads() => return,
            RecordContent::Reading => calibration_wizard::add_reading(
                readings,
                &RestStatistics::of(measurement.record()),
                &adc,
            ),
            RecordContent::ReadingFailed => {
                Err(WizardProblem::Refused(RefusalReason::SamplerStopped))
            }
            RecordContent::Nothing | RecordContent::Hit(_) | RecordContent::HitBefore(_) => {
                Err(WizardProblem::Refused(RefusalReason::Busy))
            }
        };
        *self.modal = match taken {
            Ok(false) => ModalState::Tumble(readings.clone(), false),
            Err(problem) => ModalState::Retry(readings.clone(), problem),
            Ok(true) => {
                let mut record = CalibrationRecord::from(*measurement.calibration());
                match calibration_wizard::of_tumble(readings, &mut record) {
                    Ok(proposal) => ModalState::Proposal(record, proposal),
                    Err(problem) => ModalState::Failed(problem),
                }
            }
        };
    }

    /// Computes the hammer's gain from the block test, relative to the calibration `stored`.
    pub(in crate::panel) fn solve_block(&mut self, stored: CalibrationRecord) {
        let measurement = self.rig.measurement.borrow();
        let mut record = CalibrationRecord { calibration: *measurement.calibration(), ..stored };
        let proposal = match measurement.result().block {
            Some(Ok(ratio)) => calibration_wizard::of_block(&ratio, &mut record),
            Some(Err(error)) => Err(WizardProblem::Block(error)),
            None => Err(WizardProblem::NoMass),
        };
        *self.modal = match proposal {
            Ok(proposal) => ModalState::Proposal(record, proposal),
            Err(problem) => ModalState::Failed(problem),
        };
        self.menu.open(Screen::CalibrationWizard);
    }

    /// Encodes the proposed calibration.
    pub(in crate::panel) fn encode_calibration<'p>(
        &self,
        piece: &'p mut [u8; PIECE],
    ) -> Result<&'p [u8], RefusalReason> {
        let ModalState::Proposal(record, _) = &*self.modal else {
            return Err(RefusalReason::NotFound);
        };
        let encoded = postcard::to_slice(record, piece);
        encoded.map(|bytes| &*bytes).map_err(|_| RefusalReason::StoreFailed)
    }

    /// Puts the proposed calibration, which has been stored, into force.
    pub(in crate::panel) fn calibrated(&mut self) {
        let ModalState::Proposal(record, _) = &*self.modal else { return };
        self.rig.measurement.borrow_mut().set_calibration(record.calibration, record.budget());
        *self.modal = ModalState::CalibrationStored;
    }
}

/// Properties of the converter, with the channels of the sensors to be calibrated: those of the layout, or
/// without one, all that have inputs.
fn calibrated(measurement: &Measurement<'_, f32>) -> AdcProperties {
    match measurement.layout() {
        Some(_) => measurement.adc_in_use(),
        None => *measurement.adc(),
    }
}

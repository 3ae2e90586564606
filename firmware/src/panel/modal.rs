//! What the panel keeps between two screens: one thing at a time, in the memory of the largest.

use massline_shared::calibration::CalibrationRecord;
use massline_shared::calibration::tumble::TumbleTest;
use massline_shared::diagnosis::Diagnostics;

use super::calibration_wizard::{CalibrationWizard, Proposal, WizardProblem};
use super::menu::{Question, Screen};
use super::summary::Summary;

/// The one thing. The first is all zero bytes, so that the rig's memory is.
#[repr(u8)]
pub(super) enum ModalState {
    Nothing,
    /// The open result.
    Result(Summary),
    /// Why the layout was refused.
    Refusal(Diagnostics),
    /// The tumble test; true while a reading is being taken.
    Tumble(TumbleTest<f32>, bool),
    /// What went wrong with the last reading; the test goes on.
    Retry(TumbleTest<f32>, WizardProblem),
    /// A calibration that did not come about.
    Failed(WizardProblem),
    /// A calibration that waits to be kept.
    Proposal(CalibrationRecord, Proposal),
    /// It is kept.
    CalibrationStored,
}

impl ModalState {
    /// How far the calibration is.
    pub fn calibration_wizard(&self) -> CalibrationWizard {
        match self {
            Self::Tumble(readings, false) => {
                CalibrationWizard::Wanted(readings.readings().len() as u8)
            }
            Self::Tumble(readings, true) => {
                CalibrationWizard::Reading(readings.readings().len() as u8)
            }
            Self::Retry(_, problem) | Self::Failed(problem) => CalibrationWizard::Wrong(*problem),
            Self::Proposal(_, proposal) => CalibrationWizard::Proposed(*proposal),
            Self::CalibrationStored => CalibrationWizard::Stored,
            Self::Nothing | Self::Result(_) | Self::Refusal(_) => CalibrationWizard::Off,
        }
    }

    /// True when it is about what is on the screen: else nobody can see it any longer.
    pub fn belongs_to(&self, screen: Screen) -> bool {
        match self {
            Self::Nothing => true,
            Self::Result(_) => matches!(screen, Screen::Result | Screen::Sure(Question::Delete)),
            Self::Refusal(_) => screen == Screen::Findings,
            _ => screen == Screen::CalibrationWizard,
        }
    }

    /// The open result.
    pub fn summary(&self) -> Option<&Summary> {
        match self {
            Self::Result(summary) => Some(summary),
            _ => None,
        }
    }
}

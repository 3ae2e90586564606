//! State of the panel between two screens: one variant at a time, in one piece of memory.

use massline_shared::calibration::CalibrationRecord;
use massline_shared::calibration::tumble::TumbleTest;
use massline_shared::diagnosis::Diagnostics;

use super::calibration_wizard::{CalibrationWizard, Proposal, WizardProblem};
use super::menu::{Question, Screen};
use super::self_test::{SelfTestRun, SelfTestState};
use super::summary::Summary;

/// The state. The first variant is all zero bytes, so that the rig's memory lies in `.bss`.
#[repr(u8)]
pub(super) enum ModalState {
    Nothing,
    /// The open result.
    Result(Summary),
    /// Why the layout was refused.
    Refusal(Diagnostics),
    /// The tumble test; the flag is true while a reading is being taken.
    Tumble(TumbleTest<f32>, bool),
    /// The last reading failed and can be repeated; the test continues.
    Retry(TumbleTest<f32>, WizardProblem),
    /// A calibration that has failed.
    Failed(WizardProblem),
    /// A calibration that waits to be stored.
    Proposal(CalibrationRecord, Proposal),
    /// The calibration is stored.
    CalibrationStored,
    /// The self-test; the flag is true when a tumble test has made the sensors known.
    SelfTest(SelfTestRun, bool),
}

impl ModalState {
    /// State of the calibration.
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
            Self::Nothing | Self::Result(_) | Self::Refusal(_) | Self::SelfTest(..) => {
                CalibrationWizard::Off
            }
        }
    }

    /// True when the state belongs to this screen; otherwise it is no longer shown.
    pub fn belongs_to(&self, screen: Screen) -> bool {
        match self {
            Self::Nothing => true,
            Self::Result(_) => matches!(screen, Screen::Result | Screen::Sure(Question::Delete)),
            Self::Refusal(_) => screen == Screen::Findings,
            Self::SelfTest(..) => screen == Screen::SelfTest,
            _ => screen == Screen::CalibrationWizard,
        }
    }

    /// True while a reading is being taken for it.
    pub fn waits_for_reading(&self) -> bool {
        matches!(self, Self::Tumble(_, true) | Self::SelfTest(SelfTestRun::Reading, _))
    }

    /// State of the self-test.
    pub fn self_test(&self) -> SelfTestState {
        match self {
            Self::SelfTest(run, _) => run.state(),
            _ => SelfTestState::Off,
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

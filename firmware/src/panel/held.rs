//! What the panel keeps between two screens: one thing at a time, in the memory of the largest.

use massline_shared::calibration::CalibrationRecord;
use massline_shared::calibration::tumble::TumbleTest;
use massline_shared::diagnosis::Diagnostics;

use super::menu::{Question, Screen};
use super::summary::Summary;
use super::trial::{Problem, Proposal, Trial};

/// The one thing. The first is all zero bytes, so that the rig's memory is.
#[repr(u8)]
pub(super) enum Held {
    Nothing,
    /// The open result.
    Result(Summary),
    /// Why the layout was refused.
    Refusal(Diagnostics),
    /// The tumble test; true while a reading is being taken.
    Tumble(TumbleTest<f32>, bool),
    /// What went wrong with the last reading; the test goes on.
    Retry(TumbleTest<f32>, Problem),
    /// A calibration that did not come about.
    Failed(Problem),
    /// A calibration that waits to be kept.
    Proposal(CalibrationRecord, Proposal),
    /// It is kept.
    Kept,
}

impl Held {
    /// How far the calibration is.
    pub fn trial(&self) -> Trial {
        match self {
            Self::Tumble(readings, false) => Trial::Wanted(readings.readings().len() as u8),
            Self::Tumble(readings, true) => Trial::Reading(readings.readings().len() as u8),
            Self::Retry(_, problem) | Self::Failed(problem) => Trial::Wrong(*problem),
            Self::Proposal(_, proposal) => Trial::Proposed(*proposal),
            Self::Kept => Trial::Kept,
            Self::Nothing | Self::Result(_) | Self::Refusal(_) => Trial::Off,
        }
    }

    /// True when it is about what is on the glass: else nobody can see it any longer.
    pub fn belongs_to(&self, screen: Screen) -> bool {
        match self {
            Self::Nothing => true,
            Self::Result(_) => matches!(screen, Screen::Result | Screen::Sure(Question::Delete)),
            Self::Refusal(_) => screen == Screen::Findings,
            _ => screen == Screen::Trial,
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

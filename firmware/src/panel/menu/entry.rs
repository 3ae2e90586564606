//! The lines of the lists.

use heapless::Vec;
use massline_shared::measurement::campaign::Phase;

use super::is_complete;
use crate::panel::PanelModel;

/// Lines of a list.
pub type Entries = Vec<Entry, 8>;

/// One line of a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entry {
    /// Opens the campaign's screen.
    Measure,
    /// Opens the list of results.
    Results,
    /// Opens the list of layouts.
    Layouts,
    /// Opens the list of calibrations.
    Calibration,
    /// Begins a self-test.
    SelfTest,
    /// Opens the screen about the flash.
    Storage,
    /// Opens the pages about the rig.
    About,
    /// Resume a paused campaign.
    Resume,
    /// Take back the last accepted hit.
    Undo,
    /// Measure the current DOF again.
    Redo,
    /// Skip the current DOF.
    Skip,
    /// Finish the current DOF with the hits that it has.
    Finish,
    /// Show how precise the answer would be so far.
    Precision,
    /// Show the campaign's diagnostics.
    Findings,
    /// End the campaign without a result.
    End,
    /// Accept the hit that waits for confirmation.
    Accept,
    /// Reject the hit that waits for confirmation.
    Reject,
    /// Calibrate the sensors by gravity.
    Tumble,
    /// Calibrate by a block of known mass.
    Block,
    /// Measure mass lines.
    MassLines,
    /// Measure the suspension modes.
    Modes,
}

impl Entry {
    /// Its text in the list.
    pub fn label(self, model: &PanelModel) -> &'static str {
        match self {
            Self::Measure if model.phase == Phase::Paused => "Measure (paused)",
            Self::Measure if runs(model) => "Measure (running)",
            Self::Measure => "Measure",
            Self::Results => "Results",
            Self::Layouts => "Layouts",
            Self::Calibration => "Calibrate",
            Self::SelfTest => "Self-test",
            Self::Storage => "Storage",
            Self::About => "About",
            Self::Resume if model.interrupted => "Try again",
            Self::Resume if is_complete(model) => "Compute again",
            Self::Resume => "Go on",
            Self::Undo => "Undo last hit",
            Self::Redo => "This place again",
            Self::Skip => "Skip this place",
            Self::Finish => "Enough hits here",
            Self::Precision => "How precise so far",
            Self::Findings => "What is wrong",
            Self::End => "End, no result",
            Self::Accept => "Keep this hit",
            Self::Reject => "Reject this hit",
            Self::Tumble => "Sensors by gravity",
            Self::Block => "Block of known mass",
            Self::MassLines => "Mass lines, short",
            Self::Modes => "Modes, 40 s records",
        }
    }
}

fn runs(model: &PanelModel) -> bool {
    !matches!(model.phase, Phase::Idle | Phase::Done)
}

//! How far a campaign has come.

use heapless::Vec;

use super::command::Start;
use crate::layout::RIG_HITS;

/// How a DOF stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Outcome {
    /// Not finished.
    Open,
    /// Has all the hits that were wanted.
    Complete,
    /// The operator went on with fewer hits.
    Early,
    /// Left out by the operator.
    Skipped,
}

/// One DOF of the campaign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DofProgress {
    /// Hits averaged.
    pub accepted: u8,
    /// How it stands.
    pub outcome: Outcome,
}

impl DofProgress {
    /// Nothing measured.
    pub const OPEN: Self = Self { accepted: 0, outcome: Outcome::Open };

    /// True when it is not measured any more.
    pub fn is_finished(&self) -> bool {
        self.outcome != Outcome::Open
    }
}

/// What outlives a cut of the power: the finished DOFs. Hits of the DOF in hand do not.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CampaignProgress {
    /// How it was started.
    pub start: Start,
    /// All DOFs, in the order of the layout; without hits unless finished.
    pub dofs: Vec<DofProgress, RIG_HITS>,
    /// Accepted hits wanted at each DOF.
    pub wanted: u8,
    /// Hits rejected.
    pub rejected: u16,
}

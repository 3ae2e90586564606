//! Progress of a campaign.

use heapless::Vec;

use super::command::Start;
use crate::layout::RIG_HITS;

/// State of a DOF.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Outcome {
    /// Not finished.
    Open,
    /// The DOF has all the hits that were wanted.
    Complete,
    /// The operator continued with fewer hits.
    Early,
    /// The operator left out the DOF.
    Skipped,
    /// The DOF was left out because the target had been reached.
    NotNeeded,
}

/// Progress of one DOF.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DofProgress {
    /// Number of hits averaged.
    pub accepted: u8,
    /// State of the DOF.
    pub outcome: Outcome,
}

impl DofProgress {
    /// A DOF without measured hits.
    pub const OPEN: Self = Self { accepted: 0, outcome: Outcome::Open };

    /// True when the DOF needs no more hits.
    pub fn is_finished(&self) -> bool {
        self.outcome != Outcome::Open
    }
}

/// Checkpoint of a campaign that survives a power failure: the finished DOFs. Hits of the current DOF are not
/// included.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CampaignProgress {
    /// Options with which the campaign was started.
    pub start: Start,
    /// All DOFs, in the order of the layout; without hits unless finished.
    pub dofs: Vec<DofProgress, RIG_HITS>,
    /// Accepted hits wanted at each DOF.
    pub wanted: u8,
    /// Number of hits rejected.
    pub rejected: u16,
}

//! The log of all hits of a campaign, good and bad.

use serde::{Deserialize, Serialize};

use crate::finding::Finding;

/// A hit that the rig has graded, and what became of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LoggedHit {
    /// The DOF, `node:±axis`.
    pub dof: String,
    /// Number of the hit on the rig, counted from 1 since power-on.
    pub hit: u32,
    /// What became of it.
    pub verdict: HitVerdict,
    /// What was found: the reasons of a hit that is not in the answer, and remarks about one that is.
    pub findings: Vec<Finding>,
    /// Largest force; `null` where it is not known.
    pub peak_force_n: Option<f32>,
    /// Largest acceleration of any channel; `null` where it is not known.
    pub peak_acceleration_m_per_s2: Option<f32>,
    /// Impulse of the force, in the suspension profile.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub impulse_n_s: Option<f32>,
    /// How much the object moved before the hit, relative to the largest peak, in the suspension profile; 0 where no
    /// response moved by more than its noise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rest: Option<f32>,
    /// How much of the response is left at the end of the record, relative to the largest peak, in the suspension
    /// profile.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub remainder: Option<f32>,
    /// When it was graded, by the clock of the computer, RFC 3339 in UTC; `null` for a simulated hit.
    pub graded: Option<String>,
}

/// What became of a hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum HitVerdict {
    /// It is in the answer.
    Accepted,
    /// Its record was bad, or the operator has rejected it: then nothing was found.
    Rejected,
    /// It differed from its repeat hits.
    OutlierRemoved,
    /// Its DOF was begun again.
    Redone,
    /// The operator has taken it back.
    Undone,
    /// Its DOF was skipped.
    Skipped,
    /// The campaign was paused, or its DOF finished, before the hit was averaged.
    Dropped,
    /// The campaign went on while the program did not follow it, and its DOF has other hits now.
    Unknown,
}

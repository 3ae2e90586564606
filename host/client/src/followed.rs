//! Whether a campaign has gone on while the program did not follow it.
//!
//! Between two commands that follow one campaign, another one or the rig's panel may undo a hit and take a new one. The
//! numbers of hits are the same then, but what was read before belongs to another hit.

use massline_protocol::crc32;
use massline_protocol::message::Status;
use massline_protocol::object::DofResult;
use massline_shared::layout::HOST_HITS;
use massline_shared::measurement::campaign::Phase;
use serde::{Deserialize, Serialize};

use crate::campaign::open_dof;
use crate::error::ClientError;
use crate::exchange::Client;
use massline_files::limited::at_most;

/// How far a campaign was followed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FollowedCampaign {
    #[serde(deserialize_with = "at_most::<HOST_HITS, _, _>")]
    finished: Vec<FinishedDof>,
    open: Option<OpenDof>,
}

/// A DOF that is finished.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct FinishedDof {
    dof: u8,
    /// Checksum of its mass lines.
    mass_lines: u32,
}

/// The DOF that waits for a hit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct OpenDof {
    dof: u8,
    /// Number of the last hit that was graded.
    last_hit: u32,
    /// Hits of all DOFs that were accepted or rejected.
    settled: u32,
}

impl FollowedCampaign {
    /// Notes how far the campaign is according to this status.
    pub fn status(&mut self, status: &Status) {
        let phase = Phase::try_from(status.phase).ok();
        if let Some(dof) = open_dof(status) {
            // It is open again.
            self.finished.retain(|known| known.dof != dof);
        }
        let paused = (phase == Some(Phase::Paused)).then_some(status.dof);
        if let Some(dof) = open_dof(status).or(paused) {
            self.open = Some(OpenDof { dof, last_hit: status.last_hit, settled: settled(status) });
        }
    }

    /// Notes the mass lines of a DOF that is finished.
    pub fn finished(&mut self, result: &DofResult) {
        self.finished.retain(|known| known.dof != result.index);
        self.finished.push(FinishedDof { dof: result.index, mass_lines: checksum(result) });
    }

    /// The DOFs whose hits are others on the rig now. One without hits is left out: what is read of its next ones takes
    /// the place of what was read before.
    ///
    /// # Errors
    /// When the link is lost or the rig sends invalid data.
    pub fn changed(&self, client: &mut Client) -> Result<Vec<u8>, ClientError> {
        let status = client.status()?;
        let mut changed = Vec::new();
        for known in &self.finished {
            let now = client.mass_lines(known.dof)?;
            if now.is_none_or(|now| checksum(&now) != known.mass_lines) {
                changed.push(known.dof);
            }
        }
        let open = self.open.filter(|known| known.is_changed(&status));
        let is_finished = |dof: u8| self.finished.iter().any(|known| known.dof == dof);
        changed.extend(open.map(|known| known.dof).filter(|&dof| !is_finished(dof)));
        let has_hits =
            |dof: &u8| status.accepted.get(usize::from(*dof)).is_some_and(|&hits| hits > 0);
        changed.retain(has_hits);
        Ok(changed)
    }
}

impl OpenDof {
    /// Whether accepted hits were taken back or discarded meanwhile, as the counters of hits show: without that, every
    /// hit that was graded meanwhile was accepted or rejected, or is in hand. One that was in hand before may have been
    /// accepted or rejected too.
    fn is_changed(&self, status: &Status) -> bool {
        let graded = i64::from(status.last_hit) - i64::from(self.last_hit);
        let settled = i64::from(settled(status)) - i64::from(self.settled);
        let phase = Phase::try_from(status.phase).ok();
        let in_hand = i64::from(matches!(phase, Some(Phase::Confirming | Phase::Busy)));
        graded - settled > in_hand
    }
}

/// Hits of all DOFs that were accepted or rejected.
fn settled(status: &Status) -> u32 {
    let accepted: u32 = status.accepted.iter().map(|&hits| u32::from(hits)).sum();
    accepted + u32::from(status.rejected)
}

fn checksum(result: &DofResult) -> u32 {
    // Nothing in it cannot be encoded.
    crc32(&postcard::to_allocvec(result).unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use massline_shared::diagnosis::Diagnostics;

    use super::*;

    fn status(phase: Phase, last_hit: u32, accepted: u8, rejected: u16) -> Status {
        Status {
            phase: phase.into(),
            dof: 0,
            armings: 1,
            accepted: [accepted].into_iter().collect(),
            hits_per_dof: 5,
            rejected,
            last_hit,
            layout_hash: 1,
            result: 0,
            started_unix_s: 1,
            diagnostics: Diagnostics::new(),
        }
    }

    #[test]
    fn a_hit_in_hand_that_is_accepted_during_a_pause_replaces_none() {
        // Hit 3 is being averaged, and hit 4 was rejected.
        let before = OpenDof { dof: 0, last_hit: 3, settled: 2 };
        for (phase, last_hit, accepted, rejected, changed) in [
            (Phase::Armed, 3, 3, 0, false),
            (Phase::Armed, 4, 3, 1, false),
            (Phase::Confirming, 4, 3, 0, false),
            (Phase::Armed, 5, 2, 0, true),
            (Phase::Confirming, 5, 2, 0, true),
        ] {
            let now = status(phase, last_hit, accepted, rejected);
            assert_eq!(before.is_changed(&now), changed, "{now:?}");
        }
        // Hit 3 is taken back, and hit 4 accepted.
        let before = OpenDof { dof: 0, last_hit: 3, settled: 3 };
        assert!(before.is_changed(&status(Phase::Armed, 4, 3, 0)));
        assert!(!before.is_changed(&status(Phase::Armed, 4, 4, 0)));
    }
}

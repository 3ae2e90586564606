//! The finished DOFs of the campaign that is under way, kept so that it goes on after a cut of the power.
//!
//! Flash is written between two hits, while the sampler is stopped. What could not be kept is tried
//! again when the next DOF is finished; measuring goes on meanwhile.

use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::mutex::Mutex;
use embedded_storage_async::nor_flash::NorFlash;
use heapless::Vec;
use massline_protocol::object::DofResult;
use massline_shared::diagnosis::Diagnostics;
use massline_shared::layout::RIG_HITS;
use massline_shared::measurement::campaign::{CampaignProgress, DofProgress};
use serde::{Deserialize, Serialize};

use crate::outcome::checksum_of;
use crate::rig::Rig;
use crate::store::{MAX_DOF, Store};

/// What finished DOFs and the progress of a campaign are encoded in for the flash.
pub(crate) type Room = [u8; MAX_DOF];

/// How far a campaign has come, as it is kept.
#[derive(Debug, Serialize, Deserialize)]
struct ProgressCheckpoint {
    /// Hash of its layout.
    layout: u32,
    /// Checksum of its calibration.
    calibration: u32,
    /// Bit by bit the DOFs that have mass lines.
    measured: u16,
    campaign: CampaignProgress,
    #[serde(with = "massline_protocol::diagnostic")]
    diagnostics: Diagnostics,
}

/// What the store has of the campaign that is under way.
#[derive(Debug, Default)]
pub(crate) struct Checkpoint {
    /// The campaign, as counted by the measurement; 0 when nothing is kept.
    campaign: u32,
    dofs: Vec<DofProgress, RIG_HITS>,
    /// Bit by bit the DOFs whose mass lines are kept.
    measured: u16,
}

impl Checkpoint {
    /// Keeps what has been finished since the last call, and forgets a campaign that has ended. To be
    /// called only while the sampler is stopped: a page of flash may be erased.
    pub async fn update<F: NorFlash>(
        &mut self,
        rig: &Rig<'_>,
        store: &Mutex<NoopRawMutex, Store<F>>,
        room: &mut Room,
    ) {
        let (campaign, progress) = {
            let measurement = rig.measurement.borrow();
            (measurement.campaigns(), measurement.progress())
        };
        if self.campaign != 0 && (self.campaign != campaign || progress.is_none()) {
            // A campaign that the flash does not let go of is offered again at the next start.
            let _ = store.lock().await.clear_progress().await;
            *self = Self::default();
        }
        if let Some(progress) = progress
            && progress.dofs.iter().any(DofProgress::is_finished)
            && progress.dofs != self.dofs
        {
            self.campaign = campaign;
            self.dofs.clone_from(&progress.dofs);
            let mut store = store.lock().await;
            self.keep_dofs(rig, &mut store, room).await;
            let length = encode(rig, progress, room);
            // Tried again, with all that is new, after the next DOF.
            let _ = store.put_progress(room.get(..length).unwrap_or_default()).await;
        }
    }

    /// Keeps the mass lines of the DOFs that have been closed.
    async fn keep_dofs<F: NorFlash>(
        &mut self,
        rig: &Rig<'_>,
        store: &mut Store<F>,
        room: &mut Room,
    ) {
        for place in 0..RIG_HITS {
            let Some((index, length)) = encode_dof(rig, place, room) else { return };
            let bit = bit_of(index.into());
            let bytes = room.get(..length).unwrap_or_default();
            if self.measured & bit == 0 && store.put_dof(index, bytes).await.is_ok() {
                self.measured |= bit;
            }
        }
    }

    /// Takes up the campaign that a cut of the power has ended, when it belongs to the layout and the
    /// calibration in force: paused, as after an interruption.
    pub async fn recall<F: NorFlash>(rig: &Rig<'_>, store: &mut Store<F>, room: &mut Room) -> Self {
        let mut dofs = Vec::<DofResult, RIG_HITS>::new();
        for place in 0..RIG_HITS {
            let Some(bytes) = store.dof(place, room).await else { break };
            if let Ok(dof) = postcard::from_bytes(bytes) {
                // There is room for every DOF of a layout.
                let _ = dofs.push(dof);
            }
        }
        // What cannot be taken up is forgotten as soon as the rig measures.
        let nothing = Self { campaign: u32::from(store.has_progress()), ..Self::default() };
        let kept = store.progress(room).await;
        kept.and_then(|bytes| take_up(rig, &dofs, bytes)).unwrap_or(nothing)
    }
}

// Plain functions: what they hold is not held while the flash is written.

/// The progress of the campaign that is under way as bytes; gives their number.
fn encode(rig: &Rig<'_>, campaign: CampaignProgress, room: &mut Room) -> usize {
    let measurement = rig.measurement.borrow();
    let progress = ProgressCheckpoint {
        layout: rig.layout_hash.get(),
        calibration: checksum_of(measurement.calibration()),
        measured: measured(measurement.result().mass_lines.iter().map(|(index, _)| *index)),
        campaign,
        diagnostics: measurement.diagnostics().clone(),
    };
    postcard::to_slice(&progress, room).map_or(0, |bytes| bytes.len())
}

/// The DOF at a place of the result as bytes; gives its index in the layout and their number.
fn encode_dof(rig: &Rig<'_>, place: usize, room: &mut Room) -> Option<(u8, usize)> {
    let measurement = rig.measurement.borrow();
    let result = measurement.result();
    let stored = DofResult::of(result.dofs.get(place)?, result.mass_lines.get(place)?);
    Some((stored.index, postcard::to_slice(&stored, room).ok()?.len()))
}

/// Takes up the campaign whose DOFs and whose progress were kept.
fn take_up(rig: &Rig<'_>, dofs: &[DofResult], progress: &[u8]) -> Option<Checkpoint> {
    let kept = postcard::from_bytes::<ProgressCheckpoint>(progress).ok()?;
    let mut measurement = rig.measurement.borrow_mut();
    let same = kept.layout == rig.layout_hash.get()
        && kept.calibration == checksum_of(measurement.calibration());
    if !same {
        return None;
    }
    let had_lines = |index: usize| kept.measured & bit_of(index) != 0;
    let dofs = dofs.iter().filter_map(DofResult::measured);
    measurement.resume(kept.campaign, dofs, had_lines, kept.diagnostics).ok()?;
    Some(Checkpoint {
        campaign: measurement.campaigns(),
        dofs: measurement.progress()?.dofs,
        measured: measured(measurement.result().mass_lines.iter().map(|(index, _)| *index)),
    })
}

fn measured(indexes: impl Iterator<Item = usize>) -> u16 {
    indexes.fold(0, |all, index| all | bit_of(index))
}

fn bit_of(index: usize) -> u16 {
    u32::try_from(index).ok().and_then(|index| 1_u16.checked_shl(index)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::MAX_PROGRESS;
    use massline_shared::diagnosis::{Code, Diagnostic, Severity, Subject};
    use massline_shared::measurement::campaign::{Object, Outcome, Start};

    #[test]
    fn the_longest_progress_fits_the_store() {
        let dof = DofProgress { accepted: u8::MAX, outcome: Outcome::Skipped };
        let found = Diagnostic {
            code: Code::Unknown(u16::MAX),
            severity: Severity::Error,
            subject: Subject::Response { hit: u8::MAX, response: u8::MAX },
            value: 1.0,
        };
        let progress = ProgressCheckpoint {
            layout: u32::MAX,
            calibration: u32::MAX,
            measured: u16::MAX,
            campaign: CampaignProgress {
                start: Start { object: Object::Block { mass: 2.0 }, confirm: true },
                dofs: (0..RIG_HITS).map(|_| dof).collect(),
                wanted: u8::MAX,
                rejected: u16::MAX,
            },
            diagnostics: (0..16).map(|_| found).collect(),
        };
        let mut room = [0; MAX_PROGRESS];
        assert!(progress.diagnostics.is_full());
        postcard::to_slice(&progress, &mut room).expect("fits");
    }
}

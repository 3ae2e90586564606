//! The finished DOFs of the campaign that is under way, kept so that it goes on after a cut of the power.
//!
//! Flash is written between two hits, while the sampler is stopped. What could not be kept is tried
//! again when the next DOF is finished; measuring goes on meanwhile.

use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::mutex::Mutex;
use embedded_storage_async::nor_flash::NorFlash;
use heapless::Vec;
use massline_protocol::object::DofResult;
use massline_shared::campaign::{CampaignProgress, DofProgress, Outcome};
use massline_shared::diagnosis::Diagnostics;
use massline_shared::layout::RIG_HITS;
use serde::{Deserialize, Serialize};

use crate::analysis::{AnalysisMemory, checksum_of};
use crate::rig::Rig;
use crate::store::Store;

/// How far a campaign has come, as it is kept.
#[derive(Debug, Serialize, Deserialize)]
struct KeptProgress {
    /// Hash of its layout.
    layout: u32,
    /// Checksum of its calibration.
    calibration: u32,
    block: bool,
    /// Bit by bit the DOFs that have mass lines.
    measured: u16,
    campaign: CampaignProgress,
    #[serde(with = "massline_protocol::diagnostic")]
    diagnostics: Diagnostics,
}

/// What the store has of the campaign that is under way.
#[derive(Debug, Default)]
pub(crate) struct Kept {
    /// The campaign, as counted by the campaign; 0 when nothing is kept.
    start: u32,
    dofs: Vec<DofProgress, RIG_HITS>,
    /// Bit by bit the DOFs whose mass lines are kept.
    measured: u16,
}

impl Kept {
    /// Keeps what has been finished since the last call, and forgets a campaign that has ended. To be
    /// called only while the sampler is stopped: a page of flash may be erased.
    pub async fn update<F: NorFlash>(
        &mut self,
        rig: &Rig,
        store: &Mutex<NoopRawMutex, Store<F>>,
        memory: &mut AnalysisMemory,
    ) {
        let (start, progress) = {
            let campaign = rig.campaign.borrow();
            (campaign.starts(), campaign.progress())
        };
        if self.start != 0 && (self.start != start || progress.is_none()) {
            // A campaign that the flash does not let go of is offered again at the next start.
            let _ = store.lock().await.clear_progress().await;
            *self = Self::default();
        }
        let finished = |dof: &DofProgress| dof.outcome != Outcome::Open;
        if let Some(progress) = progress
            && progress.dofs.iter().any(finished)
            && progress.dofs != self.dofs
        {
            self.start = start;
            self.dofs.clone_from(&progress.dofs);
            let mut store = store.lock().await;
            self.keep_dofs(&mut store, memory).await;
            // Tried again, with all that is new, after the next DOF.
            let _ = store.put_progress(encode(rig, progress, memory)).await;
        }
    }

    /// Keeps the mass lines of the DOFs that have been closed.
    async fn keep_dofs<F: NorFlash>(&mut self, store: &mut Store<F>, memory: &mut AnalysisMemory) {
        for i in 0..RIG_HITS {
            let Some((index, bytes)) = memory.encode_dof(self.start, i) else { return };
            let bit = bit_of(index);
            if self.measured & bit == 0 && store.put_dof(index, bytes).await.is_ok() {
                self.measured |= bit;
            }
        }
    }

    /// Takes up the campaign that a cut of the power has ended, when it belongs to the layout and the
    /// calibration in force: paused, as after an interruption.
    pub async fn recall<F: NorFlash>(
        rig: &Rig,
        store: &mut Store<F>,
        memory: &mut AnalysisMemory,
    ) -> Self {
        for i in 0..RIG_HITS {
            let Some(length) = store.dof(i, memory.room()).await.map(<[u8]>::len) else { break };
            memory.take_dof(length);
        }
        let length = store.progress(memory.room()).await.map(<[u8]>::len);
        // What cannot be taken up is forgotten as soon as the rig measures.
        let nothing = Self { start: u32::from(store.has_progress()), ..Self::default() };
        length.and_then(|length| take_up(rig, memory, length)).unwrap_or(nothing)
    }
}

// Plain functions: what they hold is not held while the flash is written.

/// The progress of the campaign that is under way as bytes.
#[inline(never)]
fn encode<'m>(rig: &Rig, campaign: CampaignProgress, memory: &'m mut AnalysisMemory) -> &'m [u8] {
    let progress = KeptProgress {
        layout: rig.layout_hash.get(),
        calibration: checksum_of(&rig.calibration.borrow()),
        block: rig.block.get(),
        measured: measured(memory.dofs_of(rig.campaign.borrow().starts())),
        campaign,
        diagnostics: rig.diagnostics.borrow().clone(),
    };
    memory.encode(&progress)
}

/// Takes up the campaign whose DOFs are in the memory and whose progress is in its room.
#[inline(never)]
fn take_up(rig: &Rig, memory: &mut AnalysisMemory, length: usize) -> Option<Kept> {
    let mut progress = postcard::from_bytes::<KeptProgress>(memory.room().get(..length)?).ok()?;
    let same = progress.layout == rig.layout_hash.get()
        && progress.calibration == checksum_of(&rig.calibration.borrow())
        && progress.campaign.dofs.len() == rig.dofs();
    if !same {
        return None;
    }
    let mut running = rig.campaign.borrow_mut();
    // A DOF that was closed but not yet noted as finished is measured anew.
    let start = running.starts() + 1;
    let dofs = memory.take_up(start, |dof| progress.is_finished(dof.index));
    let measured = measured(dofs);
    progress.reopen(progress.measured & !measured);
    let KeptProgress { block, campaign, diagnostics, .. } = progress;
    let dofs = campaign.dofs.clone();
    running.restore(campaign).ok()?;
    rig.block.set(block);
    *rig.diagnostics.borrow_mut() = diagnostics;
    Some(Kept { start, dofs, measured })
}

fn measured(dofs: &[DofResult]) -> u16 {
    dofs.iter().fold(0, |all, dof| all | bit_of(dof.index))
}

impl KeptProgress {
    fn is_finished(&self, index: u8) -> bool {
        let dof = self.campaign.dofs.get(usize::from(index));
        dof.is_some_and(|dof| dof.outcome != Outcome::Open)
    }

    /// Asks again for the DOFs of these bits: their mass lines are lost.
    fn reopen(&mut self, lost: u16) {
        for (index, dof) in (0..).zip(&mut self.campaign.dofs) {
            if lost & bit_of(index) != 0 {
                *dof = DofProgress::OPEN;
            }
        }
    }
}

fn bit_of(index: u8) -> u16 {
    1_u16.checked_shl(index.into()).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::MAX_PROGRESS;
    use massline_shared::diagnosis::{Code, Diagnostic, Severity, Subject};

    #[test]
    fn the_longest_progress_fits_the_store() {
        let dof = DofProgress { accepted: u8::MAX, outcome: Outcome::Skipped };
        let said = Diagnostic {
            code: Code::Unknown(u16::MAX),
            severity: Severity::Error,
            subject: Subject::response(usize::MAX, usize::MAX),
            value: 1.0,
        };
        let progress = KeptProgress {
            layout: u32::MAX,
            calibration: u32::MAX,
            block: true,
            measured: u16::MAX,
            campaign: CampaignProgress {
                dofs: (0..RIG_HITS).map(|_| dof).collect(),
                wanted: u8::MAX,
                confirm: true,
                rejected: u16::MAX,
            },
            diagnostics: (0..16).map(|_| said).collect(),
        };
        let mut room = [0; MAX_PROGRESS];
        assert!(progress.diagnostics.is_full());
        postcard::to_slice(&progress, &mut room).expect("fits");
    }
}

//! The finished DOFs of the current campaign, stored so that it can be resumed after a power cut.
//!
//! Flash is written between two hits, while the sampler is stopped. A write that failed is tried again after the next
//! hit; measuring continues meanwhile.

use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::mutex::Mutex;
use embedded_storage_async::nor_flash::NorFlash;
use heapless::Vec;
use massline_protocol::calibration_checksum;
use massline_protocol::lines::head_of_dof;
use massline_protocol::lines_head::LinesHead;
use massline_protocol::object::DofResult;
use massline_shared::diagnosis::Diagnostics;
use massline_shared::layout::{RIG_HITS, TestProfile};
use massline_shared::measurement::campaign::{CampaignProgress, DofProgress};
use massline_shared::measurement::{DofData, RestoredDof};
use massline_shared::signal::CompactLines;
use serde::{Deserialize, Serialize};

use crate::rig::Rig;
use crate::store::{DofWithLines, MAX_DOF, MAX_PROGRESS, Store};

/// Buffer in which a finished DOF or the progress of a campaign is encoded for the flash.
pub(crate) type CheckpointBuffer = [u8; MAX_DOF];
const _: () = assert!(MAX_PROGRESS <= MAX_DOF);

/// The progress of a campaign as it is stored.
#[derive(Debug, Serialize, Deserialize)]
struct ProgressCheckpoint {
    /// Hash of the campaign's layout.
    layout: u32,
    /// Checksum of the campaign's calibration.
    calibration: u32,
    /// Bit mask of the DOFs that have mass lines.
    measured: u16,
    campaign: CampaignProgress,
    #[serde(with = "massline_protocol::diagnostic")]
    diagnostics: Diagnostics,
}

/// What the store holds of the current campaign.
#[derive(Debug, Default)]
pub(crate) struct Checkpoint {
    /// The campaign's number, as counted by the measurement; 0 when nothing is stored.
    campaign: u32,
    dofs: Vec<DofProgress, RIG_HITS>,
    /// Bit mask of the DOFs whose mass lines are stored.
    measured: u16,
    /// The number of armings when a write failed.
    failed_at: Option<u32>,
}

impl Checkpoint {
    /// Stores what has been finished since the last call, and deletes the progress of a campaign that has
    /// ended. To be called only while the sampler is stopped, because a page of flash may be erased.
    pub async fn update<F: NorFlash>(
        &mut self,
        rig: &Rig<'_>,
        store: &Mutex<NoopRawMutex, Store<F>>,
        room: &mut CheckpointBuffer,
    ) {
        let (campaign, progress) = {
            let measurement = rig.measurement.borrow();
            (measurement.campaigns(), measurement.progress())
        };
        if self.campaign != 0 && (self.campaign != campaign || progress.is_none()) {
            // If this fails, the campaign is offered again after the next start.
            let _ = store.lock().await.clear_progress().await;
            *self = Self::default();
        }
        // An undo may leave no DOF finished: what is stored must not bring its hit back.
        if let Some(progress) = progress
            && (self.campaign != 0 || progress.dofs.iter().any(DofProgress::is_finished))
            && (progress.dofs != self.dofs || self.failed_at.is_some_and(|at| at != armings(rig)))
        {
            self.campaign = campaign;
            self.dofs.clone_from(&progress.dofs);
            // The stored data of a DOF that is open again do not count.
            let reopened = self.measured & !measured(rig);
            self.measured &= !reopened;
            let mut store = store.lock().await;
            self.failed_at = None;
            self.store_dofs(rig, &mut store, room).await;
            let length = encode(rig, progress, room);
            if store.put_progress(room.get(..length).unwrap_or_default()).await.is_err() {
                self.failed_at = Some(armings(rig));
            }
            for index in (0..RIG_HITS as u8).filter(|index| reopened & bit_of((*index).into()) != 0)
            {
                // If this fails, the new lines replace the old ones all the same.
                let _ = store.reopen_dof(index).await;
            }
        }
    }

    /// Stores the lines of the DOF that has been closed, and reports it to the measurement.
    pub async fn store_lines<F: NorFlash>(
        &mut self,
        rig: &Rig<'_>,
        store: &Mutex<NoopRawMutex, Store<F>>,
        room: &mut CheckpointBuffer,
        dof: usize,
    ) {
        let stored = match encode_lines_head(rig, dof, room) {
            Some((index, length)) => {
                let head = room.get(..length).unwrap_or_default();
                put_lines(rig, &mut *store.lock().await, index, head).await
            }
            None => false,
        };
        let mut measurement = rig.measurement.borrow_mut();
        if stored {
            self.measured |= bit_of(dof);
            measurement.lines_stored();
        } else {
            measurement.lines_not_stored();
        }
    }

    /// Stores the mass lines of the DOFs that have been closed.
    async fn store_dofs<F: NorFlash>(
        &mut self,
        rig: &Rig<'_>,
        store: &mut Store<F>,
        room: &mut CheckpointBuffer,
    ) {
        for place in 0..RIG_HITS {
            let Some((index, length)) = encode_dof(rig, place, room) else { return };
            let bit = bit_of(index.into());
            if self.measured & bit != 0 {
                continue;
            }
            if store.put_dof(index, room.get(..length).unwrap_or_default()).await.is_ok() {
                self.measured |= bit;
            } else {
                self.failed_at = Some(armings(rig));
            }
        }
    }

    /// Restores the campaign that a power cut has interrupted, if it belongs to the layout and the
    /// calibration in force. The campaign is paused, as after any interruption.
    pub async fn recall<F: NorFlash>(
        rig: &Rig<'_>,
        store: &mut Store<F>,
        room: &mut CheckpointBuffer,
    ) -> Self {
        let mut dofs = Vec::<StoredDof, RIG_HITS>::new();
        for place in 0..RIG_HITS {
            let Some(bytes) = store.dof(place, room).await else { break };
            // There is room for every DOF of a layout.
            dofs.extend(StoredDof::of(rig, bytes));
        }
        // A campaign that cannot be restored is deleted as soon as the rig measures.
        let nothing = Self { campaign: u32::from(store.has_progress()), ..Self::default() };
        let stored = store.progress(room).await;
        stored.and_then(|bytes| take_up(rig, &dofs, bytes)).unwrap_or(nothing)
    }
}

/// What is stored of a finished DOF, under the profile of the layout in force.
#[expect(clippy::large_enum_variant, reason = "a list of either kind, without an allocator")]
enum StoredDof {
    MassLines(DofResult),
    Lines(LinesHead),
}

impl StoredDof {
    /// Decodes the beginning of a stored DOF.
    fn of(rig: &Rig<'_>, bytes: &[u8]) -> Option<Self> {
        match rig.measurement.borrow().profile() {
            TestProfile::MassLine => DofResult::take(bytes).map(|(dof, _)| Self::MassLines(dof)),
            TestProfile::Suspension => head_of_dof(bytes).map(Self::Lines),
        }
    }

    fn measured(&self) -> Option<RestoredDof<f32>> {
        match self {
            Self::MassLines(dof) => {
                let (details, lines) = dof.measured()?;
                Some((details, DofData::MassLines(lines)))
            }
            Self::Lines(head) => Some(head.measured()),
        }
    }
}

/// Stores a DOF with its lines, which are encoded while they are written; false when that fails.
async fn put_lines<F: NorFlash>(
    rig: &Rig<'_>,
    store: &mut Store<F>,
    index: u8,
    head: &[u8],
) -> bool {
    let responses = rig.measurement.borrow().adc_in_use().responses();
    let line = |response: usize, line: usize| rig.measurement.borrow().line(response, line);
    match CompactLines::new(responses, line) {
        Ok(lines) => store.put_dof(index, &DofWithLines { head, lines: &lines }).await.is_ok(),
        Err(_) => false,
    }
}

// Plain functions: their locals take no memory in the futures that wait for the flash.

/// Encodes the progress of the current campaign; returns the number of bytes.
fn encode(rig: &Rig<'_>, campaign: CampaignProgress, room: &mut CheckpointBuffer) -> usize {
    let measurement = rig.measurement.borrow();
    let progress = ProgressCheckpoint {
        layout: rig.layout_hash.get(),
        calibration: calibration_checksum(measurement.calibration()),
        measured: measured(rig),
        campaign,
        diagnostics: measurement.diagnostics().clone(),
    };
    postcard::to_slice(&progress, room).map_or(0, |bytes| bytes.len())
}

/// Encodes the DOF at a place of the result; returns its index in the layout and the number of bytes.
fn encode_dof(rig: &Rig<'_>, place: usize, room: &mut CheckpointBuffer) -> Option<(u8, usize)> {
    let measurement = rig.measurement.borrow();
    let result = measurement.result();
    let stored = DofResult::of(result.dofs.get(place)?, result.mass_lines.get(place)?);
    Some((stored.index, postcard::to_slice(&stored, room).ok()?.len()))
}

/// Encodes what is said of a DOF besides its lines; returns its index in the layout and the number of bytes.
fn encode_lines_head(
    rig: &Rig<'_>,
    dof: usize,
    room: &mut CheckpointBuffer,
) -> Option<(u8, usize)> {
    let measurement = rig.measurement.borrow();
    let result = measurement.result();
    let place = result.lines.iter().position(|lines| usize::from(lines.dof) == dof)?;
    let head = LinesHead::of(result.dofs.get(place)?, result.lines.get(place)?);
    Some((head.index, postcard::to_slice(&head, room).ok()?.len()))
}

/// Restores the campaign from its stored DOFs and progress.
fn take_up(rig: &Rig<'_>, dofs: &[StoredDof], progress: &[u8]) -> Option<Checkpoint> {
    let stored = postcard::from_bytes::<ProgressCheckpoint>(progress).ok()?;
    let mut measurement = rig.measurement.borrow_mut();
    let same = stored.layout == rig.layout_hash.get()
        && stored.calibration == calibration_checksum(measurement.calibration());
    if !same {
        return None;
    }
    let had_lines = |index: usize| stored.measured & bit_of(index) != 0;
    let dofs = dofs.iter().filter_map(StoredDof::measured);
    measurement.resume(stored.campaign, dofs, had_lines, stored.diagnostics).ok()?;
    let (campaign, dofs) = (measurement.campaigns(), measurement.progress()?.dofs);
    drop(measurement);
    Some(Checkpoint { campaign, dofs, measured: measured(rig), failed_at: None })
}

/// How often the rig has waited for a hit.
fn armings(rig: &Rig<'_>) -> u32 {
    rig.measurement.borrow().armings()
}

/// Bit mask of the DOFs that have mass lines or stored lines.
fn measured(rig: &Rig<'_>) -> u16 {
    let measurement = rig.measurement.borrow();
    let dofs = (0..RIG_HITS).filter(|index| measurement.has_data(*index));
    dofs.fold(0, |mask, index| mask | bit_of(index))
}

fn bit_of(index: usize) -> u16 {
    u32::try_from(index).ok().and_then(|index| 1_u16.checked_shl(index)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::MAX_LINES_HEAD;
    use massline_shared::diagnosis::{Code, Diagnostic, Severity, Subject};
    use massline_shared::measurement::campaign::{Object, Outcome, Start};

    #[test]
    fn the_longest_head_of_lines_fits_the_store() {
        let head = LinesHead {
            dof: "65535:-Z".parse().expect("a DOF"),
            index: u8::MAX,
            hits: u16::MAX,
            band_hz: [1.0; 2],
            coherence: Some([1.0; 9]),
            mean_squared: 1.0,
            scatter_squared: 1.0,
        };
        postcard::to_slice(&head, &mut [0; MAX_LINES_HEAD]).expect("fits");
    }

    #[test]
    fn the_longest_progress_fits_the_store() {
        let dof = DofProgress { accepted: u8::MAX, outcome: Outcome::Skipped };
        let diagnostic = Diagnostic {
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
                start: Start {
                    object: Object::Block { mass: 2.0 },
                    confirm: true,
                    calibration_age_days: u16::MAX,
                    started_unix_s: u32::MAX,
                },
                dofs: (0..RIG_HITS).map(|_| dof).collect(),
                wanted: u8::MAX,
                rejected: u16::MAX,
            },
            diagnostics: (0..16).map(|_| diagnostic).collect(),
        };
        let mut room = [0; MAX_PROGRESS];
        assert!(progress.diagnostics.is_full());
        postcard::to_slice(&progress, &mut room).expect("fits");
    }
}

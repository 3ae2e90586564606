//! Takes the last accepted hit out of the averages again, as if it had never been made.
//!
//! The record of a hit stays in memory until the next one triggers: while the rig waits, only the first scans of the
//! record are overwritten, and their codes are kept in the scratch memory. Before anything is computed, as when the
//! operator finishes the DOF early, the record is completed.
//!
//! ```text
//!             accepted            sampling starts              trigger
//!  Nothing ────────────▶ Whole ────────────────────▶ Split ───────────────▶ Overwritten
//!     ▲                    │                           │                        │
//!     └────────────────────┴── undone, redo, skip ─────┴────────────────────────┘
//! ```
//! The hit is computed again as it was when it was added, from the search for hum on, and subtracted, so the sums
//! differ by rounding only: those of the spectra by at most `ε` times the sum of absolute values with the hit,
//! `ε = 2⁻²³` in single precision. The precision is restored from a copy. Diagnostics that came with the hit are
//! dropped; one that was there before keeps its largest value.

use super::averaged_hit::AveragedHit;
use super::campaign::{Campaign, CommandError, Step};
use super::{CampaignPrecision, Measurement, RecordContent};
use crate::diagnosis::{Code, Diagnostic, Severity, Subject};
use crate::signal::{RealFft, Record};

/// The last accepted hit of the campaign, and the state before it.
#[derive(Debug)]
pub(super) struct LastAcceptedHit<R> {
    hit: UndoState,
    /// The precision before the hit that was analysed last.
    precision: Option<CampaignPrecision<R>>,
    /// The number of diagnostics before it.
    diagnostics: u8,
    /// The number of diagnostics before the first hit of its DOF.
    diagnostics_before_dof: u8,
}

/// Whether the last accepted hit can be undone.
#[derive(Clone, Copy, Debug)]
enum UndoState {
    /// There is no such hit.
    Nothing,
    /// A later hit has overwritten its record.
    Overwritten,
    /// The record contains the hit at this DOF.
    Whole(u8),
    /// The start of its record is in the scratch memory.
    Split(u8),
}

impl<R: RealFft> LastAcceptedHit<R> {
    /// No accepted hit.
    pub fn new() -> Self {
        Self { hit: UndoState::Nothing, precision: None, diagnostics: 0, diagnostics_before_dof: 0 }
    }

    /// Whether the hit can be undone.
    pub fn check(&self) -> Result<(), CommandError> {
        match self.hit {
            UndoState::Nothing => Err(CommandError::NothingToUndo),
            UndoState::Overwritten => Err(CommandError::HitOverwritten),
            UndoState::Whole(_) | UndoState::Split(_) => Ok(()),
        }
    }

    /// The DOF of the hit that can be undone.
    pub fn dof(&self) -> Option<usize> {
        match self.hit {
            UndoState::Whole(dof) | UndoState::Split(dof) => Some(dof.into()),
            UndoState::Nothing | UndoState::Overwritten => None,
        }
    }

    /// The hit in the record, at this DOF, is accepted.
    pub fn accept(&mut self, dof: usize) {
        self.hit = UndoState::Whole(dof as u8);
    }

    /// There is no hit to undo any more.
    pub fn forget(&mut self) {
        self.hit = UndoState::Nothing;
    }

    /// The rig starts to wait for the next hit; what the wait overwrites is in the scratch memory.
    fn wait_begins(&mut self) {
        if let UndoState::Whole(dof) = self.hit {
            self.hit = UndoState::Split(dof);
        }
    }

    /// The record is complete again.
    fn wait_ends(&mut self) {
        if let UndoState::Split(dof) = self.hit {
            self.hit = UndoState::Whole(dof);
        }
    }

    /// The next hit has triggered.
    pub fn overwritten(&mut self) {
        if self.check().is_ok() {
            self.hit = UndoState::Overwritten;
        }
    }
}

impl<R: RealFft> Measurement<'_, R> {
    /// Keeps what the hit that is about to be analysed may change, after `accepted` other hits of its DOF.
    pub(super) fn keep_before_hit(&mut self, accepted: u8) {
        let diagnostics = self.diagnostics.len() as u8;
        self.last_accepted.precision = self.precision;
        self.last_accepted.diagnostics = diagnostics;
        if accepted == 0 {
            self.last_accepted.diagnostics_before_dof = diagnostics;
        }
    }

    /// Drops what was found in the hits of the current DOF, which are discarded. Call it only after a hit of this DOF
    /// was accepted.
    pub(super) fn drop_diagnostics_of_dof(&mut self) {
        self.drop_diagnostics_after(self.last_accepted.diagnostics_before_dof);
    }

    fn drop_diagnostics_after(&mut self, before: u8) {
        let mut place = 0;
        self.diagnostics.retain(|diagnostic| {
            place += 1;
            // The rig may have been interrupted after the hit.
            place <= before || diagnostic.interrupts()
        });
    }

    /// Keeps the start of the hit in the record, which the wait for the next one overwrites.
    pub(super) fn save_record(&mut self) {
        self.recorded = match self.recorded {
            RecordContent::Hit(number) => {
                let memory = &mut *self.memory;
                memory.record.save_start(&mut memory.scratch[..Record::START_CODES]);
                RecordContent::HitBefore(number)
            }
            RecordContent::HitBefore(number) => RecordContent::HitBefore(number),
            RecordContent::Nothing | RecordContent::Reading | RecordContent::ReadingFailed => {
                RecordContent::Nothing
            }
        };
        self.last_accepted.wait_begins();
    }

    /// Completes the record of the hit before the present wait, because a computation needs the scratch memory.
    pub(super) fn restore_record(&mut self) {
        if let RecordContent::HitBefore(number) = self.recorded {
            let memory = &mut *self.memory;
            memory.record.restore_start(&memory.scratch[..Record::START_CODES]);
            self.recorded = RecordContent::Hit(number);
            self.last_accepted.wait_ends();
        }
    }

    /// Restores the state before the hit that is undone, after it has been removed from the spectra; if that was not
    /// possible, there is no `hit`, and its DOF starts again. No effect unless a hit is undone.
    pub(super) fn finish_undo(&mut self, campaign: &mut Campaign, hit: Option<&AveragedHit<R>>) {
        let Some(dof) = self.last_accepted.dof().filter(|_| campaign.step() == Step::Undo) else {
            return;
        };
        self.last_accepted.forget();
        let accepted = campaign.dofs().get(dof).map_or(0, |dof| dof.accepted);
        let left = if hit.is_some() { accepted.saturating_sub(1) } else { 0 };
        campaign.undone(dof, left);
        if left == 0 {
            self.averaged = None;
        }
        let memory = &mut *self.memory;
        if let (Some(AveragedHit::MassLine(hit)), Some(others)) = (hit, &mut memory.single_hits)
            && let Some(own) = hit.mass_lines(&self.calibration)
        {
            others.remove(&own, |others| hit.squared_force(&memory.record, &own, others));
        }
        memory.discard_dof(dof);
        self.precision = self.last_accepted.precision;
        self.drop_diagnostics_after(self.last_accepted.diagnostics);
        let undone = Diagnostic::about(Code::HitUndone, Severity::Error, Subject::hit(dof), 0.0);
        self.report_again(undone);
    }
}

#[cfg(test)]
mod tests;

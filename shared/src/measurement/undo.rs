//! Takes the last accepted hit out of the averages again, as if it had never been made.
//!
//! The record of a hit stays in memory until the next one triggers: while the rig waits, only the first scans of the
//! record are overwritten, and their codes are kept in the scratch memory, which nothing else uses meanwhile.
//!
//! ```text
//!             accepted            sampling starts              trigger
//!  Nothing ────────────▶ Whole ────────────────────▶ Split ───────────────▶ Overwritten
//!     ▲                    │                           │                        │
//!     └────────────────────┴── undone, redo, skip ─────┴────────────────────────┘
//! ```
//! The hit is computed again as it was when it was added, from the search for hum on, and its spectra are subtracted, so
//! the sums differ by rounding only: each by at most `ε` times the sum of absolute values with the hit, `ε = 2⁻²³` in
//! single precision. So is the scatter of the repeat hits; the rest is restored from a copy made before the hit.

use super::campaign::{Campaign, CommandError, Step};
use super::{CampaignPrecision, Measurement, Memory, note};
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity, Subject};
use crate::identify::{ScatterAccumulator, ScatterMark};
use crate::layout::RIG_SENSORS;
use crate::signal::{RealFft, Record};

/// The last accepted hit of the campaign, and the state before it.
#[derive(Debug)]
pub(super) struct LastAccepted<R> {
    hit: Undoable,
    /// The state before the hit that was analysed last.
    before: BeforeHit<R>,
}

/// Whether the last accepted hit can be undone.
#[derive(Clone, Copy, Debug)]
enum Undoable {
    /// There is no such hit.
    Nothing,
    /// A later hit has overwritten its record.
    Overwritten,
    /// The record contains the hit at this DOF.
    Whole(u8),
    /// The start of its record is in the scratch memory.
    Split(u8),
}

/// What a hit changes besides the spectra.
#[derive(Debug)]
struct BeforeHit<R> {
    scatter: Option<ScatterMark<R, RIG_SENSORS>>,
    precision: Option<CampaignPrecision<R>>,
    diagnostics: Diagnostics,
}

impl<R: RealFft> LastAccepted<R> {
    /// No accepted hit.
    pub fn new() -> Self {
        let before = BeforeHit { scatter: None, precision: None, diagnostics: Diagnostics::new() };
        Self { hit: Undoable::Nothing, before }
    }

    /// Whether the hit can be undone.
    pub fn check(&self) -> Result<(), CommandError> {
        match self.hit {
            Undoable::Nothing => Err(CommandError::NothingToUndo),
            Undoable::Overwritten => Err(CommandError::HitOverwritten),
            Undoable::Whole(_) | Undoable::Split(_) => Ok(()),
        }
    }

    /// The DOF of the hit that can be undone.
    pub fn dof(&self) -> Option<usize> {
        match self.hit {
            Undoable::Whole(dof) | Undoable::Split(dof) => Some(dof.into()),
            Undoable::Nothing | Undoable::Overwritten => None,
        }
    }

    /// The hit in the record, at this DOF, is accepted.
    pub fn accept(&mut self, dof: usize) {
        self.hit = Undoable::Whole(dof as u8);
    }

    /// There is no hit to undo any more.
    pub fn forget(&mut self) {
        self.hit = Undoable::Nothing;
    }

    /// The rig starts to wait for the next hit: keeps what the wait overwrites.
    pub fn wait_begins(&mut self, memory: &mut Memory<R>) {
        if let Undoable::Whole(dof) = self.hit {
            memory.record.save_start(&mut memory.scratch[..Record::START_CODES]);
            self.hit = Undoable::Split(dof);
        }
    }

    /// The next hit has triggered.
    pub fn overwritten(&mut self) {
        if self.check().is_ok() {
            self.hit = Undoable::Overwritten;
        }
    }
}

impl<R: RealFft> Measurement<'_, R> {
    /// Keeps what the hit that is about to be analysed may change.
    pub(super) fn keep_before_hit(&mut self) {
        let before = &mut self.last_accepted.before;
        before.scatter = self.memory.single_hits.as_ref().map(ScatterAccumulator::mark);
        before.precision = self.precision;
        before.diagnostics.clone_from(&self.diagnostics);
    }

    /// Completes the record of the last accepted hit.
    pub(super) fn restore_record(&mut self) {
        if let Undoable::Split(dof) = self.last_accepted.hit {
            let memory = &mut *self.memory;
            memory.record.restore_start(&memory.scratch[..Record::START_CODES]);
            self.last_accepted.hit = Undoable::Whole(dof);
        }
    }

    /// Restores the state before the hit that is undone. If it is not `removed` completely, its DOF starts again. No effect
    /// unless a hit is undone.
    pub(super) fn finish_undo(&mut self, campaign: &mut Campaign, removed: bool) {
        let Some(dof) = self.last_accepted.dof().filter(|_| campaign.step() == Step::Undo) else {
            return;
        };
        self.last_accepted.forget();
        let before = &mut self.last_accepted.before;
        let accepted = campaign.dofs().get(dof).map_or(0, |dof| dof.accepted);
        let left = if removed { accepted.saturating_sub(1) } else { 0 };
        campaign.undone(dof, left);
        match (&mut self.memory.single_hits, &before.scatter) {
            (Some(single_hits), Some(mark)) if left > 0 => single_hits.remove_last(mark),
            (single_hits, _) => *single_hits = None,
        }
        if left == 0 {
            self.averaged = None;
        }
        self.memory.discard_dof(dof);
        self.precision = before.precision;
        core::mem::swap(&mut self.diagnostics, &mut before.diagnostics);
        // The rig may have been interrupted after the hit.
        let interruptions = before.diagnostics.iter().filter(|found| found.interrupts());
        interruptions.for_each(|found| note(&mut self.diagnostics, *found));
        let undone = Diagnostic::about(Code::HitUndone, Severity::Error, Subject::hit(dof), 0.0);
        self.withdraw(undone);
    }
}

#[cfg(test)]
mod tests;

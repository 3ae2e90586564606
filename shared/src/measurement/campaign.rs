//! Decides which DOF is hit next, from the results of the hits and the commands of the operator.
//!
//! A pure state machine. The rig asks [`Campaign::step`] what to do, does it, and reports the outcome;
//! commands of the operator may come at any time. Nothing here waits, samples or computes.
//!
//! ```text
//!            start                 trigger          record full           good
//!        ─────────▶ AwaitHit ─────────────▶ Record ─────────────▶ grade ────────▶ Analyse
//!                      ▲                       │ lost scans         │ bad            │ averaged
//!                      └───────────────────────┴────────────────────┘◀───────────────┤ more wanted
//!                      ▲                                        next DOF             ▼ enough
//!                      ├──────────────────────────── Estimate ◀───────────────── CloseDof
//!                      │ Continue                   target │ reached            last DOF │
//!                      └────────────── TargetReached ◀─────┘                             ▼
//!                                            └── Conclude ─────────────────────────▶ Identify ──▶ Done
//! ```
//! When the target is reached the campaign waits for the operator's `Conclude` or `Continue`; it asks once. A
//! block of known mass has no target.
//!
//! A record that does not agree with its repeat hits is withdrawn after the analysis if the policy requires
//! it, and the rig waits for another one.
//! An accepted hit can be undone until the next one triggers: the rig removes it from the averages, and the campaign
//! returns to the hit's DOF.
//! With *confirmation*, a good hit waits for the operator's `Accept` or `Reject` before it is analysed.

mod command;
mod progress;

pub use command::{Command, CommandError, Object, Start};
pub use progress::{CampaignProgress, DofProgress, Outcome};

use heapless::Vec;
use num_enum::{IntoPrimitive, TryFromPrimitive};

use crate::layout::RIG_HITS;

/// State of the rig as shown to the operator. The numbers never change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, IntoPrimitive, TryFromPrimitive)]
#[repr(u8)]
pub enum Phase {
    /// No campaign.
    Idle = 0,
    /// The rig waits for a hit at the current DOF.
    Armed = 1,
    /// A record is being taken or analysed.
    Busy = 2,
    /// A graded hit waits for the operator to accept or reject it.
    Confirming = 3,
    /// The campaign was interrupted by the operator or by the rig itself; accepted hits are stored. If the
    /// rig did it, an error among the diagnostics for which [`Code::interrupts`] holds gives the reason.
    ///
    /// [`Code::interrupts`]: crate::diagnosis::Code::interrupts
    Paused = 4,
    /// The ten properties are being computed and stored.
    Solving = 5,
    /// The campaign has ended and a result is stored, with or without an estimate.
    Done = 6,
    /// The target is reached before the last DOF: the operator concludes or continues.
    TargetReached = 7,
}

/// Next action of the rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Do nothing until a command comes.
    Rest,
    /// Sample, wait for a hit at this DOF, take the record and grade it.
    AwaitHit {
        /// Index of the DOF in the layout.
        dof: usize,
    },
    /// Average the current record into this DOF.
    Analyse {
        /// Index of the DOF in the layout.
        dof: usize,
    },
    /// Compute the mass lines of this DOF from its averages.
    CloseDof {
        /// Index of the DOF in the layout.
        dof: usize,
    },
    /// Remove the last accepted hit from its DOF.
    Undo,
    /// Identify the ten properties from the DOFs so far, and compare their precision with the target.
    Estimate,
    /// Identify the ten properties and store the result.
    Identify,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Waiting,
    Recording,
    Confirming,
    Analysing,
    Closing,
    Undoing,
    Estimating,
    AtTarget,
    Identifying,
    Done { result: u32 },
    Aborted,
}

/// A campaign: every hit DOF of a layout is measured with a number of hits.
#[derive(Clone, Debug)]
pub struct Campaign {
    state: State,
    start: Start,
    dofs: Vec<DofProgress, RIG_HITS>,
    dof: usize,
    wanted: u8,
    paused: bool,
    armed: bool,
    /// The operator was asked at the target, and wanted to continue.
    continued: bool,
    rejected: u16,
}

impl Campaign {
    /// Starts a campaign over `dofs` DOFs with `wanted` hits each.
    ///
    /// # Errors
    /// [`CommandError::NoDofs`] when there are no DOFs or too many.
    pub fn new(dofs: usize, wanted: u8, start: Start) -> Result<Self, CommandError> {
        let mut list = Vec::new();
        if dofs == 0 || list.resize(dofs, DofProgress::OPEN).is_err() {
            return Err(CommandError::NoDofs);
        }
        Ok(Self {
            state: State::Waiting,
            start,
            dofs: list,
            dof: 0,
            wanted: wanted.max(1),
            paused: false,
            armed: false,
            continued: false,
            rejected: 0,
        })
    }

    /// Restores a campaign after a power failure: paused, with its finished DOFs. The DOF that was being
    /// measured starts again.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn resume(progress: CampaignProgress) -> Result<Self, CommandError> {
        let CampaignProgress { start, dofs, wanted, rejected } = progress;
        let mut campaign = Self::new(dofs.len(), wanted, start)?;
        campaign.dofs = dofs;
        campaign.rejected = rejected;
        campaign.next_dof();
        campaign.paused = true;
        Ok(campaign)
    }

    /// What the rig does next.
    pub fn step(&self) -> Step {
        let dof = self.dof;
        match self.state {
            State::Waiting if !self.paused => Step::AwaitHit { dof },
            State::Analysing => Step::Analyse { dof },
            State::Closing => Step::CloseDof { dof },
            State::Undoing => Step::Undo,
            State::Estimating => Step::Estimate,
            State::Identifying if !self.paused => Step::Identify,
            _ => Step::Rest,
        }
    }

    /// State of the campaign as shown to the operator.
    pub fn phase(&self) -> Phase {
        match self.state {
            State::Aborted => Phase::Idle,
            _ if self.paused => Phase::Paused,
            State::Waiting if self.armed => Phase::Armed,
            State::Waiting
            | State::Recording
            | State::Analysing
            | State::Closing
            | State::Undoing
            | State::Estimating => Phase::Busy,
            State::Confirming => Phase::Confirming,
            State::AtTarget => Phase::TargetReached,
            State::Identifying => Phase::Solving,
            State::Done { .. } => Phase::Done,
        }
    }

    /// Index of the current DOF.
    pub fn dof(&self) -> usize {
        self.dof
    }

    /// All DOFs, in the order of the layout.
    pub fn dofs(&self) -> &[DofProgress] {
        &self.dofs
    }

    /// Number of hits averaged at the current DOF.
    pub fn accepted(&self) -> u8 {
        self.dofs.get(self.dof).map_or(0, |dof| dof.accepted)
    }

    /// Accepted hits wanted at each DOF.
    pub fn hits_per_dof(&self) -> u8 {
        self.wanted
    }

    /// Number of hits rejected in this campaign.
    pub fn rejected(&self) -> u16 {
        self.rejected
    }

    /// Options with which the campaign was started.
    pub fn started(&self) -> Start {
        self.start
    }

    /// Number of the result; 0 before the campaign is done.
    pub fn result(&self) -> u32 {
        match self.state {
            State::Done { result } => result,
            _ => 0,
        }
    }

    /// True from the start to the end of a campaign, including pauses.
    pub fn is_running(&self) -> bool {
        !matches!(self.state, State::Aborted | State::Done { .. })
    }

    /// True when the target is reached and the operator has not decided yet, paused or not.
    pub fn is_at_target(&self) -> bool {
        self.state == State::AtTarget
    }

    /// True when another campaign may replace this one: it has ended, or it is paused between two hits or
    /// after its result could not be stored.
    pub fn can_be_replaced(&self) -> bool {
        let held = matches!(self.state, State::Waiting | State::AtTarget | State::Identifying);
        !self.is_running() || (self.paused && held)
    }

    /// The finished DOFs, to be stored as a checkpoint; `None` unless a campaign is running.
    pub fn progress(&self) -> Option<CampaignProgress> {
        let Self { start, wanted, rejected, .. } = *self;
        let mut dofs = self.dofs.clone();
        for (i, dof) in dofs.iter_mut().enumerate() {
            // A DOF has no mass lines until it is closed.
            let closing = self.state == State::Closing && i == self.dof;
            if closing || dof.outcome == Outcome::Open {
                *dof = DofProgress::OPEN;
            }
        }
        self.is_running().then_some(CampaignProgress { start, dofs, wanted, rejected })
    }

    /// Executes a command of the operator. A computation that is paused begins anew when it is resumed. The caller
    /// gives no command while it stores the result, which can no longer be interrupted then.
    ///
    /// # Errors
    /// [`CommandError::WrongPhase`] when the command is not possible in this phase; nothing has changed then.
    pub fn command(&mut self, command: Command) -> Result<(), CommandError> {
        use Command as C;
        // Between hits nothing is recorded or computed, so the current DOF may be changed.
        let between = matches!(self.state, State::Waiting | State::Confirming);
        match command {
            C::Accept if self.state == State::Confirming => self.state = State::Analysing,
            C::Reject if self.state == State::Confirming => self.reject(),
            C::Redo if between => {
                self.set_current(0, Outcome::Open);
                self.wait();
            }
            C::Skip if between => {
                self.set_current(0, Outcome::Skipped);
                self.next_dof();
            }
            C::Finish if between && self.accepted() > 0 => {
                self.set_current(self.accepted(), Outcome::Early);
                self.state = State::Closing;
            }
            C::Conclude if self.state == State::AtTarget && !self.paused => self.conclude(),
            C::Continue if self.state == State::AtTarget && !self.paused => {
                self.continued = true;
                self.next_dof();
            }
            C::Undo if matches!(self.state, State::Waiting | State::AtTarget) => {
                self.state = State::Undoing;
            }
            C::Pause if self.is_running() => self.interrupted(),
            C::Resume if self.paused => self.paused = false,
            C::Abort if self.is_running() => self.end(State::Aborted),
            _ => return Err(CommandError::WrongPhase),
        }
        Ok(())
    }

    /// Reports that the rig samples and waits for a hit.
    pub fn armed(&mut self) {
        if self.state == State::Waiting {
            self.armed = true;
        }
    }

    /// Reports that the trigger has fired.
    pub fn triggered(&mut self) {
        if self.state == State::Waiting {
            self.state = State::Recording;
        }
    }

    /// Reports that the record is complete and graded.
    pub fn graded(&mut self, good: bool) {
        if self.state != State::Recording {
            return;
        }
        match (good, self.start.confirm) {
            (false, _) => self.reject(),
            (true, true) => self.state = State::Confirming,
            (true, false) => self.state = State::Analysing,
        }
    }

    /// Reports that the record was lost because scans are missing.
    pub fn record_lost(&mut self) {
        if matches!(self.state, State::Recording | State::Waiting) {
            self.reject();
        }
    }

    /// Reports that the record has been averaged into the current DOF.
    pub fn analysed(&mut self) {
        if self.state != State::Analysing {
            return;
        }
        let accepted = self.accepted().saturating_add(1);
        if accepted >= self.wanted {
            self.set_current(accepted, Outcome::Complete);
            self.state = State::Closing;
        } else {
            self.set_current(accepted, Outcome::Open);
            self.wait();
        }
    }

    /// Reports that the current record is an outlier and was removed from the averages.
    pub fn withdrawn(&mut self) {
        if self.state == State::Analysing {
            self.reject();
        }
    }

    /// Reports that the current record and the only one before it are inconsistent: the DOF starts again.
    pub fn drop_inconsistent_pair(&mut self) {
        if self.state == State::Analysing {
            self.drop_hits_before();
            self.reject();
        }
    }

    /// Reports that the hits before the current record are inconsistent: the DOF starts again with this record.
    pub fn drop_hits_before(&mut self) {
        if self.state == State::Analysing {
            self.rejected = self.rejected.saturating_add(self.accepted().into());
            self.set_current(0, Outcome::Open);
        }
    }

    /// Reports that the last accepted hit, at this DOF, has been removed, and that the averages contain `left` hits:
    /// the DOF is open again.
    pub fn undone(&mut self, dof: usize, left: u8) {
        if self.state == State::Undoing {
            self.dof = dof;
            self.set_current(left, Outcome::Open);
            self.wait();
        }
    }

    /// Reports that the mass lines or the lines of the current DOF are stored.
    pub fn dof_closed(&mut self) {
        if self.state != State::Closing {
            return;
        }
        let open = self.dofs.iter().any(|dof| dof.outcome == Outcome::Open);
        if open && self.start.object == Object::Unknown {
            self.state = State::Estimating;
        } else {
            self.next_dof();
        }
    }

    /// Reports that the precision is known, and whether it reaches the target.
    pub fn estimated(&mut self, reached: bool) {
        if self.state != State::Estimating {
            return;
        }
        if reached && !self.continued {
            self.state = State::AtTarget;
        } else {
            self.next_dof();
        }
    }

    /// Reports that the result is stored with this number.
    pub fn identified(&mut self, result: u32) {
        if self.state == State::Identifying {
            self.end(State::Done { result });
        }
    }

    /// Reports that the result could not be stored: `Resume` tries again.
    pub fn not_stored(&mut self) {
        if self.state == State::Identifying {
            self.paused = true;
        }
    }

    /// Reports that the converter does not respond: `Resume` tries again.
    pub fn interrupted(&mut self) {
        if self.is_running() {
            self.paused = true;
            if matches!(self.state, State::Recording | State::Confirming) {
                self.wait();
            }
        }
    }

    fn set_current(&mut self, accepted: u8, outcome: Outcome) {
        if let Some(dof) = self.dofs.get_mut(self.dof) {
            *dof = DofProgress { accepted, outcome };
        }
    }

    fn reject(&mut self) {
        self.rejected = self.rejected.saturating_add(1);
        self.wait();
    }

    fn wait(&mut self) {
        self.state = State::Waiting;
        self.armed = false;
    }

    /// Leaves out the DOFs that are open.
    fn conclude(&mut self) {
        for dof in self.dofs.iter_mut().filter(|dof| dof.outcome == Outcome::Open) {
            dof.outcome = Outcome::NotNeeded;
        }
        self.state = State::Identifying;
    }

    fn next_dof(&mut self) {
        match self.dofs.iter().position(|dof| dof.outcome == Outcome::Open) {
            Some(next) => {
                self.dof = next;
                self.wait();
            }
            None => self.state = State::Identifying,
        }
    }

    fn end(&mut self, state: State) {
        self.state = state;
        self.paused = false;
        self.armed = false;
    }
}

#[cfg(test)]
mod tests;

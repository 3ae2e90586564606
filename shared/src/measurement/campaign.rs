//! Which DOF is hit next, and what a verdict or the operator's word leads to.
//!
//! A pure state machine. The rig asks [`Campaign::step`] what to do, does it, and reports what came
//! of it; the operator's commands come in between at any time. Nothing here waits, samples or
//! computes.
//!
//! ```text
//!            start                 trigger          record full           good
//!        ─────────▶ AwaitHit ─────────────▶ Record ─────────────▶ grade ────────▶ Analyse
//!                      ▲                       │ lost scans         │ bad            │ averaged
//!                      └───────────────────────┴────────────────────┘◀───────────────┤ more wanted
//!                      ▲                                        next DOF             ▼ enough
//!                      └──────────────────────────────────────────────────────── CloseDof
//!                                                                last DOF ──▶ Identify ──▶ Done
//! ```
//! A record that was analysed and does not agree with its repeat hits is withdrawn where the policy wants
//! it: the rig waits for another one.
//! With *confirmation* a good hit waits for the operator's `Accept` or `Reject` before it is analysed.

mod command;
mod progress;

pub use command::{Command, CommandError, Object, Start};
pub use progress::{CampaignProgress, DofProgress, Outcome};

use heapless::Vec;
use num_enum::{IntoPrimitive, TryFromPrimitive};

use crate::layout::RIG_HITS;

/// What is shown of a rig. The numbers are never changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, IntoPrimitive, TryFromPrimitive)]
#[repr(u8)]
pub enum Phase {
    /// No campaign.
    Idle = 0,
    /// Waits for the hammer at the DOF in hand.
    Armed = 1,
    /// A record is being taken or analysed.
    Busy = 2,
    /// A graded hit waits for the operator to accept or reject it.
    Confirming = 3,
    /// A campaign is interrupted, by the operator or by the rig itself; what has been accepted is
    /// kept. An error among the diagnostics that [`Code::interrupts`] says why the rig did it.
    ///
    /// [`Code::interrupts`]: crate::diagnosis::Code::interrupts
    Paused = 4,
    /// The ten properties are being computed and stored.
    Solving = 5,
    /// The campaign has ended and a result is stored, with or without an answer.
    Done = 6,
}

/// What the rig does next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Nothing until a command comes.
    Rest,
    /// Sample, wait for the hammer at this DOF, take the record, grade it.
    AwaitHit {
        /// Index in the layout.
        dof: usize,
    },
    /// Average the record in hand into this DOF.
    Analyse {
        /// Index in the layout.
        dof: usize,
    },
    /// Turn this DOF's averages into mass lines.
    CloseDof {
        /// Index in the layout.
        dof: usize,
    },
    /// Compute the ten properties and keep them.
    Identify,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Waiting,
    Recording,
    Confirming,
    Analysing,
    Closing,
    Identifying,
    Done { result: u32 },
    Aborted,
}

/// A campaign: every hit DOF of a layout measured with a number of hits. It begins with its start.
#[derive(Clone, Debug)]
pub struct Campaign {
    state: State,
    start: Start,
    dofs: Vec<DofProgress, RIG_HITS>,
    dof: usize,
    wanted: u8,
    paused: bool,
    armed: bool,
    rejected: u16,
}

impl Campaign {
    /// Starts a campaign over `dofs` DOFs with `wanted` hits each.
    ///
    /// # Errors
    /// [`CommandError::NoDofs`] without DOFs, or with too many.
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
            rejected: 0,
        })
    }

    /// Takes up a campaign that a cut of the power has ended: paused, with its finished DOFs. The DOF that was
    /// in hand begins anew.
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
            State::Identifying if !self.paused => Step::Identify,
            _ => Step::Rest,
        }
    }

    /// What is shown of the campaign.
    pub fn phase(&self) -> Phase {
        match self.state {
            State::Aborted => Phase::Idle,
            _ if self.paused => Phase::Paused,
            State::Waiting if self.armed => Phase::Armed,
            State::Waiting | State::Recording | State::Analysing | State::Closing => Phase::Busy,
            State::Confirming => Phase::Confirming,
            State::Identifying => Phase::Solving,
            State::Done { .. } => Phase::Done,
        }
    }

    /// Index of the DOF in hand.
    pub fn dof(&self) -> usize {
        self.dof
    }

    /// All DOFs, in the order of the layout.
    pub fn dofs(&self) -> &[DofProgress] {
        &self.dofs
    }

    /// Hits averaged at the DOF in hand.
    pub fn accepted(&self) -> u8 {
        self.dofs.get(self.dof).map_or(0, |dof| dof.accepted)
    }

    /// Accepted hits wanted at each DOF.
    pub fn wanted(&self) -> u8 {
        self.wanted
    }

    /// Hits rejected in this campaign.
    pub fn rejected(&self) -> u16 {
        self.rejected
    }

    /// How it was started.
    pub fn started(&self) -> Start {
        self.start
    }

    /// Number of the result, 0 before the campaign is done.
    pub fn result(&self) -> u32 {
        match self.state {
            State::Done { result } => result,
            _ => 0,
        }
    }

    /// True from the start to the end of a campaign, pauses included.
    pub fn is_running(&self) -> bool {
        !matches!(self.state, State::Aborted | State::Done { .. })
    }

    /// True when another campaign may take its place: it has ended, or is paused between two hits.
    pub fn gives_way(&self) -> bool {
        let held = matches!(self.state, State::Waiting | State::Identifying);
        !self.is_running() || (self.paused && held)
    }

    /// What has been finished; `None` unless a campaign is running.
    pub fn progress(&self) -> Option<CampaignProgress> {
        let Self { start, wanted, rejected, .. } = *self;
        let mut dofs = self.dofs.clone();
        for (i, dof) in dofs.iter_mut().enumerate() {
            // A DOF has no mass lines before it is closed.
            let closing = self.state == State::Closing && i == self.dof;
            if closing || dof.outcome == Outcome::Open {
                *dof = DofProgress::OPEN;
            }
        }
        self.is_running().then_some(CampaignProgress { start, dofs, wanted, rejected })
    }

    /// Executes a command of the operator.
    ///
    /// # Errors
    /// [`CommandError::WrongPhase`] when the command has no meaning now; nothing has changed then.
    pub fn command(&mut self, command: Command) -> Result<(), CommandError> {
        use Command as C;
        // Between hits: nothing is recorded or computed, so the DOF in hand may be changed.
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
            C::Pause if self.is_running() && self.state != State::Identifying => {
                self.interrupted();
            }
            C::Resume if self.paused => self.paused = false,
            // A result that is being stored is not torn; one that could not be is given up.
            C::Abort if self.is_running() && (self.paused || self.state != State::Identifying) => {
                self.end(State::Aborted);
            }
            _ => return Err(CommandError::WrongPhase),
        }
        Ok(())
    }

    /// The rig samples and waits for the hammer.
    pub fn armed(&mut self) {
        if self.state == State::Waiting {
            self.armed = true;
        }
    }

    /// The hammer has touched.
    pub fn triggered(&mut self) {
        if self.state == State::Waiting {
            self.state = State::Recording;
        }
    }

    /// The record is whole and graded.
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

    /// The record was lost: scans are missing.
    pub fn record_lost(&mut self) {
        if matches!(self.state, State::Recording | State::Waiting) {
            self.reject();
        }
    }

    /// The record has been averaged into the DOF in hand.
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

    /// The record in hand does not belong to the hits before it: it was taken out of the averages.
    pub fn withdrawn(&mut self) {
        if self.state == State::Analysing {
            self.reject();
        }
    }

    /// The record in hand and the only one before it contradict each other: the DOF begins anew.
    pub fn drop_inconsistent_pair(&mut self) {
        if self.state == State::Analysing {
            self.rejected = self.rejected.saturating_add(self.accepted().into());
            self.set_current(0, Outcome::Open);
            self.reject();
        }
    }

    /// The mass lines of the DOF in hand are kept.
    pub fn dof_closed(&mut self) {
        if self.state == State::Closing {
            self.next_dof();
        }
    }

    /// The ten properties are kept as this result.
    pub fn identified(&mut self, result: u32) {
        if self.state == State::Identifying {
            self.end(State::Done { result });
        }
    }

    /// The result could not be kept: `Resume` tries again.
    pub fn not_stored(&mut self) {
        if self.state == State::Identifying {
            self.paused = true;
        }
    }

    /// The converter does not answer: `Resume` tries again.
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

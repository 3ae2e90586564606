//! Follows a campaign from its start to its result.
//!
//! The rig is in control: it arms, triggers, grades and computes. The host observes, passes on the operator's
//! commands, and notifies the operator or bench of the DOF to hit. The [`Status`] is authoritative; events
//! only make the host see a change sooner, and polling makes up for lost events.

use std::time::{Duration, Instant};

use massline_protocol::event::{HitEvent, ScanBlock};
use massline_protocol::message::{Reason, StartRequest, Status};
use massline_shared::diagnosis::{Code, Diagnostic, Subject};
use massline_shared::measurement::campaign::{Command, Object, Phase, Start};

use crate::error::ClientError;
use crate::exchange::{Client, Event};
use crate::interrupt::Interrupt;
use massline_files::day::age_in_days;
use massline_result::{Error, Result};

/// The host polls the status after this much silence.
const POLL: Duration = Duration::from_millis(40);

/// Observes a running campaign, and steers it.
pub trait Observer {
    /// The rig waits for a hit at DOF `dof` of the layout; `arming` differs each time. If the hits come from
    /// outside of the rig, the observer triggers one now.
    ///
    /// # Errors
    /// When the notification fails; `follow` then ends.
    fn armed(&mut self, arming: u32, dof: usize) -> Result<()> {
        let _ = (arming, dof);
        Ok(())
    }

    /// The status has changed.
    fn status(&mut self, status: &Status) {
        let _ = status;
    }

    /// A hit was graded. This event can be lost on a bad link.
    fn hit(&mut self, hit: &HitEvent) {
        let _ = hit;
    }

    /// A block of streamed scans arrived.
    fn scans(&mut self, block: &ScanBlock) {
        let _ = block;
    }

    /// Returns the next command for the rig. Called repeatedly, at least every 40 ms; the observer may use the client,
    /// for example to read the record of a hit that waits for confirmation.
    ///
    /// # Errors
    /// An error makes `follow` end.
    fn steer(&mut self, client: &mut Client, status: &Status) -> Result<Option<Command>> {
        let _ = (client, status);
        Ok(None)
    }

    /// Called instead of [`Observer::steer`] while the rig asks whether to finish at the target. Without a
    /// decision of its own, the observer finishes.
    ///
    /// # Errors
    /// An error makes `follow` end.
    fn at_target(&mut self, client: &mut Client, status: &Status) -> Result<Option<Command>> {
        let _ = (client, status);
        Ok(Some(Command::Conclude))
    }

    /// The rig refused the command of [`Observer::steer`] and goes on; [`explain_refusal`] has the words.
    fn refused(&mut self, command: Command, reason: Reason) {
        let _ = (command, reason);
    }
}

/// An observer that does nothing.
impl Observer for () {}

/// How following a campaign ended.
#[derive(Clone, Debug, PartialEq)]
pub enum CampaignOutcome {
    /// The campaign completed with the result of this number.
    Done(u32),
    /// The rig interrupted the campaign itself; the diagnostics of the status give the reason. It can be
    /// resumed.
    Stopped(Box<Status>),
    /// The campaign is interrupted and can be resumed.
    Paused(Box<Status>),
    /// The rig has restarted: its supply has failed, or it was reset. What it keeps can be resumed.
    Restarted(Box<Status>),
    /// The campaign was aborted.
    Aborted,
}

/// Options for the start of a campaign.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StartOptions {
    /// Every hit waits for a verdict.
    pub confirm: bool,
    /// Start although the layout has an error.
    pub force: bool,
    /// Discard an interrupted campaign.
    pub restart: bool,
    /// The object is a block of this mass, kg: mass lines only.
    pub block_mass: Option<f32>,
    /// When it is, seconds since 1970-01-01 00:00 UTC; zero when that does not matter, as for a simulated test, which
    /// gives the same result at any time.
    pub started_unix_s: u32,
}

/// What [`begin`] did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StartOutcome {
    /// A new campaign.
    Started,
    /// An interrupted campaign was resumed.
    Resumed,
    /// A campaign was already running.
    Joined,
}

/// Starts a campaign with the layout stored on the rig, resumes an interrupted campaign, or joins the one
/// that is running.
///
/// # Errors
/// When the rig refuses or cannot be reached.
pub fn begin(client: &mut Client, how: StartOptions) -> Result<StartOutcome, ClientError> {
    let status = client.status()?;
    match Phase::try_from(status.phase).ok() {
        Some(Phase::Paused) if !how.restart => {
            client.command(Command::Resume)?;
            Ok(StartOutcome::Resumed)
        }
        Some(
            Phase::Armed | Phase::Busy | Phase::Confirming | Phase::TargetReached | Phase::Solving,
        ) if !how.restart => Ok(StartOutcome::Joined),
        Some(
            Phase::Armed
            | Phase::Busy
            | Phase::Confirming
            | Phase::TargetReached
            | Phase::Paused
            | Phase::Solving,
        ) => {
            client.command(Command::Abort)?;
            start(client, how)?;
            Ok(StartOutcome::Started)
        }
        _ => {
            start(client, how)?;
            Ok(StartOutcome::Started)
        }
    }
}

/// Starts; the rig, which has no calendar, is told the time and the age of its calibration.
fn start(client: &mut Client, how: StartOptions) -> Result<Status, ClientError> {
    let StartOptions { confirm, force, block_mass, started_unix_s, restart: _ } = how;
    let calibration_age_days = age_in_days(&client.calibration()?);
    let object = block_mass.map_or(Object::Unknown, |mass| Object::Block { mass });
    let start = Start { object, confirm, calibration_age_days, started_unix_s };
    client.start_with(StartRequest { start, force })
}

/// Follows the running campaign until it ends.
///
/// `patience` is how long the status may stay unchanged before the rig counts as stuck; `None` where a person
/// taps. Ctrl-C interrupts the campaign on the rig, and the function returns [`CampaignOutcome::Paused`].
///
/// # Errors
/// When the link is lost for good, the rig is stuck, or the observer fails; the campaign is then interrupted
/// if the rig can still be reached.
pub fn follow(
    client: &mut Client,
    interrupt: &Interrupt,
    patience: Option<Duration>,
    observer: &mut dyn Observer,
) -> Result<CampaignOutcome> {
    let _guard = interrupt.guard();
    let mut follower = Follower {
        client,
        observer,
        last: None,
        heard: 0,
        reported: None,
        changed: Instant::now(),
    };
    let ending = follower.run(interrupt, patience);
    // With a rig that is gone or silent, both would only wait for it again; the first error is the one to report.
    // What is interrupted here is the wait for such a rig.
    let waited = |e: &Error| is_out_of_reach(e) || e.code() == Error::INTERRUPTED;
    if ending.as_ref().is_err_and(|e| !waited(e)) {
        let _ = follower.hear_the_rest();
        let _ = client.command(Command::Pause);
    }
    ending
}

/// Whether an error means that the rig cannot be reached.
pub fn is_out_of_reach(error: &Error) -> bool {
    ["link_lost", "no_answer", "port_busy"].contains(&error.code())
}

struct Follower<'a> {
    client: &'a mut Client,
    observer: &'a mut dyn Observer,
    last: Option<Status>,
    /// The last hit that the observer was told of, or whose event did not come.
    heard: u32,
    /// The last arming that the observer was notified of.
    reported: Option<u32>,
    changed: Instant,
}

impl Follower<'_> {
    fn run(
        &mut self,
        interrupt: &Interrupt,
        patience: Option<Duration>,
    ) -> Result<CampaignOutcome> {
        let mut status = self.ask()?;
        loop {
            if let Some(ending) = self.take(&status)? {
                return Ok(ending);
            }
            if interrupt.pressed() {
                return self.leave();
            }
            let command = match Phase::try_from(status.phase).ok() {
                Some(Phase::TargetReached) => self.observer.at_target(self.client, &status)?,
                _ => self.observer.steer(self.client, &status)?,
            };
            status = match command {
                Some(command) => self.command(command)?,
                None => self.listen()?,
            };
            if let Some(patience) = patience.filter(|&p| self.changed.elapsed() > p) {
                return Err(self.stuck(&status, patience));
            }
        }
    }

    /// Processes a status; returns how the campaign ended, if it has.
    fn take(&mut self, status: &Status) -> Result<Option<CampaignOutcome>> {
        // The rig counts from power-on.
        let has_restarted = self.last.as_ref().is_some_and(|last| status.armings < last.armings);
        if self.last.as_ref() != Some(status) {
            self.hear_hits(status.last_hit)?;
            self.observer.status(status);
            self.last = Some(status.clone());
            self.changed = Instant::now();
        }
        match Phase::try_from(status.phase).ok() {
            Some(Phase::Armed) if self.reported != Some(status.armings) => {
                self.reported = Some(status.armings);
                self.observer.armed(status.armings, usize::from(status.dof))?;
                Ok(None)
            }
            Some(Phase::Done) => {
                // The observer gets the last hits before the campaign's end.
                self.drain()?;
                Ok(Some(CampaignOutcome::Done(status.result)))
            }
            Some(Phase::Paused) if status.diagnostics.iter().any(Diagnostic::interrupts) => {
                Ok(Some(CampaignOutcome::Stopped(Box::new(status.clone()))))
            }
            Some(Phase::Paused | Phase::Idle) if has_restarted => {
                Ok(Some(CampaignOutcome::Restarted(Box::new(status.clone()))))
            }
            Some(Phase::Paused) => Ok(Some(CampaignOutcome::Paused(Box::new(status.clone())))),
            Some(Phase::Idle) => Ok(Some(CampaignOutcome::Aborted)),
            _ => Ok(None),
        }
    }

    /// Waits a moment for the event of a hit that a status already counts, so that the observer hears of the hit first.
    fn hear_hits(&mut self, last: u32) -> Result<()> {
        let deadline = Instant::now() + POLL;
        while self.heard < last {
            let left = deadline.saturating_duration_since(Instant::now());
            match self.client.next_event(left)? {
                // The caller has a newer one.
                Some(Event::Status(_)) => {}
                Some(event) => self.pass_on(&event),
                // The event is lost, or the hit was graded before.
                None => self.heard = last,
            }
        }
        Ok(())
    }

    /// Tells the observer of the hits that it has not heard of yet.
    fn hear_the_rest(&mut self) -> Result<()> {
        let last = self.ask()?.last_hit;
        self.hear_hits(last)?;
        self.drain()
    }

    /// Waits for the next status: from an event, or by polling after a silence.
    fn listen(&mut self) -> Result<Status> {
        match self.client.next_event(POLL)? {
            Some(Event::Status(status)) => Ok(status),
            Some(other) => {
                self.pass_on(&other);
                self.last.clone().map_or_else(|| self.ask(), Ok)
            }
            None => self.ask(),
        }
    }

    fn drain(&mut self) -> Result<()> {
        while let Some(event) = self.client.next_event(Duration::ZERO)? {
            self.pass_on(&event);
        }
        Ok(())
    }

    fn pass_on(&mut self, event: &Event) {
        match event {
            Event::Hit(hit) => {
                self.changed = Instant::now();
                self.heard = self.heard.max(hit.number);
                self.observer.hit(hit);
            }
            Event::Scans(block) => self.observer.scans(block),
            Event::Status(_) => {}
        }
    }

    fn ask(&mut self) -> Result<Status> {
        let status = self.client.status()?;
        self.client.discard_statuses();
        Ok(status)
    }

    /// Sends a command; returns the status after it, also when the rig refused the command and goes on.
    fn command(&mut self, command: Command) -> Result<Status> {
        match self.client.command(command) {
            Ok(status) => {
                self.client.discard_statuses();
                Ok(status)
            }
            Err(e) => match e.refusal() {
                Some(reason) if concerns_operator(command, reason) => {
                    self.observer.refused(command, reason);
                    self.ask()
                }
                _ => Err(e.into()),
            },
        }
    }

    /// Interrupts the campaign; returns its ending if it has ended meanwhile.
    fn leave(&mut self) -> Result<CampaignOutcome> {
        loop {
            let status = self.command(Command::Pause)?;
            if let Some(ending) = self.take(&status)? {
                return Ok(ending);
            }
            // The rig is storing the result, which takes a moment and cannot be interrupted.
            self.listen()?;
        }
    }

    fn stuck(&self, status: &Status, patience: Duration) -> Error {
        Error::device(
            "rig_stuck",
            format!(
                "the rig has made no progress for {} s: phase {}, DOF number {}, {} hits \
                 accepted and {} rejected; `massline device stats` may show why",
                patience.as_secs(),
                phase_name(status.phase),
                u32::from(status.dof) + 1,
                status.accepted.iter().map(|&n| u32::from(n)).sum::<u32>(),
                status.rejected,
            ),
        )
    }
}

/// The error of a rig that has restarted during a campaign, with what it keeps of it and how to go on.
pub fn restarted(status: &Status) -> Error {
    let accepted: u32 = status.accepted.iter().map(|&hits| u32::from(hits)).sum();
    let kept = match Phase::try_from(status.phase).ok() {
        Some(Phase::Idle) => {
            "no DOF was finished, so there are no hits to keep: the same command starts again"
                .to_owned()
        }
        _ => {
            let ending = if accepted == 1 { "" } else { "s" };
            format!(
                "it keeps the {accepted} accepted hit{ending} of the DOFs that were finished; only the hits of the DOF \
                 under way are to be repeated: the same command resumes, --restart starts over"
            )
        }
    };
    let message = format!(
        "the rig has restarted during the measurement (check its cable and supply): {kept}"
    );
    Error::device("rig_restarted", message)
}

/// The DOF that waits for its next hit, and is therefore open; `None` while the rig is doing something else.
pub fn open_dof(status: &Status) -> Option<u8> {
    let phase = Phase::try_from(status.phase).ok();
    matches!(phase, Some(Phase::Armed | Phase::Confirming)).then_some(status.dof)
}

/// The DOFs of the layout, by their indices, that the rig still asks for or is storing: those before the current one
/// that have no hits were skipped.
pub fn dofs_left(status: &Status) -> Vec<usize> {
    let skipped = |dof: usize| {
        let is_that = |diagnostic: &Diagnostic| {
            diagnostic.code == Code::DofSkipped && diagnostic.subject == Subject::Hit(dof as u8)
        };
        status.diagnostics.iter().any(is_that)
    };
    let hits = status.accepted.iter().enumerate();
    hits.filter(|(dof, hits)| (*dof >= usize::from(status.dof) || **hits > 0) && !skipped(*dof))
        .map(|(dof, _)| dof)
        .collect()
}

/// True when a refusal is something to tell the operator, and not a failure.
fn concerns_operator(command: Command, reason: Reason) -> bool {
    let undo = [Reason::NothingToUndo, Reason::HitOverwritten];
    reason == Reason::WrongPhase || command == Command::Undo && undo.contains(&reason)
}

/// Why the rig refused a command of the operator, as a sentence.
pub fn explain_refusal(command: Command, reason: Reason) -> String {
    let action = match command {
        Command::Undo => {
            return match reason {
                Reason::NothingToUndo => "there is no hit to undo: only the last accepted hit can be undone, once",
                Reason::HitOverwritten => {
                    "the last accepted hit can no longer be undone, because a later hit has replaced its record; d \
                     redoes the DOF"
                }
                _ => "a hit can be undone only while the rig waits for the next one",
            }
            .to_owned();
        }
        Command::Pause => "pausing",
        Command::Resume => "resuming",
        Command::Accept => "accepting a hit",
        Command::Reject => "rejecting a hit",
        Command::Redo => "repeating the DOF",
        Command::Skip => "skipping the DOF",
        Command::Finish => "finishing the DOF",
        Command::Abort => "ending the campaign",
        Command::Conclude => "finishing at the target",
        Command::Continue => "going on after the target",
    };
    let why = match command {
        Command::Finish => ": the DOF has no accepted hit yet, or is being closed",
        _ => "",
    };
    format!("{action} is not possible now{why}")
}

/// The name of a phase from its raw value.
pub fn phase_name(raw: u8) -> &'static str {
    match Phase::try_from(raw).ok() {
        Some(Phase::Idle) => "idle",
        Some(Phase::Armed) => "armed",
        Some(Phase::Busy) => "busy",
        Some(Phase::Confirming) => "confirming",
        Some(Phase::Paused) => "paused",
        Some(Phase::Solving) => "solving",
        Some(Phase::Done) => "done",
        Some(Phase::TargetReached) => "at the target",
        None => "unknown",
    }
}

#[cfg(test)]
mod tests;

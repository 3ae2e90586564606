//! The person at the keyboard who follows a campaign: progress, verdicts, precision after each DOF.

use std::time::Instant;

use massline_protocol::event::HitEvent;
use massline_protocol::lines::{CURRENT_CAMPAIGN, LinesId};
use massline_protocol::message::{Reason, Status};
use massline_shared::layout::RigLayout;
use massline_shared::measurement::campaign::{Command, Phase};

use crate::output::{Output, counted};
use crate::rig_lines::lines_of;
use crate::screen::guide::{AnswerSoFar, GuideOptions};
use crate::support::collected::hit_log::HitLog;
use crate::support::collected::hit_records::RecordCollection;
use crate::support::collected::spectra::{CollectingObserver, SpectraCollection};
use crate::support::keyboard::{self, KeyMeaning, Keyboard};
use crate::support::progress::{Progress, Prompts};
use crate::{Error, Result};
use massline_analysis::modes_so_far::ModesMonitor;
use massline_analysis::precision::PrecisionMonitor;
use massline_client::Client;
use massline_client::campaign::{CampaignOutcome, Observer, dofs_left, follow, open_dof};
use massline_report::words::precision;

use super::full_screen::{DisplayedCampaign, FullScreen};
use super::presenter::Presenter;
use super::ringing::Ringing;

/// What becomes of a campaign whose rig does not answer; a link that is lost says so itself.
const GOES_ON: &str =
    "the rig keeps the hits that it has accepted: the same command goes on with them";

/// What is done while a campaign is followed.
#[derive(Debug, Default)]
pub(in crate::commands) struct Watching<'a> {
    /// Reports the precision after each DOF.
    pub monitor: Option<&'a mut PrecisionMonitor>,
    /// Reports which modes show after each DOF, in the suspension profile.
    pub modes: Option<&'a mut ModesMonitor>,
    /// Collects the spectra.
    pub collection: Option<&'a mut SpectraCollection>,
    /// Collects the records of accepted hits, beside the spectra.
    pub records: Option<&'a mut RecordCollection>,
    /// Collects what became of every hit, beside the spectra.
    pub log: Option<&'a mut HitLog>,
    /// The person gives a verdict on each hit that the rig waits with; else the program accepts it.
    pub confirm: bool,
    /// Finish at the target without asking.
    pub yes: bool,
    /// Length of a record after its hit, s, in the suspension profile.
    pub record_s: Option<f64>,
    /// What is shown on a full screen; lines without it, or without a terminal for it.
    pub shown: Option<DisplayedCampaign<'a>>,
}

/// Follows the running campaign with a person at the keyboard.
pub(in crate::commands) fn watch(
    client: &mut Client,
    layout: &RigLayout,
    watching: Watching<'_>,
    output: &mut Output,
) -> Result<CampaignOutcome> {
    let interrupt = output.interrupt().clone();
    let Watching { monitor, modes, collection, records, log, confirm, yes, record_s, shown } =
        watching;
    let ringing = record_s.map(Ringing::new);
    // The rig waits with every hit until what is collected and shown of it has been read. It keeps waiting when its
    // campaign is resumed in another way.
    let accepts = !confirm;
    let keyboard = output.has_keyboard().then(|| Keyboard::take(output)).transpose()?;
    let presenter: Box<dyn Presenter + '_> = match shown.zip(keyboard.as_ref()) {
        Some((shown, keyboard)) => {
            let answer = match (&monitor, &modes) {
                (Some(_), _) => Some(AnswerSoFar::Intervals),
                (None, Some(_)) => Some(AnswerSoFar::Modes),
                (None, None) => None,
            };
            let wanted = GuideOptions { answer, verdicts: !accepts };
            Box::new(FullScreen::open(shown, layout, wanted, (keyboard, output))?)
        }
        None => {
            if keyboard.is_some() {
                output.note(keyboard::HELP);
            }
            let prompts = if accepts { Prompts::Hits } else { Prompts::HitsAndVerdicts };
            Box::new(Progress::new(output, "hits", layout, prompts))
        }
    };
    let mut person =
        Person { presenter, keyboard, monitor, modes, yes, accepts, ringing, asked: false };
    let ending = match collection {
        Some(collection) => {
            let records = records.map(|records| (records, layout));
            let mut collecting =
                CollectingObserver { observer: &mut person, collection, records, log, accepts };
            follow(client, &interrupt, None, &mut collecting)
        }
        None => follow(client, &interrupt, None, &mut person),
    };
    drop(person);
    ending.map_err(|error| match error.code() {
        "no_answer" | Error::INTERRUPTED => error.advising(GOES_ON),
        _ => error,
    })
}

/// The operator with a hammer, who may have a keyboard.
struct Person<'o> {
    presenter: Box<dyn Presenter + 'o>,
    keyboard: Option<Keyboard>,
    monitor: Option<&'o mut PrecisionMonitor>,
    modes: Option<&'o mut ModesMonitor>,
    /// Finish at the target without asking.
    yes: bool,
    /// The program gives the verdicts.
    accepts: bool,
    /// The record that is taken, in the suspension profile.
    ringing: Option<Ringing>,
    /// The question at the target has been asked.
    asked: bool,
}

impl Person<'_> {
    /// Reads the mass lines of the DOFs that have been closed meanwhile, and reports the precision with them.
    fn follow_precision(&mut self, client: &mut Client, status: &Status) -> Result<()> {
        let Some(monitor) = &mut self.monitor else { return Ok(()) };
        if let Some(open) = open_dof(status)
            && monitor.forget(open)
        {
            self.presenter.reopened(monitor.measured());
        }
        let at_target = is_at_target(status);
        if read_new(client, monitor, status, |dof| dof != status.dof || at_target)? {
            self.presenter.precision(&monitor.report());
        }
        Ok(())
    }

    /// Reads the lines of the DOFs that have been stored meanwhile, and reports which modes they show.
    fn follow_modes(&mut self, client: &mut Client, status: &Status) -> Result<()> {
        let Some(monitor) = &mut self.modes else { return Ok(()) };
        if let Some(open) = open_dof(status)
            && monitor.forget(open)
        {
            self.presenter.reopened(monitor.measured());
        }
        let new =
            read_new_lines(client, monitor, status, CURRENT_CAMPAIGN, |dof| dof != status.dof)?;
        let left = dofs_left(status);
        if new || monitor.is_outdated(&left) {
            self.presenter.modes(monitor.report(&left));
        }
        Ok(())
    }

    /// The question at the target.
    fn question(&mut self) -> String {
        let reached = self.monitor.as_mut().map_or_else(
            || "target reached".to_owned(),
            |monitor| {
                let report = monitor.latest();
                format!(
                    "target reached after {}: {}",
                    precision::progress(&report),
                    precision::widths(&report)
                )
            },
        );
        if self.asks() {
            format!("{reached}; finish now? [Y/n]")
        } else {
            format!("{reached}; finishing")
        }
    }

    fn asks(&self) -> bool {
        self.keyboard.is_some() && !self.yes
    }

    fn poll(&mut self, status: &Status) -> Option<Command> {
        let keyboard = self.keyboard.as_mut()?;
        let presenter = &mut self.presenter;
        let phase = Phase::try_from(status.phase).ok();
        match keyboard.poll(phase, |key| presenter.key(key))? {
            KeyMeaning::QuitOnce => {
                let hits: u32 = status.accepted.iter().map(|&hits| u32::from(hits)).sum();
                self.presenter.line(&format!(
                    "q again aborts the campaign and discards its {}; p pauses it",
                    counted(hits, "accepted hit")
                ));
                None
            }
            KeyMeaning::Command(command) => {
                self.presenter.acted();
                Some(command)
            }
        }
    }
}

/// Reads the mass lines of the DOFs that are `closed` and not known yet; returns whether there were any.
pub(super) fn read_new(
    client: &mut Client,
    monitor: &mut PrecisionMonitor,
    status: &Status,
    closed: impl Fn(u8) -> bool,
) -> Result<bool> {
    let mut new = false;
    for index in dofs_with_hits(status) {
        if closed(index)
            && !monitor.knows(index)
            && let Some(dof) = client.mass_lines(index)?
        {
            monitor.add(dof);
            new = true;
        }
    }
    Ok(new)
}

/// Reads the lines of the DOFs of a result, or of the campaign, that are `closed` and not known yet; returns whether
/// there were any.
pub(super) fn read_new_lines(
    client: &mut Client,
    monitor: &mut ModesMonitor,
    status: &Status,
    result: u32,
    closed: impl Fn(u8) -> bool,
) -> Result<bool> {
    let mut new = false;
    for dof in dofs_with_hits(status) {
        if closed(dof)
            && !monitor.knows(dof)
            && let Some(stored) = client.lines(LinesId { result, dof })?
        {
            monitor.add(lines_of(&stored));
            new = true;
        }
    }
    Ok(new)
}

/// The indices of the DOFs with accepted hits.
fn dofs_with_hits(status: &Status) -> impl Iterator<Item = u8> + '_ {
    (0..).zip(&status.accepted).filter(|(_, hits)| **hits > 0).map(|(dof, _)| dof)
}

fn is_at_target(status: &Status) -> bool {
    Phase::try_from(status.phase).ok() == Some(Phase::TargetReached)
}

impl Observer for Person<'_> {
    fn status(&mut self, status: &Status) {
        if let Some(ringing) = &mut self.ringing {
            let phase = Phase::try_from(status.phase).ok();
            ringing.status(phase, status.armings, Instant::now());
        }
        self.presenter.status(status);
    }

    fn hit(&mut self, hit: &HitEvent) {
        if let Some(ringing) = &mut self.ringing {
            ringing.graded();
        }
        self.presenter.hit(hit);
    }

    fn steer(&mut self, client: &mut Client, status: &Status) -> Result<Option<Command>> {
        self.asked = false;
        self.follow_precision(client, status)?;
        self.follow_modes(client, status)?;
        let waits = Phase::try_from(status.phase).ok() == Some(Phase::Confirming);
        if let Some(ringing) = &self.ringing {
            self.presenter.ringing(ringing.left_s(Instant::now()));
        }
        self.presenter.look(client, status)?;
        let accept = Command::Accept;
        Ok(self.poll(status).or((waits && self.accepts).then_some(accept)))
    }

    fn at_target(&mut self, client: &mut Client, status: &Status) -> Result<Option<Command>> {
        self.follow_precision(client, status)?;
        if !self.asked {
            self.asked = true;
            let question = self.question();
            self.presenter.question(&question);
        }
        self.presenter.look(client, status)?;
        if self.asks() {
            return Ok(self.poll(status));
        }
        Ok(Some(Command::Conclude))
    }

    fn refused(&mut self, command: Command, reason: Reason) {
        self.presenter.refused(command, reason);
    }
}

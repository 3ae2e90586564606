//! The person at the keyboard who follows a campaign: progress, verdicts, precision after each DOF.

use massline_protocol::event::HitEvent;
use massline_protocol::message::{CampaignCommand, Reason, Status};
use massline_shared::layout::RigLayout;
use massline_shared::measurement::campaign::Phase;

use crate::archive::RecordCollection;
use crate::campaign::{CampaignOutcome, Observer, OperatorAction, follow, open_dof};
use crate::client::Client;
use crate::commands::keyboard::{self, Keyboard};
use crate::commands::progress::{Progress, Prompts};
use crate::error::{Error, Result};
use crate::output::Output;
use crate::precision::PrecisionMonitor;
use crate::spectra::{Collecting, SpectraCollection};

/// What is done while a campaign is followed.
#[derive(Debug, Default)]
pub(in crate::commands) struct Watching<'a> {
    /// Reports the precision after each DOF.
    pub monitor: Option<&'a mut PrecisionMonitor>,
    /// Collects the spectra; good hits are then accepted without asking, unless `confirm` is set.
    pub collection: Option<&'a mut SpectraCollection>,
    /// Collects the records of accepted hits, beside the spectra.
    pub records: Option<&'a mut RecordCollection>,
    /// The person gives a verdict on each hit.
    pub confirm: bool,
    /// Finish at the target without asking.
    pub yes: bool,
}

/// Follows the running campaign with a person at the keyboard.
pub(in crate::commands) fn watch(
    client: &mut Client,
    layout: &RigLayout,
    watching: Watching<'_>,
    output: &mut Output,
) -> Result<CampaignOutcome> {
    let interrupt = output.interrupt().clone();
    let keyboard = if output.has_keyboard() {
        let taken = Keyboard::take();
        taken.map_err(|e| Error::internal("no_keyboard", format!("the terminal: {e}")))?
    } else {
        None
    };
    output.set_raw(keyboard.is_some());
    if keyboard.is_some() {
        output.note(keyboard::HELP);
    }
    let Watching { monitor, collection, records, confirm, yes } = watching;
    let accepts = collection.is_some() && !confirm;
    let prompts = if accepts { Prompts::Hits } else { Prompts::HitsAndVerdicts };
    let progress = Progress::new(output, "hits", layout, prompts);
    let mut person = Person { progress, keyboard, monitor, yes, accepts, asked: false };
    let ending = match collection {
        Some(collection) => {
            let records = records.map(|records| (records, layout));
            let mut collecting = Collecting { observer: &mut person, collection, records, accepts };
            follow(client, &interrupt, None, &mut collecting)
        }
        None => follow(client, &interrupt, None, &mut person),
    };
    drop(person);
    output.set_raw(false);
    ending
}

/// The operator with a hammer, who may have a keyboard.
struct Person<'o> {
    progress: Progress<'o>,
    keyboard: Option<Keyboard>,
    monitor: Option<&'o mut PrecisionMonitor>,
    /// Finish at the target without asking.
    yes: bool,
    /// The program gives the verdicts.
    accepts: bool,
    /// The question at the target has been asked.
    asked: bool,
}

impl Person<'_> {
    /// Reads the mass lines of the DOFs that have been closed meanwhile, and reports the precision with them.
    fn follow_precision(&mut self, client: &mut Client, status: &Status) -> Result<()> {
        let Some(monitor) = &mut self.monitor else { return Ok(()) };
        let at_target = is_at_target(status);
        if read_new(client, monitor, status, |dof| dof != status.dof || at_target)? {
            self.progress.line(&monitor.report().to_text());
        }
        Ok(())
    }

    /// The question at the target.
    fn question(&mut self) -> String {
        let reached = self.monitor.as_mut().map_or_else(
            || "target reached".to_owned(),
            |monitor| {
                let report = monitor.latest();
                format!("target reached after {}: {}", report.progress(), report.widths())
            },
        );
        if self.asks() {
            format!("{reached}; finish now? [Y/n]")
        } else {
            format!("{reached}; finishing")
        }
    }

    /// Only good hits wait for a verdict; the rig has been asked to wait by another program or on its panel.
    fn accept_unasked(&mut self, status: &Status) -> OperatorAction {
        self.progress.line(&format!(
            "hit {} is accepted: the rig asks for a verdict, and there is no keyboard to give it",
            status.last_hit
        ));
        OperatorAction::Command(CampaignCommand::Accept)
    }

    fn asks(&self) -> bool {
        self.keyboard.is_some() && !self.yes
    }

    fn poll(&mut self, status: &Status) -> Result<Option<OperatorAction>> {
        let Some(keyboard) = &mut self.keyboard else { return Ok(None) };
        keyboard
            .poll(Phase::try_from(status.phase).ok())
            .map_err(|e| Error::internal("no_keyboard", format!("the terminal: {e}")))
    }
}

/// Reads the mass lines of the DOFs that are `closed` and not known yet; returns whether there were any. A DOF that is
/// open again, because its last hit was undone, is forgotten.
pub(super) fn read_new(
    client: &mut Client,
    monitor: &mut PrecisionMonitor,
    status: &Status,
    closed: impl Fn(u8) -> bool,
) -> Result<bool> {
    let mut new = false;
    open_dof(status).into_iter().for_each(|dof| monitor.forget(dof));
    for (index, &hits) in (0..).zip(&status.accepted) {
        if hits > 0
            && closed(index)
            && !monitor.knows(index)
            && let Some(dof) = client.mass_lines(index)?
        {
            monitor.add(dof);
            new = true;
        }
    }
    Ok(new)
}

fn is_at_target(status: &Status) -> bool {
    Phase::try_from(status.phase).ok() == Some(Phase::TargetReached)
}

impl Observer for Person<'_> {
    fn status(&mut self, status: &Status) {
        self.progress.status(status);
    }

    fn hit(&mut self, hit: &HitEvent) {
        self.progress.hit(hit);
    }

    fn steer(&mut self, client: &mut Client, status: &Status) -> Result<Option<OperatorAction>> {
        self.asked = false;
        self.follow_precision(client, status)?;
        let waits = Phase::try_from(status.phase).ok() == Some(Phase::Confirming);
        if self.keyboard.is_none() && waits && !self.accepts {
            return Ok(Some(self.accept_unasked(status)));
        }
        self.poll(status)
    }

    fn at_target(
        &mut self,
        client: &mut Client,
        status: &Status,
    ) -> Result<Option<OperatorAction>> {
        self.follow_precision(client, status)?;
        if !self.asked {
            self.asked = true;
            let question = self.question();
            self.progress.line(&question);
        }
        if self.asks() {
            return self.poll(status);
        }
        Ok(Some(OperatorAction::Command(CampaignCommand::Conclude)))
    }

    fn refused(&mut self, command: CampaignCommand, reason: Reason) {
        self.progress.refused(command, reason);
    }
}

//! `massline measure`: a campaign on a real rig, from the layout to the result.

use std::path::PathBuf;

use massline_protocol::LayoutHash;
use massline_protocol::event::HitEvent;
use massline_protocol::message::{CampaignCommand, Identity, LayoutAnswer, Status};
use massline_shared::calibration::CalibrationRecord;
use massline_shared::diagnosis::Diagnostic;
use massline_shared::layout::RigLayout;
use massline_shared::measurement::campaign::Phase;

use super::connect::PortArgs;
use super::files;
use super::keyboard::{self, Keyboard};
use super::progress::{Progress, Prompts};
use super::{hash, show};
use crate::calibration::day::Day;
use crate::campaign::phase_name;
use crate::campaign::{
    CampaignOutcome, Observer, OperatorAction, StartOptions, StartOutcome, begin, follow,
};
use crate::client::Client;
use crate::error::{Error, Result};
use crate::identification::Selection;
use crate::layout_file::LayoutFile;
use crate::output::Output;
use crate::report;
use crate::single_fault::NominalTest;
use crate::spectra::{Collecting, SpectraCollection};

/// Arguments of `massline measure`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
While it runs (when the keyboard is a terminal): a accept, r reject, d redo the DOF, s skip it,
f finish it with the hits it has, p or Ctrl-C pause, q q abort.
A paused campaign keeps every accepted hit; the same command goes on with it.

Examples:
  massline measure frame.toml
  massline measure frame.toml --port /dev/ttyACM0 --confirm
  massline measure frame.toml --restart --json > result.json")]
pub struct Args {
    /// The layout file.
    layout: PathBuf,
    #[command(flatten)]
    port: PortArgs,
    /// Ask for a verdict on each hit.
    #[arg(long)]
    confirm: bool,
    /// Discard a campaign that is running or interrupted.
    #[arg(long)]
    restart: bool,
    /// Start although the layout cannot determine all ten properties.
    #[arg(long)]
    force: bool,
    /// Calibration file; default: the calibration stored on the rig.
    #[arg(long, value_name = "FILE")]
    calibration: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// When a file is bad, the rig cannot be reached or refuses, the data cannot determine the answer, or the
/// user interrupts the command.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    let file = LayoutFile::read(&args.layout)?;
    files::for_rig(&file, &args.layout)?;
    let calibration = files::calibration(args.calibration.as_deref(), &file)?;
    if args.confirm && !output.has_keyboard() {
        return Err(Error::input(
            "no_keyboard",
            "--confirm asks for a verdict on each hit, and there is no keyboard: run it in a \
             terminal or leave --confirm out",
        ));
    }
    let (mut client, identity) = args.port.connect()?;
    let kept = client.calibration()?;
    let layout = files::for_rig(&file, &args.layout)?;
    fits(&layout, &identity)?;
    make_room(&mut client, &layout, args.restart)?;
    let answer = client.put_layout(&layout)?;
    judge_layout(&answer, &layout, args.force, output)?;
    if let Some(calibration) = &calibration
        && kept != *calibration
    {
        client.put_calibration(calibration)?;
    }
    let how = StartOptions {
        confirm: args.confirm,
        force: args.force,
        restart: args.restart,
        calibration_age_days: age_in_days(calibration.as_ref().unwrap_or(&kept)),
        ..StartOptions::default()
    };
    match begin(&mut client, how)? {
        StartOutcome::Started => {}
        StartOutcome::Resumed => output.note("resuming the interrupted campaign"),
        StartOutcome::Joined => output.note("joins the campaign that is under way"),
    }
    let ending = watch(&mut client, &layout, None, output)?;
    finish(&mut client, &ending, &NominalTest::of_file(&file), output)
}

/// Age of a calibration by the clock of this computer, days; zero when it has no date or one in the future.
fn age_in_days(record: &CalibrationRecord) -> u16 {
    record.date.parse().map_or(0, |day: Day| day.age_in_days())
}

/// Rejects a layout that the rig has no inputs or memory for, before anything is sent.
pub fn fits(layout: &RigLayout, identity: &Identity) -> Result<()> {
    let (sensors, hits) = (layout.sensors.len(), layout.hits.len());
    if sensors <= usize::from(identity.max_sensors) && hits <= usize::from(identity.max_hits) {
        return Ok(());
    }
    Err(Error::input(
        "layout_too_large",
        format!(
            "the layout has {sensors} sensors and {hits} hits; this rig takes {} and {}",
            identity.max_sensors, identity.max_hits,
        ),
    ))
}

/// Ensures that the rig can accept the layout: aborts a campaign with another layout if `restart` is set.
pub(super) fn make_room(client: &mut Client, layout: &RigLayout, restart: bool) -> Result<()> {
    let status = client.status()?;
    let resting = matches!(Phase::try_from(status.phase).ok(), Some(Phase::Idle | Phase::Done));
    if resting || (status.layout_hash == layout.hash() && !restart) {
        return Ok(());
    }
    if !restart {
        return Err(Error::device(
            "another_campaign",
            format!(
                "the rig is {} in a campaign with another layout ({}); go on with it by `massline \
                 measure` with that layout, or forget it with --restart",
                phase_name(status.phase),
                hash(status.layout_hash).unwrap_or_default(),
            ),
        ));
    }
    client.command(CampaignCommand::Abort)?;
    Ok(())
}

/// Reports the rig's diagnostics of the layout; an error among them ends the command unless `force` is set.
pub fn judge_layout(
    answer: &LayoutAnswer,
    layout: &RigLayout,
    force: bool,
    output: &mut Output,
) -> Result<()> {
    let message_of = |d: &Diagnostic| report::message_in(d, layout);
    if let Some(error) = show::first_error(&answer.diagnostics, message_of)
        && !force
    {
        return Err(error);
    }
    show::warn(&answer.diagnostics, message_of, output);
    Ok(())
}

/// Follows the running campaign with a person at the keyboard. With a `collection` for spectra, good hits are
/// accepted without asking.
pub(super) fn watch(
    client: &mut Client,
    layout: &RigLayout,
    collection: Option<&mut SpectraCollection>,
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
    let prompts = if collection.is_some() { Prompts::Hits } else { Prompts::HitsAndVerdicts };
    let progress = Progress::new(output, "hits", layout, prompts);
    let mut person = Person { progress, keyboard };
    let ending = match collection {
        Some(collection) => {
            let mut collecting = Collecting { observer: &mut person, collection };
            follow(client, &interrupt, None, &mut collecting)
        }
        None => follow(client, &interrupt, None, &mut person),
    };
    drop(person);
    output.set_raw(false);
    ending
}

/// The result, or the reason why there is none.
fn finish(
    client: &mut Client,
    ending: &CampaignOutcome,
    nominal: &NominalTest,
    output: &mut Output,
) -> Result<()> {
    match ending {
        CampaignOutcome::Done(number) => {
            let result = client.result(*number)?;
            show::measurement(&result, Some(nominal), Selection::All, output)
        }
        CampaignOutcome::Stopped(status) => Err(show::stopped(status)),
        CampaignOutcome::Paused(status) => Err(paused(status)),
        CampaignOutcome::Aborted => {
            Err(Error::interrupted("the campaign was aborted; it has no result"))
        }
    }
}

pub(super) fn paused(status: &Status) -> Error {
    let accepted: u32 = status.accepted.iter().map(|&n| u32::from(n)).sum();
    Error::interrupted(format!(
        "the campaign is interrupted; the rig keeps the {accepted} accepted hits: the same command \
         resumes it, --restart starts over"
    ))
}

/// The operator with a hammer, who may have a keyboard.
struct Person<'o> {
    progress: Progress<'o>,
    keyboard: Option<Keyboard>,
}

impl Observer for Person<'_> {
    fn status(&mut self, status: &Status) {
        self.progress.status(status);
    }

    fn hit(&mut self, hit: &HitEvent) {
        self.progress.hit(hit);
    }

    fn steer(&mut self, _: &mut Client, status: &Status) -> Result<Option<OperatorAction>> {
        let Some(keyboard) = &mut self.keyboard else { return Ok(None) };
        keyboard
            .poll(Phase::try_from(status.phase).ok())
            .map_err(|e| Error::internal("no_keyboard", format!("the terminal: {e}")))
    }

    fn refused(&mut self, command: CampaignCommand) {
        self.progress.refused(command);
    }
}

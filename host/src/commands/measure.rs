//! `massline measure`: a campaign on a real rig, from the layout to the result.

mod full_screen;
mod presenter;
mod ringing;
mod watch;

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use massline_protocol::LayoutHash;
use massline_protocol::message::{Reason, Status};
use massline_protocol::object::MeasurementResult;
use massline_result::{FilePath, TestResult};
use massline_shared::calibration::CalibrationRecord;
use massline_shared::layout::{HostLayout, RigLayout, TestProfile};
use massline_shared::measurement::campaign::{Command, Phase};
use massline_shared::signal::{AdcProperties, COMPACT_RESPONSE, ringing_s};

use crate::output::{Output, counted};
use crate::rig_lines::{RigLines, StoredTest};
use crate::rig_solution::solve_test;
use crate::support::archive::ArchiveArgs;
use crate::support::collected::CollectedData;
use crate::support::collected::archive_part::Part;
use crate::support::connect::PortArgs;
use crate::support::files;
use crate::support::rest::begun;
use crate::support::rig_layout::{fits, judge_layout};
use crate::support::show::{self, DetailsArgs, NextStep};
use crate::{Error, Result};
use massline_analysis::identification::Selection;
use massline_analysis::modes_so_far::ModesMonitor;
use massline_analysis::precision::PrecisionMonitor;
use massline_analysis::single_fault::NominalTest;
use massline_client::campaign::phase_name;
use massline_client::campaign::{CampaignOutcome, StartOptions, StartOutcome, begin, restarted};
use massline_client::{Client, ClientError};
use massline_files::archive::{Archive, ArchivedLayout, EXTENSION};
use massline_files::clock;
use massline_files::day::age_in_days;
use massline_report::words;
use massline_report::words::modes_so_far;

pub(super) use full_screen::DisplayedCampaign;
pub use full_screen::ScreenArgs;
pub(super) use watch::{Watching, watch};

/// Arguments of `massline measure`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
On a terminal, a full screen shows where to hit, the last hit and the intervals;
--plain prints lines.
While it runs (when the keyboard is a terminal): a accept, r reject, u undo the last hit,
d redo the DOF, s skip it, f finish it with the hits it has, p or Ctrl-C pause, q q abort.
Until the next hit, u takes back the last accepted one, also the one that finished a DOF,
but not the last hit of the test.
A paused campaign keeps every accepted hit; the same command goes on with it.

After each DOF the 95 % intervals so far are printed, and which further hit of the layout would
narrow the worst of them most. With a [target] table in the layout, the command asks whether to
finish as soon as the target is reached; without a keyboard or with --yes it finishes.

With the suspension profile, which the layout states as profile = 'suspension' in [test], each record
takes 40 s: hit with a soft mallet, let the object ring without touching it, and wait until it hangs
still before the next hit.

Examples:
  massline measure frame.toml
  massline measure wheel.toml --profile suspension
  massline measure frame.toml --port /dev/ttyACM0 --confirm
  massline measure frame.toml --output frame.massline
  massline measure frame.toml --restart --yes --json > result.json")]
pub struct Args {
    /// The layout file.
    layout: PathBuf,
    /// Measure this instead of what the layout states: its settings that the layout leaves out have the defaults of
    /// this profile.
    #[arg(long, value_name = "PROFILE", value_parser = profile())]
    profile: Option<TestProfile>,
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
    any_layout: bool,
    /// Finish without asking when the target of the layout is reached.
    #[arg(long)]
    yes: bool,
    #[command(flatten)]
    screen: ScreenArgs,
    /// Calibration file; default: the calibration stored on the rig.
    #[arg(long, value_name = "FILE")]
    calibration: Option<PathBuf>,
    #[command(flatten)]
    archive: ArchiveArgs,
    #[command(flatten)]
    details: DetailsArgs,
    /// Keep the record of every accepted hit in the archive as well, about 0.1 MB each; not in the suspension profile.
    #[arg(long, requires = "output")]
    records: bool,
}

/// Runs the command.
///
/// # Errors
/// When a file is bad, the rig cannot be reached or refuses, the data cannot determine the answer, or the
/// user interrupts the command.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    let file = files::layout_in_profile(&args.layout, args.profile, output)?;
    files::for_rig(&file, &args.layout)?;
    args.archive.check()?;
    let calibration = files::calibration(args.calibration.as_deref(), &file)?;
    if args.confirm && !output.has_keyboard() {
        return Err(Error::input(
            "no_keyboard",
            "--confirm asks for a verdict on each hit, and there is no keyboard: run it in a \
             terminal or leave --confirm out",
        ));
    }
    let profile = file.layout.test.profile;
    if args.records && profile == TestProfile::Suspension {
        return Err(Error::input(
            "usage",
            "--records keeps records of half a second: a rig does not give those of the suspension profile; leave it \
             out",
        ));
    }
    let (mut client, identity) = args.port.connect(output)?;
    let kept = client.calibration()?;
    let layout = files::for_rig(&file, &args.layout)?;
    fits(&layout, &identity)?;
    make_room(&mut client, &layout, args.restart)?;
    let answer = client.put_layout(&layout)?;
    judge_layout(&answer, &layout, args.any_layout, output)?;
    if let Some(calibration) = &calibration
        && kept != *calibration
    {
        client.put_calibration(calibration)?;
    }
    let in_force = calibration.as_ref().unwrap_or(&kept);
    let age = age_in_days(in_force);
    if in_force.budget().is_some() && in_force.date.is_empty() {
        output.note(
            "the calibration has no date (a rig that calibrates itself has no calendar): the growth of its \
             deviations with age is left out",
        );
    }
    let on_screen = args.screen.wants_screen(output);
    let shown = on_screen.then_some(DisplayedCampaign {
        kind: "measurement",
        title: &file.title,
        identity: &identity,
        calibration: in_force,
    });
    let with_gains = with_gains(&file.layout, in_force, age);
    let mut monitors = Monitors::new(with_gains, identity.adc);
    let how = StartOptions {
        // A hit that waits for its verdict leaves time to read spectra and records.
        confirm: args.confirm || args.archive.path().is_some() || on_screen,
        force: args.any_layout,
        restart: args.restart,
        started_unix_s: clock::unix_seconds(),
        ..StartOptions::default()
    };
    let earlier = earlier_result(&mut client, &layout)?;
    let board = identity.board.as_str();
    let began = begin(&mut client, how).map_err(|error| advised(error, board, &layout));
    match began? {
        StartOutcome::Started => earlier.iter().for_each(|note| output.note(note)),
        StartOutcome::Resumed => output.note("resuming the interrupted campaign"),
        StartOutcome::Joined => output.note("joins the campaign that is under way"),
    }
    let archive = args.archive.path();
    let mut collected = CollectedData::of_campaign(archive, &layout, &mut client)?;
    let record_s = (profile == TestProfile::Suspension).then(|| ringing_s(&identity.adc));
    let followed = follow(
        (args, record_s),
        &mut client,
        &layout,
        (&mut monitors, shown),
        &mut collected,
        output,
    );
    if followed.is_err() {
        collected.keep(&layout, output);
    }
    let result = followed?;
    let lines = RigLines::read(&mut client, identity.adc, &result)?;
    let nominal = NominalTest::of_file(&file);
    let test = StoredTest { result: &result, lines: &lines };
    let solution = solve_test(test, &nominal, Selection::All);
    let mut answers = solution.result();
    answers.archive = archive.map(FilePath::from);
    if archive.is_some() {
        answers.hit_log = collected.hit_log_of(&result, &layout);
    }
    monitors.add_to(&mut answers);
    if solution.no_answer.is_some() {
        explain_modes(&answers, output);
    }
    let next = match archive {
        // Said once the file is there.
        Some(_) => NextStep::Other(String::new()),
        None => NextStep::Other(format!(
            "next: `massline results get {0} -o result-{0}.{EXTENSION}{1}` keeps it in a file",
            result.head.number,
            args.port.as_typed()
        )),
    };
    output.conclude(answers.verdict);
    // The answer is printed first: a disk that is full must not cost it.
    let printed = show::print(&solution, &answers, (args.details.extent(), &next), output);
    if let Some(path) = archive {
        let archived = ArchivedLayout::of_file(&file);
        let mut archive = Archive::new(&identity, archived, in_force, result, Some(answers));
        archive.lines = lines.into_dofs();
        let archive = collected.added_to(archive, &layout, args.records, output);
        args.archive.write_anywhere(&archive, output)?;
        args.archive.propose_report(output);
        Part::delete(path);
    }
    printed
}

/// Tells which modes the points have shown, where they have no answer.
fn explain_modes(result: &TestResult, output: &mut Output) {
    if let Some(last) = result.modes_after_each_dof.last() {
        output.note(modes_so_far::text(last));
    }
}

/// What is told after each DOF: the precision of mass lines so far, or the suspension modes so far.
struct Monitors {
    precision: Option<PrecisionMonitor>,
    modes: Option<ModesMonitor>,
}

impl Monitors {
    /// For this layout on a rig with this converter.
    fn new(layout: HostLayout, adc: AdcProperties) -> Self {
        match layout.test.profile {
            TestProfile::MassLine => {
                Self { precision: Some(PrecisionMonitor::new(layout)), modes: None }
            }
            TestProfile::Suspension => {
                Self { precision: None, modes: Some(ModesMonitor::new(layout, adc)) }
            }
        }
    }

    /// Adds what was told to the result.
    fn add_to(self, result: &mut TestResult) {
        result.after_each_dof =
            self.precision.map(PrecisionMonitor::into_reports).unwrap_or_default();
        result.modes_after_each_dof =
            self.modes.map(ModesMonitor::into_reports).unwrap_or_default();
    }
}

/// Follows the campaign to its result, and reads what the archive is to hold.
fn follow(
    (args, record_s): (&Args, Option<f64>),
    client: &mut Client,
    layout: &RigLayout,
    (monitors, shown): (&mut Monitors, Option<DisplayedCampaign<'_>>),
    collected: &mut CollectedData,
    output: &mut Output,
) -> Result<MeasurementResult> {
    let archived = args.archive.path().is_some();
    let watching = Watching {
        monitor: monitors.precision.as_mut(),
        modes: monitors.modes.as_mut(),
        collection: archived.then_some(&mut collected.spectra),
        records: args.records.then_some(&mut collected.records),
        log: archived.then_some(&mut collected.log),
        confirm: args.confirm,
        yes: args.yes,
        record_s,
        shown,
    };
    let number = match watch(client, layout, watching, output)? {
        CampaignOutcome::Done(number) => number,
        CampaignOutcome::Stopped(status) => return Err(show::stopped(&status)),
        CampaignOutcome::Paused(status) => {
            collected.spectra.followed.status(&status);
            return Err(paused(&status));
        }
        CampaignOutcome::Restarted(status) => {
            match Phase::try_from(status.phase).ok() {
                Some(Phase::Paused) => collected.spectra.followed.status(&status),
                _ => collected.discard(),
            }
            return Err(restarted(&status));
        }
        CampaignOutcome::Aborted => {
            collected.discard();
            return Err(Error::interrupted("the campaign was aborted; it has no result"));
        }
    };
    let result = client.result(number)?;
    let status = client.status()?;
    if let Some(monitor) = &mut monitors.precision
        && watch::read_new(client, monitor, &status, |_| true)?
    {
        monitor.report();
    }
    if let Some(monitor) = &mut monitors.modes
        && (watch::read_new_lines(client, monitor, &status, number, |_| true)?
            || monitor.is_outdated(&[]))
    {
        // No point is left.
        monitor.report(&[]);
    }
    if archived {
        // Those of the last DOF.
        collected.spectra.collect(client, &status)?;
    }
    Ok(result)
}

/// A parser for the name of a profile.
pub(super) fn profile() -> impl TypedValueParser<Value = TestProfile> {
    let names = PossibleValuesParser::new(TestProfile::ALL.map(TestProfile::name));
    names.try_map(|name| TestProfile::from_name(&name).ok_or("there is no profile of this name"))
}

/// What is said of the last result that the rig keeps of this layout, which may be the one that was to be measured.
fn earlier_result(client: &mut Client, layout: &RigLayout) -> Result<Option<String>> {
    let hash = layout.hash();
    let last = client.results()?.into_iter().rfind(|entry| entry.layout_hash == hash);
    Ok(last.map(|entry| {
        let number = entry.number;
        format!(
            "a new test; the rig keeps result {number} of this layout: `massline results get {number}` fetches it"
        )
    }))
}

/// The refusal to start, with what helps against a full store: lines take much room.
fn advised(error: ClientError, board: &str, layout: &RigLayout) -> Error {
    let ClientError::Refused { reason, results_to_delete, .. } = error else { return error.into() };
    let error = Error::from(error);
    if reason != Reason::StoreFull as u16 || layout.test.profile != TestProfile::Suspension {
        return error;
    }
    let help = match results_to_delete {
        0 => "every board holds six hit points with nine responses",
        _ => {
            "keep old results with `massline results get N --output FILE` before you delete them, and repeat the \
             command"
        }
    };
    error.advising(format!(
        "on this board, {board}, the lines of {} need {} kB: {help}",
        counted(layout.hits.len() as u32, "hit point"),
        (layout.hits.len() * 3 * layout.sensors.len() * COMPACT_RESPONSE).div_ceil(1000),
    ))
}

/// The layout with the standard deviations that a calibration of this age, in days, contributes.
fn with_gains(layout: &HostLayout, record: &CalibrationRecord, age: u16) -> HostLayout {
    let mut layout = layout.clone();
    if let Some(gains) = record.budget() {
        gains.aged(age).apply_to(&mut layout);
    }
    layout
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
                "the rig is {} in {} with another layout ({}); go on with it by that command and that layout, or \
                 discard its hits with `massline device abort` or --restart",
                phase_name(status.phase),
                begun(&status),
                words::hash_text(status.layout_hash).unwrap_or_default(),
            ),
        ));
    }
    client.command(Command::Abort)?;
    Ok(())
}

pub(super) fn paused(status: &Status) -> Error {
    let accepted: u32 = status.accepted.iter().map(|&n| u32::from(n)).sum();
    Error::interrupted(format!(
        "the campaign is interrupted; the rig keeps the {}: the same command resumes it, --restart starts over",
        counted(accepted, "accepted hit")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use massline_files::layout_file::LayoutFile;

    #[test]
    fn a_full_store_is_explained_by_what_the_lines_need() {
        let refused = |results_to_delete| ClientError::Refused {
            request: "start a campaign",
            reason: Reason::StoreFull as u16,
            results_to_delete,
        };
        let full = || refused(2);
        let wheel = include_str!("../../examples/wheel.toml");
        let wheel = LayoutFile::parse(wheel, "wheel.toml").unwrap().rig_layout().unwrap();
        let message = advised(full(), "blackpill-f411", &wheel).to_string();
        // Five DOFs with nine responses of 513 bytes.
        assert!(
            message.contains(
                "on this board, blackpill-f411, the lines of 5 hit points need 24 kB: keep"
            ),
            "{message}"
        );
        assert!(message.contains("delete the 2 oldest results"), "{message}");
        let never = advised(refused(0), "blackpill-f411", &wheel).to_string();
        for says in ["cannot hold a test of so many hit points", "blackpill-f411", "six hit points"]
        {
            assert!(never.contains(says), "{never}");
        }
        let frame = include_str!("../../examples/three-bar-test-1.toml");
        let frame = LayoutFile::parse(frame, "frame.toml").unwrap().rig_layout().unwrap();
        assert_eq!(advised(full(), "", &frame).to_string(), Error::from(full()).to_string());
    }
}

//! `massline results get`.

use std::path::PathBuf;

use massline_protocol::object::MeasurementResult;
use massline_shared::layout::HostLayout;

use crate::output::{Output, shell_path};
use crate::rig_lines::{RigLines, StoredTest};
use crate::rig_solution::solve_test;
use crate::support::archive::ArchiveArgs;
use crate::support::connect::PortArgs;
use crate::support::files;
use crate::support::show::{self, DetailsArgs, NextStep};
use crate::{Error, Result};
use massline_analysis::identification::Selection;
use massline_analysis::single_fault::NominalTest;
use massline_client::Client;
use massline_files::archive::{Archive, ArchivedLayout, EXTENSION};
use massline_files::layout_file::LayoutFile;
use massline_report::words::hash_text;
use massline_report::words::result_of_rig;
use massline_result::{FilePath, TestResult};

/// Arguments of `massline results get`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
An archive holds what the rig has stored: mass lines or, in the suspension profile, the frequency
responses, scatter and number of the hits, the answers of all methods, layout and calibration. Other
frequency responses are in it only when `massline measure
--output` wrote it, because a rig does not store them.

Examples:
  massline results get 3
  massline results get 3 --json
  massline results get 3 --output frame.massline")]
pub struct Args {
    /// Number of the result in the list.
    #[arg(value_parser = clap::value_parser!(u32).range(1..))]
    number: u32,
    /// The layout file of the test; default: the layout that the rig has stored, one of the last four.
    #[arg(long, value_name = "FILE")]
    layout: Option<PathBuf>,
    #[command(flatten)]
    archive: ArchiveArgs,
    #[command(flatten)]
    details: DetailsArgs,
    #[command(flatten)]
    port: PortArgs,
}

/// Runs the command.
///
/// # Errors
/// When the rig cannot be reached or has no such result, the layout is that of another test, or the archive cannot be
/// written.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    args.archive.check()?;
    let (mut client, identity) = args.port.connect(output)?;
    let result = client.result(args.number)?;
    let lines = RigLines::read(&mut client, identity.adc, &result)?;
    let layout = layout(args, &mut client, &result, output)?;
    if args.archive.path().is_some() && layout.is_none() {
        return Err(no_layout(&result));
    }
    let test = StoredTest { result: &result, lines: &lines };
    let next = match (args.archive.path(), &layout) {
        // Said once the file is there.
        (Some(_), _) => NextStep::Other(String::new()),
        (None, Some(_)) => {
            let layout = args.layout.as_deref().map(shell_path);
            let layout = layout.map(|path| format!(" --layout {path}")).unwrap_or_default();
            NextStep::Other(format!(
                "next: `massline results get {} -o result-{0}.{EXTENSION}{layout}{}` keeps it in a file",
                args.number,
                args.port.as_typed()
            ))
        }
        (None, None) => NextStep::Other(
            "next: with the layout of the test (--layout FILE) the program solves it itself".into(),
        ),
    };
    let next = (args.details.extent(), &next);
    let (answers, printed) = match &layout {
        Some(layout) => {
            let solution = solve_test(test, &NominalTest::of_archive(layout), Selection::All);
            let archive = args.archive.path().map(FilePath::from);
            let answers = TestResult { archive, ..solution.result() };
            let printed = show::print(&solution, &answers, next, output);
            (Some(answers), printed)
        }
        None => {
            let of_rig = show::require_answer(&result).map(|()| result_of_rig(&result));
            (None, of_rig.and_then(|of_rig| show::print_result(&of_rig, next, output)))
        }
    };
    if args.archive.path().is_some() {
        let layout = layout.ok_or_else(|| no_layout(&result))?;
        let mut archive = Archive::new(&identity, layout, &client.calibration()?, result, answers);
        archive.lines = lines.into_dofs();
        if archive.calibration().is_none() {
            output.warn(
                "the rig has another calibration by now than the result was measured with: the archive has none",
            );
        }
        args.archive.write(&archive, output)?;
        args.archive.propose_report(output);
    }
    printed
}

/// The layout of the test: that of the file, in the profile that was measured, or that of the rig unless it has
/// replaced it by another one.
fn layout(
    args: &Args,
    client: &mut Client,
    result: &MeasurementResult,
    output: &mut Output,
) -> Result<Option<ArchivedLayout>> {
    let wanted = result.head.layout_hash;
    if let Some(path) = &args.layout {
        let mut file = files::layout(path, output)?;
        if file.hash() != Some(wanted)
            && let Ok(in_profile) = LayoutFile::read_in_profile(path, Some(result.profile()))
            && in_profile.hash() == Some(wanted)
        {
            // It was measured with `--profile`.
            file = in_profile;
        }
        if file.hash() != Some(wanted) {
            let message = format!(
                "{}: this layout is not that of result {} (layout {} was measured): give the file as it was then, or \
                 leave --layout out for the layout that the rig has stored",
                path.display(),
                args.number,
                hash_text(wanted).unwrap_or_default()
            );
            return Err(Error::input("another_layout", message));
        }
        return Ok(Some(ArchivedLayout::of_file(&file)));
    }
    let layout: Option<HostLayout> = client.stored_layout(wanted)?.and_then(|kept| kept.cast());
    Ok(layout.map(ArchivedLayout::of_rig))
}

fn no_layout(result: &MeasurementResult) -> Error {
    let message = format!(
        "an archive needs the layout of the test ({}), and the rig has replaced it by others; give its file with \
         --layout",
        hash_text(result.head.layout_hash).unwrap_or_default()
    );
    Error::input("layout_unknown", message)
}

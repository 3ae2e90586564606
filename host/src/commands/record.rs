//! `massline record`: records a rig's live scans on a tape.
//!
//! If the link is fast enough, the stream of all scans is written, and this program finds the hits in it.
//! Otherwise a campaign runs in which every hit waits for its verdict until its record has been read.

mod finder;
mod stream;
mod triggered;

use std::path::{Path, PathBuf};

use massline_protocol::LayoutHash;
use massline_protocol::message::Identity;
use massline_shared::layout::{RigLayout, TestProfile};
use massline_shared::signal::{Calibration, PRE_TRIGGER_SCANS};

use crate::output::Output;
use crate::support::connect::PortArgs;
use crate::support::files;
use crate::support::files::ReplaceArgs;
use crate::support::rest::without_campaign;
use crate::support::rig_layout::{fits, judge_layout};
use crate::{Error, Result};
use massline_files::file::ExistingFile;
use massline_files::tape::{Sidecar, TapeWriter};
use massline_report::document::RecordedTape;

/// Arguments of `massline record`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Hit each DOF when prompted. The tape gets a sidecar of the same name with .toml. A gap in the scans
ends the recording with exit 4; what came before it is kept. Until the tape is complete it is called
OUT.partial.npy: a recording that is killed leaves it, and it can be replayed.
With the stream, hits are found in it by the trigger of [test]; with --triggered, or where the link
is too slow, the rig runs a campaign and each good hit's record is read. In the suspension profile
there is the stream only: a rig does not keep the scans of 40 s.

Examples:
  massline record frame.toml --output frame-tape.npy
  massline record frame.toml --output frame-tape.npy --triggered
  massline replay frame-tape.npy --layout frame.toml")]
pub struct Args {
    /// The layout file.
    layout: PathBuf,
    /// The tape to write.
    #[arg(short, long, value_name = "OUT.npy")]
    output: PathBuf,
    #[command(flatten)]
    replace: ReplaceArgs,
    #[command(flatten)]
    port: PortArgs,
    /// Read the record of each hit instead of the stream.
    #[arg(long)]
    triggered: bool,
    /// Discard a campaign that is running or interrupted.
    #[arg(long)]
    restart: bool,
    /// Calibration file; default: the calibration stored on the rig.
    #[arg(long, value_name = "FILE")]
    calibration: Option<PathBuf>,
}

/// The inputs of a recording.
struct Recording<'a> {
    layout: &'a RigLayout,
    calibration: &'a Calibration,
    identity: &'a Identity,
}

/// Runs the command.
///
/// # Errors
/// When a file is bad or cannot be written, the rig cannot be reached, scans are missing, or the user
/// interrupts the command.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    let file = files::layout(&args.layout, output)?;
    let layout = files::for_rig(&file, &args.layout)?;
    let given = files::calibration(args.calibration.as_deref(), &file)?;
    if args.triggered {
        has_records(&layout)?;
    }
    TapeWriter::check(&args.output, args.replace.existing())?;
    let (mut client, identity) = args.port.connect(output)?;
    fits(&layout, &identity)?;
    without_campaign(&mut client, args.restart)?;
    let calibration = match given {
        Some(calibration) => {
            client.put_calibration(&calibration)?;
            calibration.calibration
        }
        None => client.calibration()?.calibration,
    };
    let recording = Recording { layout: &layout, calibration: &calibration, identity: &identity };
    let triggered = args.triggered || !identity.streams;
    if triggered {
        has_records(&layout)?;
    }
    if triggered && !args.triggered {
        output.note("the link is too slow for the stream: the record of each hit is read");
    }
    if triggered {
        judge_layout(&client.put_layout(&layout)?, &layout, false, output)?;
    }
    let mut writer = recording.writer(&args.output, args.replace.existing())?;
    let recorded = if triggered {
        triggered::record(&mut client, &recording, &mut writer, output)
    } else {
        stream::record(&mut client, &recording, &mut writer, output)
    };
    let segments = match recorded {
        Ok(segments) => segments,
        Err(error) => return Err(keep_tape(error, writer, &args.output)),
    };
    let scans = writer.finish()?;
    let value = RecordedTape { tape: (&args.output).into(), scans, segments };
    output.answer(&value, |_| format!("{}: {scans} scans, {segments} hits", args.output.display()))
}

/// Refuses to read records of hits that are not kept as scans.
fn has_records(layout: &RigLayout) -> Result<()> {
    match layout.test.profile {
        TestProfile::MassLine => Ok(()),
        TestProfile::Suspension => Err(Error::input(
            "usage",
            "a record of the suspension profile is not kept as scans: it is taken from the stream, without --triggered \
             and over USB",
        )),
    }
}

/// The error of a recording, with what is left of its tape.
fn keep_tape(error: Error, writer: TapeWriter, path: &Path) -> Error {
    match writer.keep() {
        Ok(Some(scans)) => {
            error.within(format!("{} has the {scans} scans before this", path.display()))
        }
        Ok(None) => {
            error.within(format!("{} is not written, because it would have no hit", path.display()))
        }
        // A tape that cannot be written is usually the error itself.
        Err(at_end) if at_end.code() == error.code() => at_end,
        Err(at_end) => error.within(at_end),
    }
}

impl Recording<'_> {
    fn writer(&self, path: &Path, existing: ExistingFile) -> Result<TapeWriter> {
        let sidecar = Sidecar {
            adc: self.identity.adc,
            calibration: *self.calibration,
            pre_trigger_scans: PRE_TRIGGER_SCANS as u32,
            layout_hash: self.layout.hash(),
            segments: Vec::new(),
        };
        TapeWriter::create(path, sidecar, existing)
    }

    fn profile(&self) -> TestProfile {
        self.layout.test.profile
    }

    fn dof(&self, index: usize) -> String {
        self.layout.hits.get(index).map_or_else(|| "?".into(), |hit| hit.dof.to_string())
    }
}

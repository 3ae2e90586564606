//! `massline calibrate show`, `pull` and `push`: the calibration stored on a rig.

use std::path::PathBuf;

use massline_shared::calibration::CalibrationRecord;

use super::{rig::RigArgs, store};
use crate::Result;
use crate::output::Output;
use crate::support::files::ReplaceArgs;
use massline_files::calibration_file::{CalibrationFile, to_toml};
use massline_files::file;
use massline_report::calibration as report;
use massline_report::document::WrittenFile;

/// Arguments of `massline calibrate show`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  massline calibrate show\n  massline calibrate show --json")]
pub struct ShowArgs {
    #[command(flatten)]
    rig: RigArgs,
}

/// Arguments of `massline calibrate pull`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  massline calibrate pull rig.toml\n  massline simulate frame.toml \
                        --bench uncalibrated --calibration rig.toml"
)]
pub struct PullArgs {
    /// The file.
    file: PathBuf,
    #[command(flatten)]
    replace: ReplaceArgs,
    #[command(flatten)]
    rig: RigArgs,
}

/// Arguments of `massline calibrate push`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  massline calibrate push rig.toml --port /dev/ttyACM0")]
pub struct PushArgs {
    /// The file.
    file: PathBuf,
    #[command(flatten)]
    rig: RigArgs,
}

/// Runs `calibrate show`.
///
/// # Errors
/// When the rig cannot be reached.
pub fn show(args: &ShowArgs, output: &mut Output) -> Result<()> {
    let record = args.rig.tumble_rig(output)?.client.calibration()?;
    output.answer(&report::record_json(&record), |_| report::record_text(&record))
}

/// Runs `calibrate pull`.
///
/// # Errors
/// When the rig cannot be reached, or the file exists or cannot be written.
pub fn pull(args: &PullArgs, output: &mut Output) -> Result<()> {
    let path = args.file.display();
    file::check(&args.file, args.replace.existing())?;
    let record = args.rig.tumble_rig(output)?.client.calibration()?;
    file::write(&args.file, to_toml(&record).as_bytes(), args.replace.existing())?;
    let value = WrittenFile { written: (&args.file).into() };
    output.answer(&value, |_| format!("{path} written"))
}

/// Runs `calibrate push`.
///
/// # Errors
/// When the file is bad, or the rig cannot be reached or refuses.
pub fn push(args: &PushArgs, output: &mut Output) -> Result<()> {
    let record: CalibrationRecord = CalibrationFile::read(&args.file)?.record;
    let mut rig = args.rig.tumble_rig(output)?;
    store(&mut rig.client, &record)?;
    output.answer(&report::record_json(&record), |_| report::record_text(&record))
}

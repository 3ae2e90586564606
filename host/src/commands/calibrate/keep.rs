//! `massline calibrate show`, `pull` and `push`: the calibration stored on a rig.

use std::io::Write;
use std::path::PathBuf;

use massline_shared::calibration::CalibrationRecord;
use serde_json::json;

use super::{report, rig::RigArgs, store};
use crate::calibration_file::{CalibrationFile, to_toml};
use crate::error::{Error, Result};
use crate::output::Output;

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
    /// The file, which must not exist yet.
    file: PathBuf,
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
    let record = args.rig.tumble_rig()?.client.calibration()?;
    output.answer(&report::record_json(&record), |_| report::record_text(&record))
}

/// Runs `calibrate pull`.
///
/// # Errors
/// When the rig cannot be reached, or the file exists or cannot be written.
pub fn pull(args: &PullArgs, output: &mut Output) -> Result<()> {
    let path = args.file.display();
    let mut file = std::fs::File::create_new(&args.file)
        .map_err(|e| Error::input("cannot_write", format!("{path} cannot be written: {e}")))?;
    let pulled = args.rig.tumble_rig().and_then(|mut rig| Ok(rig.client.calibration()?));
    let record = match pulled {
        Ok(record) => record,
        Err(error) => {
            // An empty file would block the next attempt.
            let _ = std::fs::remove_file(&args.file);
            return Err(error);
        }
    };
    file.write_all(to_toml(&record).as_bytes())
        .map_err(|e| Error::input("cannot_write", format!("{path} cannot be written: {e}")))?;
    output.answer(&json!({ "written": args.file }), |_| format!("{path} written"))
}

/// Runs `calibrate push`.
///
/// # Errors
/// When the file is bad, or the rig cannot be reached or refuses.
pub fn push(args: &PushArgs, output: &mut Output) -> Result<()> {
    let record: CalibrationRecord = CalibrationFile::read(&args.file)?.record;
    let mut rig = args.rig.tumble_rig()?;
    store(&mut rig.client, &record)?;
    output.answer(&report::record_json(&record), |_| report::record_text(&record))
}

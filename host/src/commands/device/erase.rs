//! `massline device erase`.

use super::is_in_safe_mode;
use crate::output::Output;
use crate::support::connect::PortArgs;
use crate::{Error, Result};
use massline_report::document::DeviceErase;

/// Arguments of `massline device erase`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
A rig whose last three starts have failed is in safe mode: see `massline device identify`. What it
stores may be the cause. It asks before it erases; --yes answers yes, and is needed without a
keyboard. Any other rig is refused: `massline results delete` deletes results.

Examples:
  massline device erase
  massline device erase --port /dev/ttyACM0 --yes --json")]
pub struct Args {
    /// Erase without asking.
    #[arg(short, long)]
    yes: bool,
    #[command(flatten)]
    port: PortArgs,
}

/// Runs the command.
///
/// # Errors
/// When the rig cannot be reached, is not in safe mode, or cannot erase its flash, and when nobody confirms.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    output.can_confirm(args.yes, "erasing")?;
    let (mut client, identity) = args.port.connect(output)?;
    if !is_in_safe_mode(&identity) {
        return Err(Error::input(
            "not_in_safe_mode",
            "the rig runs as usual, and only a rig in safe mode is erased as a whole; `massline results delete` \
             deletes results",
        ));
    }
    if !args.yes && !output.confirm("erase all results, layouts and the calibration?")? {
        return Err(Error::interrupted("nothing was erased"));
    }
    client.erase_store()?;
    output.answer(&DeviceErase { erased: true }, |_| {
        "erased; press reset on the rig, or switch it off and on".into()
    })
}

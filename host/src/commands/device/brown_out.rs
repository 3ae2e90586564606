//! `massline device brown-out`, and the same after flashing.

use std::time::{Duration, Instant};

use crate::output::Output;
use crate::support::connect::PortArgs;
use crate::{Error, Result};
use massline_client::{Client, ClientError};
use massline_protocol::message::Reason;
use massline_report::document::DeviceBrownOut;

/// Arguments of `massline device brown-out`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
A chip that goes on with too little supply writes nonsense into its flash. An STM32 as delivered goes
on down to 1.7 V. This has it reset itself below 2.7 V (STM32F411) or 2.8 V (STM32G474), from the next
time that it is switched on. `massline flash` does it too.

Examples:
  massline device brown-out
  massline device brown-out --port /dev/ttyACM0 --json")]
pub struct Args {
    #[command(flatten)]
    port: PortArgs,
}

/// Runs the command.
///
/// # Errors
/// When the rig cannot be reached, has no such level, or its supply is too low to write it.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    let (mut client, _) = args.port.connect(output)?;
    let level = raise(&mut client)?.ok_or_else(|| {
        Error::input(
            "no_brown_out",
            "this board, or its firmware, has no level to set; update the firmware of an STM32",
        )
    })?;
    output.answer(&DeviceBrownOut { brown_out_mv: level }, |_| text(level))
}

/// What was achieved, for people.
pub fn text(level_mv: u16) -> String {
    let volts = f64::from(level_mv) / 1000.0;
    format!("the chip resets itself below {volts:.1} V, from the next time that it is switched on")
}

/// Sets the highest level; returns it, mV. `None` from a board that has none to set.
///
/// # Errors
/// Those of the client.
pub fn raise(client: &mut Client) -> std::result::Result<Option<u16>, ClientError> {
    match client.raise_brown_out() {
        Ok(()) => Ok(client.hardware()?.and_then(|hardware| hardware.brown_out_mv)),
        Err(error) if error.refusal() == Some(Reason::UnknownMessage) => Ok(None),
        Err(error) => Err(error),
    }
}

/// What became of the level of a board that was flashed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LevelOutcome {
    /// It is this, mV.
    Raised(u16),
    /// The rig could not set it.
    Refused(String),
    /// No rig on this board has answered.
    Silent,
}

/// Raises the level of a board that has just been flashed and starts.
pub fn raise_after_start(board: &str, output: &mut Output) -> LevelOutcome {
    /// How long a rig takes to start and to appear as a port.
    const PATIENCE: Duration = Duration::from_secs(8);
    /// Interval between two looks for its port.
    const LOOK: Duration = Duration::from_millis(250);
    output.note("waiting for the rig to start; leave it plugged in");
    let deadline = Instant::now() + PATIENCE;
    let port = PortArgs::default();
    while Instant::now() < deadline && !output.interrupt().pressed() {
        if let Ok((mut client, identity)) = port.connect(output)
            && identity.board == board
        {
            return match raise(&mut client) {
                Ok(Some(level)) => LevelOutcome::Raised(level),
                Ok(None) => LevelOutcome::Refused("it has no such level to set".into()),
                Err(error) => LevelOutcome::Refused(error.to_string()),
            };
        }
        std::thread::sleep(LOOK);
    }
    LevelOutcome::Silent
}

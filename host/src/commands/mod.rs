//! The subcommands: arguments, help, dispatch.

pub mod connect;
pub mod device;
pub mod keyboard;

pub(crate) use device::phase_name;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::output::Output;

/// Mass, centre of mass and inertia tensor of an object from a few hammer taps.
#[derive(Debug, Parser)]
#[command(
    name = "massline",
    version,
    max_term_width = 100,
    subcommand_required = true,
    arg_required_else_help = true,
    after_help = "\
Examples:
  massline demo                               watch a simulated rig measure an object
  massline layout new > frame.toml            start a layout
  massline layout check frame.toml            can it determine all ten properties?
  massline measure frame.toml                 measure with the rig that is connected

Exit codes:
  0 done   1 internal fault   2 bad input or usage   3 the data cannot determine the answer
  4 device or link failure   130 Ctrl-C"
)]
pub struct Cli {
    /// Print one JSON object on stdout instead of text; errors too.
    #[arg(long, global = true)]
    pub json: bool,
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Find rigs, say who they are and what they have counted.
    Device(device::Args),
}

/// The whole program: reads the arguments, runs the command, gives the exit code.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let json = arguments.iter().any(|a| a == "--json");
    let mut output = Output::of_process(json, Interrupt::of_process());
    match Cli::try_parse_from(&arguments) {
        Ok(cli) => match run(cli, &mut output) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                output.error(&error);
                ExitCode::from(error.exit_code())
            }
        },
        Err(usage) => {
            // Help and version are no errors; clap prints them to stdout.
            if usage.use_stderr() && json {
                let message = usage.to_string();
                let error = Error::input("usage", message.trim_end());
                output.error(&error);
            } else {
                let _ = usage.print();
            }
            ExitCode::from(if usage.use_stderr() { 2 } else { 0 })
        }
    }
}

/// Runs one command.
///
/// # Errors
/// Whatever the command fails with; nothing has been printed about it yet.
pub fn run(cli: Cli, output: &mut Output) -> Result<()> {
    match cli.command {
        Command::Device(args) => device::run(&args, output),
    }
}

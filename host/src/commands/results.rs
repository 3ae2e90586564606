//! `massline results`: the results stored on the rig.

mod delete;
mod get;
mod list;
mod numbers;

use crate::Result;
use crate::output::Output;

/// Arguments of `massline results`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  massline results list
  massline results get 3
  massline results get 3 --output frame.massline
  massline results delete 1-3 --port /dev/ttyACM0")]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// List all results stored on the rig.
    List(list::Args),
    /// Show one result with its ten properties, and write it to an archive.
    Get(get::Args),
    /// Delete results from the rig.
    Delete(delete::Args),
}

/// Runs the command.
///
/// # Errors
/// When the rig cannot be reached or has no such result.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    match &args.command {
        Command::List(args) => list::run(args, output),
        Command::Get(args) => get::run(args, output),
        Command::Delete(args) => delete::run(args, output),
    }
}

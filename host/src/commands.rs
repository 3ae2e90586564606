//! The subcommands: arguments, help, dispatch.

pub mod calibrate;
pub mod completions;
pub mod demo;
pub mod device;
mod doctor;
pub mod export;
pub mod flash;
pub mod history;
pub mod hits;
pub mod layout;
pub mod measure;
pub mod modes;
pub mod plot;
pub mod record;
pub mod replay;
pub mod report;
mod results;
pub mod schema;
pub mod simulate;
pub mod solve;
pub mod virtual_rig;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::output::{ColorChoice, Output};
use crate::support::config::Config;
use crate::support::{color, help, number, version};
use crate::{Error, Result};
use massline_client::interrupt::Interrupt;

/// Mass, centre of mass and inertia tensor of an object from a few hammer taps.
#[derive(Debug, Parser)]
#[command(
    name = "massline",
    version = version::VERSION,
    subcommand_required = true,
    arg_required_else_help = true,
    after_help = "\
Examples:
  massline demo                      watch a simulated rig measure an object
  massline layout new > frame.toml   start a layout
  massline layout check frame.toml   can it determine all ten properties?
  massline measure frame.toml        measure with the rig that is connected

Exit codes:
  0 done                       3 the data give no answer that can be used
  1 internal fault             4 device or link failure
  2 bad input or usage         130 Ctrl-C"
)]
pub struct Cli {
    /// Print one JSON object on stdout instead of text; errors too.
    #[arg(long, global = true)]
    pub json: bool,
    /// When text is coloured: on a terminal without NO_COLOR, or always, or never.
    #[arg(long, global = true, value_enum, value_name = "WHEN", default_value_t)]
    pub color: ColorChoice,
    /// The subcommand.
    #[command(subcommand)]
    pub command: Command,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Watch a simulated rig measure the paper's three-bar frame in four tests.
    Demo(demo::Args),
    /// Create, check, improve and show layout files.
    Layout(layout::Args),
    /// Find rigs, show their identity and counters, abort a campaign.
    Device(device::Args),
    /// Check this computer: ports and permissions, what is plugged in, what is missing.
    Doctor(doctor::Args),
    /// Write the firmware to a board; the data stored on the rig stay.
    Flash(flash::Args),
    /// Measure with a rig: send the layout, follow the hits, fetch the result.
    Measure(measure::Args),
    /// Calibrate sensors and hammer, store calibrations, check whether one is still valid.
    Calibrate(calibrate::Args),
    /// List, fetch and delete the results stored on a rig.
    Results(results::Args),
    /// List the archives in a folder.
    History(history::Args),
    /// Record a rig's live scans on a tape.
    Record(record::Args),
    /// Grade the hits of recorded hammer data.
    Hits(hits::Args),
    /// Solve offline from the frequency responses in a universal file.
    Solve(solve::Args),
    /// Write a result as a file of another program: robot simulators, finite elements, numerics.
    Export(export::Args),
    /// Draw pictures of a result.
    Plot(plot::Args),
    /// Write results as an HTML page for people.
    Report(report::Args),
    /// Show the suspension modes in the frequency responses of a universal file.
    Modes(modes::Args),
    /// Replay recorded scans through the whole rig.
    Replay(replay::Args),
    /// Simulate a measurement with a layout, and compare it with the truth.
    Simulate(simulate::Args),
    /// Serve a virtual rig on a pty that any serial program can open.
    Virtual(virtual_rig::Args),
    /// Print the JSON schemas of the documents that other programs read.
    Schema(schema::Args),
    /// Print the completions of a shell.
    Completions(completions::Args),
}

/// The whole program: parses the arguments, runs the command, returns the exit code.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let json = arguments.iter().any(|a| a == "--json");
    let config = Config::of_user();
    let of_config = config.as_ref().ok().and_then(Config::color);
    let color = color::chosen(&arguments).or(of_config).unwrap_or_default();
    let mut output =
        Output::of_process(json, color, Interrupt::of_process(crate::terminal::give_back));
    let command = match config.and_then(|config| config.apply(command())) {
        Ok(command) => command,
        Err(error) => {
            output.error(&error);
            return ExitCode::from(error.exit_code());
        }
    };
    let parsed = color::in_color(command, output.in_color())
        .try_get_matches_from(&arguments)
        .and_then(|m| Cli::from_arg_matches(&m));
    match parsed {
        Ok(cli) => match run(cli, &mut output) {
            Ok(()) => ExitCode::from(output.exit_code()),
            Err(error) => {
                output.error(&error);
                ExitCode::from(error.exit_code())
            }
        },
        Err(usage) => {
            // Help and version are not errors; clap prints them to stdout.
            if usage.use_stderr() && json {
                let message = usage.to_string();
                let message = message.trim_start_matches("error: ").trim_end();
                let error = Error::input("usage", message);
                output.error(&error);
            } else {
                color::print(&usage, &arguments, &mut output);
            }
            ExitCode::from(if usage.use_stderr() { 2 } else { 0 })
        }
    }
}

/// The command line with its help texts.
fn command() -> clap::Command {
    help::reflowed(number::with_negative_numbers(Cli::command()))
}

/// Runs one command.
///
/// # Errors
/// Whatever error the command fails with; it has not been printed yet.
pub fn run(cli: Cli, output: &mut Output) -> Result<()> {
    match cli.command {
        Command::Demo(args) => demo::run(&args, output),
        Command::Layout(args) => layout::run(&args, output),
        Command::Device(args) => device::run(&args, output),
        Command::Doctor(args) => doctor::run(&args, output),
        Command::Flash(args) => flash::run(&args, output),
        Command::Measure(args) => measure::run(&args, output),
        Command::Calibrate(args) => calibrate::run(&args, output),
        Command::Results(args) => results::run(&args, output),
        Command::History(args) => history::run(&args, output),
        Command::Record(args) => record::run(&args, output),
        Command::Hits(args) => hits::run(&args, output),
        Command::Solve(args) => solve::run(&args, output),
        Command::Export(args) => export::run(&args, output),
        Command::Plot(args) => plot::run(&args, output),
        Command::Report(args) => report::run(&args, output),
        Command::Modes(args) => modes::run(&args, output),
        Command::Replay(args) => replay::run(&args, output),
        Command::Simulate(args) => simulate::run(&args, output),
        Command::Virtual(args) => virtual_rig::run(&args, output),
        Command::Schema(args) => schema::run(&args, output),
        Command::Completions(args) => completions::run(&args, command(), output),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A broken line would leave a single word on the next.
    #[test]
    fn examples_and_lists_fit_a_terminal_of_eighty_columns() {
        fn check(command: &clap::Command) {
            let notes = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            for line in notes.lines().filter(|line| line.starts_with(' ')) {
                assert!(line.chars().count() <= 80, "{}: {line}", command.get_name());
            }
            command.get_subcommands().for_each(check);
        }
        check(&command());
    }
}

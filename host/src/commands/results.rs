//! `massline results`: the results stored on the rig.

use massline_protocol::LayoutHash;
use massline_protocol::message::{EstimatedMass, ResultEntry};
use serde_json::json;

use super::connect::PortArgs;
use super::{hash, show};
use crate::error::Result;
use crate::identification::Selection;
use crate::output::{self, Output};
use crate::report::{as_exact_as, with_sigma};
use crate::single_fault::NominalTest;

/// Arguments of `massline results`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  massline results list
  massline results get 3 --json > result.json
  massline results delete 3 --port /dev/ttyACM0")]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// List all results stored on the rig.
    #[command(after_help = "Examples:\n  massline results list\n  massline results list --json")]
    List(PortArgs),
    /// Show one result with its ten properties.
    #[command(after_help = "Examples:\n  massline results get 3\n  massline results get 3 --json")]
    Get {
        /// Number of the result in the list.
        #[arg(value_parser = clap::value_parser!(u32).range(1..))]
        number: u32,
        #[command(flatten)]
        port: PortArgs,
    },
    /// Delete a result from the rig.
    #[command(after_help = "Examples:\n  massline results delete 3")]
    Delete {
        /// Number of the result in the list.
        #[arg(value_parser = clap::value_parser!(u32).range(1..))]
        number: u32,
        #[command(flatten)]
        port: PortArgs,
    },
}

/// Runs the command.
///
/// # Errors
/// When the rig cannot be reached or has no such result.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    match &args.command {
        Command::List(port) => {
            let (mut client, _) = port.connect(output)?;
            let entries = client.results()?;
            let list: Vec<_> = entries
                .iter()
                .map(|e| {
                    json!({
                        "number": e.number,
                        "layout_hash": e.layout_hash,
                        "mass_kg": e.mass.map(|mass| mass.value),
                        "mass_sigma_kg": e.mass.and_then(|mass| mass.sigma),
                        "bytes": e.length,
                    })
                })
                .collect();
            output.answer(&json!({ "results": list }), |_| table(&entries))
        }
        Command::Get { number, port } => {
            let (mut client, _) = port.connect(output)?;
            let result = client.result(*number)?;
            // The rig returns the layout in use, which may differ from that of an older result.
            let layout = client.layout().ok().filter(|kept| kept.hash() == result.head.layout_hash);
            let nominal = layout.and_then(|kept| kept.cast()).map(NominalTest::of_layout);
            show::measurement(&result, nominal.as_ref(), Selection::All, output)
        }
        Command::Delete { number, port } => {
            let (mut client, _) = port.connect(output)?;
            client.delete_result(*number)?;
            output.answer(&json!({ "deleted": number }), |_| format!("result {number} deleted"))
        }
    }
}

fn mass_text(mass: EstimatedMass) -> String {
    match mass.sigma {
        Some(sigma) => format!("{} kg", with_sigma(mass.value.into(), sigma.into())),
        None => format!("{} kg", as_exact_as(mass.value.into(), None)),
    }
}

fn table(entries: &[ResultEntry]) -> String {
    if entries.is_empty() {
        return "the rig keeps no results".into();
    }
    let mut table = output::table();
    table.set_header(["number", "layout", "mass", "bytes"]);
    for e in entries {
        table.add_row([
            e.number.to_string(),
            hash(e.layout_hash).unwrap_or_default(),
            e.mass.map_or_else(|| "none".into(), mass_text),
            e.length.to_string(),
        ]);
    }
    table.to_string()
}

//! `massline results delete`.

use super::numbers::Numbers;
use crate::output::Output;
use crate::support::connect::PortArgs;
use crate::{Error, Result};
use massline_report::document::DeletedResults;

/// Arguments of `massline results delete`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
It asks before it deletes; --yes answers yes, and is needed without a keyboard.

Examples:
  massline results delete 3
  massline results delete 1-4 6 --yes
  massline results delete --all")]
pub struct Args {
    /// Numbers of results in the list, or ranges such as 2-5 and 2-.
    #[arg(value_name = "NUMBERS", required_unless_present = "all")]
    numbers: Vec<Numbers>,
    /// Delete all results.
    #[arg(long, conflicts_with = "numbers")]
    all: bool,
    /// Delete without asking.
    #[arg(short, long)]
    yes: bool,
    #[command(flatten)]
    port: PortArgs,
}

/// Runs the command.
///
/// # Errors
/// When the rig cannot be reached or has no such result, and when nobody confirms.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    output.can_confirm(args.yes, "deleting")?;
    let (mut client, _) = args.port.connect(output)?;
    let stored: Vec<u32> = client.results()?.iter().map(|entry| entry.number).collect();
    let chosen = chosen(args, &stored)?;
    if chosen.is_empty() {
        let nothing = DeletedResults { deleted: chosen };
        return output.answer(&nothing, |_| "the rig keeps no results".into());
    }
    if !args.yes && !output.confirm(&format!("delete {}?", named(&chosen)))? {
        return Err(Error::interrupted("nothing was deleted"));
    }
    for &number in &chosen {
        client.delete_result(number)?;
    }
    let text = format!("{} deleted", named(&chosen));
    output.answer(&DeletedResults { deleted: chosen }, |_| text)
}

/// The stored results that the arguments name.
fn chosen(args: &Args, stored: &[u32]) -> Result<Vec<u32>> {
    for numbers in &args.numbers {
        if !stored.iter().any(|&number| numbers.contains(number)) {
            let wanted = numbers
                .single()
                .map_or("no result in this range".into(), |number| format!("no result {number}"));
            let has = match stored {
                [] => "no results".to_owned(),
                stored => listed(stored),
            };
            let message = format!("{wanted} is stored on the rig; it has {has}");
            return Err(Error::input("no_such_result", message));
        }
    }
    let named =
        |number: u32| args.all || args.numbers.iter().any(|numbers| numbers.contains(number));
    Ok(stored.iter().copied().filter(|&number| named(number)).collect())
}

fn named(numbers: &[u32]) -> String {
    let noun = if numbers.len() == 1 { "result" } else { "results" };
    format!("{noun} {}", listed(numbers))
}

fn listed(numbers: &[u32]) -> String {
    numbers.iter().map(u32::to_string).collect::<Vec<_>>().join(", ")
}

//! `massline results list`.

use massline_protocol::object::MeasurementResult;

use crate::Result;
use crate::output::{self, Output, Table};
use crate::support::connect::PortArgs;
use massline_report::document::{KeptResult, ResultsList};
use massline_report::words::result_of_rig;
use massline_report::words::{Summary, hash_text};

/// Arguments of `massline results list`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  massline results list\n  massline results list --json")]
pub struct Args {
    #[command(flatten)]
    port: PortArgs,
}

/// Runs the command.
///
/// # Errors
/// When the rig cannot be reached.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    let (mut client, _) = args.port.connect(output)?;
    let entries = client.results()?;
    let bar = output.bar(entries.len() as u64, "results");
    let mut results = Vec::new();
    for entry in &entries {
        results.push((client.result(entry.number)?, entry.length));
        bar.inc(1);
    }
    bar.finish_and_clear();
    let list = results.iter().map(|(result, bytes)| entry(result, *bytes));
    let document = ResultsList { results: list.collect() };
    if results.is_empty() {
        return output.answer(&document, |_| "the rig keeps no results".into());
    }
    let table = table(&results);
    output.answer_table(&document, &table)
}

fn entry(result: &MeasurementResult, bytes: u32) -> KeptResult {
    KeptResult {
        summary: summary(result).document(),
        number: result.head.number,
        layout_hash: hash_text(result.head.layout_hash),
        bytes,
    }
}

fn summary(result: &MeasurementResult) -> Summary {
    Summary::of(&result_of_rig(result))
}

fn table(results: &[(MeasurementResult, u32)]) -> Table {
    let mut table = output::table();
    table.set_header(["number", "title", "measured", "method", "mass ± 95 %", "verdict"]);
    for (result, _) in results {
        let mut row = vec![result.head.number.to_string()];
        row.extend(summary(result).columns());
        table.add_row(row);
    }
    table
}

//! `massline report`: results as one HTML page.

use std::path::{Path, PathBuf};

use super::files::{self, ReplaceArgs};
use crate::document::WrittenFile;
use crate::error::Result;
use crate::file;
use crate::html_report::html;
use crate::output::Output;
use crate::result_file::ResultFile;

/// Arguments of `massline report`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
RESULT is an archive (FRAME.massline), the output of solve, measure, results get, simulate or replay
with --json, or another report. The page is one file that needs no network: verdict, the ten
properties with their intervals, what limits them, agreement of the methods, sensors and hits,
pictures, settings. It can be printed on A4 and read on a phone, light or dark.

The page holds its results: solve, export, plot and report read it like the file that it was made
of. Of several results, report.html#result-2 is the second.

What only you know (object, support, hammer, operator) is stated in the [report] table of the layout.

Examples:
  massline report frame.massline
  massline report frame.massline -o bracket.html
  massline report test-1.massline test-2.massline -o both.html
  massline solve wheel.toml wheel.uff --json > wheel.json
  massline report wheel.json --layout wheel.toml
  massline solve frame.html")]
pub struct Args {
    /// Archives, or the JSON output of commands.
    #[arg(required = true, value_name = "RESULT")]
    results: Vec<PathBuf>,
    /// Layout file of the test, for a result that is not an archive.
    #[arg(long, value_name = "FILE")]
    layout: Option<PathBuf>,
    /// Write to this file [default: the name of the result with .html].
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    replace: ReplaceArgs,
}

/// Runs the command.
///
/// # Errors
/// When a result cannot be read, or the file cannot be written.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    let path = args.output.clone().unwrap_or_else(|| default_name(&args.results));
    file::check(&path, args.replace.existing())?;
    let layout = args.layout.as_deref().map(|path| files::layout(path, output)).transpose()?;
    let sources = ResultFile::read_all(&args.results, layout.as_ref())?;
    file::write(&path, html(&sources)?.as_bytes(), args.replace.existing())?;
    let value = WrittenFile { written: path };
    output.answer(&value, |_| {
        format!("{}: open it in a browser; it needs no network", value.written.display())
    })
}

/// The name of the result with another extension, in this folder.
fn default_name(results: &[PathBuf]) -> PathBuf {
    match results {
        [one] => Path::new(one.file_stem().unwrap_or_default()).with_extension("html"),
        _ => "report.html".into(),
    }
}

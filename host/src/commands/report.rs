//! `massline report`: results as one HTML page.

use std::path::PathBuf;

use crate::output::Output;
use crate::support::files::ReplaceArgs;
use crate::support::show::page_called;
use crate::support::sources::SourceArgs;
use crate::{Error, Result};
use massline_files::file;
use massline_report::document::WrittenFile;
use massline_report::page::html;

/// Arguments of `massline report`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
RESULT is an archive (FRAME.massline), the output of solve, measure, results get, simulate or replay
with --json, or another report. The page is one file that needs no network: verdict, the ten
properties with their intervals, what limits them, agreement of the methods, sensors and hits,
pictures, settings. It can be printed on A4 and read on a phone, light or dark.

The page holds its results: solve, export, plot and report read it like the file that it was made
of, except for the records of single hits and the file of --responses, which stay outside: keep them
for other pictures. Of several results, report.html#result-2 is the second.

What only you know (object, support, hammer, operator) is stated in the [report] table of the layout.

Examples:
  massline report frame.massline
  massline report frame.massline -o bracket.html
  massline report test-1.massline test-2.massline -o both.html
  massline solve wheel.toml wheel.uff --json > wheel.json
  massline report wheel.json --layout wheel.toml --responses wheel.uff
  massline solve frame.html")]
pub struct Args {
    #[command(flatten)]
    sources: SourceArgs,
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
    let path = args.path()?;
    file::check(&path, args.replace.existing())?;
    let sources = args.sources.read(output)?;
    file::write(&path, html(&sources)?.as_bytes(), args.replace.existing())?;
    let value = WrittenFile { written: path.into() };
    output.answer(&value, |_| {
        format!("{}: open it in a browser; it needs no network", value.written.display())
    })
}

impl Args {
    /// Where the page is written: unless that is given, in this folder, called after the result.
    ///
    /// # Errors
    /// Exit 2 when the page would take the place of its own result without being told so.
    fn path(&self) -> Result<PathBuf> {
        if let Some(path) = &self.output {
            return Ok(path.clone());
        }
        let path = page_called(&self.sources.stem("report"));
        if self.sources.hold(&path) {
            let text =
                format!("{} is the result itself; name the page with --output", path.display());
            return Err(Error::input("usage", text));
        }
        Ok(path)
    }
}

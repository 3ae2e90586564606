//! The report of simulated tests, as `demo` and `simulate` write and offer it.

use std::path::PathBuf;

use crate::Result;
use crate::output::{Output, this_command_with};
use crate::support::sources;
use massline_files::archive::Archive;
use massline_files::file::{self, ExistingFile};
use massline_report::page::html;
use massline_report::result_file::ResultFile;

/// The option for a report.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct ReportArgs {
    /// Write a report with pictures to this file, as `massline report` makes it; `massline plot` and `export` read it.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
}

impl ReportArgs {
    /// Whether a report is wanted.
    pub fn is_wanted(&self) -> bool {
        self.report.is_some()
    }

    /// Checks that the report can be written, before the work that it is about.
    ///
    /// # Errors
    /// Exit 2 when the file exists and is kept, or its folder does not exist.
    pub fn check(&self, existing: ExistingFile) -> Result<()> {
        self.report.iter().try_for_each(|path| file::check(path, existing))
    }

    /// Writes the report of these tests if it is wanted; returns the file.
    ///
    /// # Errors
    /// When a picture cannot be drawn, or the file cannot be written.
    pub fn write(
        &self,
        tests: impl FnOnce() -> Result<Vec<ResultFile>>,
        existing: ExistingFile,
    ) -> Result<Option<PathBuf>> {
        let Some(path) = &self.report else { return Ok(None) };
        let page = html(&tests()?)?;
        file::write(path, page.as_bytes(), existing)?;
        Ok(Some(path.clone()))
    }

    /// Says on stderr what can be done with the report that was written, or how to get one.
    pub fn offer(&self, written: Option<PathBuf>, output: &mut Output) {
        // Whoever reads documents has no next step.
        if written.is_none() && output.json() {
            return;
        }
        output.note(match written {
            Some(path) => format!(
                "report written to {}: open it in a browser; it holds the results as well, for `massline plot` and \
                 `massline export`",
                path.display()
            ),
            None => format!(
                "next: `{}` makes a page with pictures",
                this_command_with("--report page.html")
            ),
        });
    }
}

/// Simulated tests, each with its name, as a report shows them.
///
/// # Errors
/// When the layout of one cannot be read.
pub fn results_of(tests: impl IntoIterator<Item = (String, Archive)>) -> Result<Vec<ResultFile>> {
    tests.into_iter().map(|(name, archive)| sources::of_archive(archive, name)).collect()
}

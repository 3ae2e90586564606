//! The results that `plot` and `report` show, with what is known beside them.

use std::path::{Path, PathBuf};

use super::files;
use super::responses::Response;
use crate::embedded;
use crate::output::Output;
use crate::result_file::ResultFile;
use crate::solve::{Options, understood};
use crate::{Error, Result};
use massline_files::uff::{Quantity, UffFile};

/// Results, and files that belong to them.
#[derive(Debug, clap::Args)]
pub struct SourceArgs {
    /// Archives, the JSON output of commands, or reports.
    #[arg(required = true, value_name = "RESULT")]
    pub results: Vec<PathBuf>,
    /// Layout file of the test, for a result that is not an archive.
    #[arg(long, value_name = "FILE")]
    layout: Option<PathBuf>,
    /// Universal file with the frequency responses that a result was solved from, to draw them.
    #[arg(long, value_name = "FRFS", requires = "layout")]
    responses: Option<PathBuf>,
    /// Quantity of the responses, for a file that does not state it or states it wrongly; its units hold all the same.
    #[arg(long, value_enum, value_name = "QUANTITY", requires = "responses")]
    quantity: Option<Response>,
}

impl SourceArgs {
    /// Reads the results.
    ///
    /// # Errors
    /// When a file cannot be read or is not what it should be.
    pub fn read(&self, output: &mut Output) -> Result<Vec<ResultFile>> {
        let layout = self.layout.as_deref().map(|path| files::layout(path, output)).transpose()?;
        let mut sources = ResultFile::read_all(&self.results, layout.as_ref())?;
        if let Some(path) = &self.responses {
            let [source] = &mut sources[..] else {
                let text = "--responses belongs to one result; give them one by one";
                return Err(Error::input("usage", text));
            };
            let uff = UffFile::read(path)?;
            let options =
                Options { quantity: self.quantity.map(Quantity::from), ..Options::default() };
            let added = source.add_responses(&uff, options.quantity);
            added.map_err(|error| error.within(path.display()))?;
            let layout = source.layout().filter(|_| !output.json());
            let line = layout.and_then(|layout| understood(layout, (&uff, path), &options));
            if let Some(line) = line {
                output.note(line);
            }
        }
        Ok(sources)
    }

    /// A name for files that are made of the results; `several` is that of more than one.
    pub fn stem(&self, several: &str) -> String {
        match &self.results[..] {
            [one] => embedded::stem(one),
            _ => several.into(),
        }
    }

    /// True when a path is that of one of the results.
    pub fn hold(&self, path: &Path) -> bool {
        let is_that = |result: &PathBuf| embedded::is_file_of(result, path);
        self.results.iter().any(is_that)
    }
}

//! The results that `plot` and `report` show, with what is known beside them.

use std::path::{Path, PathBuf};

use super::files;
use super::responses::Response;
use crate::output::Output;
use crate::solve::{Options, responses_of, understood};
use crate::support::measured::result_of_archive;
use crate::{Error, Result};
use massline_files::archive::{Archive, is_archive};
use massline_files::embedded;
use massline_files::layout_file::LayoutFile;
use massline_files::uff::{Quantity, UffFile};
use massline_report::export::read_document;
use massline_report::result_file::ResultFile;
use massline_result::{Document, TestResult};

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
        let mut sources = read_all(&self.results, layout.as_ref())?;
        if let Some(path) = &self.responses {
            let [source] = &mut sources[..] else {
                let text = "--responses belongs to one result; give them one by one";
                return Err(Error::input("usage", text));
            };
            let uff = UffFile::read(path)?;
            let options =
                Options { quantity: self.quantity.map(Quantity::from), ..Options::default() };
            let added = source.add_responses(|layout| responses_of(layout, &uff, options.quantity));
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

/// Reads several results; `layout` is the layout file of those that are no archives.
///
/// # Errors
/// As [`read`], and exit 2 for a layout where all are archives.
fn read_all(paths: &[PathBuf], layout: Option<&LayoutFile>) -> Result<Vec<ResultFile>> {
    let read = |path: &PathBuf| read(path, layout);
    let sources = paths.iter().map(read).collect::<Result<Vec<_>>>()?;
    if layout.is_some() && sources.iter().all(|source| source.archive().is_some()) {
        let names: Vec<&str> = sources.iter().map(|source| source.name.as_str()).collect();
        let text = format!(
            "{}: an archive has the layout of its test, which --layout does not replace; leave it out, or solve the \
             archive with another layout: `massline solve LAYOUT.toml ARCHIVE`",
            names.join(", ")
        );
        return Err(Error::input("layout_not_for_archive", text));
    }
    Ok(sources)
}

/// Reads an archive or the JSON output of a command; `layout` is the layout file of the test. An archive has its own,
/// with which its answers were found.
///
/// # Errors
/// Exit 2 when the file cannot be read or is neither.
fn read(path: &Path, layout: Option<&LayoutFile>) -> Result<ResultFile> {
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    let stem = embedded::stem(path);
    if is_archive(path) {
        let archive = Archive::read(path)?;
        return ResultFile::new(result_of_archive(&archive), Some(archive), name, &stem, layout);
    }
    let result = match read_document(path)? {
        Document::Result(result) => *result,
        Document::Modes(modes) => TestResult { suspension: Some(*modes), ..TestResult::default() },
    };
    ResultFile::new(result, None, name, &stem, layout)
}

/// The result of an archive that is no file, by its name.
///
/// # Errors
/// When the layout in it cannot be read.
pub fn of_archive(archive: Archive, name: String) -> Result<ResultFile> {
    ResultFile::new(result_of_archive(&archive), Some(archive), name.clone(), &name, None)
}

#[cfg(test)]
mod tests;

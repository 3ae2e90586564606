//! Where `massline measure` and `massline results get` write an archive.

use std::path::{Path, PathBuf};

use super::files::ReplaceArgs;
use super::show::NextStep;
use crate::output::Output;
use crate::{Error, Result};
use massline_files::archive::{Archive, EXTENSION};
use massline_files::clock;
use massline_files::file::{self, ExistingFile};
use massline_report::words::Extent;

/// The options about the archive.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct ArchiveArgs {
    /// Write an archive to this file: everything that the test has measured, in one file to solve again and export.
    #[arg(short, long, value_name = "FILE.massline")]
    output: Option<PathBuf>,
    #[command(flatten)]
    replace: ReplaceArgs,
}

impl ArchiveArgs {
    /// The file of the archive, if one is wanted.
    pub fn path(&self) -> Option<&Path> {
        self.output.as_deref()
    }

    /// Checks that the archive can be written, before the work whose result it is to hold.
    ///
    /// # Errors
    /// Exit 2 when the file exists and is kept, or its folder does not exist.
    pub fn check(&self) -> Result<()> {
        self.output.iter().try_for_each(|path| file::check(path, self.replace.existing()))
    }

    /// Writes the archive, if one is wanted, and says so.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(&self, archive: &Archive, output: &mut Output) -> Result<()> {
        let Some(path) = &self.output else { return Ok(()) };
        archive.write(path, self.replace.existing())?;
        output.note(format!("archive written to {}", path.display()));
        Ok(())
    }

    /// Says what a person would do next with the archive that was written.
    pub fn propose_report(&self, output: &mut Output) {
        if let Some(path) = &self.output {
            let next = NextStep::Page(path).text(Extent::Details);
            if !next.is_empty() {
                output.note(next);
            }
        }
    }

    /// As [`Self::write`], for an archive that cannot be made again. When the file cannot be written, the archive goes
    /// to the folder for temporary files.
    ///
    /// # Errors
    /// When the file cannot be written, wherever the archive is then.
    pub fn write_anywhere(&self, archive: &Archive, output: &mut Output) -> Result<()> {
        let error = match self.write(archive, output) {
            Err(error) if error.exit_code() == 2 => error,
            done => return done,
        };
        let number = archive.result.head.number;
        let name = format!("massline-result-{number}-{}.{EXTENSION}", clock::unix_seconds());
        let other = std::env::temp_dir().join(name);
        let whereabouts = match archive.write(&other, ExistingFile::Kept) {
            Ok(()) => {
                format!(
                    "the archive is in {} instead: move it to where it is safe",
                    other.display()
                )
            }
            Err(_) => format!(
                "result {number} stays on the rig: `massline results get {number} --output FILE` writes an archive \
                 without frequency responses and records of hits, which are lost"
            ),
        };
        Err(Error::input(error.code().to_owned(), format!("{error}; {whereabouts}")))
    }
}

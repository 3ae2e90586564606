//! `massline history`: the archives in a folder, the oldest first.

use std::path::{Path, PathBuf};

use massline_result::TestResult;

use crate::output::{self, Output, Table};
use crate::{Error, Result};
use massline_files::archive::{Archive, EXTENSION, is_named};
use massline_report::document::{History, ListedArchive, UnreadableFile};
use massline_report::words::Summary;

/// Arguments of `massline history`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Of each archive (*.massline): title, when it was measured, the best method, mass ± 95 %,
and the verdict when it was written. Files that cannot be read are named, and the others are listed.

Examples:
  massline history
  massline history tests/
  massline history tests/ --json")]
pub struct Args {
    /// The folder with the archives.
    #[arg(default_value = ".")]
    folder: PathBuf,
}

/// Runs the command.
///
/// # Errors
/// Exit 2 when the folder cannot be read.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    let mut tests = Vec::new();
    let mut unreadable = Vec::new();
    for path in archives(&args.folder)? {
        match Archive::read(&path) {
            Ok(archive) => tests.push((path, Test::of(&archive))),
            Err(error) => unreadable.push((path, error)),
        }
    }
    tests.sort_by(|(_, a), (_, b)| a.time.cmp(&b.time));
    let cannot_be_read = |(path, error): &(PathBuf, Error)| UnreadableFile {
        file: path.into(),
        code: error.code().to_owned(),
        message: error.to_string(),
    };
    let document = History {
        archives: tests.iter().map(|(path, test)| test.entry(path)).collect(),
        unreadable: unreadable.iter().map(cannot_be_read).collect(),
    };
    if tests.is_empty() {
        output.answer(&document, |_| nothing_in(&args.folder))?;
    } else {
        let table = table(&tests);
        output.answer_table(&document, &table)?;
    }
    if !output.json() {
        unreadable.iter().for_each(|(_, error)| output.warn(error.to_string()));
    }
    Ok(())
}

/// What the list says about an archive.
struct Test {
    summary: Summary,
    /// When it was measured, else when the archive was written.
    time: String,
}

impl Test {
    fn of(archive: &Archive) -> Self {
        let time = archive.measured.as_ref().unwrap_or(&archive.written).clone();
        let summary = Summary::of(archive.answers().unwrap_or(&TestResult::default()));
        // The rig keeps a part of a long title only.
        let title = archive.layout.title.clone();
        let summary = Summary { title, measured: archive.measured.clone(), ..summary };
        Self { summary, time }
    }

    fn entry(&self, path: &Path) -> ListedArchive {
        ListedArchive { summary: self.summary.document(), file: path.into() }
    }
}

/// The archives in a folder, by their extension.
fn archives(folder: &Path) -> Result<Vec<PathBuf>> {
    let failed = |e: std::io::Error| {
        let message =
            format!("{}: the folder cannot be read: {e}; check the path", folder.display());
        Error::input("folder_not_readable", message)
    };
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if is_named(&path) {
            paths.push(path);
        }
    }
    paths.sort();
    Ok(paths)
}

fn nothing_in(folder: &Path) -> String {
    format!(
        "{} has no archives that can be read (*.{EXTENSION}); `massline measure --output` and `massline results get \
         --output` write them",
        folder.display()
    )
}

fn table(tests: &[(PathBuf, Test)]) -> Table {
    let mut table = output::table();
    table.set_header(["file", "title", "measured", "method", "mass ± 95 %", "verdict"]);
    for (path, test) in tests {
        let name = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
        let mut row = vec![name];
        row.extend(test.summary.columns());
        table.add_row(row);
    }
    table
}

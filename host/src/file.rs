//! Reads files of unknown size, and writes files that are whole or not there.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Read, Write};
use std::path::Path;

use crate::{Error, Result};

#[cfg_attr(unix, path = "file/unix.rs")]
#[cfg_attr(not(unix), path = "file/elsewhere.rs")]
mod system;

pub(crate) use system::open;

/// What happens to a file that exists already.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Existing {
    /// It stays, and writing is refused.
    #[default]
    Kept,
    /// It is replaced.
    Replaced,
}

/// The bytes of a file.
///
/// # Errors
/// When the file cannot be read or is longer than `most` bytes, and for a pipe that nothing writes to.
pub(crate) fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(path)?.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        let message = format!("it is longer than {most} bytes");
        return Err(io::Error::new(ErrorKind::FileTooLarge, message));
    }
    Ok(bytes)
}

/// Checks that a file may be written, before the work whose result it is to hold.
///
/// # Errors
/// Exit 2 when the file exists and is kept, or its folder does not exist.
pub fn check(path: &Path, existing: Existing) -> Result<()> {
    if path.is_dir() {
        return Err(cannot(path, "it is a folder; give the name of a file"));
    }
    if let Some(folder) = folder(path).filter(|folder| !folder.is_dir()) {
        return Err(cannot(path, format!("there is no folder {}", folder.display())));
    }
    if existing == Existing::Kept && (is_regular(path) || path.is_symlink()) {
        return Err(exists(path));
    }
    Ok(())
}

/// Writes a file: the whole of it, or nothing. The bytes go to a temporary file in the same folder, which then takes
/// the name; pipes and devices are written directly.
///
/// # Errors
/// Exit 2 when the file exists and is kept, or cannot be written.
pub fn write(path: &Path, bytes: &[u8], existing: Existing) -> Result<()> {
    check(path, existing)?;
    if path.exists() && !is_regular(path) {
        let written = File::options().write(true).open(path).and_then(|mut to| to.write_all(bytes));
        return written.map_err(|e| cannot(path, e));
    }
    // A link stays a link.
    let path = &fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let failed = |e: io::Error| match e.kind() {
        ErrorKind::AlreadyExists => exists(path),
        _ => cannot(path, e),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".massline-");
    if let Some(permissions) = system::permissions() {
        builder.permissions(permissions);
    }
    let mut temporary =
        builder.tempfile_in(folder(path).unwrap_or(Path::new("."))).map_err(failed)?;
    temporary.write_all(bytes).map_err(failed)?;
    temporary.as_file().sync_all().map_err(failed)?;
    let named = match existing {
        // Sticks for cameras and boards (FAT) cannot refuse to replace; it has been checked above.
        Existing::Kept => temporary.persist_noclobber(path).or_else(|e| match e.error.kind() {
            ErrorKind::AlreadyExists => Err(e),
            _ => e.file.persist(path),
        }),
        Existing::Replaced => temporary.persist(path),
    };
    named.map(|_| ()).map_err(|e| failed(e.error))
}

/// The folder of a path; `None` for a name in the folder of the process.
fn folder(path: &Path) -> Option<&Path> {
    path.parent().filter(|folder| !folder.as_os_str().is_empty())
}

fn is_regular(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|of| of.is_file())
}

fn exists(path: &Path) -> Error {
    let message =
        format!("{} exists already; give another name, or replace it with --force", path.display());
    Error::input("file_exists", message)
}

/// The error of a file that cannot be written.
pub(crate) fn cannot(path: &Path, why: impl std::fmt::Display) -> Error {
    Error::input("cannot_write", format!("{}: cannot be written: {why}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_existing_file_is_kept_unless_it_may_be_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.toml");
        write(&path, b"one", Existing::Kept).unwrap();
        assert_eq!(write(&path, b"two", Existing::Kept).unwrap_err().code(), "file_exists");
        assert_eq!(fs::read(&path).unwrap(), b"one");
        write(&path, b"two", Existing::Replaced).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "a temporary file is left");
    }

    #[cfg(unix)]
    #[test]
    fn a_written_file_may_be_read_by_others_and_a_link_stays_a_link() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let (path, link) = (folder.path().join("a"), folder.path().join("b"));
        fs::write(&path, "zero").unwrap();
        let usual = fs::metadata(&path).unwrap().permissions().mode();
        symlink(&path, &link).unwrap();
        write(&link, b"one", Existing::Replaced).unwrap();
        assert!(link.is_symlink());
        assert_eq!(fs::read(&path).unwrap(), b"one");
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode(), usual);
    }

    #[test]
    fn folders_that_are_missing_or_in_the_way_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("none").join("a");
        let error = write(&missing, b"", Existing::Kept).unwrap_err();
        assert!(error.to_string().contains("there is no folder"), "{error}");
        let error = write(folder.path(), b"", Existing::Replaced).unwrap_err();
        assert!(error.to_string().contains("it is a folder"), "{error}");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_an_error_of_the_file() {
        let error = write(Path::new("/dev/full"), b"text", Existing::Kept).unwrap_err();
        assert_eq!((error.code(), error.exit_code()), ("cannot_write", 2), "{error}");
    }

    #[test]
    fn a_file_that_is_too_long_is_not_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        fs::write(&path, [0; 11]).unwrap();
        assert_eq!(read(&path, 11).unwrap().len(), 11);
        assert_eq!(read(&path, 10).unwrap_err().kind(), ErrorKind::FileTooLarge);
    }
}

//! Reads files of unknown size, and writes files that are whole or not there.

use std::fs::{self, File};
use std::io::{self, BufRead, ErrorKind, Read, Write};
use std::path::Path;

use massline_result::{Error, Result};

#[cfg_attr(unix, path = "file/unix.rs")]
#[cfg_attr(not(unix), path = "file/elsewhere.rs")]
mod system;

pub use system::open;

/// What happens to a file that exists already.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ExistingFile {
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
pub fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(path)?.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        let message = format!("it is longer than {} MiB, and more is not read", most as f64 / MIB);
        return Err(io::Error::new(ErrorKind::FileTooLarge, message));
    }
    Ok(bytes)
}

/// Bytes.
const MIB: f64 = (1 << 20) as f64;

/// The message of a file that cannot be read, with what to do.
pub fn unreadable(path: &Path, error: &io::Error) -> String {
    let advice = match error.kind() {
        ErrorKind::NotFound => "; check the path",
        ErrorKind::PermissionDenied => "; check its permissions",
        ErrorKind::IsADirectory => "; give the name of a file",
        _ => "",
    };
    format!("{}: cannot be read: {error}{advice}", path.display())
}

/// The next line of a stream, without its end; `None` at the end of the stream.
///
/// # Errors
/// When the stream cannot be read, or the line is longer than `most` bytes.
pub fn line(stream: &mut impl BufRead, most: usize) -> io::Result<Option<String>> {
    let mut bytes = Vec::new();
    stream.take(most as u64 + 1).read_until(b'\n', &mut bytes)?;
    if bytes.len() > most {
        let message = format!("a line is longer than {most} bytes");
        return Err(io::Error::new(ErrorKind::FileTooLarge, message));
    }
    let ended = bytes.is_empty();
    Ok((!ended).then(|| String::from_utf8_lossy(&bytes).trim_end_matches(['\r', '\n']).to_owned()))
}

/// Checks that a file may be written, before the work whose result it is to hold.
///
/// # Errors
/// Exit 2 when the file exists and is kept, its folder does not exist, or its name is that of the standard streams.
pub fn check(path: &Path, existing: ExistingFile) -> Result<()> {
    if path == Path::new("-") {
        return Err(cannot(path, "it names no file here; give the name of a file"));
    }
    if path.is_dir() {
        return Err(cannot(path, "it is a folder; give the name of a file"));
    }
    if let Some(folder) = folder(path).filter(|folder| !folder.is_dir()) {
        return Err(cannot(path, format!("there is no folder {}", folder.display())));
    }
    if is_stream(path) {
        return Ok(());
    }
    if existing == ExistingFile::Kept && (is_regular(path) || path.is_symlink()) {
        return Err(exists(path));
    }
    Ok(())
}

/// Writes a file: the whole of it, or nothing. The bytes go to a temporary file in the same folder, which then takes
/// the name; pipes and devices are written directly.
///
/// # Errors
/// Exit 2 when the file exists and is kept, or cannot be written.
pub fn write(path: &Path, bytes: &[u8], existing: ExistingFile) -> Result<()> {
    check(path, existing)?;
    if path.exists() && (is_stream(path) || !is_regular(path)) {
        // A shell may have redirected the stream into a file that it appends to.
        let written =
            File::options().append(true).open(path).and_then(|mut to| to.write_all(bytes));
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
        ExistingFile::Kept => temporary.persist_noclobber(path).or_else(|e| match e.error.kind() {
            ErrorKind::AlreadyExists => Err(e),
            _ => e.file.persist(path),
        }),
        ExistingFile::Replaced => temporary.persist(path),
    };
    named.map(|_| ()).map_err(|e| failed(e.error))
}

/// The folder of a path; `None` for a name in the folder of the process.
fn folder(path: &Path) -> Option<&Path> {
    path.parent().filter(|folder| !folder.as_os_str().is_empty())
}

/// True for a stream of this process, whatever it leads to.
fn is_stream(path: &Path) -> bool {
    let of_process = ["/dev/stdout", "/dev/stderr"].iter().any(|stream| path == Path::new(stream));
    of_process || path.starts_with("/dev/fd") || path.starts_with("/proc/self/fd")
}

fn is_regular(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|metadata| metadata.is_file())
}

fn exists(path: &Path) -> Error {
    let message =
        format!("{} exists already; give another name, or replace it with --force", path.display());
    Error::input("file_exists", message)
}

/// The error of a file that cannot be written.
pub fn cannot(path: &Path, why: impl std::fmt::Display) -> Error {
    Error::input("cannot_write", format!("{}: cannot be written: {why}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_existing_file_is_kept_unless_it_may_be_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.toml");
        write(&path, b"one", ExistingFile::Kept).unwrap();
        assert_eq!(write(&path, b"two", ExistingFile::Kept).unwrap_err().code(), "file_exists");
        assert_eq!(fs::read(&path).unwrap(), b"one");
        write(&path, b"two", ExistingFile::Replaced).unwrap();
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
        write(&link, b"one", ExistingFile::Replaced).unwrap();
        assert!(link.is_symlink());
        assert_eq!(fs::read(&path).unwrap(), b"one");
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode(), usual);
    }

    #[test]
    fn folders_that_are_missing_or_in_the_way_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("none").join("a");
        let error = write(&missing, b"", ExistingFile::Kept).unwrap_err();
        assert!(error.to_string().contains("there is no folder"), "{error}");
        let error = write(folder.path(), b"", ExistingFile::Replaced).unwrap_err();
        assert!(error.to_string().contains("it is a folder"), "{error}");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_an_error_of_the_file() {
        let error = write(Path::new("/dev/full"), b"text", ExistingFile::Kept).unwrap_err();
        assert_eq!((error.code(), error.exit_code()), ("cannot_write", 2), "{error}");
    }

    #[test]
    fn a_file_that_is_too_long_is_not_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        fs::write(&path, [0; 11]).unwrap();
        assert_eq!(read(&path, 11).unwrap().len(), 11);
        assert_eq!(read(&path, 10).unwrap_err().kind(), ErrorKind::FileTooLarge);
        let long = read(Path::new(env!("CARGO_MANIFEST_DIR")), 10).unwrap_err();
        let message = unreadable(Path::new("x"), &long);
        assert!(
            message.contains("give the name of a file") && !message.contains("path"),
            "{message}"
        );
        let missing = read(Path::new("no-such-file"), 10).unwrap_err();
        assert!(unreadable(Path::new("x"), &missing).ends_with("; check the path"));
    }

    #[test]
    fn a_line_that_is_too_long_is_not_read_to_its_end() {
        let mut stream = io::Cursor::new(b"1:+Y\r\n\n12345678\n123456789".to_vec());
        let mut next = || line(&mut stream, 9);
        assert_eq!(next().unwrap().as_deref(), Some("1:+Y"));
        assert_eq!(next().unwrap().as_deref(), Some(""));
        assert_eq!(next().unwrap().as_deref(), Some("12345678"));
        assert_eq!(next().unwrap().as_deref(), Some("123456789"));
        assert_eq!(next().unwrap(), None);
        let zero = [0; 20];
        assert_eq!(line(&mut zero.as_slice(), 9).unwrap_err().kind(), ErrorKind::FileTooLarge);
    }
}

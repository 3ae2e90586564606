//! Systems whose files are not also pipes, and whose new files have the permissions of their folder.

use std::fs::{File, Permissions};
use std::io;
use std::path::Path;

/// Opens a file for reading.
pub fn open(path: &Path) -> io::Result<File> {
    File::open(path)
}

/// None other than those of the folder.
pub(super) fn permissions() -> Option<Permissions> {
    None
}

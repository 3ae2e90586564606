//! Named pipes and permissions of Unix.

use std::fs::{self, File, Permissions};
use std::io::{self, ErrorKind};
use std::os::fd::AsFd;
use std::os::unix::fs::{FileTypeExt, OpenOptionsExt, PermissionsExt};
use std::path::Path;

use nix::fcntl::{FcntlArg, OFlag, fcntl};
use nix::poll::{PollFd, PollFlags, poll};

/// Time for a program to write the first bytes to a named pipe, ms.
const WRITER_WITHIN_MS: u16 = 10_000;

/// Opens a file for reading; a named pipe that no program writes to is an error instead of a wait without end.
pub fn open(path: &Path) -> io::Result<File> {
    // The pipes of a shell, /dev/fd/63 for instance, have a writer and no path of their own.
    let named = fs::canonicalize(path).is_ok_and(|real| {
        fs::symlink_metadata(real).is_ok_and(|about| about.file_type().is_fifo())
    });
    if !named {
        return File::open(path);
    }
    let pipe = File::options().read(true).custom_flags(OFlag::O_NONBLOCK.bits()).open(path)?;
    let mut waiting = [PollFd::new(pipe.as_fd(), PollFlags::POLLIN)];
    if poll(&mut waiting, WRITER_WITHIN_MS)? == 0 {
        let message = "it is a pipe that no program writes to; start the one that writes first";
        return Err(io::Error::new(ErrorKind::WouldBlock, message));
    }
    fcntl(&pipe, FcntlArg::F_SETFL(OFlag::empty()))?;
    Ok(pipe)
}

/// The permissions with which any other program creates files; the mask of the user applies.
pub(super) fn permissions() -> Option<Permissions> {
    Some(Permissions::from_mode(0o666))
}

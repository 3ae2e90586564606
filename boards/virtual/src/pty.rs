//! Serves a virtual rig on a pseudo-terminal: to any serial program it is a serial port.

use std::fs::File;
use std::io::{self, ErrorKind, Read, Write};
use std::os::fd::{AsFd, BorrowedFd};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use nix::pty::openpty;
use nix::sys::termios::{FlushArg, SetArg, cfmakeraw, tcflush, tcgetattr, tcsetattr};
use nix::unistd::ttyname;

use crate::pipe::HostEnd;

/// How soon the end of the server or of a client is noticed. The kernel reports a client that closes, but
/// not one that opens, so the server has to poll for that.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// A pseudo-terminal that carries the link of a rig until it is dropped.
///
/// While no program has it open, the rig's link is unplugged: the next program does not receive what the
/// rig sends in the meantime, and the rig continues as without a host.
#[derive(Debug)]
pub struct PtyServer {
    path: PathBuf,
    ended: Arc<AtomicBool>,
    pumps: Vec<JoinHandle<()>>,
}

impl PtyServer {
    /// Opens a pseudo-terminal and carries the bytes of `link` over it.
    ///
    /// # Errors
    /// When the system has no pseudo-terminal or no thread left.
    pub fn serve(link: HostEnd) -> io::Result<Self> {
        let pair = openpty(None, None)?;
        let path = ttyname(&pair.slave)?;
        let mut settings = tcgetattr(&pair.slave)?;
        cfmakeraw(&mut settings);
        tcsetattr(&pair.slave, SetArg::TCSANOW, &settings)?;
        // Closed here, so that the kernel reports when the last program has closed it too.
        drop(pair.slave);
        link.unplug();
        let master = File::from(pair.master);
        let ended = Arc::new(AtomicBool::new(false));
        let mut server = Self { path, ended: ended.clone(), pumps: Vec::new() };
        let (to_rig, to_client) = ((master.try_clone()?, link.clone()), (master, link));
        let flag = ended.clone();
        server.spawn("pty to rig", move || carry_to_rig(to_rig.0, to_rig.1, &flag))?;
        server.spawn("rig to pty", move || carry_to_client(to_client.0, to_client.1, &ended))?;
        Ok(server)
    }

    /// The path that a serial program opens.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn spawn(&mut self, name: &str, pump: impl FnOnce() + Send + 'static) -> io::Result<()> {
        self.pumps.push(thread::Builder::new().name(name.into()).spawn(pump)?);
        Ok(())
    }
}

impl Drop for PtyServer {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Release);
        for pump in self.pumps.drain(..) {
            // A panic of the pump has already been printed.
            let _ = pump.join();
        }
    }
}

/// Waits for one of `events`, for at most [`LOOK_EVERY`].
fn wait(master: BorrowedFd<'_>, events: PollFlags) -> PollFlags {
    let mut fds = [PollFd::new(master, events)];
    let timeout = PollTimeout::try_from(LOOK_EVERY).unwrap_or(PollTimeout::ZERO);
    match poll(&mut fds, timeout) {
        Ok(_) => fds[0].revents().unwrap_or(PollFlags::empty()),
        Err(_) => PollFlags::empty(),
    }
}

/// Carries the client's bytes to the rig, and unplugs the link while there is no client.
fn carry_to_rig(mut master: File, mut link: HostEnd, ended: &AtomicBool) {
    link.set_timeout(LOOK_EVERY);
    let mut buffer = [0; 4096];
    while !ended.load(Ordering::Acquire) {
        let events = wait(master.as_fd(), PollFlags::POLLIN);
        if events.contains(PollFlags::POLLIN) {
            link.plug();
            if let Ok(count) = master.read(&mut buffer) {
                write_all(&mut link, &buffer[..count], ended);
            }
        } else if events.contains(PollFlags::POLLHUP) {
            if link.is_plugged() {
                link.unplug();
                // Output that the last client has not read must not reach the next one. Input stays: the
                // next client may have opened and written already.
                let _ = tcflush(&master, FlushArg::TCOFLUSH);
            }
            thread::sleep(LOOK_EVERY);
        } else {
            link.plug();
        }
    }
}

/// Writes at the speed at which the rig reads: a slow rig makes the client wait.
fn write_all(link: &mut HostEnd, mut bytes: &[u8], ended: &AtomicBool) {
    while !bytes.is_empty() && !ended.load(Ordering::Acquire) {
        match link.write(bytes) {
            Ok(count) => bytes = &bytes[count..],
            Err(error) if error.kind() == ErrorKind::TimedOut => {}
            Err(_) => return,
        }
    }
}

/// Carries the rig's bytes to the client, as fast as the client reads.
fn carry_to_client(mut master: File, mut link: HostEnd, ended: &AtomicBool) {
    link.set_timeout(LOOK_EVERY);
    let mut buffer = [0; 4096];
    while !ended.load(Ordering::Acquire) {
        match link.read(&mut buffer) {
            Ok(count) => write_to_client(&mut master, &buffer[..count], &link, ended),
            Err(error) if error.kind() == ErrorKind::TimedOut => {}
            // The link is unplugged, or the rig has ended.
            Err(_) => thread::sleep(LOOK_EVERY),
        }
    }
}

fn write_to_client(master: &mut File, mut bytes: &[u8], link: &HostEnd, ended: &AtomicBool) {
    while !bytes.is_empty() && link.is_plugged() && !ended.load(Ordering::Acquire) {
        if wait(master.as_fd(), PollFlags::POLLOUT).contains(PollFlags::POLLOUT) {
            match master.write(bytes) {
                Ok(count) => bytes = &bytes[count..],
                Err(_) => return,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::echo::{END, many_bytes, rig};
    use serialport::SerialPort;

    fn open(path: &Path) -> Box<dyn SerialPort> {
        serialport::new(path.to_str().unwrap(), 115_200)
            .timeout(Duration::from_secs(60))
            .open()
            .unwrap()
    }

    fn said_back(port: &mut dyn SerialPort, bytes: &[u8]) -> Vec<u8> {
        let writer = port.try_clone().unwrap();
        crate::echo::said_back(port, writer, bytes)
    }

    #[test]
    fn a_serial_program_can_open_close_and_reopen_it() {
        let (rig, host) = rig();
        let server = PtyServer::serve(host).unwrap();
        let bytes = many_bytes();
        for _ in 0..3 {
            let mut port = open(server.path());
            assert!(said_back(&mut *port, &bytes) == bytes);
        }
        for _ in 0..30 {
            assert_eq!(said_back(&mut *open(server.path()), b"at once"), b"at once");
        }
        // Stays open until the rig has read the mark: bytes in transit are lost when the client leaves.
        let mut port = open(server.path());
        port.write_all(&[END]).unwrap();
        rig.join().unwrap();
    }
}

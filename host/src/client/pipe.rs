//! The in-memory pipe to a virtual rig.

use std::io::{self, Read, Write};
use std::time::{Duration, Instant};

use massline_virtual::pipe::HostEnd;

use super::Transport;

/// For the rig to take a frame.
const WRITE_TIMEOUT: Duration = Duration::from_secs(5);

/// A rig of this process behind its pipe.
pub struct PipeTransport(HostEnd);

impl PipeTransport {
    /// The rig at the other end of `pipe`.
    pub fn new(pipe: HostEnd) -> Self {
        Self(pipe)
    }
}

impl Transport for PipeTransport {
    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        self.0.set_timeout(timeout);
        match self.0.read(buffer) {
            Err(e) if e.kind() == io::ErrorKind::TimedOut => Ok(0),
            other => other,
        }
    }

    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        let deadline = Instant::now() + WRITE_TIMEOUT;
        let mut left = bytes;
        while !left.is_empty() {
            self.0.set_timeout(deadline.saturating_duration_since(Instant::now()));
            match self.0.write(left) {
                Ok(n) => left = left.get(n..).unwrap_or_default(),
                // The rig reads nothing: the link stands, and the request will be repeated.
                Err(e) if e.kind() == io::ErrorKind::TimedOut => return Ok(()),
                Err(e) => return Err(e),
            }
        }
        Ok(())
    }

    fn reconnect(&mut self) -> io::Result<()> {
        if !self.0.is_plugged() {
            return Err(io::Error::new(io::ErrorKind::NotConnected, "the rig is unplugged"));
        }
        // A rig that has ended says so without being asked.
        self.0.set_timeout(Duration::ZERO);
        match self.0.read(&mut [0; 64]) {
            Err(e) if e.kind() == io::ErrorKind::BrokenPipe => {
                Err(io::Error::new(io::ErrorKind::Unsupported, e))
            }
            // Bytes from before the cut are of no use.
            _ => Ok(()),
        }
    }

    fn name(&self) -> &str {
        "virtual rig"
    }
}

//! The in-memory pipe to a virtual rig.

use std::io::{self, Read, Write};
use std::time::{Duration, Instant};

use massline_virtual::pipe::HostEnd;

use massline_client::Transport;

/// How long the rig may take to accept a frame.
const WRITE_TIMEOUT: Duration = Duration::from_secs(5);

/// The pipe to a virtual rig in this process.
pub struct PipeTransport(HostEnd);

impl PipeTransport {
    /// The transport to the rig at the other end of `pipe`.
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
                // The rig reads nothing, but the link still exists; the client will repeat the request.
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
        // Finds out whether the rig has ended, which closes the pipe.
        self.0.set_timeout(Duration::ZERO);
        match self.0.read(&mut [0; 64]) {
            Err(e) if e.kind() == io::ErrorKind::BrokenPipe => {
                Err(io::Error::new(io::ErrorKind::Unsupported, e))
            }
            // Bytes from before the reconnection are useless.
            _ => Ok(()),
        }
    }

    fn name(&self) -> &str {
        "virtual rig"
    }
}

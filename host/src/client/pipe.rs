//! A pair of byte streams inside this process or to another one.

use std::io::{self, Read, Write};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

use super::Transport;

/// A transport over a [`Read`] and a [`Write`], such as the in-memory pipe of a virtual rig.
///
/// A thread reads, because a plain `Read` cannot wait with a timeout; it ends with the stream.
pub struct PipeTransport {
    name: String,
    received: Receiver<Vec<u8>>,
    left: Vec<u8>,
    writer: Box<dyn Write + Send>,
}

impl PipeTransport {
    /// A transport that reads from `reader` until its end and writes to `writer`.
    pub fn new(
        name: impl Into<String>,
        mut reader: impl Read + Send + 'static,
        writer: impl Write + Send + 'static,
    ) -> Self {
        let (sender, received) = channel();
        std::thread::spawn(move || {
            let mut buffer = [0; 4096];
            loop {
                match reader.read(&mut buffer) {
                    Ok(n) if n > 0 => {
                        if sender.send(buffer[..n].to_vec()).is_err() {
                            return;
                        }
                    }
                    Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                    _ => return,
                }
            }
        });
        Self { name: name.into(), received, left: Vec::new(), writer: Box::new(writer) }
    }
}

impl Transport for PipeTransport {
    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        if self.left.is_empty() {
            match self.received.recv_timeout(timeout) {
                Ok(bytes) => self.left = bytes,
                Err(RecvTimeoutError::Timeout) => return Ok(0),
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(io::Error::new(io::ErrorKind::UnexpectedEof, "the rig has ended"));
                }
            }
        }
        let n = buffer.len().min(self.left.len());
        buffer[..n].copy_from_slice(&self.left[..n]);
        self.left.drain(..n);
        Ok(n)
    }

    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.writer.write_all(bytes)?;
        self.writer.flush()
    }

    fn reconnect(&mut self) -> io::Result<()> {
        Err(io::Error::new(io::ErrorKind::Unsupported, "the rig has ended"))
    }

    fn name(&self) -> &str {
        &self.name
    }
}

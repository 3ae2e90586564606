//! The byte stream that carries the protocol.

use std::io;
use std::time::Duration;

/// A byte stream to and from a rig that can be reopened after it was lost.
pub trait Transport: Send {
    /// Reads the available bytes, waiting up to `timeout` for the first one; 0 when none came.
    ///
    /// # Errors
    /// When the link is lost; only [`Transport::reconnect`] can restore it.
    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize>;

    /// Writes all of `bytes`.
    ///
    /// # Errors
    /// When the link is lost, or the other side has accepted nothing for longer than any rig needs; a part of
    /// the bytes may have been written.
    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Tries once to reopen the link.
    ///
    /// # Errors
    /// When the other side is not there (yet); [`io::ErrorKind::Unsupported`] when it can never come back.
    fn reconnect(&mut self) -> io::Result<()>;

    /// The name for messages, for example the path of the port.
    fn name(&self) -> &str;
}

impl<T: Transport + ?Sized> Transport for Box<T> {
    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        (**self).read(buffer, timeout)
    }
    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        (**self).write_all(bytes)
    }
    fn reconnect(&mut self) -> io::Result<()> {
        (**self).reconnect()
    }
    fn name(&self) -> &str {
        (**self).name()
    }
}

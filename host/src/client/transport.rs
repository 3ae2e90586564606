//! What carries the bytes.

use std::io;
use std::time::Duration;

/// A stream of bytes to and from a rig that can be opened again after it was lost.
pub trait Transport: Send {
    /// Reads what is there, waiting up to `timeout` for the first byte; 0 when nothing came.
    ///
    /// # Errors
    /// The link is lost: only [`Transport::reconnect`] can help.
    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize>;

    /// Writes all of `bytes`.
    ///
    /// # Errors
    /// The link is lost, or the other side has taken nothing for longer than any rig needs; then
    /// only a part may have been written.
    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Tries once to open the link anew.
    ///
    /// # Errors
    /// When it is not there (yet); [`io::ErrorKind::Unsupported`] when it will never be again.
    fn reconnect(&mut self) -> io::Result<()>;

    /// The name in messages, for example the path of the port.
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

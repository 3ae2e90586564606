//! The asynchronous end of the pipe.

use std::fmt;
use std::future::poll_fn;
use std::sync::Arc;
use std::task::Poll;

use embedded_io_async::{Error, ErrorKind, ErrorType, Read, Write};
use massline_firmware::board::Link;

use super::{SharedPipe, State, wait};

/// The rig's end: its [`Link`]. The host sees the rig as ended when either half is dropped.
pub struct PipeLink {
    rx: RigRx,
    tx: RigTx,
}

impl PipeLink {
    pub(super) fn new(shared: Arc<SharedPipe>) -> Self {
        Self { rx: RigRx(Half(shared.clone())), tx: RigTx(Half(shared)) }
    }
}

impl PipeLink {
    /// A handle to the bytes that the host has not read yet.
    pub fn backlog(&self) -> Backlog {
        Backlog(self.tx.0.0.clone())
    }
}

/// The bytes that the host has not read yet.
pub struct Backlog(Arc<SharedPipe>);

impl Backlog {
    /// True when at most half of the pipe's capacity is unread, or the host is unplugged.
    pub fn is_small(&self) -> bool {
        self.0.lock().has_small_backlog()
    }

    /// Waits until [`is_small`](Self::is_small).
    pub async fn small(&self) {
        poll_fn(|cx| {
            let mut state = self.0.lock();
            if state.has_small_backlog() {
                return Poll::Ready(());
            }
            wait(&mut state.rig_pacer, cx)
        })
        .await;
    }
}

impl State {
    fn begin_write(&mut self) {
        self.writing = true;
        self.cut_off = false;
    }

    fn has_small_backlog(&self) -> bool {
        !self.plugged || self.to_host.bytes.len() <= self.to_host.capacity / 2
    }
}

impl fmt::Debug for Backlog {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Backlog")
    }
}

impl Link for PipeLink {
    type Rx = RigRx;
    type Tx = RigTx;

    const STREAMS: bool = true;

    fn split(self) -> (RigRx, RigTx) {
        (self.rx, self.tx)
    }
}

/// The host has pulled the plug.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnpluggedError;

impl fmt::Display for UnpluggedError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the link is unplugged")
    }
}

impl std::error::Error for UnpluggedError {}

impl Error for UnpluggedError {
    fn kind(&self) -> ErrorKind {
        ErrorKind::NotConnected
    }
}

/// The receiving half: bytes from the host.
///
/// A read after the plug was pulled fails once; the next one waits until the host is back.
pub struct RigRx(Half);

/// The sending half: bytes to the host.
///
/// A write fails while the host is unplugged. A write that is waiting when the plug is pulled fails even
/// if the plug is back at once.
pub struct RigTx(Half);

struct Half(Arc<SharedPipe>);

impl Drop for Half {
    fn drop(&mut self) {
        self.0.lock().rig_ended = true;
        self.0.changed.notify_all();
    }
}

impl ErrorType for RigRx {
    type Error = UnpluggedError;
}

impl ErrorType for RigTx {
    type Error = UnpluggedError;
}

impl Read for RigRx {
    async fn read(&mut self, buf: &mut [u8]) -> Result<usize, UnpluggedError> {
        let shared = &self.0.0;
        poll_fn(|cx| {
            let mut state = shared.lock();
            if std::mem::take(&mut state.pulled) {
                return Poll::Ready(Err(UnpluggedError));
            }
            if buf.is_empty() {
                return Poll::Ready(Ok(0));
            }
            match state.to_rig.take(buf) {
                0 => wait(&mut state.rig_reader, cx),
                count => {
                    shared.changed.notify_all();
                    Poll::Ready(Ok(count))
                }
            }
        })
        .await
    }
}

impl Write for RigTx {
    async fn write(&mut self, buf: &[u8]) -> Result<usize, UnpluggedError> {
        let shared = &self.0.0;
        // An earlier write that was abandoned does not affect this one.
        shared.lock().begin_write();
        poll_fn(|cx| {
            let mut state = shared.lock();
            if std::mem::take(&mut state.cut_off) || !state.plugged {
                return Poll::Ready(Err(UnpluggedError));
            }
            if buf.is_empty() {
                return Poll::Ready(Ok(0));
            }
            match state.to_host.put(buf) {
                0 => wait(&mut state.rig_writer, cx),
                count => {
                    state.writing = false;
                    shared.changed.notify_all();
                    Poll::Ready(Ok(count))
                }
            }
        })
        .await
    }

    async fn flush(&mut self) -> Result<(), UnpluggedError> {
        Ok(())
    }
}

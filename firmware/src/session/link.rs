//! The link: bytes that come and frames that leave, as far as they are counted.

use embassy_time::{Duration, with_timeout};
use embedded_io_async::Write;
use massline_protocol::{Frame, FrameError};

use crate::rig::Rig;

/// A frame that has not left after this long is given up: nobody reads.
const WRITE_TIMEOUT: Duration = Duration::from_millis(500);

/// What has come in, as far as it is counted by the byte and by the plug.
#[derive(Default)]
pub(super) struct Intake {
    /// Bytes since the end of the last frame.
    pending: u32,
    /// The link is gone.
    lost: bool,
}

impl Intake {
    /// The link is gone.
    pub fn lost(&mut self) {
        self.lost = true;
    }

    /// Bytes have come: the link is there.
    pub fn heard(&mut self, rig: &Rig<'_>) {
        rig.stats.borrow_mut().reconnects += u32::from(core::mem::take(&mut self.lost));
    }

    /// The deframer took these bytes and found this in them.
    pub fn took(
        &mut self,
        rig: &Rig<'_>,
        bytes: Option<&[u8]>,
        frame: &Option<Result<Frame<'_>, FrameError>>,
    ) {
        let bytes = bytes.unwrap_or_default();
        self.pending = self.pending.saturating_add(bytes.len() as u32);
        if let Some(Err(_)) = frame {
            let mut stats = rig.stats.borrow_mut();
            stats.bytes_dropped = stats.bytes_dropped.saturating_add(self.pending);
        }
        // A zero without a frame is padding.
        if bytes.last() == Some(&0) {
            self.pending = 0;
        }
    }
}

/// Writes whole frames to the link, never for longer than [`WRITE_TIMEOUT`].
pub(super) struct Sender<'r, 'm, W> {
    tx: W,
    /// The last frame did not leave whole: the next begins with a zero, which ends the torn one.
    broken: bool,
    /// A host has been heard and does read; news is sent to nobody else.
    pub listened: bool,
    rig: &'r Rig<'m>,
}

impl<'r, 'm, W: Write> Sender<'r, 'm, W> {
    /// Nobody has been heard.
    pub fn new(tx: W, rig: &'r Rig<'m>) -> Self {
        Self { tx, broken: true, listened: false, rig }
    }

    /// Sends a frame; what does not leave in time is given up.
    pub async fn send(&mut self, frame: Option<&[u8]>) {
        let Some(frame) = frame.filter(|frame| !frame.is_empty()) else { return };
        let torn = self.broken;
        let write = async {
            if torn {
                self.tx.write_all(&[0]).await?;
            }
            self.tx.write_all(frame).await?;
            self.tx.flush().await
        };
        let sent = with_timeout(WRITE_TIMEOUT, write).await;
        self.broken = !matches!(sent, Ok(Ok(())));
        let mut stats = self.rig.stats.borrow_mut();
        if self.broken {
            self.listened = false;
            stats.frames_unsent += 1;
        } else {
            stats.frames_out += 1;
        }
    }
}

//! The link: sends frames, and counts the bytes that arrive and the frames that are sent.

use embassy_time::{Duration, with_timeout};
use embedded_io_async::Write;
use massline_protocol::{Frame, FrameError};

use crate::rig::Rig;

/// A frame that could not be sent within this time is given up: no host is reading. The time is longer than an erase
/// of a sector, 0.8 s on an STM32F411, during which nothing is sent.
pub(crate) const WRITE_TIMEOUT: Duration = Duration::from_secs(2);
/// The same after a frame that was given up, until one is sent: longer than the longest frame takes at 115 200 baud,
/// 0.1 s.
const UNREAD_TIMEOUT: Duration = Duration::from_millis(250);

/// Counts received bytes and reconnections.
#[derive(Default)]
pub(super) struct Intake {
    /// Bytes received since the end of the last frame.
    pending: u32,
    /// The link is disconnected.
    lost: bool,
}

impl Intake {
    /// The link is disconnected.
    pub fn lost(&mut self) {
        self.lost = true;
    }

    /// Called when bytes have arrived: the link is connected.
    pub fn heard(&mut self, rig: &Rig<'_>) {
        rig.stats.borrow_mut().reconnects += u32::from(core::mem::take(&mut self.lost));
    }

    /// Called with the bytes that the deframer has consumed, and the frame that it has found in them.
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
        // A zero byte outside a frame is padding.
        if bytes.last() == Some(&0) {
            self.pending = 0;
        }
    }
}

/// Writes whole frames to the link, each within [`WRITE_TIMEOUT`], or [`UNREAD_TIMEOUT`] while nobody reads.
pub(super) struct Sender<'r, 'm, W> {
    tx: W,
    /// The last frame was not sent completely: the next is preceded by a zero, which ends the torn one.
    broken: bool,
    /// The last frame was given up.
    unread: bool,
    /// A host has sent something and reads what it is sent; without one, no events are sent.
    pub listened: bool,
    rig: &'r Rig<'m>,
}

impl<'r, 'm, W: Write> Sender<'r, 'm, W> {
    /// A sender that has not heard from a host yet.
    pub fn new(tx: W, rig: &'r Rig<'m>) -> Self {
        Self { tx, broken: true, unread: false, listened: false, rig }
    }

    /// Sends a frame, or gives it up.
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
        let patience = if self.unread { UNREAD_TIMEOUT } else { WRITE_TIMEOUT };
        let sent = with_timeout(patience, write).await;
        self.unread = sent.is_err();
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

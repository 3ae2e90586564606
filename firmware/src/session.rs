//! Answers requests from the host and sends it events. Whatever arrives is checked, and nothing that
//! arrives can block measuring: the session only changes shared state and wakes the measuring loop.
//!
//! | module | subject |
//! | --- | --- |
//! | `link` | sends frames, and counts the bytes that arrive and the frames that are sent |
//! | `requests` | requests from the host |
//! | `objects` | large objects as bytes, a piece at a time |
//! | `news` | events that are sent to the host without a request |

mod link;
mod news;
mod objects;
mod requests;

use embassy_futures::select::{Either, select};
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::mutex::Mutex;
use embassy_time::{Duration, Timer};
use embedded_io_async::{Read, Write};
use embedded_storage_async::nor_flash::NorFlash;
use heapless::Vec;
use massline_protocol::message::{MAX_CHANGE_ANSWER, changes};
use massline_protocol::{Deframer, Frame, MAX_FRAME, crc32};

use crate::pulse::Part;
use crate::rig::Rig;
use crate::store::Store;
pub(crate) use link::WRITE_TIMEOUT;
use link::{Intake, Sender};
use news::EventSender;
use requests::Reply;

/// Most events sent before the link is read again.
const NEWS_AT_ONCE: usize = 8;
/// Pause before a link that is disconnected, or reports that it is empty, is read again.
pub(crate) const LINK_PAUSE: Duration = Duration::from_millis(10);

/// State of the session between two frames.
pub(crate) struct SessionMemory {
    pub deframer: Deframer,
    /// The answer or the event that is being sent.
    pub out: [u8; MAX_FRAME],
    done: AnsweredRequest,
}

impl SessionMemory {
    pub const fn new() -> Self {
        Self { deframer: Deframer::new(), out: [0; MAX_FRAME], done: AnsweredRequest::NOTHING }
    }
}

/// The last request, if it changes the rig, and its answer: stored so that the request is executed once
/// even if it arrives several times.
struct AnsweredRequest {
    /// Kind, sequence and body checksum of the request.
    request: Option<(u16, u16, u32)>,
    answer: Vec<u8, MAX_CHANGE_ANSWER>,
}

impl AnsweredRequest {
    const NOTHING: Self = Self { request: None, answer: Vec::new() };
}

/// The session's access to the rest of the rig.
pub(crate) struct Session<'a, 'm, F: NorFlash> {
    pub rig: &'a Rig<'m>,
    pub store: &'a Mutex<NoopRawMutex, Store<F>>,
}

impl<F: NorFlash> Session<'_, '_, F> {
    /// Serves the link; never returns.
    pub async fn run(&self, mut rx: impl Read, tx: impl Write, memory: &mut SessionMemory) -> ! {
        let SessionMemory { deframer, out, done } = memory;
        let mut sender = Sender::new(tx, self.rig);
        let mut news = EventSender::default();
        let mut bytes = [0; 64];
        let mut intake = Intake::default();
        loop {
            self.rig.pulse.waits(Part::Session);
            let event = select(rx.read(&mut bytes), self.rig.news.wait()).await;
            self.rig.pulse.works(Part::Session);
            match event {
                // The link is disconnected.
                Either::First(Ok(0) | Err(_)) => {
                    sender.listened = false;
                    intake.lost();
                    Timer::after(LINK_PAUSE).await;
                }
                Either::First(Ok(n)) => {
                    let mut rest = bytes.get(..n).unwrap_or_default();
                    intake.heard(self.rig);
                    while !rest.is_empty() {
                        self.rig.pulse.works(Part::Session);
                        let (taken, frame) = deframer.push(rest);
                        intake.took(self.rig, rest.get(..taken), &frame);
                        rest = rest.get(taken..).unwrap_or_default();
                        match frame {
                            Some(Ok(frame)) => {
                                self.rig.stats.borrow_mut().frames_in += 1;
                                let answer = self.answer(frame, out, done).await;
                                sender.listened = true;
                                sender.send(answer).await;
                            }
                            Some(Err(_)) => self.rig.stats.borrow_mut().frames_broken += 1,
                            None => {}
                        }
                    }
                }
                Either::Second(()) => {}
            }
            self.report(&mut news, &mut sender, out).await;
        }
    }

    /// Sends what has changed since the last call.
    async fn report(
        &self,
        news: &mut EventSender,
        sender: &mut Sender<'_, '_, impl Write>,
        out: &mut [u8; MAX_FRAME],
    ) {
        for _ in 0..NEWS_AT_ONCE {
            if !sender.listened {
                return;
            }
            self.rig.pulse.works(Part::Session);
            match news.next(self.rig, out) {
                0 => return,
                length => sender.send(out.get(..length)).await,
            }
        }
        // More events may be waiting: they are sent after the next read of the link.
        self.rig.news.signal(());
    }

    /// Executes a request; returns its framed answer.
    async fn answer<'m>(
        &self,
        frame: Frame<'_>,
        out: &'m mut [u8; MAX_FRAME],
        done: &'m mut AnsweredRequest,
    ) -> Option<&'m [u8]> {
        let request = (frame.kind, frame.sequence, crc32(frame.body));
        if done.request == Some(request) {
            self.rig.stats.borrow_mut().requests_repeated += 1;
            return Some(&done.answer);
        }
        let mut reply = Reply::new(frame, out);
        if let Err(reason) = self.execute(&mut reply).await {
            self.rig.stats.borrow_mut().requests_refused += 1;
            reply.refuse(reason);
        }
        let length = reply.length();
        let answer = out.get(..length)?;
        // Refusals are stored as well: a refused request must not be executed when it is repeated.
        done.request = changes(frame.kind).then_some(request);
        if done.request.is_some() {
            // Every answer to a change fits; a test of the protocol proves it.
            done.answer = Vec::from_slice(answer).unwrap_or_default();
        }
        Some(answer)
    }
}

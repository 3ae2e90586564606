//! Answers the host and tells it the news. Whatever arrives is checked; nothing that arrives can
//! block measuring: the session only changes shared state and wakes the measuring loop.

use core::cell::RefCell;

use embassy_futures::select::{Either, select};
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::mutex::Mutex;
use embassy_time::{Duration, Timer, with_timeout};
use embedded_io_async::{Read, Write};
use embedded_storage_async::nor_flash::NorFlash;
use heapless::Vec;
use massline_shared::layout::RigLayout;
use massline_shared::protocol::event::{HIT, SCAN_BLOCK_BYTES, SCANS, STATUS_CHANGED, ScanBlock};
use massline_shared::protocol::message::{
    ANSWER, Command, DeleteResult, GetCalibration, GetIdentity, GetLayout, GetObjectInfo, GetStats,
    GetStatus, LayoutAnswer, ListRequest, ListResults, PutCalibration, PutLayout, REFUSED,
    ReadObject, Reason, Refusal, ResultPage, SetStream, Status, changes,
};
use massline_shared::protocol::{Deframer, Endpoint, Frame, MAX_FRAME, crc32, encode_frame};
use massline_shared::signal::{Calibration, Record};

use crate::objects::Objects;
use crate::rig::{Rig, Streamed};
use crate::store::Store;

/// A frame that has not left after this long is given up: nobody reads.
const WRITE_TIMEOUT: Duration = Duration::from_millis(500);

/// Events sent before the host is listened to again.
const NEWS_AT_ONCE: usize = 8;
/// A link that is gone, or says that it is empty, is asked again after this long.
const LINK_PAUSE: Duration = Duration::from_millis(10);

/// What the session keeps between two frames.
pub(crate) struct SessionMemory {
    deframer: Deframer,
    answer: Answer,
    event: [u8; MAX_FRAME],
}

impl SessionMemory {
    pub const fn new() -> Self {
        Self { deframer: Deframer::new(), answer: Answer::NONE, event: [0; MAX_FRAME] }
    }
}

/// The last answer, kept so that a request which changes the rig is executed once however often it
/// arrives.
struct Answer {
    frame: [u8; MAX_FRAME],
    length: usize,
    /// Kind, sequence and body checksum of the request, when it changed the rig.
    of: Option<(u16, u16, u32)>,
}

impl Answer {
    const NONE: Self = Self { frame: [0; MAX_FRAME], length: 0, of: None };
}

/// What the session sees of the rest of the rig.
pub(crate) struct Session<'a, F: NorFlash> {
    pub rig: &'a Rig,
    pub store: &'a Mutex<NoopRawMutex, Store<F>>,
    pub record: &'a RefCell<Record>,
    pub objects: Objects<'a, F>,
}

impl<F: NorFlash> Session<'_, F> {
    /// Serves the link for ever.
    pub async fn run(&self, mut rx: impl Read, tx: impl Write, memory: &mut SessionMemory) -> ! {
        let SessionMemory { deframer, answer, event } = memory;
        let mut sender = Sender { tx, broken: true, listened: false, rig: self.rig };
        let mut news = News::default();
        let mut bytes = [0; 64];
        loop {
            match select(rx.read(&mut bytes), self.rig.news.wait()).await {
                // The link is gone.
                Either::First(Ok(0) | Err(_)) => {
                    sender.listened = false;
                    Timer::after(LINK_PAUSE).await;
                }
                Either::First(Ok(n)) => {
                    let mut rest = bytes.get(..n).unwrap_or_default();
                    while !rest.is_empty() {
                        let (taken, frame) = deframer.push(rest);
                        rest = rest.get(taken..).unwrap_or_default();
                        match frame {
                            Some(Ok(frame)) => {
                                self.rig.stats.borrow_mut().frames_in += 1;
                                self.answer(frame, answer).await;
                                sender.listened = true;
                                sender.send(answer.frame.get(..answer.length)).await;
                            }
                            Some(Err(_)) => self.rig.stats.borrow_mut().frames_broken += 1,
                            None => {}
                        }
                    }
                }
                Either::Second(()) => {}
            }
            self.tell(&mut news, &mut sender, event).await;
        }
    }

    /// Sends what has changed since the last call.
    async fn tell(
        &self,
        news: &mut News,
        sender: &mut Sender<'_, impl Write>,
        event: &mut [u8; MAX_FRAME],
    ) {
        for _ in 0..NEWS_AT_ONCE {
            let length = if !sender.listened {
                return;
            } else if let Some(hit) = self.rig.hits.borrow_mut().pop_front() {
                news.encode(HIT, &hit, event)
            } else if let Some(block) = news.scans(self.rig, self.record) {
                news.encode(SCANS, &block, event)
            } else {
                let status = self.rig.status();
                if news.status.as_ref() == Some(&status) {
                    return;
                }
                let length = news.encode(STATUS_CHANGED, &status, event);
                news.status = Some(status);
                length
            };
            sender.send(event.get(..length)).await;
        }
        // The rest after the next look at what the host wants.
        self.rig.news.signal(());
    }

    /// Executes a request and encodes its answer.
    async fn answer(&self, frame: Frame<'_>, answer: &mut Answer) {
        let of = (frame.kind, frame.sequence, crc32(frame.body));
        if answer.of == Some(of) {
            self.rig.stats.borrow_mut().requests_repeated += 1;
            return;
        }
        let mut reply = Reply { frame, out: answer };
        let done = self.execute(&mut reply).await;
        if let Err(reason) = done {
            self.rig.stats.borrow_mut().requests_refused += 1;
            reply.encode(REFUSED, &Refusal::from(reason));
        }
        // A refusal counts as well: what was refused must not be executed when it is sent again.
        answer.of = changes(frame.kind).then_some(of);
    }

    async fn execute(&self, reply: &mut Reply<'_, '_>) -> Result<(), Reason> {
        let rig = self.rig;
        match reply.frame.kind {
            GetIdentity::KIND => reply.with::<GetIdentity>(&rig.identity()),
            GetStatus::KIND => reply.with::<GetStatus>(&rig.status()),
            GetStats::KIND => {
                let mut stats = rig.stats();
                stats.store_failures = self.store.lock().await.failures();
                reply.with::<GetStats>(&stats)
            }
            PutLayout::KIND => {
                // By reference: a future keeps an argument by value twice.
                let layout = reply.request::<PutLayout>()?;
                let answer = self.put_layout(&layout).await?;
                reply.with::<PutLayout>(&answer)
            }
            GetLayout::KIND => {
                let layout = rig.layout.borrow();
                reply.with::<GetLayout>(layout.as_ref().ok_or(Reason::NoLayout)?)
            }
            PutCalibration::KIND => {
                self.put_calibration(reply.request::<PutCalibration>()?).await?;
                reply.with::<PutCalibration>(&())
            }
            GetCalibration::KIND => reply.with::<GetCalibration>(&rig.calibration.borrow()),
            Command::KIND => {
                let store_full = self.store.lock().await.is_full();
                rig.command(reply.request::<Command>()?, store_full)?;
                reply.with::<Command>(&rig.status())
            }
            GetObjectInfo::KIND => {
                let object = reply.request::<GetObjectInfo>()?;
                let info = self.objects.info(object).await?;
                reply.with::<GetObjectInfo>(&info)
            }
            ReadObject::KIND => {
                let request = reply.request::<ReadObject>()?;
                let chunk = self.objects.read(request).await?;
                reply.with::<ReadObject>(&chunk)
            }
            ListResults::KIND => {
                let page = self.list(reply.request::<ListResults>()?).await;
                reply.with::<ListResults>(&page)
            }
            DeleteResult::KIND => {
                let number = reply.request::<DeleteResult>()?;
                if !rig.rests() {
                    return Err(Reason::WrongPhase);
                }
                self.store.lock().await.delete_result(number).await?;
                reply.with::<DeleteResult>(&())
            }
            SetStream::KIND => {
                self.set_stream(reply.request::<SetStream>()?)?;
                reply.with::<SetStream>(&())
            }
            _ => Err(Reason::UnknownMessage),
        }
    }

    async fn put_layout(&self, layout: &RigLayout) -> Result<LayoutAnswer, Reason> {
        let diagnostics = self.rig.check(layout);
        let hash = layout.hash();
        if hash != self.rig.layout_hash.get() {
            if !self.rig.is_idle() {
                return Err(Reason::WrongPhase);
            }
            self.store.lock().await.put_layout(layout).await?;
            self.rig.set_layout(layout.clone());
            self.rig.changed();
        }
        Ok(LayoutAnswer { hash, diagnostics })
    }

    async fn put_calibration(&self, calibration: Calibration) -> Result<(), Reason> {
        if !calibration.is_usable() {
            return Err(Reason::Malformed);
        }
        if !self.rig.is_idle() {
            return Err(Reason::WrongPhase);
        }
        self.store.lock().await.put_calibration(&calibration).await?;
        *self.rig.calibration.borrow_mut() = calibration;
        Ok(())
    }

    fn set_stream(&self, on: bool) -> Result<(), Reason> {
        if on && !self.rig.stream.get() && (!self.rig.is_idle() || !self.rig.streams) {
            return Err(Reason::WrongPhase);
        }
        self.rig.streamed.set(Streamed::default());
        self.rig.stream.set(on);
        self.rig.steer.signal(());
        Ok(())
    }

    async fn list(&self, request: ListRequest) -> ResultPage {
        let store = self.store.lock().await;
        let mut page = ResultPage { entries: Vec::new(), more: false };
        for kept in store.results().iter().filter(|kept| kept.entry.number > request.after) {
            page.more |= page.entries.push(kept.entry).is_err();
        }
        page
    }
}

/// A request and where its answer goes.
struct Reply<'f, 'o> {
    frame: Frame<'f>,
    out: &'o mut Answer,
}

impl Reply<'_, '_> {
    fn request<E: Endpoint>(&self) -> Result<E::Request, Reason> {
        postcard::from_bytes(self.frame.body).map_err(|_| Reason::Malformed)
    }

    fn with<E: Endpoint>(&mut self, response: &E::Response) -> Result<(), Reason> {
        self.encode(E::KIND | ANSWER, response);
        Ok(())
    }

    fn encode<T: serde::Serialize>(&mut self, kind: u16, body: &T) {
        let encoded = encode_frame(kind, self.frame.sequence, body, &mut self.out.frame);
        // Every message fits a frame, which a test of the protocol proves.
        self.out.length = encoded.unwrap_or(0);
    }
}

/// What the host has been told.
#[derive(Default)]
struct News {
    status: Option<Status>,
    /// Next scan of the stream to be sent, none while there is no stream.
    next_scan: Option<u64>,
    sequence: u16,
}

impl News {
    /// The next scans of the stream, when there are enough to be sent.
    fn scans(&mut self, rig: &Rig, record: &RefCell<Record>) -> Option<ScanBlock> {
        const SCANS: u64 = (SCAN_BLOCK_BYTES / Record::SCAN_BYTES) as u64;
        if !rig.stream.get() {
            self.next_scan = None;
            return None;
        }
        let record = record.try_borrow().ok()?;
        let Streamed { end, held } = rig.streamed.get();
        let oldest = end.checked_sub(held.min(record.len() as u64))?;
        // Scans that have left the record before they were sent are missing: the host sees the jump.
        let first = self.next_scan.map_or(oldest, |next| next.max(oldest));
        if first + SCANS > end {
            return None;
        }
        self.next_scan = Some(first + SCANS);
        let start = record.len().checked_sub((end - first) as usize)?;
        let mut codes = Vec::new();
        codes.resize(SCAN_BLOCK_BYTES, 0).ok()?;
        record.read_bytes(start * Record::SCAN_BYTES, &mut codes);
        Some(ScanBlock { first, codes })
    }

    fn encode<T: serde::Serialize>(
        &mut self,
        kind: u16,
        body: &T,
        out: &mut [u8; MAX_FRAME],
    ) -> usize {
        self.sequence = self.sequence.wrapping_add(1);
        encode_frame(kind, self.sequence, body, out).unwrap_or(0)
    }
}

/// Writes whole frames to the link, never for longer than [`WRITE_TIMEOUT`].
struct Sender<'r, W> {
    tx: W,
    /// The last frame did not leave whole: the next begins with a zero, which ends the torn one.
    broken: bool,
    /// A host has been heard and does read; news is sent to nobody else.
    listened: bool,
    rig: &'r Rig,
}

impl<W: Write> Sender<'_, W> {
    async fn send(&mut self, frame: Option<&[u8]>) {
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

//! Answers the host and tells it the news. Whatever arrives is checked; nothing that arrives can
//! block measuring: the session only changes shared state and wakes the measuring loop.

use massline_shared::signal::StaticReading;

use embassy_futures::select::{Either, select};
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::mutex::Mutex;
use embassy_time::{Duration, Timer, with_timeout};
use embedded_io_async::{Read, Write};
use embedded_storage_async::nor_flash::NorFlash;
use heapless::Vec;
use massline_protocol::event::{HIT, HitEvent, SCAN_BLOCK_BYTES, SCANS, STATUS_CHANGED, ScanBlock};
use massline_protocol::message::{
    ANSWER, CampaignCommand, Command, CommandRequest, DeleteResult, GetCalibration, GetIdentity,
    GetLayout, GetObjectInfo, GetReading, GetStats, GetStatus, LayoutAnswer, ListRequest,
    ListResults, MAX_CHANGE_ANSWER, PutCalibration, PutLayout, REFUSED, ReadObject, Reason,
    Refusal, ResultPage, SetStream, Status, TakeReading, changes,
};
use massline_protocol::object::{ChunkRef, ChunkRequest};
use massline_protocol::{
    Deframer, Endpoint, Frame, FrameError, MAX_FRAME, PlainFrame, crc32, encode_frame,
};
use massline_shared::calibration::CalibrationRecord;
use massline_shared::measurement::campaign::{Object, Start};
use massline_shared::measurement::{Recorded, Streamed};
use massline_shared::signal::Record;
use serde::de::DeserializeOwned;

use crate::deadline::Deadline;
use crate::objects::Objects;
use crate::rig::Rig;
use crate::store::{Store, StoreError, decode_layout};

/// A frame that has not left after this long is given up: nobody reads.
const WRITE_TIMEOUT: Duration = Duration::from_millis(500);

/// Events sent before the host is listened to again.
const NEWS_AT_ONCE: usize = 8;
/// A link that is gone, or says that it is empty, is asked again after this long.
const LINK_PAUSE: Duration = Duration::from_millis(10);

/// What the session keeps between two frames.
pub(crate) struct SessionMemory {
    deframer: Deframer,
    /// The answer or the event that is being sent.
    out: [u8; MAX_FRAME],
    done: Done,
}

impl SessionMemory {
    pub const fn new() -> Self {
        Self { deframer: Deframer::new(), out: [0; MAX_FRAME], done: Done::NOTHING }
    }
}

/// The last request when it changed the rig, and its answer: kept so that it is executed once however
/// often it arrives.
struct Done {
    /// Kind, sequence and body checksum of the request.
    request: Option<(u16, u16, u32)>,
    answer: Vec<u8, MAX_CHANGE_ANSWER>,
}

impl Done {
    const NOTHING: Self = Self { request: None, answer: Vec::new() };
}

/// What the session sees of the rest of the rig.
pub(crate) struct Session<'a, 'm, F: NorFlash> {
    pub rig: &'a Rig<'m>,
    pub store: &'a Mutex<NoopRawMutex, Store<F>>,
    pub objects: Objects<'a, 'm, F>,
}

impl<F: NorFlash> Session<'_, '_, F> {
    /// Serves the link for ever.
    pub async fn run(&self, mut rx: impl Read, tx: impl Write, memory: &mut SessionMemory) -> ! {
        let SessionMemory { deframer, out, done } = memory;
        let mut sender = Sender { tx, broken: true, listened: false, rig: self.rig };
        let mut news = News::default();
        let mut bytes = [0; 64];
        let mut intake = Intake::default();
        loop {
            match select(rx.read(&mut bytes), self.rig.news.wait()).await {
                // The link is gone.
                Either::First(Ok(0) | Err(_)) => {
                    sender.listened = false;
                    intake.lost = true;
                    Timer::after(LINK_PAUSE).await;
                }
                Either::First(Ok(n)) => {
                    let mut rest = bytes.get(..n).unwrap_or_default();
                    intake.heard(self.rig);
                    while !rest.is_empty() {
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
            self.tell(&mut news, &mut sender, out).await;
        }
    }

    /// Sends what has changed since the last call.
    async fn tell(
        &self,
        news: &mut News,
        sender: &mut Sender<'_, '_, impl Write>,
        out: &mut [u8; MAX_FRAME],
    ) {
        for _ in 0..NEWS_AT_ONCE {
            if !sender.listened {
                return;
            }
            match self.next_news(news, out) {
                0 => return,
                length => sender.send(out.get(..length)).await,
            }
        }
        // The rest after the next look at what the host wants.
        self.rig.news.signal(());
    }

    /// Writes the next event as a frame; gives its length, zero without news. An event is not held while its
    /// frame is sent.
    // Never inlined: 1.5 KB less of the firmware's deepest stack.
    #[inline(never)]
    fn next_news(&self, news: &mut News, out: &mut [u8; MAX_FRAME]) -> usize {
        let hit = self.rig.measurement.borrow_mut().next_hit();
        if let Some(hit) = hit {
            return news.encode(HIT, &HitEvent::from(hit), out);
        }
        if let Some(block) = news.scans(self.rig) {
            return news.encode(SCANS, &block, out);
        }
        let status = self.rig.status();
        if news.status.as_ref() == Some(&status) {
            return 0;
        }
        let length = news.encode(STATUS_CHANGED, &status, out);
        news.status = Some(status);
        length
    }

    /// Executes a request; gives its framed answer.
    async fn answer<'m>(
        &self,
        frame: Frame<'_>,
        out: &'m mut [u8; MAX_FRAME],
        done: &'m mut Done,
    ) -> Option<&'m [u8]> {
        let request = (frame.kind, frame.sequence, crc32(frame.body));
        if done.request == Some(request) {
            self.rig.stats.borrow_mut().requests_repeated += 1;
            return Some(&done.answer);
        }
        let mut reply = Reply { frame, out, length: 0 };
        if let Err(reason) = self.execute(&mut reply).await {
            self.rig.stats.borrow_mut().requests_refused += 1;
            reply.encode(REFUSED, &Refusal::from(reason));
        }
        let length = reply.length;
        let answer = out.get(..length)?;
        // A refusal counts as well: what was refused must not be executed when it is sent again.
        done.request = changes(frame.kind).then_some(request);
        if done.request.is_some() {
            // Every answer to a change fits, which a test of the protocol proves.
            done.answer = Vec::from_slice(answer).unwrap_or_default();
        }
        Some(answer)
    }

    async fn execute(&self, reply: &mut Reply<'_, '_>) -> Result<(), Reason> {
        let rig = self.rig;
        match reply.frame.kind {
            GetIdentity::KIND => reply.with::<GetIdentity>(&rig.identity()),
            GetStatus::KIND => reply.with::<GetStatus>(&rig.status()),
            GetStats::KIND => {
                let stats = self.store.lock().await.counted(rig.stats());
                reply.with::<GetStats>(&stats)
            }
            PutLayout::KIND => {
                let answer = self.put_layout(reply.frame.body).await?;
                reply.with::<PutLayout>(&answer)
            }
            GetLayout::KIND => {
                let measurement = rig.measurement.borrow();
                reply.with::<GetLayout>(measurement.layout().ok_or(Reason::NoLayout)?)
            }
            PutCalibration::KIND => {
                self.put_calibration(reply.frame.body).await?;
                reply.with::<PutCalibration>(&())
            }
            GetCalibration::KIND => {
                let record = self.calibration().await;
                reply.with::<GetCalibration>(&record)
            }
            Command::KIND => {
                let request = reply.request::<Command>()?;
                self.command(request).await?;
                reply.with::<Command>(&rig.status())
            }
            GetObjectInfo::KIND => {
                let object = reply.request::<GetObjectInfo>()?;
                let info = self.objects.info(object).await?;
                reply.with::<GetObjectInfo>(&info)
            }
            ReadObject::KIND => {
                let request = reply.request::<ReadObject>()?;
                let read = self.objects.read(request, reply.out).await?;
                reply.with_chunk(request, read);
                Ok(())
            }
            ListResults::KIND => {
                let page = self.list(reply.request::<ListResults>()?).await;
                reply.with::<ListResults>(&page)
            }
            DeleteResult::KIND => {
                let number = reply.request::<DeleteResult>()?;
                if !rig.measurement.borrow().rests() {
                    return Err(Reason::WrongPhase);
                }
                self.store.lock().await.delete_result(number).await?;
                reply.with::<DeleteResult>(&())
            }
            TakeReading::KIND => {
                rig.take_reading()?;
                reply.with::<TakeReading>(&())
            }
            GetReading::KIND => {
                let measurement = rig.measurement.borrow();
                match measurement.recorded() {
                    _ if measurement.reads() => Err(Reason::Busy),
                    Recorded::Reading => {
                        reply.with::<GetReading>(&StaticReading::of(measurement.record()))
                    }
                    Recorded::ReadingFailed => Err(Reason::SamplerStopped),
                    Recorded::Nothing | Recorded::Hit(_) => Err(Reason::NotFound),
                }
            }
            SetStream::KIND => {
                self.set_stream(reply.request::<SetStream>()?)?;
                reply.with::<SetStream>(&())
            }
            _ => Err(Reason::UnknownMessage),
        }
    }

    /// Takes a layout. It is decoded after the flash is written, so that it needs no memory meanwhile.
    async fn put_layout(&self, body: &[u8]) -> Result<LayoutAnswer, Reason> {
        let hash = crc32(body);
        let rig = self.rig;
        if decode_layout(body).is_none() {
            return Err(Reason::Malformed);
        }
        if hash != rig.layout_hash.get() {
            let write = async || {
                self.store.lock().await.put_layout(body).await?;
                Ok::<_, Reason>(rig.use_layout(body)?)
            };
            rig.changing(write).await?;
        }
        let _deadline = Deadline::begin(&rig.stats);
        let measurement = rig.measurement.borrow();
        let layout = measurement.layout().ok_or(Reason::NoLayout)?;
        Ok(LayoutAnswer { hash, diagnostics: measurement.check(layout) })
    }

    async fn put_calibration(&self, body: &[u8]) -> Result<(), Reason> {
        if !decode::<CalibrationRecord>(body)?.is_usable() {
            return Err(Reason::Malformed);
        }
        let write = async || {
            self.store.lock().await.put_calibration(body).await?;
            let record = decode::<CalibrationRecord>(body)?;
            self.rig.measurement.borrow_mut().set_calibration(record.calibration);
            Ok::<_, Reason>(())
        };
        self.rig.changing(write).await
    }

    /// The calibration in force; where it comes from is kept in the store alone.
    async fn calibration(&self) -> CalibrationRecord {
        let kept = self.store.lock().await.calibration().await;
        let calibration = *self.rig.measurement.borrow().calibration();
        CalibrationRecord { calibration, ..kept.unwrap_or_default() }
    }

    fn set_stream(&self, on: bool) -> Result<(), Reason> {
        let mut measurement = self.rig.measurement.borrow_mut();
        if on == measurement.streamed().is_some() {
            // Nothing changes: a record that is being taken is not disturbed.
            return Ok(());
        }
        if on && !self.rig.streams {
            return Err(Reason::WrongPhase);
        }
        measurement.set_stream(on)?;
        drop(measurement);
        self.rig.steered();
        Ok(())
    }

    /// Starts or steers the campaign.
    async fn command(&self, request: CommandRequest) -> Result<(), Reason> {
        let command = CampaignCommand::from_raw(request.command).ok_or(Reason::Malformed)?;
        if let Some(command) = command.steering() {
            return Ok(self.rig.command(command)?);
        }
        let object = match request.block_mass {
            None => Object::Unknown,
            Some(mass) if mass.is_finite() && mass > 0.0 => Object::Block { mass },
            Some(_) => return Err(Reason::Malformed),
        };
        let start = Start { object, confirm: request.confirm };
        let room = !self.store.lock().await.is_full(self.rig.dofs()).await;
        Ok(self.rig.start(start, request.force, room)?)
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

/// What has come in, as far as it is counted by the byte and by the plug.
#[derive(Default)]
struct Intake {
    /// Bytes since the end of the last frame.
    pending: u32,
    /// The link is gone.
    lost: bool,
}

impl Intake {
    /// Bytes have come: the link is there.
    fn heard(&mut self, rig: &Rig<'_>) {
        rig.stats.borrow_mut().reconnects += u32::from(core::mem::take(&mut self.lost));
    }

    /// The deframer took these bytes and found this in them.
    fn took(
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

impl From<StoreError> for Reason {
    fn from(error: StoreError) -> Self {
        match error {
            StoreError::NotFound => Self::NotFound,
            StoreError::Malformed => Self::Malformed,
            StoreError::Full => Self::StoreFull,
            StoreError::Failed => Self::StoreFailed,
        }
    }
}

/// The message of a whole body.
fn decode<T: DeserializeOwned>(body: &[u8]) -> Result<T, Reason> {
    match postcard::take_from_bytes(body) {
        Ok((message, [])) => Ok(message),
        _ => Err(Reason::Malformed),
    }
}

/// A request and where its answer goes.
struct Reply<'f, 'o> {
    frame: Frame<'f>,
    out: &'o mut [u8; MAX_FRAME],
    length: usize,
}

impl Reply<'_, '_> {
    fn request<E: Endpoint>(&self) -> Result<E::Request, Reason> {
        decode(self.frame.body)
    }

    fn with<E: Endpoint>(&mut self, response: &E::Response) -> Result<(), Reason> {
        self.encode(E::KIND | ANSWER, response);
        Ok(())
    }

    /// Answers with the bytes of an object that stand at the front of `out`.
    fn with_chunk(&mut self, request: ChunkRequest, read: usize) {
        let bytes = self.out.get(..read).unwrap_or_default();
        let chunk = ChunkRef { object: request.object, offset: request.offset, bytes };
        let plain = PlainFrame::new(ReadObject::KIND | ANSWER, self.frame.sequence, &chunk);
        self.length = plain.map_or(0, |plain| plain.stuff(self.out));
    }

    fn encode<T: serde::Serialize>(&mut self, kind: u16, body: &T) {
        // Every message fits a frame, which a test of the protocol proves.
        self.length = encode_frame(kind, self.frame.sequence, body, self.out).unwrap_or(0);
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
    fn scans(&mut self, rig: &Rig<'_>) -> Option<ScanBlock> {
        const SCANS: u64 = (SCAN_BLOCK_BYTES / Record::SCAN_BYTES) as u64;
        let measurement = rig.measurement.borrow();
        let Some(Streamed { end, held }) = measurement.streamed() else {
            self.next_scan = None;
            return None;
        };
        let record = measurement.record();
        let oldest = end.checked_sub(held.min(record.len() as u64))?;
        // Scans that have left the record before they were sent are missing: the host sees the jump.
        let first = self.next_scan.map_or(oldest, |next| next.max(oldest));
        if first + SCANS > end {
            return None;
        }
        // A stream that has not filled the record yet has jumped because scans were lost, or begins.
        if held > record.len() as u64 {
            let gone = self.next_scan.map_or(0, |next| first - next);
            rig.stats.borrow_mut().stream_scans_dropped += gone as u32;
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
struct Sender<'r, 'm, W> {
    tx: W,
    /// The last frame did not leave whole: the next begins with a zero, which ends the torn one.
    broken: bool,
    /// A host has been heard and does read; news is sent to nobody else.
    listened: bool,
    rig: &'r Rig<'m>,
}

impl<W: Write> Sender<'_, '_, W> {
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

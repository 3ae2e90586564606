//! Executes requests from the host.

use embedded_storage_async::nor_flash::NorFlash;
use heapless::Vec;
use massline_protocol::message::{
    ANSWER, DeleteResult, GetBattery, GetCalibration, GetHardware, GetIdentity, GetLayout,
    GetLevels, GetMassLines, GetObjectInfo, GetRestStatistics, GetStats, GetStatus, LayoutAnswer,
    ListRequest, ListResults, PutCalibration, PutLayout, REFUSED, ReadObject, Reason, Refusal,
    ResultPage, SetBrownOut, SetStream, StartCampaign, StartRequest, SteerCampaign, TakeReading,
};
use massline_protocol::object::{ChunkRef, ChunkRequest, DofResult};
use massline_protocol::{Endpoint, Frame, MAX_FRAME, PlainFrame, crc32, encode_frame};
use massline_shared::calibration::CalibrationRecord;
use massline_shared::measurement::RecordContent;
use massline_shared::measurement::campaign::Object;
use massline_shared::signal::RestStatistics;
use serde::de::DeserializeOwned;

use super::Session;
use super::objects::Objects;
use crate::deadline::Deadline;
use crate::store::{StoreError, decode_layout};

impl<'a, 'm, F: NorFlash> Session<'a, 'm, F> {
    /// Executes a request and writes the answer into `reply`.
    pub(super) async fn execute(&self, reply: &mut Reply<'_, '_>) -> Result<(), Reason> {
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
                reply.with::<GetLayout>(&measurement.stated_layout().ok_or(Reason::NoLayout)?)
            }
            PutCalibration::KIND => {
                self.put_calibration(reply.frame.body).await?;
                reply.with::<PutCalibration>(&())
            }
            GetCalibration::KIND => {
                let record = self.calibration().await;
                reply.with::<GetCalibration>(&record)
            }
            StartCampaign::KIND => {
                let request = reply.request::<StartCampaign>()?;
                self.start(request, &mut reply.results_to_delete).await?;
                reply.with::<StartCampaign>(&rig.status())
            }
            SteerCampaign::KIND => {
                rig.command(reply.request::<SteerCampaign>()?)?;
                reply.with::<SteerCampaign>(&rig.status())
            }
            GetObjectInfo::KIND => {
                let object = reply.request::<GetObjectInfo>()?;
                let info = self.objects().info(object, reply.out).await?;
                reply.with::<GetObjectInfo>(&info)
            }
            ReadObject::KIND => {
                let request = reply.request::<ReadObject>()?;
                let read = self.objects().read(request, reply.out).await?;
                reply.with_chunk(request, read);
                Ok(())
            }
            ListResults::KIND => {
                let page = self.list(reply.request::<ListResults>()?).await;
                reply.with::<ListResults>(&page)
            }
            DeleteResult::KIND => {
                let number = reply.request::<DeleteResult>()?;
                let delete = async || {
                    self.store.lock().await.delete_result(number).await?;
                    Ok::<(), Reason>(())
                };
                rig.deleting(delete).await?;
                reply.with::<DeleteResult>(&())
            }
            TakeReading::KIND => {
                rig.take_reading()?;
                reply.with::<TakeReading>(&())
            }
            GetRestStatistics::KIND => {
                let measurement = rig.measurement.borrow();
                match measurement.recorded() {
                    _ if measurement.reads() => Err(Reason::Busy),
                    RecordContent::Reading => {
                        reply.with::<GetRestStatistics>(&RestStatistics::of(measurement.record()))
                    }
                    RecordContent::ReadingFailed => Err(Reason::SamplerStopped),
                    RecordContent::Nothing
                    | RecordContent::Hit(_)
                    | RecordContent::HitBefore(_) => Err(Reason::NotFound),
                }
            }
            GetMassLines::KIND => {
                let index = reply.request::<GetMassLines>()?;
                let dof = self.mass_lines(index.into()).ok_or(Reason::NotFound)?;
                reply.with::<GetMassLines>(&dof)
            }
            GetLevels::KIND => reply.with::<GetLevels>(&rig.levels.get()),
            GetHardware::KIND => reply.with::<GetHardware>(&rig.info.hardware()),
            GetBattery::KIND => reply.with::<GetBattery>(&rig.info.supply.charge()),
            SetBrownOut::KIND => {
                let level = rig.info.supply.brown_out.ok_or(Reason::UnknownMessage)?;
                if (rig.info.supply.is_low)() {
                    return Err(Reason::SupplyLow);
                }
                if !rig.measurement.borrow().rests() {
                    return Err(Reason::WrongPhase);
                }
                (level.raise)();
                reply.with::<SetBrownOut>(&())
            }
            SetStream::KIND => {
                self.set_stream(reply.request::<SetStream>()?)?;
                reply.with::<SetStream>(&())
            }
            _ => Err(Reason::UnknownMessage),
        }
    }

    /// Stores a layout and puts it into use. The decoded layout takes no memory while the flash is
    /// written: it is decoded again afterwards.
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
            let gains = record.budget();
            self.rig.measurement.borrow_mut().set_calibration(record.calibration, gains);
            Ok::<_, Reason>(())
        };
        self.rig.changing(write).await
    }

    /// The calibration in force. Its origin is stored in flash only, so it is read from there.
    async fn calibration(&self) -> CalibrationRecord {
        let stored = self.store.lock().await.calibration().await;
        let calibration = *self.rig.measurement.borrow().calibration();
        CalibrationRecord { calibration, ..stored.unwrap_or_default() }
    }

    /// The mass lines of the DOF with this index in the layout.
    fn mass_lines(&self, index: usize) -> Option<DofResult> {
        let measurement = self.rig.measurement.borrow();
        let result = measurement.result();
        let place = result.mass_lines.iter().position(|(dof, _)| *dof == index)?;
        Some(DofResult::of(result.dofs.get(place)?, result.mass_lines.get(place)?))
    }

    fn set_stream(&self, on: bool) -> Result<(), Reason> {
        let mut measurement = self.rig.measurement.borrow_mut();
        if on == measurement.streamed().is_some() {
            // Nothing to change; a record that is being taken is not disturbed.
            return Ok(());
        }
        if on && !self.rig.streams {
            return Err(Reason::WrongPhase);
        }
        self.rig.unless_deleting()?;
        measurement.set_stream(on)?;
        drop(measurement);
        self.rig.steered();
        Ok(())
    }

    /// Starts a campaign. When there is too little room, `results_to_delete` says how many results would make it.
    async fn start(
        &self,
        StartRequest { start, force }: StartRequest,
        results_to_delete: &mut u8,
    ) -> Result<(), Reason> {
        if let Object::Block { mass } = start.object
            && !(mass.is_finite() && mass > 0.0)
        {
            return Err(Reason::Malformed);
        }
        let shortage = self.store.lock().await.shortage(self.rig.campaign_size()).await;
        *results_to_delete = shortage.map_or(0, |shortage| shortage.results_to_delete());
        Ok(self.rig.start(start, force, shortage.is_none())?)
    }

    async fn list(&self, request: ListRequest) -> ResultPage {
        let store = self.store.lock().await;
        let mut page = ResultPage { entries: Vec::new(), more: false };
        for stored in store.results().iter().filter(|stored| stored.entry.number > request.after) {
            page.more |= page.entries.push(stored.entry).is_err();
        }
        page
    }

    fn objects(&self) -> Objects<'a, 'm, F> {
        Objects { rig: self.rig, store: self.store }
    }
}

/// A request and the buffer for its answer.
pub(super) struct Reply<'f, 'o> {
    frame: Frame<'f>,
    out: &'o mut [u8; MAX_FRAME],
    length: usize,
    /// What a refusal says besides its reason.
    results_to_delete: u8,
}

impl<'f, 'o> Reply<'f, 'o> {
    /// A reply without an answer yet.
    pub fn new(frame: Frame<'f>, out: &'o mut [u8; MAX_FRAME]) -> Self {
        Self { frame, out, length: 0, results_to_delete: 0 }
    }

    /// Length of the framed answer.
    pub fn length(&self) -> usize {
        self.length
    }

    fn request<E: Endpoint>(&self) -> Result<E::Request, Reason> {
        decode(self.frame.body)
    }

    fn with<E: Endpoint>(&mut self, response: &E::Response) -> Result<(), Reason> {
        self.encode(E::KIND | ANSWER, response);
        Ok(())
    }

    /// Answers with the `read` bytes of an object at the front of `out`.
    fn with_chunk(&mut self, request: ChunkRequest, read: usize) {
        let bytes = self.out.get(..read).unwrap_or_default();
        let chunk = ChunkRef { object: request.object, offset: request.offset, bytes };
        let plain = PlainFrame::new(ReadObject::KIND | ANSWER, self.frame.sequence, &chunk);
        self.length = plain.map_or(0, |plain| plain.stuff(self.out));
    }

    /// Answers that the request is refused.
    pub fn refuse(&mut self, reason: Reason) {
        let results_to_delete = match reason {
            Reason::StoreFull => self.results_to_delete,
            _ => 0,
        };
        self.encode(REFUSED, &Refusal { reason: reason.into(), results_to_delete });
    }

    fn encode<T: serde::Serialize>(&mut self, kind: u16, body: &T) {
        // Every message fits a frame; a test of the protocol proves it.
        self.length = encode_frame(kind, self.frame.sequence, body, self.out).unwrap_or(0);
    }
}

impl From<StoreError> for Reason {
    fn from(error: StoreError) -> Self {
        match error {
            StoreError::NotFound => Self::NotFound,
            StoreError::Malformed => Self::Malformed,
            StoreError::Full => Self::StoreFull,
            StoreError::Failed => Self::StoreFailed,
            StoreError::SupplyLow => Self::SupplyLow,
        }
    }
}

/// Decodes a body, which must hold one message and nothing after it.
fn decode<T: DeserializeOwned>(body: &[u8]) -> Result<T, Reason> {
    match postcard::take_from_bytes(body) {
        Ok((message, [])) => Ok(message),
        _ => Err(Reason::Malformed),
    }
}

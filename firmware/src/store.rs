//! Stores what survives a restart: layouts, calibration, results, the finished DOFs of the current campaign, and
//! those with lines of the results.
//!
//! Everything is written to a log of records in the board's flash region (`log`, `record`), which is safe
//! against a power cut at any word. An *object* is the bytes of one stored item, written as pieces that
//! share a serial. An object exists once the *change* that names it (`contents`) has been written to the
//! log, and the change is written after the last piece has been read back. After a torn write the store
//! therefore holds the previous state, and never half of an object.
//!
//! Flash is erased only by the functions that store or delete something; they are called only while the
//! sampler is stopped.

mod campaign;
mod contents;
mod error;
mod log;
mod reading;
mod record;
mod room;
mod source;
mod writing;

use embedded_storage_async::nor_flash::NorFlash;
use heapless::String;
use massline_protocol::MAX_LAYOUT;
use massline_protocol::message::{EstimatedMass, Stats};
use massline_shared::calibration::CalibrationRecord;
use massline_shared::identify::MASS_LINE_METHODS;
use massline_shared::layout::{RIG_HITS, RigLayout, TestProfile};
use massline_shared::signal::{COMPACT_RESPONSE, RESPONSES};

use contents::{Change, Contents};
pub use contents::{DOFS, DofHandle, LayoutHandle, ResultHandle};
pub use error::StoreError;
use log::{Checkpoint, Log, Work};
pub use room::{CampaignSize, Shortage};
pub use source::{DofWithLines, Source};
use writing::MAX_PIECE;

use crate::screen_setting::ScreenSetting;

/// Most results that the store holds, if the flash has room for them.
pub const RESULTS: usize = 24;
/// Most layouts that the store holds.
pub const LAYOUTS: usize = 4;
/// Most bytes of one finished DOF without lines, stored separately or as a part of a result.
pub const MAX_DOF: usize = 386;
/// Most bytes of the lines of one finished DOF.
pub const MAX_LINES: usize = RESPONSES * COMPACT_RESPONSE;
/// Most bytes of one estimate in a result.
pub const MAX_ESTIMATE: usize = 424;
/// Most bytes of one result: its head and diagnostics, its DOFs and its estimates.
pub const MAX_RESULT: usize =
    MAX_RESULT_HEAD + RIG_HITS * MAX_DOF + MASS_LINE_METHODS * MAX_ESTIMATE;
/// Most bytes of the head and the diagnostics of a result.
pub const MAX_RESULT_HEAD: usize = 268;
/// Most bytes of what a result says of a DOF besides its lines.
pub const MAX_LINES_HEAD: usize = 72;
/// Most bytes of the progress of a campaign.
pub const MAX_PROGRESS: usize = 280;

/// Room for an encoded calibration: numbers and texts are not longer encoded, except for the lengths.
const CALIBRATION_ROOM: usize = size_of::<CalibrationRecord>() + 16;

/// The store, over a flash region for its exclusive use.
pub struct Store<F: NorFlash> {
    log: Log<F>,
    contents: Contents,
    /// The piece or the change that is being written. It is here once: in the futures it would be once for each task
    /// that writes.
    piece: [u8; MAX_PIECE],
    /// The last serial that was assigned.
    serial: u32,
    /// Serial of the object that is being written.
    writing: u32,
    usable: bool,
    failures: u32,
    supply_is_low: fn() -> bool,
}

impl<F: NorFlash> Store<F> {
    /// A store over the whole of `flash`. Every write returns [`StoreError::Failed`] until
    /// [`Store::open`] has succeeded, and always if the region is unusable for a store. A write returns
    /// [`StoreError::SupplyLow`], and what is stored stays as it was, when `supply_is_low`.
    // Always inlined, so that it is built in place: this saves 1.1 KB of the firmware's deepest stack.
    #[inline(always)]
    pub fn new(flash: F, supply_is_low: fn() -> bool) -> Self {
        Self {
            log: Log::new(flash),
            contents: Contents::default(),
            piece: [0; MAX_PIECE],
            serial: 0,
            writing: 0,
            usable: false,
            failures: 0,
            supply_is_low,
        }
    }

    /// Reads what is stored; to be called once before anything else. Writes nothing.
    ///
    /// * Data in the format of other firmware is ignored, and is overwritten from now on.
    /// * If not a single page can be read, the content may still be intact. Until the next start the
    ///   store shows nothing, and every write returns [`StoreError::Failed`].
    pub async fn open(&mut self) {
        if !self.log.is_usable() {
            return;
        }
        match self.log.open().await {
            Ok(checkpoint) => {
                let Checkpoint { serial, last_number } = checkpoint.unwrap_or_default();
                self.serial = serial;
                self.contents.last_number = last_number;
                self.read_changes().await;
                self.find_objects().await;
                self.failures += self.contents.drop_torn();
                self.usable = true;
            }
            Err(_) => self.failures += 1,
        }
    }

    /// Number of failures: writes that failed, stored objects found torn, and one if the flash could not
    /// be read at the start.
    pub fn failures(&self) -> u32 {
        self.failures
    }

    /// Adds the store's counters to `stats`.
    pub fn counted(&self, stats: Stats) -> Stats {
        let Work { erases, bytes, read_back_failures } = self.log.work();
        Stats {
            store_failures: self.failures,
            flash_erases: erases,
            flash_bytes_written: bytes,
            read_back_failures,
            ..stats
        }
    }

    /// The stored layouts.
    pub fn layouts(&self) -> &[LayoutHandle] {
        &self.contents.layouts
    }

    /// The layout in use as postcard bytes, read into `room`. It is not decoded here, because a decoded
    /// layout would take memory in every future that waits for the flash.
    pub async fn layout<'r>(&mut self, room: &'r mut [u8; MAX_LAYOUT]) -> Option<&'r [u8]> {
        let object = self.contents.layout_in_use()?;
        self.read_whole(object, room).await
    }

    /// Stores a layout, given by its postcard bytes, and puts it into use. If there are already
    /// [`LAYOUTS`], the least recently used one is removed, those without a result first. The parameter is not a
    /// decoded layout, which would take memory beside the bytes while the flash is written.
    ///
    /// # Errors
    /// [`StoreError::Malformed`] when the bytes are not a layout, [`StoreError::Full`], or
    /// [`StoreError::Failed`] when the write fails.
    pub async fn put_layout(&mut self, encoded: &[u8]) -> Result<(), StoreError> {
        let (title, profile) = named(encoded).ok_or(StoreError::Malformed)?;
        self.put_named_layout(&encoded, &title, profile).await
    }

    /// The same with a layout that is encoded while it is written, and its title and profile.
    ///
    /// # Errors
    /// Those of [`Self::put_layout`].
    pub(crate) async fn put_named_layout(
        &mut self,
        layout: &dyn Source,
        title: &String<48>,
        profile: TestProfile,
    ) -> Result<(), StoreError> {
        let hash = layout.checksum();
        if self.contents.layout(hash).is_some() {
            return self.use_layout(hash).await;
        }
        let evicted = self.contents.layout_to_evict();
        let change =
            |object| Change::Layout { hash, title: title.clone(), profile, object, evicted };
        self.keep(layout, &change).await
    }

    /// Puts a stored layout into use.
    ///
    /// # Errors
    /// [`StoreError::NotFound`], or [`StoreError::Failed`].
    pub async fn use_layout(&mut self, hash: u32) -> Result<(), StoreError> {
        let stored = self.contents.layout(hash).ok_or(StoreError::NotFound)?;
        let LayoutHandle { title, profile, object, .. } = stored.clone();
        self.note(Change::Layout { hash, title, profile, object, evicted: None }).await
    }

    /// The stored calibration.
    pub async fn calibration(&mut self) -> Option<CalibrationRecord> {
        let object = self.contents.calibration?;
        self.decode(object, &mut [0; CALIBRATION_ROOM]).await
    }

    /// Stores a calibration, given by its postcard bytes.
    ///
    /// # Errors
    /// [`StoreError::Full`], or [`StoreError::Failed`] when the write fails.
    pub async fn put_calibration(&mut self, encoded: &[u8]) -> Result<(), StoreError> {
        self.keep(&encoded, &|object| Change::Calibration { object }).await
    }

    /// Which controller the screen has.
    pub fn screen(&self) -> ScreenSetting {
        self.contents.screen.map_or_else(ScreenSetting::default, |(_, setting)| setting)
    }

    /// Stores which controller the screen has.
    ///
    /// # Errors
    /// [`StoreError::Full`], or [`StoreError::Failed`] when the write fails.
    pub async fn put_screen(&mut self, setting: ScreenSetting) -> Result<(), StoreError> {
        self.note(Change::Screen { setting }).await
    }

    /// All results, in the order of their numbers.
    pub fn results(&self) -> &[ResultHandle] {
        &self.contents.results
    }

    /// The result with this number.
    pub fn find(&self, number: u32) -> Option<ResultHandle> {
        self.contents.results.iter().copied().find(|stored| stored.entry.number == number)
    }

    /// The number of the next result. Numbers are never reused.
    pub fn next_number(&self) -> u32 {
        self.contents.last_number + 1
    }

    /// Stores a result under [`Store::next_number`]; this ends the current campaign. Returns the number.
    ///
    /// # Errors
    /// [`StoreError::Full`], or [`StoreError::Failed`] when the write fails.
    pub async fn put_result(
        &mut self,
        result: &(impl Source + ?Sized),
        layout: u32,
        mass: Option<EstimatedMass>,
    ) -> Result<u32, StoreError> {
        if self.contents.results.is_full() || result.length() > MAX_RESULT {
            return Err(StoreError::Full);
        }
        self.evict_layouts_for(result.length()).await?;
        let (number, campaign, crc) =
            (self.next_number(), self.contents.campaign.serial, result.checksum());
        let change = |object| Change::Result { object, number, layout, mass, crc, campaign };
        self.keep(&result, &change).await?;
        Ok(number)
    }

    /// Deletes a result and its DOFs with lines.
    ///
    /// # Errors
    /// [`StoreError::NotFound`], or [`StoreError::Failed`].
    pub async fn delete_result(&mut self, number: u32) -> Result<(), StoreError> {
        let campaign = self.find(number).ok_or(StoreError::NotFound)?.campaign;
        self.note(Change::Deleted { number, campaign }).await
    }

    /// Reads part of a result into `out`, starting at `offset`; returns the number of bytes read.
    ///
    /// # Errors
    /// [`StoreError::Failed`] when a part of it cannot be read.
    pub async fn read_result(
        &mut self,
        stored: &ResultHandle,
        offset: usize,
        out: &mut [u8],
    ) -> Result<usize, StoreError> {
        self.read(stored.object, offset, out).await.ok_or(StoreError::Failed)
    }

    /// Length of the layout with this hash, bytes.
    pub fn length_of_layout(&self, hash: u32) -> Option<usize> {
        self.contents.layout(hash).map(|stored| stored.object.length.into())
    }

    /// Reads as much of the layout with this hash from `offset` on as fits into `out`. Returns the number of bytes
    /// read.
    ///
    /// # Errors
    /// [`StoreError::NotFound`] when it has been replaced, or [`StoreError::Failed`] when a part of it cannot be read.
    pub async fn read_layout(
        &mut self,
        hash: u32,
        offset: usize,
        out: &mut [u8],
    ) -> Result<usize, StoreError> {
        let object = self.contents.layout(hash).ok_or(StoreError::NotFound)?.object;
        self.read(object, offset, out).await.ok_or(StoreError::Failed)
    }

    fn next_serial(&mut self) -> u32 {
        self.serial += 1;
        self.serial
    }
}

/// Title and profile of an encoded layout; `None` when the bytes are not a layout.
fn named(encoded: &[u8]) -> Option<(String<48>, TestProfile)> {
    decode_layout(encoded).map(|layout| (layout.title, layout.test.profile))
}

/// Decodes a layout; `None` when the bytes are not exactly one layout.
pub(crate) fn decode_layout(encoded: &[u8]) -> Option<RigLayout> {
    match postcard::take_from_bytes(encoded) {
        Ok((layout, [])) if encoded.len() <= MAX_LAYOUT => Some(layout),
        _ => None,
    }
}

//! What survives a restart: layouts, calibration, results, and the finished DOFs of the campaign that
//! is under way.
//!
//! Everything lies in a log of records in the board's flash region (`log`, `record`), which is safe
//! against a cut of the power at any word. An *object* is the bytes of one thing that is kept, as
//! pieces that share a serial. It is there from the moment when the *change* that names it (`contents`)
//! stands in the log, which is written after the last piece has been read back: a torn write shows as
//! nothing, or as what was there before, and never as half of something.
//!
//! Flash is erased only by the functions that keep or delete something, which are called only while
//! nothing is sampled.

mod contents;
mod error;
mod log;
mod reading;
mod record;
mod source;
mod writing;

use embedded_storage_async::nor_flash::NorFlash;
use heapless::String;
use massline_protocol::message::{EstimatedMass, Stats};
use massline_protocol::{MAX_LAYOUT, crc32};
use massline_shared::calibration::CalibrationRecord;
use massline_shared::identify::MASS_LINE_METHODS;
use massline_shared::layout::{RIG_HITS, RigLayout};

use contents::{Change, Contents};
pub use contents::{LayoutHandle, ResultHandle};
pub use error::StoreError;
use log::{Checkpoint, Log, Work};
pub use source::Source;

/// Results that the store holds, if the flash has room for them.
pub const RESULTS: usize = 24;
/// Layouts that the store holds.
pub const LAYOUTS: usize = 4;
/// The most bytes of one finished DOF, by itself and as a part of a result.
pub const MAX_DOF: usize = 306;
/// The most bytes of one answer in a result.
pub const MAX_ESTIMATE: usize = 424;
/// The most bytes of one result: what is said of it and of its campaign, its DOFs and its answers.
pub const MAX_RESULT: usize = 184 + RIG_HITS * MAX_DOF + MASS_LINE_METHODS * MAX_ESTIMATE;
/// The most bytes of the progress of a campaign.
pub const MAX_PROGRESS: usize = 272;

/// Room for an encoded calibration: numbers and texts take less encoded, and a length each.
const CALIBRATION_ROOM: usize = size_of::<CalibrationRecord>() + 16;

/// The store over a flash region that belongs to it alone.
pub struct Store<F: NorFlash> {
    log: Log<F>,
    contents: Contents,
    /// The last serial that was given.
    serial: u32,
    /// Serial of the object that is being written.
    writing: u32,
    usable: bool,
    failures: u32,
}

impl<F: NorFlash> Store<F> {
    /// A store over the whole of `flash`, to be opened. Until then, and for ever over a region that a store
    /// cannot use, it refuses every write with [`StoreError::Failed`].
    // Always inlined, so that it is built where it stays: 1.1 KB less of the firmware's deepest stack.
    #[inline(always)]
    pub fn new(flash: F) -> Self {
        Self {
            log: Log::new(flash),
            contents: Contents::default(),
            serial: 0,
            writing: 0,
            usable: false,
            failures: 0,
        }
    }

    /// Finds out what is kept; to be called once before anything else. Writes nothing.
    ///
    /// * What other firmware has kept in another format is passed over; it gives way to what is kept
    ///   from now on.
    /// * Flash of which not a single page answers: the content may be whole. Until the next start the
    ///   store shows nothing and refuses every write with [`StoreError::Failed`].
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

    /// Writes that failed verification, things that were kept and have been found torn, and one when
    /// the flash did not answer at the start.
    pub fn failures(&self) -> u32 {
        self.failures
    }

    /// What has been counted, with the part of the store.
    pub fn counted(&self, stats: Stats) -> Stats {
        let Work { erases, bytes, not_kept } = self.log.work();
        Stats {
            store_failures: self.failures,
            flash_erases: erases,
            flash_bytes_written: bytes,
            read_back_failures: not_kept,
            ..stats
        }
    }

    /// The kept layouts.
    pub fn layouts(&self) -> &[LayoutHandle] {
        &self.contents.layouts
    }

    /// The layout in use as postcard bytes, read into `room`: a decoded one would stay in the memory of
    /// whoever waits for the flash.
    pub async fn layout<'r>(&mut self, room: &'r mut [u8; MAX_LAYOUT]) -> Option<&'r [u8]> {
        let object = self.contents.layout_in_use()?;
        self.read_whole(object, room).await
    }

    /// Keeps a layout and takes it into use, given by its postcard bytes: a decoded one would stay in
    /// memory beside them while the flash is written. The layout that was in use the longest ago gives
    /// way when there are [`LAYOUTS`].
    ///
    /// # Errors
    /// [`StoreError::Malformed`] when the bytes are no layout, [`StoreError::Full`], or
    /// [`StoreError::Failed`] when the flash does not keep it.
    pub async fn put_layout(&mut self, encoded: &[u8]) -> Result<(), StoreError> {
        let hash = crc32(encoded);
        if self.contents.layout(hash).is_some() {
            return self.use_layout(hash).await;
        }
        let title = &title_of(encoded).ok_or(StoreError::Malformed)?;
        let gave_way = self.contents.gives_way();
        self.keep(encoded, |object| Change::Layout { hash, title: title.clone(), object, gave_way })
            .await
    }

    /// Takes a kept layout into use.
    ///
    /// # Errors
    /// [`StoreError::NotFound`], or [`StoreError::Failed`].
    pub async fn use_layout(&mut self, hash: u32) -> Result<(), StoreError> {
        let (object, title) = self.contents.layout(hash).ok_or(StoreError::NotFound)?;
        let title = title.clone();
        self.note(Change::Layout { hash, title, object, gave_way: None }).await
    }

    /// The kept calibration.
    pub async fn calibration(&mut self) -> Option<CalibrationRecord> {
        let object = self.contents.calibration?;
        self.decode(object, &mut [0; CALIBRATION_ROOM]).await
    }

    /// Keeps a calibration, given by its postcard bytes.
    ///
    /// # Errors
    /// [`StoreError::Full`], or [`StoreError::Failed`] when the flash does not keep it.
    pub async fn put_calibration(&mut self, encoded: &[u8]) -> Result<(), StoreError> {
        self.keep(encoded, |object| Change::Calibration { object }).await
    }

    /// All results, in the order of their numbers.
    pub fn results(&self) -> &[ResultHandle] {
        &self.contents.results
    }

    /// The result of this number.
    pub fn find(&self, number: u32) -> Option<ResultHandle> {
        self.contents.results.iter().copied().find(|kept| kept.entry.number == number)
    }

    /// True when there is no room for another campaign over `dofs` DOFs, all of its progress and its result.
    pub async fn is_full(&mut self, dofs: usize) -> bool {
        let dofs = dofs.min(RIG_HITS);
        let longest_result = MAX_RESULT - (RIG_HITS - dofs) * MAX_DOF;
        let progress = 2 * Self::cost(MAX_PROGRESS) + dofs as u32 * Self::cost(MAX_DOF);
        let campaign = progress + Self::cost(longest_result);
        self.contents.results.is_full() || !self.has_room(campaign).await
    }

    /// The number that the next result gets. Numbers are never used again.
    pub fn next_number(&self) -> u32 {
        self.contents.last_number + 1
    }

    /// Keeps a result under [`Store::next_number`]. The campaign that is under way has ended with it.
    ///
    /// # Errors
    /// [`StoreError::Full`], or [`StoreError::Failed`] when the flash does not keep it.
    pub async fn put_result(
        &mut self,
        result: &(impl Source + ?Sized),
        layout: u32,
        mass: Option<EstimatedMass>,
    ) -> Result<u32, StoreError> {
        if self.contents.results.is_full() || result.length() > MAX_RESULT {
            return Err(StoreError::Full);
        }
        let (number, campaign, crc) =
            (self.next_number(), self.contents.campaign.serial, result.checksum());
        let change = |object| Change::Result { object, number, layout, mass, crc, campaign };
        self.keep(result, change).await?;
        Ok(number)
    }

    /// Forgets a result.
    ///
    /// # Errors
    /// [`StoreError::NotFound`], or [`StoreError::Failed`].
    pub async fn delete_result(&mut self, number: u32) -> Result<(), StoreError> {
        self.find(number).ok_or(StoreError::NotFound)?;
        self.note(Change::Deleted { number }).await
    }

    /// Reads part of a result into `out`, from `offset` on; gives how many bytes there were.
    ///
    /// # Errors
    /// [`StoreError::Failed`] when some of it cannot be read.
    pub async fn read_result(
        &mut self,
        kept: &ResultHandle,
        offset: usize,
        out: &mut [u8],
    ) -> Result<usize, StoreError> {
        self.read(kept.object, offset, out).await.ok_or(StoreError::Failed)
    }

    /// Keeps a finished DOF of the campaign that is under way, by its index in the layout.
    /// [`Store::put_progress`] follows: without it nothing is known of the campaign.
    ///
    /// # Errors
    /// [`StoreError::Full`], or [`StoreError::Failed`] when the flash does not keep it.
    pub async fn put_dof(&mut self, index: u8, bytes: &[u8]) -> Result<(), StoreError> {
        let campaign = self.campaign();
        self.keep(bytes, |object| Change::Dof { object, campaign, index }).await
    }

    /// Keeps how far the campaign has come.
    ///
    /// # Errors
    /// [`StoreError::Full`], or [`StoreError::Failed`] when the flash does not keep it.
    pub async fn put_progress(&mut self, bytes: &[u8]) -> Result<(), StoreError> {
        let campaign = self.campaign();
        self.keep(bytes, |object| Change::Progress { object, campaign }).await
    }

    /// True when the progress of a campaign is kept that has not ended.
    pub fn has_progress(&self) -> bool {
        self.contents.campaign.serial != 0
    }

    /// How far the campaign had come, read into `room`.
    pub async fn progress<'r>(&mut self, room: &'r mut [u8]) -> Option<&'r [u8]> {
        let object = self.contents.campaign.progress?;
        self.read_whole(object, room).await
    }

    /// The `i`th finished DOF of the campaign in the order of their keeping, read into `room`; `None` behind
    /// the last.
    pub async fn dof<'r>(&mut self, i: usize, room: &'r mut [u8]) -> Option<&'r [u8]> {
        let dofs = &self.contents.campaign.dofs;
        let place = |serial: u32| dofs.iter().filter(|(_, other)| other.serial < serial).count();
        let (_, object) = *dofs.iter().find(|(_, object)| place(object.serial) == i)?;
        self.read_whole(object, room).await
    }

    /// Forgets the progress of the campaign: what is kept from now on belongs to another one.
    ///
    /// # Errors
    /// [`StoreError::Failed`] when the flash does not keep that; then, as long as no other campaign is
    /// kept, the next start finds it again.
    pub async fn clear_progress(&mut self) -> Result<(), StoreError> {
        let campaign = self.contents.campaign.serial;
        if campaign == 0 {
            return Ok(());
        }
        let noted = self.note(Change::Ended { campaign }).await;
        self.contents.end(campaign);
        noted
    }

    /// The name of the campaign that is under way, a new one when nothing is kept of it.
    fn campaign(&mut self) -> u32 {
        match self.contents.campaign.serial {
            0 => self.next_serial(),
            serial => serial,
        }
    }

    fn next_serial(&mut self) -> u32 {
        self.serial += 1;
        self.serial
    }
}

/// The title of an encoded layout; `None` when the bytes are no layout.
fn title_of(encoded: &[u8]) -> Option<String<48>> {
    decode_layout(encoded).map(|layout| layout.title)
}

/// The layout that the bytes are, whole and without a rest; `None` when they are none.
pub(crate) fn decode_layout(encoded: &[u8]) -> Option<RigLayout> {
    match postcard::take_from_bytes(encoded) {
        Ok((layout, [])) if encoded.len() <= MAX_LAYOUT => Some(layout),
        _ => None,
    }
}

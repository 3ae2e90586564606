//! What survives a restart: layout, calibration, results.
//!
//! Everything is an item of a wear-levelled map in the board's flash region. A result is cut into
//! chunks that fit any flash page; it exists from the moment when the *index* that names it is
//! written, which happens last, so a torn write shows as no result and never as half of one. What is
//! written is read back before it is believed.
//!
//! *Slot*: room for one result; the chunks of slot `s` have keys of their own.

use embedded_storage_async::nor_flash::NorFlash;
use heapless::Vec;
use massline_shared::calibration::CalibrationRecord;
use massline_shared::layout::RigLayout;
use massline_shared::protocol::crc32;
use massline_shared::protocol::message::{Measured, Reason, ResultEntry};
use sequential_storage::Error;
use sequential_storage::cache::Cache;
use sequential_storage::cache::Uncached;
use sequential_storage::map::{MapConfig, MapStorage, SerializationError, Value};
use serde::{Deserialize, Serialize, de::DeserializeOwned};

/// Results that the store holds.
pub const RESULTS: usize = 8;
/// The most bytes of one result.
pub const MAX_RESULT: usize = 4608;

const CHUNK: usize = 512;
const CHUNKS: u16 = MAX_RESULT.div_ceil(CHUNK) as u16;
/// The most bytes of an item: the layout is the longest.
const MAX_ITEM: usize = RigLayout::MAX_ENCODED;
const _: () = assert!(CHUNK <= MAX_ITEM && MAX_INDEX <= MAX_ITEM, "the layout is the longest");
/// Room for an item with its format and key, in whole words of any flash.
const SCRATCH: usize = MAX_ITEM + 64;
/// Every item starts with the store's format, so that other firmware does not misread it: raised
/// whenever the encoding of an item changes.
const FORMAT: u8 = 3;

const LAYOUT: u16 = 1;
const CALIBRATION: u16 = 2;
const INDEX: u16 = 3;
const FIRST_CHUNK: u16 = 0x100;

/// One result of the index.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    /// What the list of results shows.
    pub entry: ResultEntry,
    /// CRC-32 over the result's bytes.
    pub crc: u32,
    slot: u8,
}

/// The most bytes of an entry of the index: four integers of at most five bytes, the mass that there
/// may be with its sigma, and the slot.
const MAX_KEPT: usize = 4 * 5 + 2 * 5 + 1;
const MAX_INDEX: usize = 5 + 1 + RESULTS * MAX_KEPT;

#[derive(Debug, Default, Serialize, Deserialize)]
struct Index {
    last_number: u32,
    results: Vec<Kept, RESULTS>,
}

/// Why there is no telling what the store holds.
#[derive(Clone, Copy, Debug)]
enum Unreadable {
    /// The content is no store, or no longer.
    Damaged,
    /// The flash does not answer.
    NoAnswer,
}

/// An item as it lies in flash.
#[derive(Clone, Copy, PartialEq)]
struct Item<'a> {
    format: u8,
    bytes: &'a [u8],
}

impl<'a> Value<'a> for Item<'a> {
    fn serialize_into(&self, buffer: &mut [u8]) -> Result<usize, SerializationError> {
        let length = 1 + self.bytes.len();
        let too_small = SerializationError::BufferTooSmall;
        let (format, bytes) =
            buffer.get_mut(..length).and_then(<[u8]>::split_first_mut).ok_or(too_small)?;
        *format = self.format;
        bytes.copy_from_slice(self.bytes);
        Ok(length)
    }

    fn deserialize_from(buffer: &'a [u8]) -> Result<(Self, usize), SerializationError> {
        let (&format, bytes) = buffer.split_first().ok_or(SerializationError::InvalidData)?;
        Ok((Self { format, bytes }, buffer.len()))
    }
}

type Map<F> = MapStorage<u16, F, Cache<Uncached, Uncached, Uncached, u16>>;

/// The store over a flash region that belongs to it alone.
pub struct Store<F: NorFlash> {
    map: Option<Map<F>>,
    index: Index,
    scratch: [u8; SCRATCH],
    failures: u32,
}

impl<F: NorFlash> Store<F> {
    /// A store over the whole of `flash`, to be opened. A region that the map cannot use makes a store that
    /// refuses every write with [`Reason::StoreFailed`].
    pub fn new(flash: F) -> Self {
        let end = u32::try_from(flash.capacity()).unwrap_or(0);
        let config = MapConfig::try_new(0..end).ok();
        let map = config.map(|config| MapStorage::new(flash, config, Cache::new_uncached()));
        Self { map, index: Index::default(), scratch: [0; SCRATCH], failures: 0 }
    }

    /// Reads the index; to be called once before anything else.
    ///
    /// * No index, or one of another format: no results. What other firmware has kept is passed
    ///   over, item by item, and gives way to what is kept from now on.
    /// * A region that holds no map, a map that cannot be repaired, or an index of this format that
    ///   cannot be read: without an index no result can be found, and to begin another one over the
    ///   old chunks would mix the two. The region is erased.
    /// * Flash that does not answer: the content may be whole. It is kept, and until the next start
    ///   the store shows nothing and refuses every write with [`Reason::StoreFailed`].
    pub async fn open(&mut self) {
        let Some(map) = &mut self.map else { return };
        let found = match map.fetch_item::<Item<'_>>(&mut self.scratch, &INDEX).await {
            Ok(Some(Item { format: FORMAT, bytes })) => {
                postcard::from_bytes(bytes).map_err(|_| Unreadable::Damaged)
            }
            Ok(_) => Ok(Index::default()),
            Err(Error::Storage { .. } | Error::LogicBug { .. }) => Err(Unreadable::NoAnswer),
            // The rest are items that this store never writes.
            Err(_) => Err(Unreadable::Damaged),
        };
        let usable = match found {
            Ok(index) => {
                self.index = index;
                return;
            }
            Err(Unreadable::Damaged) => map.erase_all().await.is_ok(),
            Err(Unreadable::NoAnswer) => false,
        };
        self.failures += 1;
        if !usable {
            self.map = None;
        }
    }

    /// Writes that failed verification, and one when the index could not be read at the start.
    pub fn failures(&self) -> u32 {
        self.failures
    }

    /// The kept layout.
    pub async fn layout(&mut self) -> Option<RigLayout> {
        self.get(LAYOUT).await.ok().flatten()
    }

    /// Keeps a layout, given by its postcard bytes: a decoded one would stay in memory beside them
    /// while the flash is written.
    ///
    /// # Errors
    /// When the flash does not keep it.
    pub async fn put_layout(&mut self, encoded: &[u8]) -> Result<(), Reason> {
        self.put(LAYOUT, encoded).await
    }

    /// The kept calibration.
    pub async fn calibration(&mut self) -> Option<CalibrationRecord> {
        self.get(CALIBRATION).await.ok().flatten()
    }

    /// Keeps a calibration, given by its postcard bytes.
    ///
    /// # Errors
    /// When the flash does not keep it.
    pub async fn put_calibration(&mut self, encoded: &[u8]) -> Result<(), Reason> {
        self.put(CALIBRATION, encoded).await
    }

    /// All results, in the order of their numbers.
    pub fn results(&self) -> &[Kept] {
        &self.index.results
    }

    /// The result of this number.
    pub fn find(&self, number: u32) -> Option<Kept> {
        self.index.results.iter().copied().find(|kept| kept.entry.number == number)
    }

    /// True when no further result fits.
    pub fn is_full(&self) -> bool {
        self.index.results.is_full()
    }

    /// The number that the next result gets. Numbers are never used again.
    pub fn next_number(&self) -> u32 {
        self.index.last_number + 1
    }

    /// Keeps a result under [`Store::next_number`].
    ///
    /// # Errors
    /// [`Reason::StoreFull`], or [`Reason::StoreFailed`] when the flash does not keep it.
    pub async fn put_result(
        &mut self,
        bytes: &[u8],
        layout_hash: u32,
        mass: Option<Measured>,
    ) -> Result<u32, Reason> {
        let used = |slot: u8| self.index.results.iter().any(|kept| kept.slot == slot);
        let slot = (0..RESULTS as u8).find(|&slot| !used(slot)).ok_or(Reason::StoreFull)?;
        if bytes.len() > MAX_RESULT {
            return Err(Reason::StoreFull);
        }
        for (i, chunk) in (0_u16..).zip(bytes.chunks(CHUNK)) {
            self.put(chunk_key(slot, i), chunk).await?;
        }
        let number = self.next_number();
        let entry = ResultEntry { number, layout_hash, mass, length: bytes.len() as u32 };
        let kept = Kept { entry, crc: crc32(bytes), slot };
        self.index.results.push(kept).map_err(|_| Reason::StoreFull)?;
        self.index.last_number = number;
        if let Err(reason) = self.put_index().await {
            self.index.results.pop();
            self.index.last_number = number - 1;
            return Err(reason);
        }
        Ok(number)
    }

    /// Forgets a result.
    ///
    /// # Errors
    /// [`Reason::NotFound`], or [`Reason::StoreFailed`].
    pub async fn delete_result(&mut self, number: u32) -> Result<(), Reason> {
        let at = self.index.results.iter().position(|kept| kept.entry.number == number);
        let at = at.ok_or(Reason::NotFound)?;
        let kept = self.index.results.remove(at);
        if let Err(reason) = self.put_index().await {
            // There is room: it stood there before.
            let _ = self.index.results.insert(at, kept);
            return Err(reason);
        }
        Ok(())
    }

    /// Reads part of a result into `out`, from `offset` on; gives how many bytes there were.
    ///
    /// # Errors
    /// [`Reason::StoreFailed`] when a chunk is missing.
    pub async fn read_result(
        &mut self,
        kept: &Kept,
        offset: usize,
        out: &mut [u8],
    ) -> Result<usize, Reason> {
        let length = kept.entry.length as usize;
        let end = length.min(offset.saturating_add(out.len()));
        let mut at = offset;
        while at < end {
            let key = chunk_key(kept.slot, (at / CHUNK) as u16);
            let chunk = self.get_bytes(key).await.map_err(|_| Reason::StoreFailed)?;
            let within = at % CHUNK;
            let take = (CHUNK - within).min(end - at);
            let from = chunk.and_then(|chunk| chunk.get(within..within + take));
            let to = out.get_mut(at - offset..at - offset + take);
            match (from, to) {
                (Some(from), Some(to)) => to.copy_from_slice(from),
                _ => return Err(Reason::StoreFailed),
            }
            at += take;
        }
        Ok(end.saturating_sub(offset))
    }

    async fn put_index(&mut self) -> Result<(), Reason> {
        let mut encoded = [0; MAX_INDEX];
        let encoded = postcard::to_slice(&self.index, &mut encoded);
        self.put(INDEX, encoded.map_err(|_| Reason::StoreFull)?).await
    }

    async fn get<T: DeserializeOwned>(&mut self, key: u16) -> Result<Option<T>, ()> {
        match self.get_bytes(key).await? {
            Some(bytes) => Ok(postcard::from_bytes(bytes).ok()),
            None => Ok(None),
        }
    }

    async fn get_bytes(&mut self, key: u16) -> Result<Option<&[u8]>, ()> {
        let Some(map) = &mut self.map else { return Ok(None) };
        let item = map.fetch_item::<Item<'_>>(&mut self.scratch, &key).await.map_err(|_| ())?;
        Ok(item.filter(|item| item.format == FORMAT).map(|item| item.bytes))
    }

    /// Writes an item and reads it back; tries once more before it gives up.
    async fn put(&mut self, key: u16, bytes: &[u8]) -> Result<(), Reason> {
        let Some(map) = &mut self.map else { return Err(Reason::StoreFailed) };
        let item = Item { format: FORMAT, bytes };
        let mut reason = Reason::StoreFailed;
        for _ in 0..2 {
            let stored = map.store_item(&mut self.scratch, &key, &item).await;
            if matches!(stored, Err(Error::FullStorage)) {
                reason = Reason::StoreFull;
            }
            let kept = map.fetch_item::<Item<'_>>(&mut self.scratch, &key).await;
            if matches!(kept, Ok(Some(kept)) if kept == item) {
                return Ok(());
            }
            self.failures += 1;
        }
        Err(reason)
    }
}

fn chunk_key(slot: u8, chunk: u16) -> u16 {
    FIRST_CHUNK + u16::from(slot) * CHUNKS + chunk
}

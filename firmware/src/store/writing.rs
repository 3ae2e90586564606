//! Writes objects: the pieces first, then the change that names them.

use embedded_storage_async::nor_flash::NorFlash;

use super::contents::{Change, Object};
use super::log::Checkpoint;
use super::record::Kind;
use super::{Source, Store, StoreError};

/// Shortest piece of an object that continues in another page.
pub(super) const MIN_PIECE: usize = 128;
/// Longest piece of an object; it is encoded in memory before it is written.
pub(super) const MAX_PIECE: usize = 1024;
/// Number of attempts at a write that fails.
const ATTEMPTS: usize = 3;
/// The bytes of a change that has no object.
const NOTHING: &[u8] = &[];

impl<F: NorFlash> Store<F> {
    /// Writes an object and the change that names it.
    pub(super) async fn keep(
        &mut self,
        source: &dyn Source,
        change: &dyn Fn(Object) -> Change,
    ) -> Result<(), StoreError> {
        if self.usable && !self.has_room(source.length()).await {
            return Err(StoreError::Full);
        }
        self.write(source, change).await
    }

    /// Writes a change that has no object.
    pub(super) async fn note(&mut self, change: Change) -> Result<(), StoreError> {
        self.write(&NOTHING, &|_| change.clone()).await
    }

    // Object and change are not type parameters: the firmware has room for one copy of this.
    async fn write(
        &mut self,
        source: &dyn Source,
        change: &dyn Fn(Object) -> Change,
    ) -> Result<(), StoreError> {
        if !self.usable {
            return Err(StoreError::Failed);
        }
        let mut written = Err(StoreError::Failed);
        for _ in 0..ATTEMPTS {
            // Each attempt has a new serial, so that the pieces of a failed one belong to no object.
            self.writing = self.next_serial();
            written = self.try_write(source, change).await;
            if matches!(written, Ok(()) | Err(StoreError::SupplyLow)) {
                break;
            }
            self.failures += 1;
        }
        self.writing = 0;
        written
    }

    async fn try_write(
        &mut self,
        source: &dyn Source,
        change: &dyn Fn(Object) -> Change,
    ) -> Result<(), StoreError> {
        let (serial, length) = (self.writing, source.length());
        let bytes = u16::try_from(length).map_err(|_| StoreError::Full)?;
        let mut offset = 0;
        while offset < length {
            let rest = length - offset;
            self.make_room(rest.min(MIN_PIECE)).await?;
            let count = rest.min(self.log.room()).min(MAX_PIECE);
            source.read(offset, self.piece.get_mut(..count).unwrap_or_default());
            self.append_piece(Kind::Data, serial, offset, count).await?;
            offset += count;
        }
        let change = change(Object { serial, length: bytes, found: bytes });
        let encoded = postcard::to_slice(&change, &mut self.piece).map_err(|_| StoreError::Full)?;
        let count = encoded.len();
        self.make_room(count).await?;
        self.append_piece(Kind::Change, serial, 0, count).await?;
        self.contents.apply(serial, change);
        Ok(())
    }

    /// Appends a record with the first `count` bytes of the piece.
    async fn append_piece(
        &mut self,
        kind: Kind,
        serial: u32,
        offset: usize,
        count: usize,
    ) -> Result<(), StoreError> {
        self.check_supply()?;
        let offset = u16::try_from(offset).map_err(|_| StoreError::Full)?;
        let payload = self.piece.get(..count).ok_or(StoreError::Full)?;
        self.log.append(kind, serial, offset, payload).await.map_err(|_| StoreError::Failed)
    }

    /// Refuses to write or erase with too little supply; it may fail between two pieces of an object.
    fn check_supply(&self) -> Result<(), StoreError> {
        if (self.supply_is_low)() { Err(StoreError::SupplyLow) } else { Ok(()) }
    }

    /// Opens pages until the head has room for this many bytes. After one round over all pages, every
    /// live record has been moved, so the store is full if there is still no room.
    async fn make_room(&mut self, bytes: usize) -> Result<(), StoreError> {
        let mut pages = self.log.pages();
        while self.log.room() < bytes {
            pages = pages.checked_sub(1).ok_or(StoreError::Full)?;
            self.check_supply()?;
            let Self { log, contents, writing, serial, .. } = self;
            let checkpoint = Checkpoint { serial: *serial, last_number: contents.last_number };
            let live = |serial: u32| serial == *writing || contents.is_live(serial);
            log.rotate(checkpoint, live).await.map_err(|_| StoreError::Failed)?;
        }
        Ok(())
    }
}

//! How the store keeps things: pieces first, and then the change that names them.

use embedded_storage_async::nor_flash::NorFlash;
use massline_protocol::message::Reason;

use super::Store;
use super::contents::{Change, MAX_CHANGE, Object};
use super::log::{Checkpoint, Log};
use super::record::Kind;

/// Shortest piece of an object that goes on in another page.
const MIN_PIECE: usize = 128;
/// How often a write is tried that the flash does not keep.
const ATTEMPTS: usize = 3;
/// Deletions and the like that have room in a full store.
const SMALL_CHANGES: u32 = 4;

impl<F: NorFlash> Store<F> {
    /// The most flash that an object of this length takes with its change, in whatever pieces.
    pub(super) fn cost(length: usize) -> u32 {
        let pieces = length / MIN_PIECE + 1;
        Log::<F>::size(length) + pieces as u32 * Log::<F>::size(1) + Log::<F>::size(MAX_CHANGE)
    }

    /// True when so many bytes fit beside everything that is kept.
    pub(super) async fn has_room(&mut self, bytes: u32) -> bool {
        let mut taken = SMALL_CHANGES * Log::<F>::size(MAX_CHANGE);
        let mut cursor = self.log.records();
        while let Some(record) = self.log.next(&mut cursor).await {
            let header = record.header;
            let kept = matches!(header.kind, Kind::Data | Kind::Change);
            if kept && self.contents.is_live(header.serial) {
                taken += Log::<F>::size(header.length.into());
            }
        }
        taken + bytes <= self.log.capacity(MIN_PIECE.max(MAX_CHANGE))
    }

    /// Keeps an object and the change that names it.
    pub(super) async fn keep(
        &mut self,
        bytes: &[u8],
        change: impl Fn(Object) -> Change,
    ) -> Result<(), Reason> {
        let length = u16::try_from(bytes.len()).map_err(|_| Reason::StoreFull)?;
        if self.usable && !self.has_room(Self::cost(bytes.len())).await {
            return Err(Reason::StoreFull);
        }
        self.write(bytes, |serial| change(Object { serial, length, found: length })).await
    }

    /// Makes a change that needs no object.
    pub(super) async fn note(&mut self, change: Change) -> Result<(), Reason> {
        self.write(&[], |_| change.clone()).await
    }

    async fn write(&mut self, bytes: &[u8], change: impl Fn(u32) -> Change) -> Result<(), Reason> {
        if !self.usable {
            return Err(Reason::StoreFailed);
        }
        let mut written = Err(Reason::StoreFailed);
        for _ in 0..ATTEMPTS {
            // A serial of its own, so that the pieces of a failed attempt belong to nothing.
            self.writing = self.next_serial();
            written = self.try_write(bytes, &change).await;
            if written.is_ok() {
                break;
            }
            self.failures += 1;
        }
        self.writing = 0;
        written
    }

    async fn try_write(
        &mut self,
        bytes: &[u8],
        change: &impl Fn(u32) -> Change,
    ) -> Result<(), Reason> {
        let serial = self.writing;
        let mut offset = 0;
        while let Some(rest) = bytes.get(offset..).filter(|rest| !rest.is_empty()) {
            self.make_room(rest.len().min(MIN_PIECE)).await?;
            let piece = rest.get(..self.log.room()).unwrap_or(rest);
            self.append(Kind::Data, serial, offset, piece).await?;
            offset += piece.len();
        }
        let change = change(serial);
        let mut encoded = [0; MAX_CHANGE];
        let encoded = postcard::to_slice(&change, &mut encoded).map_err(|_| Reason::StoreFull)?;
        self.make_room(encoded.len()).await?;
        self.append(Kind::Change, serial, 0, encoded).await?;
        self.contents.apply(serial, change);
        Ok(())
    }

    async fn append(
        &mut self,
        kind: Kind,
        serial: u32,
        offset: usize,
        payload: &[u8],
    ) -> Result<(), Reason> {
        let offset = u16::try_from(offset).map_err(|_| Reason::StoreFull)?;
        self.log.append(kind, serial, offset, payload).await.map_err(|_| Reason::StoreFailed)
    }

    /// Opens pages until the head has room for so many bytes. What is kept has been moved out of all
    /// other pages after as many as there are.
    async fn make_room(&mut self, bytes: usize) -> Result<(), Reason> {
        let mut pages = self.log.pages();
        while self.log.room() < bytes {
            pages = pages.checked_sub(1).ok_or(Reason::StoreFull)?;
            let Self { log, contents, writing, serial, .. } = self;
            let checkpoint = Checkpoint { serial: *serial, last_number: contents.last_number };
            let live = |kept: u32| kept == *writing || contents.is_live(kept);
            log.rotate(checkpoint, live).await.map_err(|_| Reason::StoreFailed)?;
        }
        Ok(())
    }
}

//! Finds and reads stored objects.

use embedded_storage_async::nor_flash::NorFlash;
use serde::de::DeserializeOwned;

use super::Store;
use super::contents::{Change, MAX_CHANGE, Object};
use super::record::Kind;

impl<F: NorFlash> Store<F> {
    /// Applies every change in the log, those of DOFs last.
    pub(super) async fn read_changes(&mut self) {
        for of_dofs in [false, true] {
            self.read_some_changes(|change| change.is_dof() == of_dofs).await;
        }
    }

    async fn read_some_changes(&mut self, wanted: impl Fn(&Change) -> bool) {
        let mut cursor = self.log.records();
        while let Some(record) = self.log.next(&mut cursor).await {
            self.serial = self.serial.max(record.header.serial);
            let mut bytes = [0; MAX_CHANGE];
            if record.header.kind == Kind::Change
                && let Some(length) = self.log.read(&record, 0, &mut bytes).await
                && let Ok(change) = postcard::from_bytes(bytes.get(..length).unwrap_or_default())
                && wanted(&change)
            {
                self.contents.apply(record.header.serial, change);
            }
        }
    }

    /// Counts the intact pieces of all stored objects.
    pub(super) async fn find_objects(&mut self) {
        let mut cursor = self.log.records();
        while let Some(record) = self.log.next(&mut cursor).await {
            let header = record.header;
            if header.kind == Kind::Data
                && self.contents.is_live(header.serial)
                && self.log.read(&record, 0, &mut []).await.is_some()
            {
                self.contents.count_intact(header.serial, header.length);
            }
        }
    }

    /// Reads part of an object into `out`; returns the number of bytes, or `None` when a piece is missing
    /// or torn.
    pub(super) async fn read(
        &mut self,
        object: Object,
        offset: usize,
        out: &mut [u8],
    ) -> Option<usize> {
        let end = usize::from(object.length).min(offset.saturating_add(out.len()));
        let wanted = end.saturating_sub(offset);
        let (mut cursor, mut count) = (self.log.records(), 0);
        while count < wanted {
            let record = self.log.next(&mut cursor).await?;
            let header = record.header;
            let piece = usize::from(header.offset);
            let of_object = header.kind == Kind::Data && header.serial == object.serial;
            if of_object && piece < end && offset < piece + usize::from(header.length) {
                let to = out.get_mut(piece.saturating_sub(offset)..wanted)?;
                count += self.log.read(&record, offset.saturating_sub(piece), to).await?;
            }
        }
        Some(count)
    }

    pub(super) async fn read_whole<'r>(
        &mut self,
        object: Object,
        room: &'r mut [u8],
    ) -> Option<&'r [u8]> {
        let bytes = room.get_mut(..object.length.into())?;
        self.read(object, 0, bytes).await?;
        Some(bytes)
    }

    pub(super) async fn decode<T: DeserializeOwned>(
        &mut self,
        object: Object,
        room: &mut [u8],
    ) -> Option<T> {
        postcard::from_bytes(self.read_whole(object, room).await?).ok()
    }
}

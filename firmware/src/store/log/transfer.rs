//! Reads and writes records in pieces of whole words; every write is read back.

use embedded_storage_async::nor_flash::NorFlash;
use massline_protocol::{crc32, crc32_of_chunks};

use super::{Fault, Log, Page, Record};
use crate::store::record::{Header, Kind};

/// Bytes read or written at a time.
pub(super) const PIECE: usize = 64;

/// Source of a payload.
#[derive(Clone, Copy)]
pub(super) enum Source<'a> {
    Memory(&'a [u8]),
    Flash(u32),
}

/// What lies at an address.
pub(super) enum AddressContent {
    Record(Header),
    /// No header at the address; none starts within this many bytes from there.
    Nothing(u32),
}

impl<F: NorFlash> Log<F> {
    /// Reads the payload from `from` on into `out` and checks the whole payload. Returns the number of
    /// bytes copied, or `None` when the payload is torn.
    pub async fn read(&mut self, record: &Record, from: usize, out: &mut [u8]) -> Option<usize> {
        let length = usize::from(record.header.length);
        let start = record.address + Self::size(0);
        let mut piece = [0; PIECE];
        let (mut crc, mut copied) = (crc32_of_chunks(), 0);
        for at in (0..length).step_by(PIECE) {
            let count = PIECE.min(length - at);
            let words = piece.get_mut(..count.next_multiple_of(Self::UNIT))?;
            self.read_flash(start + at as u32, words).await.ok()?;
            let bytes = piece.get(..count)?;
            crc.update(bytes);
            let wanted = bytes.get((from + copied).saturating_sub(at)..).unwrap_or_default();
            if at + count > from + copied {
                let room = out.get_mut(copied..).unwrap_or_default();
                let taken = room.len().min(wanted.len());
                room.iter_mut().zip(wanted).for_each(|(to, from)| *to = *from);
                copied += taken;
            }
        }
        (crc.finalize() == record.header.crc).then_some(copied)
    }

    /// Looks for a header; at most `rest` bytes may be read.
    pub(super) async fn look(&mut self, address: u32, page: u32, rest: usize) -> AddressContent {
        let mut bytes = [0; PIECE];
        let mut count = rest.min(PIECE);
        if self.read_flash(address, &mut bytes[..count]).await.is_err() {
            count = (Self::size(0) as usize).min(rest);
            if self.read_flash(address, &mut bytes[..count]).await.is_err() {
                return AddressContent::Nothing(Self::UNIT as u32);
            }
        }
        let bytes = &bytes[..count];
        if let Some(header) = bytes.first_chunk().and_then(|bytes| Header::decode(bytes, page))
            && Self::size(header.length.into()) as usize <= rest
        {
            return AddressContent::Record(header);
        }
        let blank = bytes.iter().take_while(|&&byte| byte == 0xFF).count();
        AddressContent::Nothing((blank / Self::UNIT * Self::UNIT).max(Self::UNIT) as u32)
    }

    pub(super) async fn write_small(
        &mut self,
        page: &mut Page,
        kind: Kind,
        serial: u32,
        payload: &[u8],
    ) -> Result<(), Fault> {
        let length = payload.len() as u16;
        let header = Header { kind, length, serial, offset: 0, crc: crc32(payload) };
        self.write(page, header, Source::Memory(payload)).await
    }

    /// Appends a record to a page and reads it back. If that fails, the page accepts no more records.
    pub(super) async fn write(
        &mut self,
        page: &mut Page,
        header: Header,
        source: Source<'_>,
    ) -> Result<(), Fault> {
        let (at, size) = (page.end, Self::size(header.length.into()));
        page.end = Self::PAGE;
        if at + size > Self::PAGE {
            return Err(Fault);
        }
        let address = self.address(page.number) + at;
        let bytes = header.encode(page.number);
        self.write_flash(address, header.encode(page.number).len(), Source::Memory(&bytes)).await?;
        self.write_flash(address + Self::size(0), header.length.into(), source).await?;
        if !self.reads_back(address, page.number, header).await {
            self.work.read_back_failures += 1;
            return Err(Fault);
        }
        page.end = at + size;
        Ok(())
    }

    /// True when this record can be read back intact from the address.
    async fn reads_back(&mut self, address: u32, page: u32, header: Header) -> bool {
        let size = Self::size(header.length.into()) as usize;
        match self.look(address, page, size).await {
            AddressContent::Record(stored) if stored == header => {
                self.read(&Record { header, address }, 0, &mut []).await.is_some()
            }
            AddressContent::Record(_) | AddressContent::Nothing(_) => false,
        }
    }

    /// Writes `length` bytes, padded with ones to whole words.
    async fn write_flash(
        &mut self,
        address: u32,
        length: usize,
        source: Source<'_>,
    ) -> Result<(), Fault> {
        for at in (0..length).step_by(PIECE) {
            let mut piece = [0xFF; PIECE];
            let count = PIECE.min(length - at);
            let words = &mut piece[..count.next_multiple_of(Self::UNIT)];
            match source {
                Source::Memory(bytes) => {
                    let bytes = bytes.get(at..at + count).ok_or(Fault)?;
                    words.iter_mut().zip(bytes).for_each(|(to, from)| *to = *from);
                }
                Source::Flash(from) => self.read_flash(from + at as u32, words).await?,
            }
            self.work.bytes = self.work.bytes.wrapping_add(words.len() as u32);
            self.flash.write(address + at as u32, words).await.map_err(|_| Fault)?;
        }
        Ok(())
    }

    /// Reads whole words; tries once more when that fails.
    pub(super) async fn read_flash(&mut self, address: u32, out: &mut [u8]) -> Result<(), Fault> {
        if self.flash.read(address, out).await.is_ok() {
            return Ok(());
        }
        self.flash.read(address, out).await.map_err(|_| Fault)
    }
}

//! Finds the window of a log, even after a power cut.

use embedded_storage_async::nor_flash::NorFlash;

use super::transfer::{AddressContent, PIECE};
use super::{Checkpoint, Cursor, Fault, GEOMETRY, Log, OPENED};
use crate::store::record::{Header, Kind};

impl<F: NorFlash> Log<F> {
    /// The highest page number below `below`, whether the page is in use or not.
    pub(super) async fn highest_page(&mut self, below: u32) -> Result<Option<u32>, Fault> {
        let (mut answered, mut highest) = (false, None);
        for place in 0..self.pages() {
            let mut bytes = [0; PIECE];
            let header = bytes.get_mut(..Self::size(0) as usize).ok_or(Fault)?;
            answered |= match self.read_flash(place * Self::PAGE, header).await {
                Ok(()) => true,
                Err(Fault) => continue,
            };
            let number = bytes.first_chunk().and_then(Header::page_number);
            let number = number.filter(|&n| n % self.pages() == place && n < below);
            if number > highest && self.is_ours(number.unwrap_or_default()).await {
                highest = number;
            }
        }
        if answered { Ok(highest) } else { Err(Fault) }
    }

    /// True when the page was written in this format for flash of this geometry.
    async fn is_ours(&mut self, number: u32) -> bool {
        let mut first = Cursor { page: number, at: 0, end: number + 1 };
        let Some(record) = self.next(&mut first).await else { return false };
        let mut geometry = [0; GEOMETRY];
        self.read(&record, 0, &mut geometry).await == Some(GEOMETRY) && geometry == self.geometry()
    }

    /// Tail and checkpoint of a page; `None` when the page is not in use.
    pub(super) async fn opened(&mut self, number: u32) -> Option<(u32, Checkpoint)> {
        let mut cursor = Cursor { page: number, at: 0, end: number + 1 };
        while let Some(record) = self.next(&mut cursor).await {
            let mut bytes = [0; OPENED];
            if record.header.kind == Kind::Opened
                && self.read(&record, 0, &mut bytes).await == Some(OPENED)
            {
                let [tail, serial, last_number] = numbers(bytes);
                let sound = tail <= number && number - tail < self.pages() - 1;
                return sound.then_some((tail, Checkpoint { serial, last_number }));
            }
        }
        None
    }

    /// Offset of the next record of a page. It is the end of the page if anything but blank words follows
    /// the last record with an intact header.
    pub(super) async fn end_of(&mut self, number: u32) -> u32 {
        let mut cursor = Cursor { page: number, at: 0, end: number + 1 };
        let mut end = 0;
        while let Some(record) = self.next(&mut cursor).await {
            end = record.address - self.address(number) + Self::size(record.header.length.into());
        }
        let mut at = end;
        while at < Self::PAGE {
            let rest = (Self::PAGE - at) as usize;
            match self.look(self.address(number) + at, number, rest).await {
                AddressContent::Nothing(bytes) if bytes as usize == rest.min(PIECE) => at += bytes,
                _ => return Self::PAGE,
            }
        }
        end
    }
}

fn numbers(bytes: [u8; 12]) -> [u32; 3] {
    let [a, b, c, d, e, f, g, h, i, j, k, l] = bytes;
    [[a, b, c, d], [e, f, g, h], [i, j, k, l]].map(u32::from_le_bytes)
}

//! The log: a ring of flash pages that records are appended to.
//!
//! Pages are numbered from the first ever opened. Page `n` lies at place `n` modulo the number of places,
//! so that all places wear evenly. The *window* is the pages from the *tail* to the *head*; it always has
//! fewer pages than there are places. Records are appended to the head. When the head is full, the next
//! page is opened at a place outside the window:
//!
//! 1. its place is erased, and its first record states its number;
//! 2. if the tail must leave the window, the tail's live records are copied into the new page;
//! 3. a record [`Kind::Opened`] makes the new page the head, and states the new tail.
//!
//! Until step 3 is complete the old window is valid, and from then on the new one: no intermediate state
//! exists. A page without an intact `Opened` is not in use, whatever else it holds. Opening a log only
//! reads.
//!
//! A record is valid if its CRC matches, and every write is read back. Words that cannot be read (a torn
//! word of flash with an error correcting code) are skipped. After a record with a torn header nothing more
//! is appended to its page.

mod finding;
mod transfer;

use embassy_futures::yield_now;
use embedded_storage_async::nor_flash::NorFlash;
use massline_protocol::crc32;

use super::record::{HEADER, Header, Kind};
use transfer::{AddressContent, PIECE, Source};

/// Fewest pages that a log needs: tail, head, and the page that is opened next.
const MIN_PAGES: u32 = 3;
/// Smallest page size that a log supports.
const MIN_PAGE: u32 = 1024;
const GEOMETRY: usize = 12;
const OPENED: usize = 12;

/// An operation on the flash failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Fault;

/// State that every page takes over from the pages before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Checkpoint {
    /// The last serial that was assigned.
    pub serial: u32,
    /// The last result number that was assigned.
    pub last_number: u32,
}

/// A record of the log.
#[derive(Clone, Copy, Debug)]
pub(super) struct Record {
    pub header: Header,
    /// Address of its header in the flash.
    address: u32,
}

/// Position in an iteration over pages.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cursor {
    page: u32,
    at: u32,
    /// The page after the last.
    end: u32,
}

#[derive(Clone, Copy, Debug)]
struct Window {
    tail: u32,
    head: Page,
}

/// A page that is being written.
#[derive(Clone, Copy, Debug)]
struct Page {
    number: u32,
    /// Offset of the next record from the start of the page.
    end: u32,
}

/// Counts the operations on the flash since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Work {
    /// Pages erased.
    pub erases: u32,
    /// Bytes written.
    pub bytes: u32,
    /// Records that did not read back as written.
    pub read_back_failures: u32,
}

/// A log over a flash region.
pub(super) struct Log<F> {
    flash: F,
    work: Work,
    window: Option<Window>,
}

impl<F: NorFlash> Log<F> {
    /// Payloads are padded to multiples of this many bytes.
    const UNIT: usize = {
        let larger = if F::WRITE_SIZE > F::READ_SIZE { F::WRITE_SIZE } else { F::READ_SIZE };
        if larger > 4 { larger } else { 4 }
    };
    const PAGE: u32 = F::ERASE_SIZE as u32;
    /// Version of the log's format.
    pub const FORMAT: u32 = 1;

    pub fn new(flash: F) -> Self {
        Self { flash, work: Work::default(), window: None }
    }

    /// Operations on the flash since the start.
    pub fn work(&self) -> Work {
        self.work
    }

    /// Number of places for pages.
    pub fn pages(&self) -> u32 {
        (self.flash.capacity() / F::ERASE_SIZE) as u32
    }

    /// True when the geometry of the flash is one that a log supports.
    pub fn is_usable(&self) -> bool {
        let words = PIECE.is_multiple_of(Self::UNIT)
            && Self::UNIT.is_multiple_of(F::WRITE_SIZE)
            && Self::UNIT.is_multiple_of(F::READ_SIZE)
            && F::ERASE_SIZE.is_multiple_of(Self::UNIT);
        words && Self::PAGE >= MIN_PAGE && self.pages() >= MIN_PAGES
    }

    /// Bytes of flash that a record with a payload of `length` bytes takes.
    pub const fn size(length: usize) -> u32 {
        (HEADER.next_multiple_of(Self::UNIT) + length.next_multiple_of(Self::UNIT)) as u32
    }

    /// Bytes of records that fit in any order of writing, if no record is longer than `longest` and one
    /// that does not fit the rest of a page goes to the next page.
    pub fn capacity(&self, longest: usize) -> u32 {
        let taken = Self::size(GEOMETRY) + Self::size(OPENED) + Self::size(longest);
        (self.pages() - 1) * (Self::PAGE - taken)
    }

    /// Finds the window; writes nothing. Returns `None` when there is no log of this format.
    ///
    /// # Errors
    /// [`Fault`] when not a single page can be read.
    pub async fn open(&mut self) -> Result<Option<Checkpoint>, Fault> {
        let mut below = u32::MAX;
        loop {
            let Some(number) = self.highest_page(below).await? else { return Ok(None) };
            if let Some((tail, checkpoint)) = self.opened(number).await {
                let head = Page { number, end: self.end_of(number).await };
                self.window = Some(Window { tail, head });
                return Ok(Some(checkpoint));
            }
            below = number;
        }
    }

    /// A cursor over all records.
    pub fn records(&self) -> Cursor {
        match self.window {
            Some(Window { tail, head }) => Cursor { page: tail, at: 0, end: head.number + 1 },
            None => Cursor { page: 0, at: 0, end: 0 },
        }
    }

    /// The next record with an intact header; its payload may be torn.
    pub async fn next(&mut self, cursor: &mut Cursor) -> Option<Record> {
        while cursor.page < cursor.end {
            let limit = match self.window {
                Some(Window { head, .. }) if head.number == cursor.page => head.end,
                _ => Self::PAGE,
            };
            let rest = limit.saturating_sub(cursor.at) as usize;
            if rest < Self::size(0) as usize {
                *cursor = Cursor { page: cursor.page + 1, at: 0, ..*cursor };
                continue;
            }
            let address = self.address(cursor.page) + cursor.at;
            match self.look(address, cursor.page, rest).await {
                AddressContent::Record(header) => {
                    cursor.at += Self::size(header.length.into());
                    return Some(Record { header, address });
                }
                // The place holds another page.
                AddressContent::Nothing(_) if cursor.at == 0 => cursor.at = Self::PAGE,
                AddressContent::Nothing(bytes) => cursor.at += bytes,
            }
        }
        None
    }

    /// Bytes of payload that still fit the head in one record.
    pub fn room(&self) -> usize {
        let end = self.window.map_or(Self::PAGE, |window| window.head.end);
        let rest = (Self::PAGE - end).saturating_sub(Self::size(0)) as usize;
        rest / Self::UNIT * Self::UNIT
    }

    /// Appends a record to the head, which must have [`Log::room`] for it.
    ///
    /// # Errors
    /// [`Fault`] when the write fails; nothing more is appended to this page then.
    pub async fn append(
        &mut self,
        kind: Kind,
        serial: u32,
        offset: u16,
        payload: &[u8],
    ) -> Result<(), Fault> {
        let mut head = self.window.ok_or(Fault)?.head;
        let length = u16::try_from(payload.len()).map_err(|_| Fault)?;
        let header = Header { kind, length, serial, offset, crc: crc32(payload) };
        let written = self.write(&mut head, header, Source::Memory(payload)).await;
        if let Some(window) = &mut self.window {
            window.head = head;
        }
        written
    }

    /// Opens the next page as the head, and copies the records with a `live` serial from the pages that
    /// leave the window. Erases a page.
    ///
    /// # Errors
    /// [`Fault`] when the flash fails; the window does not change then.
    pub async fn rotate(
        &mut self,
        checkpoint: Checkpoint,
        live: impl Fn(u32) -> bool,
    ) -> Result<(), Fault> {
        let (number, old_tail) =
            self.window.map_or((0, 0), |window| (window.head.number + 1, window.tail));
        let tail = old_tail.max((number + 2).saturating_sub(self.pages()));
        let start = self.address(number);
        self.work.erases += 1;
        let erased = self.flash.erase(start, start + Self::PAGE).await;
        // Nothing else runs while a chip erases its own flash; this lets the watchdog be fed between two
        // erases.
        yield_now().await;
        erased.map_err(|_| Fault)?;
        let mut page = Page { number, end: 0 };
        let geometry = self.geometry();
        self.write_small(&mut page, Kind::Page, number, &geometry).await?;
        let mut leaving = Cursor { page: old_tail, at: 0, end: tail };
        while let Some(record) = self.next(&mut leaving).await {
            let wanted = matches!(record.header.kind, Kind::Data | Kind::Change);
            if wanted
                && live(record.header.serial)
                && self.read(&record, 0, &mut []).await.is_some()
            {
                let source = Source::Flash(record.address + Self::size(0));
                self.write(&mut page, record.header, source).await?;
            }
        }
        let opened = words([tail, checkpoint.serial, checkpoint.last_number]);
        self.write_small(&mut page, Kind::Opened, 0, &opened).await?;
        self.window = Some(Window { tail, head: page });
        Ok(())
    }

    fn address(&self, page: u32) -> u32 {
        page % self.pages() * Self::PAGE
    }

    /// Payload of the first record of every page.
    fn geometry(&self) -> [u8; GEOMETRY] {
        words([Self::FORMAT, Self::PAGE, self.pages()])
    }
}

fn words(numbers: [u32; 3]) -> [u8; 12] {
    let [a, b, c] = numbers.map(u32::to_le_bytes);
    let mut bytes = [0; 12];
    for (to, from) in bytes.iter_mut().zip([a, b, c].as_flattened()) {
        *to = *from;
    }
    bytes
}

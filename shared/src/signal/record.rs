//! The record of one hit.

use super::samples::{extremes, reading_of};
use super::{CHANNELS, HAMMER, PRE_TRIGGER_SCANS, RECORD_SCANS, Row, Samples, Scan};
use crate::real::Real;

/// Number of pre-trigger readings that are averaged to the rest value of a channel.
///
/// The last eighth is left out because the contact begins before the force reaches the trigger level.
pub(super) const fn rest_scans(pre_trigger: usize) -> usize {
    pre_trigger - pre_trigger / 8
}

/// A ring buffer of the latest [`RECORD_SCANS`] scans.
///
/// Every new scan overwrites the oldest one; a complete record is read from the oldest scan on. While the rig waits for
/// a hit, only the first [`PRE_TRIGGER_SCANS`] places are used as the ring: the others keep the previous hit, so that
/// it can be [restored](Self::restore_start) until the next one begins.
///
/// A *long* record has the force at the full rate and decimated [rows](Row) of responses, which are
/// [pushed](Self::push_force) [separately](Self::push_row): force and responses of one place then belong to different
/// times. A complete one is read like any other record.
///
/// An empty record is all zero bytes, so a static one is in `.bss`: 40 KiB.
pub struct Record {
    scans: [Scan; RECORD_SCANS],
    force: Cursor,
    /// Of the responses.
    rows: Cursor,
}

/// Where the next value goes.
#[derive(Clone, Copy, Debug)]
struct Cursor {
    /// Index of the next place; once the ring is full, the oldest value is here.
    next: usize,
    filled: usize,
    /// True while the ring has only the places of the pre-trigger.
    waits: bool,
}

impl Cursor {
    const START: Self = Self { next: 0, filled: 0, waits: false };
    /// After a complete record.
    const COMPLETE: Self = Self { filled: RECORD_SCANS, ..Self::START };

    /// The next place, which is taken.
    fn advance(&mut self) -> usize {
        let place = self.next;
        self.next = (self.next + 1) % self.capacity();
        self.filled = (self.filled + 1).min(self.capacity());
        place
    }

    /// Number of places of the ring.
    fn capacity(&self) -> usize {
        if self.waits { PRE_TRIGGER_SCANS } else { RECORD_SCANS }
    }

    /// From now on all values are kept; those that are there have been put in order.
    fn end_wait(&mut self) {
        if self.waits {
            self.next = self.filled;
            self.waits = false;
        }
    }
}

impl Record {
    /// Size of a full record, bytes: two per code.
    pub const BYTES: usize = RECORD_SCANS * Self::SCAN_BYTES;
    /// Size of one scan, bytes.
    pub const SCAN_BYTES: usize = 2 * CHANNELS;
    /// Codes that a wait for the next hit overwrites.
    pub const START_CODES: usize = PRE_TRIGGER_SCANS * CHANNELS;

    /// An empty record.
    pub const fn new() -> Self {
        Self { scans: [[0; CHANNELS]; RECORD_SCANS], force: Cursor::START, rows: Cursor::START }
    }

    /// Discards all scans.
    pub fn clear(&mut self) {
        (self.force, self.rows) = (Cursor::START, Cursor::START);
    }

    /// Discards all scans, and keeps only the latest [`PRE_TRIGGER_SCANS`] until [`Self::end_wait`].
    pub fn begin_wait(&mut self) {
        let waits = Cursor { waits: true, ..Cursor::START };
        (self.force, self.rows) = (waits, waits);
    }

    /// The next scan is that of the trigger: from now on all scans are kept.
    pub fn end_wait(&mut self) {
        // The hit is read from the first place on.
        let Self { scans, force, rows } = self;
        let start = &mut scans[..PRE_TRIGGER_SCANS];
        if rows.waits && rows.filled == PRE_TRIGGER_SCANS {
            start.rotate_left(rows.next);
            if force.next != rows.next {
                let by = force.next + PRE_TRIGGER_SCANS - rows.next;
                turn_force(start, by % PRE_TRIGGER_SCANS);
            }
        }
        force.end_wait();
        rows.end_wait();
    }

    /// Copies the codes that the next wait overwrites into `codes`, whose length is [`Self::START_CODES`]. The record
    /// must hold a complete hit that was waited for, so that its first scan is in the first place.
    pub fn save_start<R: Real>(&self, codes: &mut [R]) {
        let start = self.scans[..PRE_TRIGGER_SCANS].as_flattened();
        codes.iter_mut().zip(start).for_each(|(to, &code)| *to = reading_of(code));
    }

    /// Restores the hit before the present wait, given the codes of [`Self::save_start`]. The record must not have
    /// ended its wait.
    pub fn restore_start<R: Real>(&mut self, codes: &[R]) {
        let start = self.scans[..PRE_TRIGGER_SCANS].as_flattened_mut();
        start.iter_mut().zip(codes).for_each(|(to, &code)| *to = code_of(code));
        (self.force, self.rows) = (Cursor::COMPLETE, Cursor::COMPLETE);
    }

    /// Appends a scan; in a full record it overwrites the oldest.
    pub fn push(&mut self, scan: &Scan) {
        let place = self.rows.advance();
        self.force = self.rows;
        if let Some(to) = self.scans.get_mut(place) {
            *to = *scan;
        }
    }

    /// Appends the code of the hammer to a long record; one with as many as it holds takes no more.
    pub fn push_force(&mut self, code: u16) {
        if self.force.filled == RECORD_SCANS {
            return;
        }
        if let Some(to) = self.scans.get_mut(self.force.advance()) {
            to[HAMMER] = code;
        }
    }

    /// Appends a row of responses to a long record; one with as many as it holds takes no more.
    pub fn push_row(&mut self, row: &Row) {
        if self.rows.filled == RECORD_SCANS {
            return;
        }
        if let Some([_, responses @ ..]) = self.scans.get_mut(self.rows.advance()) {
            *responses = *row;
        }
    }

    /// Number of scans in the record.
    pub fn len(&self) -> usize {
        self.rows.filled
    }

    /// True when there is no scan.
    pub fn is_empty(&self) -> bool {
        self.rows.filled == 0
    }

    /// The scan with this index; 0 is the oldest.
    pub fn scan(&self, index: usize) -> Option<&Scan> {
        let (older, newer) = self.halves();
        older.get(index).or_else(|| newer.get(index.checked_sub(older.len())?))
    }

    /// The codes of one channel, oldest first; empty for a channel that does not exist.
    pub fn channel(&self, channel: usize) -> impl Iterator<Item = u16> + '_ {
        let (older, newer) = if channel < CHANNELS { self.halves() } else { (&[][..], &[][..]) };
        let channel = channel.min(CHANNELS - 1);
        older.iter().chain(newer).map(move |scan| scan[channel])
    }

    /// Copies the bytes from `offset` on into `bytes` and returns their number: scan by scan, oldest first,
    /// each code little-endian. It is less than the length of `bytes` only at the end.
    pub fn read_bytes(&self, offset: usize, bytes: &mut [u8]) -> usize {
        copy_bytes(|index| self.scan(index).copied(), (offset, self.len()), bytes)
    }

    /// As [`Self::read_bytes`], of the hit before the present wait, given the codes of [`Self::save_start`]. The record
    /// must not have ended its wait.
    pub fn read_bytes_before_wait<R: Real>(
        &self,
        start: &[R],
        offset: usize,
        bytes: &mut [u8],
    ) -> usize {
        let saved = |index: usize| {
            let codes = start.get(index * CHANNELS..(index + 1) * CHANNELS)?;
            Some(core::array::from_fn(|channel| code_of(codes[channel])))
        };
        let scan = |index: usize| {
            if index < PRE_TRIGGER_SCANS { saved(index) } else { self.scans.get(index).copied() }
        };
        copy_bytes(scan, (offset, RECORD_SCANS), bytes)
    }

    /// The two pieces of the ring in order.
    fn halves(&self) -> (&[Scan], &[Scan]) {
        let rows = self.rows;
        let ring = self.scans.get(..rows.capacity()).unwrap_or(&[]);
        if rows.filled < ring.len() {
            // The ring has not wrapped since the last `clear`.
            (ring.get(..rows.filled).unwrap_or(&[]), &[])
        } else {
            let (newer, older) = ring.split_at(rows.next.min(ring.len()));
            (older, newer)
        }
    }
}

/// Turns the codes of the hammer by this number of places, less than that of the scans.
fn turn_force(scans: &mut [Scan], by: usize) {
    // Three reversals turn a list in place.
    let mut reverse = |from: usize, to: usize| {
        for k in 0..(to - from) / 2 {
            let (a, b) = (from + k, to - 1 - k);
            (scans[a][HAMMER], scans[b][HAMMER]) = (scans[b][HAMMER], scans[a][HAMMER]);
        }
    };
    let count = PRE_TRIGGER_SCANS;
    reverse(0, by);
    reverse(by, count);
    reverse(0, count);
}

/// The code of a reading; it has sixteen bits, which both precisions represent exactly.
fn code_of<R: Real>(reading: R) -> u16 {
    reading.to_f32() as u16
}

/// Copies the bytes from `offset` on of this number of scans into `bytes`, and returns how many there were.
fn copy_bytes(
    scan: impl Fn(usize) -> Option<Scan>,
    (offset, scans): (usize, usize),
    bytes: &mut [u8],
) -> usize {
    let end = scans * Record::SCAN_BYTES;
    let length = bytes.len().min(end.saturating_sub(offset));
    let mut rest = bytes.get_mut(..length).unwrap_or_default();
    // The range may start and end within a scan.
    let (mut index, mut within) = (offset / Record::SCAN_BYTES, offset % Record::SCAN_BYTES);
    while let Some(scan) = scan(index).filter(|_| !rest.is_empty()) {
        let whole = bytes_of(&scan);
        let from = whole.get(within..).unwrap_or_default();
        let (now, later) = rest.split_at_mut(from.len().min(rest.len()));
        now.iter_mut().zip(from).for_each(|(to, &from)| *to = from);
        (rest, index, within) = (later, index + 1, 0);
    }
    length
}

/// The codes of a scan, little-endian.
fn bytes_of(scan: &Scan) -> [u8; Record::SCAN_BYTES] {
    let mut bytes = [0; Record::SCAN_BYTES];
    for (place, code) in bytes.chunks_exact_mut(2).zip(scan) {
        place.copy_from_slice(&code.to_le_bytes());
    }
    bytes
}

impl Default for Record {
    fn default() -> Self {
        Self::new()
    }
}

impl<R: Real> Samples<R> for Record {
    fn scans(&self) -> usize {
        self.len()
    }

    fn copy_channel(&self, channel: usize, samples: &mut [R]) -> usize {
        let (older, newer) = self.halves();
        let first = older.copy_channel(channel, samples);
        first + newer.copy_channel(channel, samples.get_mut(first..).unwrap_or(&mut []))
    }

    fn sum_groups<const GROUP: usize>(
        &self,
        channel: (usize, R),
        from: usize,
        sums: &mut [R],
    ) -> usize {
        let (older, newer) = self.halves();
        let first = older.sum_groups::<GROUP>(channel, from, sums);
        // A group may lie across the end of the ring.
        let mut next = from + first * GROUP;
        let mut count = first;
        if next < older.len() {
            let mut across = [[0; CHANNELS]; GROUP];
            let copied = across.iter_mut().zip(older.iter().chain(newer).skip(next));
            if copied.map(|(to, scan)| *to = *scan).count() < GROUP {
                return count;
            }
            let rest = sums.get_mut(count..).unwrap_or_default();
            count += across.as_slice().sum_groups::<GROUP>(channel, 0, rest);
            next += GROUP;
        }
        // There may be room for no group of the newer half, and no need to reach it.
        let rest = sums.get_mut(count..).unwrap_or_default();
        count + newer.sum_groups::<GROUP>(channel, next.saturating_sub(older.len()), rest)
    }

    fn readings(&self, channel: usize, from: usize) -> impl Iterator<Item = R> + '_ {
        let (older, newer) = self.halves();
        let rest = from.saturating_sub(older.len());
        older.readings(channel, from).chain(newer.readings(channel, rest))
    }

    fn extremes(&self, channel: usize) -> Option<[(usize, R); 2]> {
        // Comparing codes takes half the instructions of comparing floating point numbers.
        let code_extremes = extremes(self.channel(channel).enumerate())?;
        Some(code_extremes.map(|(at, code)| (at, reading_of(code))))
    }

    fn reading(&self, channel: usize, scan: usize) -> Option<R> {
        self.scan(scan)?.get(channel).map(|&code| reading_of(code))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::boxed::Box;
    use std::vec::Vec;

    /// A record after `count` scans whose codes contain scan and channel.
    fn after(count: usize) -> Box<Record> {
        let mut record = Box::new(Record::new());
        for i in 0..count {
            record.push(&core::array::from_fn(|k| (i * CHANNELS + k) as u16));
        }
        record
    }

    #[test]
    fn the_latest_scans_come_in_order() {
        for count in [0, 1, 1000, RECORD_SCANS, RECORD_SCANS + 1, 3 * RECORD_SCANS + 17] {
            let record = after(count);
            let oldest = count.saturating_sub(RECORD_SCANS);
            assert_eq!(record.len(), count.min(RECORD_SCANS));
            for i in 0..record.len() {
                assert_eq!(record.scan(i).unwrap()[3], ((oldest + i) * CHANNELS + 3) as u16);
            }
            assert_eq!(record.scan(record.len()), None);
        }
    }

    /// Pushes the scans with these numbers, whose codes contain number and channel.
    fn push(record: &mut Record, numbers: core::ops::Range<usize>) {
        numbers.for_each(|n| record.push(&core::array::from_fn(|k| (n * CHANNELS + k) as u16)));
    }

    #[test]
    fn a_wait_keeps_the_latest_scans_and_the_hit_follows_them() {
        for waited in [PRE_TRIGGER_SCANS, PRE_TRIGGER_SCANS + 1, 7 * PRE_TRIGGER_SCANS + 33] {
            let mut record = Box::new(Record::new());
            record.begin_wait();
            push(&mut record, 0..waited);
            assert_eq!(record.len(), PRE_TRIGGER_SCANS);
            let first = (waited - PRE_TRIGGER_SCANS) * CHANNELS;
            assert_eq!(record.scan(0).unwrap()[0], first as u16);
            record.end_wait();
            push(&mut record, waited..waited + RECORD_SCANS - PRE_TRIGGER_SCANS);
            assert_eq!(record.len(), RECORD_SCANS);
            for i in 0..RECORD_SCANS {
                assert_eq!(record.scan(i).unwrap()[0], (first + i * CHANNELS) as u16);
            }
        }
    }

    #[test]
    fn a_hit_is_restored_however_long_the_wait_for_the_next_one_was() {
        let mut record = Box::new(Record::new());
        for waited in [0, 1, PRE_TRIGGER_SCANS, 5000] {
            record.begin_wait();
            push(&mut record, 0..90);
            record.end_wait();
            push(&mut record, 90..90 + RECORD_SCANS - PRE_TRIGGER_SCANS);
            let hit: Vec<u16> = (0..CHANNELS).flat_map(|k| record.channel(k)).collect();
            let mut start = [0.0_f32; Record::START_CODES];
            record.save_start(&mut start);
            record.begin_wait();
            push(&mut record, 3000..3000 + waited);
            let mut before = std::vec![0; Record::BYTES];
            let halves = before.split_at_mut(1001);
            assert_eq!(record.read_bytes_before_wait(&start, 0, halves.0), 1001);
            let rest = record.read_bytes_before_wait(&start, 1001, halves.1);
            assert_eq!(rest, Record::BYTES - 1001);
            record.restore_start(&start);
            let mut restored = std::vec![0; Record::BYTES];
            assert_eq!(record.read_bytes(0, &mut restored), Record::BYTES);
            assert!(before == restored, "{waited} scans");
            assert!((0..CHANNELS).flat_map(|k| record.channel(k)).eq(hit), "{waited} scans");
        }
    }

    #[test]
    fn a_long_record_has_force_and_rows_in_their_own_order() {
        for (forces, rows) in [(80, 80), (80, 81), (133, 97), (7 * 80 + 33, 3 * 80 + 79)] {
            let mut record = Box::new(Record::new());
            record.begin_wait();
            (0..forces).for_each(|n| record.push_force(n));
            (0..rows).for_each(|n| record.push_row(&[10_000 + n; CHANNELS - 1]));
            record.end_wait();
            // More than it holds.
            (0..3000).for_each(|n| record.push_force(forces + n));
            assert!(record.len() < RECORD_SCANS);
            (0..3000).for_each(|n| record.push_row(&[10_000 + rows + n; CHANNELS - 1]));
            assert_eq!(record.len(), RECORD_SCANS);
            for place in 0..RECORD_SCANS {
                let scan = record.scan(place).unwrap();
                let force = usize::from(forces) - PRE_TRIGGER_SCANS + place;
                let row = 10_000 + usize::from(rows) - PRE_TRIGGER_SCANS + place;
                assert_eq!((usize::from(scan[0]), usize::from(scan[9])), (force, row));
            }
        }
    }

    #[test]
    fn a_channel_is_the_column_of_the_scans() {
        let record = after(RECORD_SCANS + 900);
        for k in 0..CHANNELS {
            let column: Vec<u16> = (0..record.len()).map(|i| record.scan(i).unwrap()[k]).collect();
            assert_eq!(record.channel(k).collect::<Vec<_>>(), column);
            let mut readings = [0.0_f64; RECORD_SCANS];
            assert_eq!(record.copy_channel(k, &mut readings), record.len());
            assert!(readings.iter().zip(&column).all(|(&x, &code)| x == f64::from(code)));
            for from in [0, 1, 899, 900, RECORD_SCANS - 900, RECORD_SCANS - 1, RECORD_SCANS] {
                let rest: Vec<f64> = Samples::readings(&*record, k, from).collect();
                assert_eq!(rest, readings[from..], "channel {k} from scan {from}");
                assert_eq!(Samples::reading(&*record, k, from), readings.get(from).copied());
            }
        }
        assert_eq!(Samples::<f32>::readings(&*record, CHANNELS, 0).count(), 0);
        assert_eq!(record.channel(CHANNELS).count(), 0);
    }

    #[test]
    fn chunks_of_any_size_make_the_same_bytes() {
        let record = after(RECORD_SCANS + 5);
        let mut whole = std::vec![0; Record::BYTES];
        assert_eq!(record.read_bytes(0, &mut whole), Record::BYTES);
        let expected: Vec<u8> = (0..record.len())
            .flat_map(|i| record.scan(i).unwrap().map(u16::to_le_bytes).concat())
            .collect();
        assert!(whole == expected);

        for size in [1, 7, 19, 20, 21, 64, 1000, 1024] {
            let mut bytes = Vec::new();
            let mut chunk = std::vec![0; size];
            loop {
                let got = record.read_bytes(bytes.len(), &mut chunk);
                bytes.extend_from_slice(&chunk[..got]);
                if got < size {
                    break;
                }
            }
            assert!(bytes == expected, "chunks of {size}");
        }
        assert_eq!(record.read_bytes(usize::MAX, &mut [0; 4]), 0);
    }

    #[test]
    fn groups_are_summed_wherever_the_ring_begins_and_however_few_are_wanted() {
        const GROUP: usize = 5;
        for count in RECORD_SCANS..2 * RECORD_SCANS {
            let record = after(count);
            for (from, wanted) in [(150, 376), (176, 374), (0, 409), (2040, 1)] {
                let mut sums = std::vec![0.0_f32; wanted];
                let first: f32 = Samples::<f32>::reading(&*record, 3, from).unwrap();
                let summed = record.sum_groups::<GROUP>((3, first), from, &mut sums);
                assert_eq!(summed, wanted, "{count} scans, from {from}");
                // A few groups are enough to see an error of order.
                for at in [0, wanted / 2, wanted - 1] {
                    let readings = (0..GROUP).map(|k| {
                        Samples::<f32>::reading(&*record, 3, from + at * GROUP + k).unwrap() - first
                    });
                    // Sums of whole numbers below 2^24.
                    assert_eq!(sums[at], readings.sum::<f32>(), "{count} scans, from {from}: {at}");
                }
            }
        }
    }
}

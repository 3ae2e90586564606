//! Large objects as bytes: results, finished DOFs and layouts from the store, the record and the spectra from memory.

use embassy_futures::yield_now;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::mutex::Mutex;
use embedded_storage_async::nor_flash::NorFlash;
use massline_protocol::crc32_of_chunks;
use massline_protocol::lines::{CURRENT_CAMPAIGN, LinesId};
use massline_protocol::message::Reason;
use massline_protocol::object::{
    ChunkRequest, MAX_CHUNK, ObjectId, ObjectInfo, ObjectKind, READING,
};
use massline_shared::measurement::averaging::DofSpectra;
use massline_shared::measurement::{Measurement, RecordContent};
use massline_shared::signal::{RESPONSES, Record, SPECTRUM_BINS, resolution};

use crate::deadline::Deadline;
use crate::rig::Rig;
use crate::store::{DofHandle, ResultHandle, Store};

/// Bytes of the record that are checksummed at a time.
const PIECE: usize = 4 * Record::SCAN_BYTES;
/// Words of the spectra object: a header of four, G_FF, G_XF (re, im), G_XX.
const HEADER_WORDS: usize = 4;
const SPECTRA_WORDS: usize = HEADER_WORDS + SPECTRUM_BINS * (1 + 3 * RESPONSES);

/// Access to the objects.
pub(crate) struct Objects<'a, 'm, F: NorFlash> {
    pub rig: &'a Rig<'m>,
    pub store: &'a Mutex<NoopRawMutex, Store<F>>,
}

impl<F: NorFlash> Objects<'_, '_, F> {
    /// Length and checksum of an object. `room` is for the pieces of an object whose checksum is computed from
    /// flash.
    pub async fn info(&self, object: ObjectId, room: &mut [u8]) -> Result<ObjectInfo, Reason> {
        let (length, crc) = match kind(object)? {
            ObjectKind::Result => {
                let stored = self.stored(object).await?;
                (stored.entry.length, stored.crc)
            }
            ObjectKind::Record => {
                let _deadline = Deadline::begin(&self.rig.stats);
                let measurement = self.rig.measurement.borrow();
                has_record(&measurement, object)?;
                (Record::BYTES as u32, crc_of_record(&measurement))
            }
            ObjectKind::Spectra => {
                let _deadline = Deadline::begin(&self.rig.stats);
                let measurement = self.rig.measurement.borrow();
                let (header, spectra) = spectra(&measurement, object)?;
                let mut crc = crc32_of_chunks();
                (0..SPECTRA_WORDS).for_each(|i| crc.update(&word(header, spectra, i)));
                (SPECTRA_WORDS as u32 * 4, crc.finalize())
            }
            ObjectKind::Lines => {
                let stored = self.dof_with_lines(object).await?;
                (stored.length() as u32, self.crc_of_dof(&stored, room).await?)
            }
            // The hash of a layout is the checksum of its bytes.
            ObjectKind::Layout => (self.length_of_layout(object).await? as u32, object.number),
        };
        Ok(ObjectInfo { length, crc })
    }

    /// Reads a piece of an object into the front of `room`; returns the number of bytes read.
    ///
    /// # Errors
    /// The reason why this object or piece is not available now.
    pub async fn read(&self, request: ChunkRequest, room: &mut [u8]) -> Result<usize, Reason> {
        let ChunkRequest { object, offset, length } = request;
        let offset = offset as usize;
        let wanted = usize::from(length).min(MAX_CHUNK);
        let room = room.get_mut(..wanted).ok_or(Reason::OutOfRange)?;
        match kind(object)? {
            ObjectKind::Result => {
                let stored = self.stored(object).await?;
                in_range(offset, stored.entry.length as usize)?;
                Ok(self.store.lock().await.read_result(&stored, offset, room).await?)
            }
            ObjectKind::Record => {
                let measurement = self.rig.measurement.borrow();
                has_record(&measurement, object)?;
                in_range(offset, Record::BYTES)?;
                Ok(measurement.read_recorded(offset, room))
            }
            ObjectKind::Spectra => {
                let measurement = self.rig.measurement.borrow();
                let (header, spectra) = spectra(&measurement, object)?;
                in_range(offset, SPECTRA_WORDS * 4)?;
                let places = offset..SPECTRA_WORDS * 4;
                let read = wanted.min(places.len());
                for (byte, at) in room.iter_mut().zip(places) {
                    *byte = word(header, spectra, at / 4)[at % 4];
                }
                Ok(read)
            }
            ObjectKind::Lines => {
                let stored = self.dof_with_lines(object).await?;
                in_range(offset, stored.length())?;
                Ok(self.store.lock().await.read_dof(&stored, offset, room).await?)
            }
            ObjectKind::Layout => {
                in_range(offset, self.length_of_layout(object).await?)?;
                Ok(self.store.lock().await.read_layout(object.number, offset, room).await?)
            }
        }
    }

    async fn stored(&self, object: ObjectId) -> Result<ResultHandle, Reason> {
        self.store.lock().await.find(object.number).ok_or(Reason::NotFound)
    }

    async fn length_of_layout(&self, object: ObjectId) -> Result<usize, Reason> {
        self.store.lock().await.length_of_layout(object.number).ok_or(Reason::NotFound)
    }

    async fn dof_with_lines(&self, object: ObjectId) -> Result<DofHandle, Reason> {
        let store = self.store.lock().await;
        let handle = match LinesId::of_number(object.number) {
            LinesId { result: CURRENT_CAMPAIGN, dof } => store.dof_of_campaign(dof),
            LinesId { result, dof } => store.dof_of_result(result, dof),
        };
        handle.filter(DofHandle::has_lines).ok_or(Reason::NotFound)
    }

    /// Checksum of a stored DOF. Lets the link and the watchdog run between two pieces.
    async fn crc_of_dof(&self, stored: &DofHandle, room: &mut [u8]) -> Result<u32, Reason> {
        let room = room.get_mut(..MAX_CHUNK).ok_or(Reason::OutOfRange)?;
        let (mut crc, mut offset) = (crc32_of_chunks(), 0);
        while offset < stored.length() {
            let read = self.store.lock().await.read_dof(stored, offset, room).await?;
            crc.update(room.get(..read).unwrap_or_default());
            offset += read;
            yield_now().await;
        }
        Ok(crc.finalize())
    }
}

/// Whether the record holds the requested hit or reading.
fn has_record(measurement: &Measurement<'_, f32>, object: ObjectId) -> Result<(), Reason> {
    match measurement.recorded() {
        RecordContent::Hit(hit) | RecordContent::HitBefore(hit) if hit == object.number => Ok(()),
        RecordContent::Reading if object.number == READING && !measurement.reads() => Ok(()),
        RecordContent::Hit(_) | RecordContent::HitBefore(_) => Err(Reason::NotFound),
        _ if measurement.rests() => Err(Reason::NotFound),
        _ => Err(Reason::Busy),
    }
}

/// The averaged spectra of the requested DOF, with their header: dof, hits, responses, 0; number of bins
/// u16, 0; resolution f32; decay f32.
fn spectra<'r>(
    measurement: &'r Measurement<'_, f32>,
    object: ObjectId,
) -> Result<([[u8; 4]; HEADER_WORDS], &'r DofSpectra<f32>), Reason> {
    let entry = measurement.spectra().filter(|(dof, _)| u32::from(*dof) == object.number);
    let (dof, spectra) = entry.ok_or(Reason::NotFound)?;
    let decay = measurement.layout().map_or(0.0, |layout| layout.test.exponential_decay);
    let bins = (SPECTRUM_BINS as u16).to_le_bytes();
    let adc = measurement.adc();
    let header = [
        [dof, spectra.hits() as u8, adc.responses() as u8, 0],
        [bins[0], bins[1], 0, 0],
        resolution::<f32>(adc, measurement.profile()).to_le_bytes(),
        decay.to_le_bytes(),
    ];
    Ok((header, spectra))
}

fn kind(object: ObjectId) -> Result<ObjectKind, Reason> {
    ObjectKind::try_from(object.kind).map_err(|_| Reason::NotFound)
}

fn in_range(offset: usize, length: usize) -> Result<(), Reason> {
    if offset < length { Ok(()) } else { Err(Reason::OutOfRange) }
}

fn crc_of_record(measurement: &Measurement<'_, f32>) -> u32 {
    let mut crc = crc32_of_chunks();
    let mut piece = [0; PIECE];
    let mut at = 0;
    loop {
        let read = measurement.read_recorded(at, &mut piece);
        if read == 0 {
            return crc.finalize();
        }
        crc.update(piece.get(..read).unwrap_or_default());
        at += read;
    }
}

fn word(header: [[u8; 4]; HEADER_WORDS], spectra: &DofSpectra<f32>, i: usize) -> [u8; 4] {
    let Some(i) = i.checked_sub(HEADER_WORDS) else {
        return header.get(i).copied().unwrap_or_default();
    };
    let (block, rest) = (i / SPECTRUM_BINS, i % SPECTRUM_BINS);
    let value = if block == 0 {
        spectra.force_auto(rest)
    } else if block <= 2 * RESPONSES {
        let i = i - SPECTRUM_BINS;
        let cross = spectra.cross(i / (2 * SPECTRUM_BINS), i % (2 * SPECTRUM_BINS) / 2);
        if i.is_multiple_of(2) { cross.re } else { cross.im }
    } else {
        spectra.response_auto(block - 1 - 2 * RESPONSES, rest)
    };
    value.to_le_bytes()
}

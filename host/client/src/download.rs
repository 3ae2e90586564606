//! Downloads objects in pieces.

use std::time::{Duration, Instant};

use massline_protocol::lines::{LinesId, split_dof};
use massline_protocol::lines_head::LinesHead;
use massline_protocol::message::{GetObjectInfo, ReadObject, Reason};
use massline_protocol::object::{
    ChunkRequest, MAX_CHUNK, MeasurementResult, ObjectId, ObjectInfo, ObjectKind, READING,
};
use massline_protocol::{LayoutHash, crc32};
use massline_shared::layout::RigLayout;
use massline_shared::signal::{Scan, expand_response};
use nalgebra::Complex;

use crate::error::ClientError;
use crate::exchange::Client;
use crate::scans::scans_of;
use massline_files::dof_spectra::{DofSpectra, SpectraError};

/// How often an object is read again when its checksum is wrong or it changes during the download.
const ATTEMPTS: u32 = 3;
/// How long an object may stay busy.
const PATIENCE: Duration = Duration::from_secs(10);
/// Size limit, bytes; no object of any rig is larger.
const LONGEST: u32 = 16 << 20;

/// A finished DOF with lines, as a rig has stored it.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredDof {
    /// What is known of it besides its lines.
    pub head: LinesHead,
    /// The frequency response of each channel, line by line from 0 Hz on, (m/s²)/N.
    pub responses: Vec<Vec<Complex<f32>>>,
}

impl StoredDof {
    /// Reads an object of kind [`ObjectKind::Lines`]; `None` when it is none.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (head, compact) = split_dof::<LinesHead>(bytes)?;
        let expand = |bytes| expand_response::<f32>(bytes).map(|lines| lines.to_vec());
        let responses = compact.iter().map(expand).collect::<Option<_>>()?;
        Some(Self { head, responses })
    }
}

impl Client {
    /// Downloads an object, resumes after a lost link, and checks the whole. `progress` is called with the
    /// bytes received and the total.
    ///
    /// # Errors
    /// When there is no such object, its checksum differs, and as [`Client::ask`].
    pub fn download(
        &mut self,
        object: ObjectId,
        mut progress: impl FnMut(u32, u32),
    ) -> Result<Vec<u8>, ClientError> {
        for _ in 0..ATTEMPTS {
            let info = self.object_info(object)?;
            if let Some(bytes) = self.read_object(object, info, &mut progress)?
                && crc32(&bytes) == info.crc
            {
                return Ok(bytes);
            }
        }
        Err(ClientError::Checksum { kind: object.kind, number: object.number, attempts: ATTEMPTS })
    }

    /// Downloads a stored result.
    ///
    /// # Errors
    /// As [`Client::download`]; [`ClientError::Unreadable`] when it does not decode.
    pub fn result(&mut self, number: u32) -> Result<MeasurementResult, ClientError> {
        let object = ObjectId { kind: ObjectKind::Result as u8, number };
        let bytes = self.download(object, |_, _| ())?;
        postcard::from_bytes(&bytes)
            .map_err(|_| ClientError::Unreadable { kind: object.kind, number })
    }

    /// Downloads the stored layout with this hash, which need not be the one in use; `None` when the rig has replaced
    /// it, or cannot read it.
    ///
    /// # Errors
    /// As [`Client::download`].
    pub fn stored_layout(&mut self, hash: u32) -> Result<Option<RigLayout>, ClientError> {
        let object = ObjectId { kind: ObjectKind::Layout as u8, number: hash };
        let bytes = match self.download(object, |_, _| ()) {
            Err(e) if matches!(e.refusal(), Some(Reason::NotFound | Reason::StoreFailed)) => {
                return Ok(None);
            }
            bytes => bytes?,
        };
        Ok(postcard::from_bytes(&bytes).ok().filter(|layout: &RigLayout| layout.hash() == hash))
    }

    /// Downloads a finished DOF with lines; `None` when the rig does not have it.
    ///
    /// # Errors
    /// As [`Client::download`]; [`ClientError::Unreadable`] when it does not decode, or is another DOF.
    pub fn lines(&mut self, id: LinesId) -> Result<Option<StoredDof>, ClientError> {
        let Some(object) = id.object() else { return Ok(None) };
        let bytes = match self.download(object, |_, _| ()) {
            Err(e) if e.refusal() == Some(Reason::NotFound) => return Ok(None),
            bytes => bytes?,
        };
        let ObjectId { kind, number } = object;
        let dof = StoredDof::from_bytes(&bytes).filter(|dof| dof.head.index == id.dof);
        dof.map(Some).ok_or(ClientError::Unreadable { kind, number })
    }

    /// Downloads the record of a hit; the rig has that of its last hit until the next one triggers.
    ///
    /// # Errors
    /// As [`Client::download`].
    pub fn hit_record(&mut self, number: u32) -> Result<Vec<Scan>, ClientError> {
        let object = ObjectId { kind: ObjectKind::Record as u8, number };
        self.download(object, |_, _| ()).map(|bytes| scans_of(&bytes))
    }

    /// Downloads the record of the latest reading without a hit; `None` from a rig that does not give it.
    ///
    /// # Errors
    /// As [`Client::download`].
    pub fn rest_record(&mut self) -> Result<Option<Vec<Scan>>, ClientError> {
        let object = ObjectId { kind: ObjectKind::Record as u8, number: READING };
        match self.download(object, |_, _| ()) {
            Ok(bytes) => Ok(Some(scans_of(&bytes))),
            Err(e) if e.refusal() == Some(Reason::NotFound) => Ok(None),
            Err(e) => Err(e),
        }
    }

    /// Downloads the spectra of a DOF, by its index in the layout; the rig has those of the DOF in progress
    /// or finished last.
    ///
    /// # Errors
    /// As [`Client::download`], refused with `NotFound` when the rig no longer has them;
    /// [`ClientError::Spectra`] when they are invalid.
    pub fn spectra(&mut self, dof: u8) -> Result<DofSpectra, ClientError> {
        let object = ObjectId { kind: ObjectKind::Spectra as u8, number: u32::from(dof) };
        let bytes = self.download(object, |_, _| ())?;
        let spectra = DofSpectra::from_bytes(&bytes).and_then(|spectra| match spectra.dof {
            same if same == dof => Ok(spectra),
            other => Err(SpectraError::OtherDof { dof: other }),
        });
        spectra.map_err(|reason| ClientError::Spectra { number: object.number, reason })
    }

    fn object_info(&mut self, object: ObjectId) -> Result<ObjectInfo, ClientError> {
        self.patiently(|client| client.ask::<GetObjectInfo>(&object))
    }

    /// The bytes of an object; `None` when the rig's answers are inconsistent, as when the object changes
    /// during the download.
    fn read_object(
        &mut self,
        object: ObjectId,
        info: ObjectInfo,
        progress: &mut impl FnMut(u32, u32),
    ) -> Result<Option<Vec<u8>>, ClientError> {
        if info.length > LONGEST {
            return Ok(None);
        }
        let mut bytes: Vec<u8> = Vec::with_capacity(info.length as usize);
        progress(0, info.length);
        while (bytes.len() as u32) < info.length {
            let offset = bytes.len() as u32;
            let length = (info.length - offset).min(MAX_CHUNK as u32) as u16;
            let request = ChunkRequest { object, offset, length };
            let chunk = match self.patiently(|client| client.ask::<ReadObject>(&request)) {
                Err(e) if e.refusal() == Some(Reason::OutOfRange) => return Ok(None),
                other => other?,
            };
            let fits = chunk.object == object
                && chunk.offset == offset
                && !chunk.bytes.is_empty()
                && chunk.bytes.len() <= usize::from(length);
            if !fits {
                return Ok(None);
            }
            bytes.extend_from_slice(&chunk.bytes);
            progress(bytes.len() as u32, info.length);
        }
        Ok(Some(bytes))
    }

    /// Repeats a request while the rig is busy with the object.
    pub(super) fn patiently<T>(
        &mut self,
        mut ask: impl FnMut(&mut Self) -> Result<T, ClientError>,
    ) -> Result<T, ClientError> {
        let started = Instant::now();
        loop {
            match ask(self) {
                Err(e) if e.refusal() == Some(Reason::Busy) && started.elapsed() < PATIENCE => {
                    std::thread::sleep(Duration::from_millis(20));
                }
                other => return other,
            }
        }
    }
}

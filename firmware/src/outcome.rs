//! What a measurement has brought, as the bytes that are stored: from the domain to the wire's objects, one at a
//! time. A whole result is never in memory twice: the store reads it piece by piece.

use massline_protocol::crc32;
use massline_protocol::diagnostic::DiagnosticList;
use massline_protocol::object::{DofResult, ResultHead, StoredEstimate};
use massline_shared::signal::Calibration;
use postcard::ser_flavors::Flavor;
use serde::Serialize;

use crate::rig::{Rig, cut};
use crate::store::Source;

/// The result of a measurement as a [`MeasurementResult`] is encoded.
///
/// [`MeasurementResult`]: massline_protocol::object::MeasurementResult
pub(crate) struct StoredResult<'a, 'm> {
    rig: &'a Rig<'m>,
    number: u32,
    length: usize,
}

impl<'a, 'm> StoredResult<'a, 'm> {
    /// The result that is to be kept under this number.
    pub fn new(rig: &'a Rig<'m>, number: u32) -> Self {
        let mut counted = Self { rig, number, length: 0 };
        counted.length = counted.write(0, &mut []);
        counted
    }

    /// Writes the bytes from `offset` on into `out`; gives how many there are in all.
    fn write(&self, offset: usize, out: &mut [u8]) -> usize {
        let measurement = self.rig.measurement.borrow();
        let result = measurement.result();
        let test = measurement.layout().map(|layout| layout.test).unwrap_or_default();
        let mut window = Window { offset, out, at: 0 };
        window.put(&ResultHead {
            number: self.number,
            layout_hash: self.rig.layout_hash.get(),
            calibration: checksum_of(measurement.calibration()),
            firmware: cut(self.rig.info.firmware),
            frf_estimator: test.frf_estimator,
            terms: test.terms,
            band_automatic: test.band_hz.is_none(),
        });
        window.put(&(result.dofs.len() as u32));
        for (details, lines) in result.dofs.iter().zip(result.mass_lines) {
            window.put(&DofResult::of(details, lines));
        }
        window.put(&(result.estimates.len() as u32));
        for estimate in result.estimates {
            window.put(&StoredEstimate::from(estimate));
        }
        window.put(&DiagnosticList(result.diagnostics.clone()));
        window.at
    }
}

impl Source for StoredResult<'_, '_> {
    fn length(&self) -> usize {
        self.length
    }

    fn read(&self, offset: usize, out: &mut [u8]) {
        self.write(offset, out);
    }
}

/// Names a calibration in the results.
pub(crate) fn checksum_of(calibration: &Calibration) -> u32 {
    // Numbers of four bytes, which take as much encoded.
    let mut bytes = [0; size_of::<Calibration>()];
    postcard::to_slice(calibration, &mut bytes).map_or(0, |bytes| crc32(bytes))
}

/// A piece of what is written one behind the other; the rest is only counted.
struct Window<'o> {
    offset: usize,
    out: &'o mut [u8],
    at: usize,
}

impl Window<'_> {
    fn put(&mut self, value: &impl Serialize) {
        // Neither counting nor a piece of memory fails.
        let _ = postcard::serialize_with_flavor(value, Bytes(self));
    }
}

/// The bytes of one thing on their way into a window.
struct Bytes<'w, 'o>(&'w mut Window<'o>);

impl Flavor for Bytes<'_, '_> {
    type Output = ();

    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        let window = &mut *self.0;
        let place = window.at.checked_sub(window.offset);
        if let Some(to) = place.and_then(|place| window.out.get_mut(place)) {
            *to = byte;
        }
        window.at += 1;
        Ok(())
    }

    fn finalize(self) -> postcard::Result<()> {
        Ok(())
    }
}

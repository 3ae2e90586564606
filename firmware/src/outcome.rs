//! The result of a measurement as the bytes that are stored. Domain values are converted to the wire's
//! objects one at a time, and the store reads the bytes piece by piece, so a whole result is never in
//! memory twice.

use massline_protocol::diagnostic::DiagnosticList;
use massline_protocol::lines_head::LinesHead;
use massline_protocol::modes::{StoredAgreement, StoredMode, StoredRefusal};
use massline_protocol::object::{DofResult, ResultHead, StoredEstimate};
use massline_protocol::{calibration_checksum, crc32_of_chunks};
use massline_shared::measurement::Measurement;
use postcard::ser_flavors::Flavor;
use serde::Serialize;

use crate::deadline::Deadline;
use crate::rig::{Rig, cut};
use crate::store::Source;

/// The result of a measurement, encoded as a [`MeasurementResult`].
///
/// [`MeasurementResult`]: massline_protocol::object::MeasurementResult
pub(crate) struct StoredResult<'a, 'm> {
    rig: &'a Rig<'m>,
    number: u32,
    length: usize,
    checksum: u32,
}

impl<'a, 'm> StoredResult<'a, 'm> {
    /// The result to be stored under this number. Deadline: [`crate::deadline::DEADLINE`].
    pub fn new(rig: &'a Rig<'m>, number: u32) -> Self {
        let _deadline = Deadline::begin(&rig.stats);
        let (mut length, mut checksum) = (0, crc32_of_chunks());
        let counted = Self { rig, number, length, checksum: 0 };
        counted.write(&mut |byte| {
            length += 1;
            checksum.update(&[byte]);
        });
        Self { length, checksum: checksum.finalize(), ..counted }
    }

    /// Passes all bytes to `take`, one at a time.
    fn write(&self, take: &mut dyn FnMut(u8)) {
        let measurement = self.rig.measurement.borrow();
        let result = measurement.result();
        let layout = measurement.layout();
        let test = layout.map(|layout| layout.test).unwrap_or_default();
        let mut bytes = Bytes(take);
        bytes.put(&ResultHead {
            number: self.number,
            layout_hash: self.rig.layout_hash.get(),
            title: layout.map(|layout| layout.title.clone()).unwrap_or_default(),
            started_unix_s: measurement.campaign().map_or(0, |of| of.started().started_unix_s),
            calibration: calibration_checksum(measurement.calibration()),
            gains: result.gains,
            firmware: cut(self.rig.info.firmware),
            frf_estimator: test.frf_estimator,
            terms: test.terms,
            band_automatic: test.band_hz.is_none(),
        });
        bytes.put(&(result.mass_lines.len() as u32));
        for (details, lines) in result.dofs.iter().zip(result.mass_lines) {
            bytes.put(&DofResult::of(details, lines));
        }
        bytes.put(&(result.lines.len() as u32));
        for (details, lines) in result.dofs.iter().zip(result.lines) {
            bytes.put(&LinesHead::of(details, lines));
        }
        let of_modes = count_modal(&measurement);
        bytes.put(&((result.estimates.len() + of_modes) as u32));
        for estimate in result.estimates {
            bytes.put(&StoredEstimate::from(estimate));
        }
        put_modal(&measurement, &mut bytes);
        put_modes(&measurement, &mut bytes);
        bytes.put(&DiagnosticList(result.diagnostics.clone()));
    }
}

/// Number of estimates of the suspension modes.
#[inline(never)]
fn count_modal(measurement: &Measurement<'_, f32>) -> usize {
    measurement.modal_estimates().count()
}

/// Writes the estimates of the suspension modes.
// Not inlined: each of them is computed on its stack.
#[inline(never)]
fn put_modal(measurement: &Measurement<'_, f32>, bytes: &mut Bytes<'_>) {
    measurement.modal_estimates().for_each(|estimate| bytes.put(&StoredEstimate::from(&estimate)));
}

/// Writes the suspension modes, the methods without an answer, and how the methods agree.
// Not inlined: it has a stack of its own.
#[inline(never)]
fn put_modes(measurement: &Measurement<'_, f32>, bytes: &mut Bytes<'_>) {
    let solver = measurement.solver();
    let modes = solver.map_or(0, |solver| solver.modes().len());
    bytes.put(&(modes as u32));
    for mode in solver
        .iter()
        .flat_map(|solver| (0..modes).map(|place| StoredMode::of(solver, place)))
        .flatten()
    {
        bytes.put(&mode);
    }
    bytes.put(&(measurement.modal_refusals().count() as u32));
    for (method, reason) in measurement.modal_refusals() {
        bytes.put(&StoredRefusal { method: method.number(), reason: (&reason).into() });
    }
    bytes.put(&solver.and_then(|solver| solver.agreement()).map(StoredAgreement::of));
}

impl Source for StoredResult<'_, '_> {
    fn length(&self) -> usize {
        self.length
    }

    fn checksum(&self) -> u32 {
        self.checksum
    }

    /// Deadline: [`crate::deadline::DEADLINE`].
    fn read(&self, offset: usize, out: &mut [u8]) {
        let _deadline = Deadline::begin(&self.rig.stats);
        let mut at = 0_usize;
        self.write(&mut |byte| {
            if let Some(to) = at.checked_sub(offset).and_then(|place| out.get_mut(place)) {
                *to = byte;
            }
            at += 1;
        });
    }
}

/// A serialization flavor that passes each byte to a closure.
struct Bytes<'t>(&'t mut dyn FnMut(u8));

impl Bytes<'_> {
    fn put(&mut self, value: &impl Serialize) {
        // Cannot fail: the closure accepts every byte.
        let _ = postcard::serialize_with_flavor(value, Bytes(self.0));
    }
}

impl Flavor for Bytes<'_> {
    type Output = ();

    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        (self.0)(byte);
        Ok(())
    }

    fn finalize(self) -> postcard::Result<()> {
        Ok(())
    }
}

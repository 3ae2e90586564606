//! From a record to averaged spectra, from spectra to mass lines, and all of it in the result.

use core::cell::RefCell;

use embassy_futures::yield_now;
use heapless::Vec;
use massline_protocol::crc32;
use massline_protocol::message::Measured;
use massline_protocol::object::{DofResult, MeasurementResult};
use massline_shared::averaging::{
    DofSpectra, HitInHand, HitMemory, Method, band_of, fit_responses, resolution,
};
use massline_shared::campaign::Outcome;
use massline_shared::diagnosis::{Code, Diagnostic, Severity, Subject};
use massline_shared::identify::{ScatterAccumulator, lower_triangle};
use massline_shared::layout::{FrfEstimator, TestSettings};
use massline_shared::mass_line::{BasisRow, MassLineError, Terms};
use massline_shared::signal::{
    Calibration, FftError, RECORD_SCANS, RESPONSES, Record, SPECTRUM_LINES, Standing, lines_of_band,
};
use nalgebra::Complex;
use serde::Serialize;

use crate::block;
use crate::consistency;
use crate::deadline::Deadline;
use crate::identification;
use crate::rig::{Rig, cut};

const ZERO: Complex<f32> = Complex { re: 0.0, im: 0.0 };

/// What the analysis keeps between two steps.
pub(crate) struct AnalysisMemory {
    /// Samples and transform of one channel; after the last hit the workspace of the fit, then the
    /// encoded result.
    scratch: [f32; RECORD_SCANS],
    force: [Complex<f32>; SPECTRUM_LINES],
    basis: [BasisRow<f32>; SPECTRUM_LINES],
    /// Mass lines of the single hits of the DOF in hand.
    single_hits: Option<ScatterAccumulator<f32, RESPONSES>>,
    /// The result as far as it is known.
    result: MeasurementResult,
    /// The campaign that `result` belongs to, as counted by the campaign.
    campaign: u32,
}

impl AnalysisMemory {
    /// All zero bytes, so a static one lies in `.bss`; the settings in the result are those of no
    /// campaign and are set by every one.
    pub const fn new() -> Self {
        Self {
            scratch: [0.0; RECORD_SCANS],
            force: [ZERO; SPECTRUM_LINES],
            basis: [BasisRow::EMPTY; SPECTRUM_LINES],
            single_hits: None,
            result: MeasurementResult {
                number: 0,
                layout_hash: 0,
                calibration: 0,
                firmware: heapless::String::new(),
                frf_estimator: FrfEstimator::H1,
                terms: Terms::A,
                band_automatic: false,
                dofs: Vec::new(),
                estimates: Vec::new(),
                diagnostics: Vec::new(),
            },
            campaign: 0,
        }
    }

    /// The DOFs that this campaign has closed.
    pub fn dofs_of(&self, campaign: u32) -> &[DofResult] {
        if self.campaign == campaign { &self.result.dofs } else { &[] }
    }

    /// The `i`th DOF that this campaign has closed: its index in the layout, and itself as bytes.
    pub fn encode_dof(&mut self, campaign: u32, i: usize) -> Option<(u8, &[u8])> {
        let dof = self.dofs_of(campaign).get(i)?;
        let index = dof.index;
        let Self { scratch, result, .. } = self;
        let room = bytemuck::cast_slice_mut(scratch);
        Some((index, postcard::to_slice(result.dofs.get(i)?, room).ok()?))
    }

    /// Something small as bytes.
    pub fn encode(&mut self, value: &impl Serialize) -> &[u8] {
        postcard::to_slice(value, self.room()).map_or(&[][..], |bytes| bytes)
    }

    /// Room for bytes between two steps.
    pub fn room(&mut self) -> &mut [u8] {
        bytemuck::cast_slice_mut(&mut self.scratch)
    }

    /// Takes a closed DOF out of the room, where it has this many bytes.
    #[inline(never)]
    pub fn take_dof(&mut self, length: usize) {
        let Self { scratch, result, .. } = self;
        let bytes = bytemuck::cast_slice::<_, u8>(scratch).get(..length).unwrap_or_default();
        if let Ok(dof) = postcard::from_bytes(bytes) {
            // There is room for every DOF of a layout.
            let _ = result.dofs.push(dof);
        }
    }

    /// Takes the DOFs that were taken out of the room for those of a campaign, but for some.
    pub fn take_up(
        &mut self,
        campaign: u32,
        wanted: impl FnMut(&DofResult) -> bool,
    ) -> &[DofResult] {
        self.campaign = campaign;
        self.result.dofs.retain(wanted);
        &self.result.dofs
    }

    /// The result as bytes, and the mass by its best answer when there is one.
    #[inline(never)]
    pub fn encode_result(&mut self) -> (&[u8], Option<Measured>) {
        let mass = self.result.estimates.first().map(identification::mass_of);
        let room = bytemuck::cast_slice_mut(&mut self.scratch);
        // A result is at most as long as the store takes, which a test proves: it fits the room.
        let bytes = postcard::to_slice(&self.result, room).map_or(&[][..], |bytes| bytes);
        (bytes, mass)
    }
}

/// The analysis and what it works on.
pub(crate) struct Analysis<'a> {
    pub rig: &'a Rig,
    pub record: &'a RefCell<Record>,
    pub spectra: &'a RefCell<DofSpectra<f32>>,
    pub memory: &'a mut AnalysisMemory,
}

impl Analysis<'_> {
    /// Averages the record into the spectra of a DOF, and its own mass lines into their scatter; takes it
    /// out again when it does not agree with its siblings and the policy wants only those that do.
    ///
    /// Yields between channels; a channel takes about 0.2 M instructions. Deadline: [`crate::deadline::DEADLINE`]
    /// between two yields.
    pub async fn average_hit(&mut self, dof: usize) -> Standing<f32> {
        // The scratch is as long as the record, so no transform fails.
        self.try_average_hit(dof).await.unwrap_or(Standing::Agrees)
    }

    async fn try_average_hit(&mut self, dof: usize) -> Result<Standing<f32>, FftError> {
        let rig = self.rig;
        let Some(test) = self.settings() else { return Ok(Standing::Agrees) };
        if rig.campaign.borrow().accepted() == 0 {
            self.open_dof(dof);
        }
        let mut hit = Hit::begin(rig, self.record, self.spectra, self.memory, &test)?;
        let responses = rig.adc_in_use().responses();
        for response in 0..responses {
            // Only the measuring loop, which is here, writes the record: it stays as it is.
            yield_now().await;
            hit.add_response(response)?;
        }
        let standing = hit.join(&test, dof);
        // One that contradicts its only sibling stays: the DOF begins anew, and the next hit opens it.
        if let Standing::Astray(_) = standing {
            hit.remove_force();
            for response in 0..responses {
                yield_now().await;
                hit.remove_response(response)?;
            }
        }
        Ok(standing)
    }

    /// Turns the averaged spectra of a DOF into its mass lines and keeps them. Deadline: [`crate::deadline::DEADLINE`].
    #[inline(never)]
    pub fn close_dof(&mut self, dof: usize) {
        let rig = self.rig;
        let _deadline = Deadline::begin(rig);
        let Some(test) = self.settings() else { return };
        self.open_result();
        let name = rig.layout.borrow().as_ref().and_then(|layout| layout.hits.get(dof).copied());
        let Some(name) = name else { return };
        let spectra = self.spectra.borrow();
        let AnalysisMemory { scratch, basis, single_hits, result, .. } = &mut *self.memory;
        let mut closed = DofResult {
            dof: name.dof,
            index: dof as u8,
            hits: spectra.hits() as u8,
            band_hz: test.expected_band(),
            accelerance: [0.0; RESPONSES],
            noise: [0.0; RESPONSES],
            scatter: Vec::new(),
            coherence: (spectra.hits() > 1).then_some([0.0; RESPONSES]),
        };
        // One hit does not scatter, and a scatter of fewer hits than were averaged is not theirs.
        if let Some(single_hits) = single_hits
            && single_hits.hits() == spectra.hits()
            && single_hits.hits() > 1
        {
            closed.scatter.extend(lower_triangle(&single_hits.covariance(), RESPONSES));
        }
        let (adc, calibration) = (rig.adc_in_use(), rig.calibration.borrow());
        let method = Method { adc: &adc, calibration: &calibration, test: &test };
        if let Some(band) = band_of(method, &spectra, &mut scratch[..SPECTRUM_LINES]) {
            closed.band_hz = band;
        } else {
            closed.band_hz = TestSettings::usual_band();
            rig.say(Diagnostic::about(
                Code::BandNotFound,
                Severity::Warning,
                Subject::hit(dof),
                0.0,
            ));
        }
        let fits = fit_responses(method, &spectra, closed.band_hz, basis);
        match &fits {
            Ok(fits) => {
                closed.accelerance = fits.accelerance.into();
                closed.noise = fits.noise.into();
                for (response, part) in fits.unsteady() {
                    let subject = Subject::response(dof, response);
                    let code = Code::NoPlateau;
                    rig.say(Diagnostic::about(code, Severity::Warning, subject, part));
                }
            }
            Err(error) => {
                rig.say(Diagnostic::about(
                    code_of(*error),
                    Severity::Error,
                    Subject::hit(dof),
                    0.0,
                ));
            }
        }
        let band = lines_of_band(closed.band_hz, resolution(&adc));
        for response in 0..adc.responses() {
            let mean = spectra.mean_coherence(response, band.clone());
            if let (Some(coherence), Some(mean)) = (&mut closed.coherence, mean) {
                coherence[response] = mean;
            }
        }
        calibration.undo_cross_axis(&mut closed.accelerance);
        if fits.is_ok() {
            consistency::tell_not_rigid(rig, &test, &closed.accelerance.into());
        }
        result.dofs.retain(|kept| kept.index != closed.index);
        // A channel without a mass line has no number; neither has its DOF then.
        if fits.is_ok() {
            // There is room for every DOF of a layout.
            let _ = result.dofs.push(closed);
        }
    }

    /// Computes the ten properties from the mass lines, into the result; yields as
    /// [`identification::answer`] does.
    pub async fn identify(&mut self, number: u32) {
        let rig = self.rig;
        self.open_result();
        self.tell_unfinished_dofs();
        let AnalysisMemory { scratch, result, .. } = &mut *self.memory;
        result.number = number;
        result.layout_hash = rig.layout_hash.get();
        result.calibration = checksum_of(&rig.calibration.borrow());
        result.firmware = cut(rig.info.firmware);
        if let Some(layout) = rig.layout.borrow().as_ref() {
            result.frf_estimator = layout.test.frf_estimator;
            result.terms = layout.test.terms;
            result.band_automatic = layout.test.band_hz.is_none();
        }
        result.estimates.clear();
        if !rig.block.get() {
            identification::answer(rig, result, scratch).await;
        } else if let Some(mass) = rig.block_mass.get() {
            rig.block_ratio.set(Some(block::weigh(rig, result, mass)));
        }
        result.diagnostics = rig.diagnostics.borrow().clone();
    }

    fn settings(&self) -> Option<TestSettings<f32>> {
        self.rig.layout.borrow().as_ref().map(|layout| layout.test)
    }

    /// Forgets the hits of the DOF that was in hand.
    fn open_dof(&mut self, dof: usize) {
        self.spectra.borrow_mut().clear();
        self.memory.single_hits = None;
        self.rig.spectra_of.set(Some(dof as u8));
    }

    /// Forgets the DOFs of an earlier campaign.
    fn open_result(&mut self) {
        let campaign = self.rig.campaign.borrow().starts();
        if self.memory.campaign != campaign {
            self.memory.campaign = campaign;
            self.memory.result.dofs.clear();
        }
    }

    fn tell_unfinished_dofs(&mut self) {
        let campaign = self.rig.campaign.borrow();
        for (dof, progress) in (0_u8..).zip(campaign.dofs()) {
            let accepted = f32::from(progress.accepted);
            let code = match progress.outcome {
                Outcome::Skipped => Code::DofSkipped,
                Outcome::Early => Code::DofFinishedEarly,
                Outcome::Open | Outcome::Complete => continue,
            };
            self.rig.say(Diagnostic::about(code, Severity::Warning, Subject::Hit(dof), accepted));
        }
    }
}

/// A hit that is being averaged. Plain functions: what an async function computes is compiled with the
/// board, for size. None of them is inlined, so that none is on the stack of another.
struct Hit<'a> {
    rig: &'a Rig,
    record: &'a RefCell<Record>,
    spectra: &'a RefCell<DofSpectra<f32>>,
    hit: HitInHand<'a, f32>,
    siblings: &'a mut Option<ScatterAccumulator<f32, RESPONSES>>,
}

impl<'a> Hit<'a> {
    /// Adds the force to the spectra of the DOF.
    #[inline(never)]
    fn begin(
        rig: &'a Rig,
        record: &'a RefCell<Record>,
        spectra: &'a RefCell<DofSpectra<f32>>,
        memory: &'a mut AnalysisMemory,
        test: &TestSettings<f32>,
    ) -> Result<Self, FftError> {
        let _deadline = Deadline::begin(rig);
        let AnalysisMemory { scratch, force, basis, single_hits: siblings, .. } = memory;
        let (adc, calibration) = (rig.adc_in_use(), rig.calibration.borrow());
        let method = Method { adc: &adc, calibration: &calibration, test };
        let memory = HitMemory { scratch, force, basis };
        let mut into = spectra.borrow_mut();
        let hit = HitInHand::begin(method, &*record.borrow(), memory, &mut into)?;
        Ok(Self { rig, record, spectra, hit, siblings })
    }

    /// Adds a response to the spectra of the DOF.
    #[inline(never)]
    fn add_response(&mut self, response: usize) -> Result<(), FftError> {
        let _deadline = Deadline::begin(self.rig);
        self.hit.add_response(response, &*self.record.borrow(), &mut self.spectra.borrow_mut())
    }

    /// Puts the hit beside its siblings; one without mass lines of its own tells nothing about the
    /// scatter.
    #[inline(never)]
    fn join(&mut self, test: &TestSettings<f32>, dof: usize) -> Standing<f32> {
        let Some(own) = self.hit.mass_lines(&self.rig.calibration.borrow()) else {
            return Standing::Agrees;
        };
        consistency::join(self.rig, test, dof, self.siblings.get_or_insert_default(), &own)
    }

    /// Takes the force out of the spectra of the DOF again.
    fn remove_force(&self) {
        self.hit.remove_force(&mut self.spectra.borrow_mut());
    }

    /// Takes a response out of the spectra of the DOF again.
    #[inline(never)]
    fn remove_response(&mut self, response: usize) -> Result<(), FftError> {
        let _deadline = Deadline::begin(self.rig);
        self.hit.remove_response(response, &*self.record.borrow(), &mut self.spectra.borrow_mut())
    }
}

fn code_of(error: MassLineError) -> Code {
    match error {
        MassLineError::NotFinite => Code::DataNotFinite,
        _ => Code::BandTooNarrow,
    }
}

/// Names a calibration in the results.
pub(crate) fn checksum_of(calibration: &Calibration) -> u32 {
    // Numbers of four bytes, which take as much encoded.
    let mut bytes = [0; size_of::<Calibration>()];
    postcard::to_slice(calibration, &mut bytes).map_or(0, |bytes| crc32(bytes))
}

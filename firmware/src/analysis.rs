//! From a record to averaged spectra, from spectra to mass lines, from mass lines to the result.

use core::cell::RefCell;

use embassy_futures::yield_now;
use heapless::Vec;
use massline_shared::campaign::Outcome;
use massline_shared::diagnosis::{Code, Diagnostic, Diagnostics, Severity};
use massline_shared::identify::inertia_restraint::{self, Settings};
use massline_shared::identify::{Estimate, MassLines, Method, ScatterAccumulator, lower_triangle};
use massline_shared::layout::{RigLayout, TestSettings};
use massline_shared::mass_line::{BasisRow, Line, MassLineBasis, MassLineError, Terms};
use massline_shared::protocol::crc32;
use massline_shared::protocol::object::{DofResult, MeasurementResult, StoredEstimate};
use massline_shared::signal::{
    Calibration, HitAnalysis, PRE_TRIGGER_SCANS, RECORD_SCANS, RESPONSES, Record, SPECTRUM_LINES,
    lines_of_band,
};
use nalgebra::{Complex, SVector};

use crate::rig::{Rig, cut};
use crate::spectra::{RigSpectra, resolution};

/// What the analysis keeps between two steps.
pub(crate) struct AnalysisMemory {
    /// Samples and transform of one channel; the encoded result after the last hit.
    scratch: [f32; RECORD_SCANS],
    force: [Complex<f32>; SPECTRUM_LINES],
    lines: [Complex<f32>; SPECTRUM_LINES],
    basis: [BasisRow<f32>; SPECTRUM_LINES],
    /// Mass lines of the single hits of the DOF in hand.
    single_hits: Option<ScatterAccumulator<f32, RESPONSES>>,
    /// The result as far as it is known.
    result: MeasurementResult,
    /// The campaign that `result` belongs to, as counted by the campaign.
    campaign: u32,
}

impl AnalysisMemory {
    pub const fn new() -> Self {
        const ZERO: Complex<f32> = Complex { re: 0.0, im: 0.0 };
        Self {
            scratch: [0.0; RECORD_SCANS],
            force: [ZERO; SPECTRUM_LINES],
            lines: [ZERO; SPECTRUM_LINES],
            basis: [BasisRow::EMPTY; SPECTRUM_LINES],
            single_hits: None,
            result: MeasurementResult {
                number: 0,
                layout_hash: 0,
                calibration: 0,
                firmware: heapless::String::new(),
                dofs: Vec::new(),
                estimates: Vec::new(),
                diagnostics: Vec::new(),
            },
            campaign: 0,
        }
    }

    /// The result as bytes, and its mass when there is one.
    pub fn encode_result(&mut self) -> (&[u8], Option<f32>) {
        let mass = self.result.estimates.first().map(|estimate| estimate.properties[0]);
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
    pub spectra: &'a RefCell<RigSpectra>,
    pub memory: &'a mut AnalysisMemory,
}

impl Analysis<'_> {
    /// Averages the record into the spectra of a DOF, and its own mass lines into their scatter.
    ///
    /// Yields between channels; a channel takes about 0.2 M instructions.
    pub async fn average_hit(&mut self, dof: usize) {
        let rig = self.rig;
        let Some(test) = self.settings() else { return };
        if rig.campaign.borrow().accepted() == 0 {
            self.open_dof(dof);
        }
        let hit = {
            let calibration = rig.calibration.borrow();
            HitAnalysis::<f32>::new(&rig.adc_in_use(), &calibration, &test, PRE_TRIGGER_SCANS)
        };
        let AnalysisMemory { scratch, force, lines, basis, single_hits, .. } = &mut *self.memory;
        // The scratch is as long as the record, so no transform fails.
        if hit.force(&*self.record.borrow(), scratch, force).is_err() {
            return;
        }
        self.spectra.borrow_mut().add_force(force);
        let basis = fit_basis(rig, &test, |line| force[line].norm_sqr(), basis);
        let mut single = SVector::<f32, RESPONSES>::zeros();
        let mut whole = true;
        for response in 0..rig.adc_in_use().responses() {
            // Only the measuring loop, which is here, writes the record: it stays as it is.
            yield_now().await;
            if hit.response(&*self.record.borrow(), response, scratch, lines).is_err() {
                return;
            }
            self.spectra.borrow_mut().add_response(response, force, lines);
            HitAnalysis::divide(lines, force);
            let fit = basis.as_ref().map(|basis| basis.fit(lines.iter().copied()));
            match (fit, single.get_mut(response)) {
                (Ok(Ok(fit)), Some(value)) => *value = fit.accelerance(),
                _ => whole = false,
            }
        }
        // A hit without mass lines of its own tells nothing about the scatter.
        if whole {
            single_hits.get_or_insert_default().add(&single);
        }
    }

    /// Turns the averaged spectra of a DOF into its mass lines and keeps them.
    pub fn close_dof(&mut self, dof: usize) {
        let rig = self.rig;
        let Some(test) = self.settings() else { return };
        self.open_result();
        let name = rig.layout.borrow().as_ref().and_then(|layout| layout.hits.get(dof).copied());
        let Some(name) = name else { return };
        let spectra = self.spectra.borrow();
        let AnalysisMemory { basis, single_hits, result, .. } = &mut *self.memory;
        let mut closed = DofResult {
            dof: name.dof,
            index: dof as u8,
            hits: spectra.hits() as u8,
            accelerance: [0.0; RESPONSES],
            scatter: Vec::new(),
            coherence: [0.0; RESPONSES],
        };
        // One hit does not scatter, and a scatter of fewer hits than were averaged is not theirs.
        if let Some(single_hits) = single_hits
            && single_hits.hits() == spectra.hits()
            && single_hits.hits() > 1
        {
            closed.scatter.extend(lower_triangle(&single_hits.covariance(), RESPONSES));
        }
        let basis = fit_basis(rig, &test, |line| spectra.force_auto(line), basis);
        let mut whole = true;
        for response in 0..rig.adc_in_use().responses() {
            let h1 = (0..SPECTRUM_LINES).map(|line| spectra.h1(response, line));
            match basis.as_ref().map_err(|&error| error).and_then(|basis| basis.fit(h1)) {
                Ok(fit) => closed.accelerance[response] = fit.accelerance(),
                Err(error) => {
                    whole = false;
                    rig.say(Diagnostic::about(code_of(error), Severity::Error, dof as u16, 0.0));
                }
            }
            let band = lines_of_band(test.band_hz, resolution(rig.adc.rate.0));
            closed.coherence[response] = spectra.mean_coherence(response, band);
        }
        result.dofs.retain(|kept| kept.index != closed.index);
        // A channel without a mass line has no number; neither has its DOF then.
        if whole {
            // There is room for every DOF of a layout.
            let _ = result.dofs.push(closed);
        }
    }

    /// Computes the ten properties from the mass lines, into the result.
    pub fn identify(&mut self, number: u32) {
        let rig = self.rig;
        self.open_result();
        self.tell_unfinished_dofs();
        let layout = rig.layout.borrow();
        let Some(layout) = layout.as_ref() else { return };
        let result = &mut self.memory.result;
        result.number = number;
        result.layout_hash = rig.layout_hash.get();
        result.calibration = checksum_of(&rig.calibration.borrow());
        result.firmware = cut(rig.info.firmware);
        result.estimates.clear();
        match solve(layout, result) {
            Ok(estimate) => {
                let _ = result.estimates.push(estimate);
            }
            Err(reasons) => reasons.into_iter().for_each(|reason| rig.say(reason)),
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
        for (dof, progress) in (0_u16..).zip(campaign.dofs()) {
            let accepted = f32::from(progress.accepted);
            let code = match progress.outcome {
                Outcome::Skipped => Code::DofSkipped,
                Outcome::Early => Code::DofFinishedEarly,
                Outcome::Open | Outcome::Complete => continue,
            };
            self.rig.say(Diagnostic::about(code, Severity::Warning, dof, accepted));
        }
    }
}

/// The factored design of the mass line fit over the rig's lines.
fn fit_basis<'b>(
    rig: &Rig,
    test: &TestSettings<f32>,
    weight: impl Fn(usize) -> f32,
    workspace: &'b mut [BasisRow<f32>],
) -> Result<MassLineBasis<'b, f32>, MassLineError> {
    let resolution = resolution(rig.adc.rate.0);
    let line = |i: usize| Line { frequency: i as f32 * resolution, weight: weight(i) };
    let lines = (0..SPECTRUM_LINES).map(line);
    MassLineBasis::new(lines, test.band_hz, test.exponential_decay, Terms::Abc, workspace)
}

fn code_of(error: MassLineError) -> Code {
    match error {
        MassLineError::NotFinite => Code::DataNotFinite,
        _ => Code::BandTooNarrow,
    }
}

/// The inertia restraint method on the DOFs of a result.
fn solve(layout: &RigLayout, result: &MeasurementResult) -> Result<StoredEstimate, Diagnostics> {
    let mass_lines = result.dofs.iter().filter_map(|dof| {
        // Without a scatter they count as one hit: no standard deviation can be told.
        let hits = if dof.scatter.is_empty() { 1 } else { u16::from(dof.hits) };
        let lines = MassLines::<f32, RESPONSES>::from_parts(&dof.accelerance, &dof.scatter, hits)?;
        Some((usize::from(dof.index), lines))
    });
    inertia_restraint::solve(layout, mass_lines, Settings::weighted()).map(|e| stored(&e))
}

fn stored(estimate: &Estimate<f32>) -> StoredEstimate {
    let covariance = estimate.covariance.as_ref();
    StoredEstimate {
        method: Method::InertiaRestraint as u8,
        properties: estimate.theta().into(),
        covariance: covariance.map_or(Vec::new(), |c| lower_triangle(c, 10).collect()),
        condition: estimate.condition,
        diagnostics: estimate.diagnostics.clone(),
    }
}

/// Names a calibration in the results.
pub(crate) fn checksum_of(calibration: &Calibration) -> u32 {
    let mut bytes = [0; 128];
    // 21 numbers of four bytes.
    postcard::to_slice(calibration, &mut bytes).map_or(0, |bytes| crc32(bytes))
}

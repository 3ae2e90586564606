//! The answer of the offline solver, as JSON and as text.

use massline_shared::Responses;
use massline_shared::diagnosis::Diagnostic;
use massline_shared::identify::global_fit::GlobalFitSolution;
use massline_shared::identify::{DofMassLines, Estimate, MassLines, Method, Observable};
use massline_shared::layout::{HOST_SENSORS, Hit, HostLayout};

use super::plausibility::Suspicion;
use super::suspension::ModalPart;
use super::{MassLinePart, ReferencePoint};
use crate::document::{FrequencyResponsesRead, MassLine, Refusal, Solution, Unseen};
use crate::identification::Identification;
use crate::judgement::{Evidence, Judgement, verdict_line, verdict_reasons};
use crate::report::{
    self, Truth, comparison_json, comparison_text, global_fit_json, global_fit_text, hammer_text,
    message_in, modes_json, modes_text,
};
use crate::single_fault::Examination;
use crate::suspension::{Comparison, SuspensionModes, warn_of_flexible_mode};
use crate::verdict::Verdict;

/// Most answers that are printed whole.
const SHOWN_WHOLE: usize = 2;

/// What the solution says about how it was made.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Settings {
    pub(super) reference_point: ReferencePoint,
    pub(super) layout_hash: Option<u32>,
    pub(super) truth: Option<Truth>,
    pub(super) layout: HostLayout,
    pub(super) reading: FrequencyResponsesRead,
}

/// A method without an answer, because what it uses could not be had.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Failed {
    pub(super) method: Method,
    pub(super) code: String,
    pub(super) message: String,
}

/// The answer of the offline solver.
#[derive(Clone, Debug, PartialEq)]
pub struct FrfSolution {
    /// The answers of all methods, and the nuisance parameters of the fit.
    pub identification: Identification,
    /// The search for a single mistake that explains data that contradict the layout; where there are mass lines.
    pub examination: Option<Examination>,
    /// Mass line accelerances, (m/s²)/N: hit by hit, channel by channel (sensor 1 x, y, z, …); empty without mass lines.
    pub mass_lines: Vec<Vec<f64>>,
    /// Standard deviations of the mass lines, estimated from the scatter of the bins about the model,
    /// (m/s²)/N, in the same order.
    pub noise: Vec<Vec<f64>>,
    /// The point about which the equations were set up.
    pub reference_point: ReferencePoint,
    /// Band of the mass lines, Hz.
    pub band_hz: Option<[f64; 2]>,
    /// The suspension modes and the band they were found in, Hz.
    pub modes: Option<(SuspensionModes, [f64; 2])>,
    /// What the global fit found besides the ten properties.
    pub global_fit: Option<GlobalFitSolution<f64>>,
    /// What all methods say together.
    pub comparison: Comparison,
    /// Diagnostics of the mass lines and the modes.
    pub diagnostics: Vec<Diagnostic>,
    /// Hash of the layout, when the layout fits a rig.
    pub layout_hash: Option<u32>,
    /// The methods of a part that has failed as a whole.
    pub(super) failed: Vec<Failed>,
    /// Expected values to compare with.
    pub truth: Option<Truth>,
    /// What was understood of the file.
    pub reading: FrequencyResponsesRead,
    /// How the file was read, and which body the layout was checked with.
    pub notes: Vec<String>,
    /// What of the input looks wrong.
    pub suspicions: Vec<Suspicion>,
    layout: HostLayout,
}

impl FrfSolution {
    pub(super) fn new(
        settings: Settings,
        mass_lines: Option<MassLinePart>,
        modal: Option<ModalPart>,
        notes: Vec<String>,
    ) -> Self {
        let Settings { reference_point, layout_hash, truth, layout, reading } = settings;
        let mut all = Self {
            identification: Identification::default(),
            examination: None,
            mass_lines: Vec::new(),
            noise: Vec::new(),
            reference_point,
            band_hz: None,
            modes: None,
            global_fit: None,
            comparison: Comparison::default(),
            diagnostics: Vec::new(),
            layout_hash,
            failed: Vec::new(),
            truth,
            reading,
            notes,
            suspicions: Vec::new(),
            layout,
        };
        if let Some(MassLinePart { lines, identification, examination, .. }) = mass_lines {
            let channels = 3 * all.layout.sensors.len();
            all.mass_lines = by_hit(&lines.lines, channels, |lines| &lines.accelerance);
            all.noise = by_hit(&lines.lines, channels, |lines| &lines.noise);
            all.band_hz = Some(lines.band_hz);
            all.diagnostics = lines.diagnostics;
            all.identification = identification;
            all.examination = Some(examination);
        }
        if let Some(ModalPart { solution, band_hz, diagnostics }) = modal {
            all.identification.estimates.extend(solution.estimates);
            all.identification.not_applicable.extend(solution.not_applicable);
            all.identification.sort();
            if let Some(global) = &solution.global {
                warn_of_flexible_mode(&mut all.identification.estimates, global, &all.layout);
            }
            all.global_fit = solution.global;
            all.diagnostics.extend(diagnostics);
            all.modes = Some((solution.modes, band_hz));
            all.comparison = solution.comparison;
        }
        all
    }

    /// The best method's answer.
    pub fn answer(&self) -> Option<&Estimate<f64>> {
        self.identification.estimates.first()
    }

    /// The verdict on the best method's answer; `None` without one.
    pub fn judgement(&self) -> Option<Judgement> {
        let evidence = Evidence {
            examination: self.examination.as_ref(),
            comparison: Some(&self.comparison),
            refusals: self.identification.refusals(),
            diagnostics: [self.identification.priors.as_slice(), &self.diagnostics].concat(),
            unit_suspicions: self.suspicions.iter().filter_map(Suspicion::warning).collect(),
            ..Evidence::of(self.answer()?)
        };
        Some(evidence.judge())
    }

    /// The verdict, and the first line of the text that states it; `None` without an answer.
    pub fn verdict(&self) -> Option<(Verdict, String)> {
        let judgement = self.judgement()?;
        let message_of = |diagnostic: &Diagnostic| message_in(diagnostic, &self.layout);
        Some((judgement.verdict(), verdict_line(&judgement, &self.layout, message_of)))
    }

    /// The solution as JSON, in the form of all results.
    pub fn document(&self) -> Solution {
        let Self { layout, identification, .. } = self;
        let said = [identification.warnings(), self.diagnostics.clone()].concat();
        let mut diagnostics = report::diagnostics_json(&said, |d| message_in(d, layout));
        let mut not_applicable = identification.not_applicable_json(layout);
        not_applicable.extend(self.failed.iter().map(Failed::to_json));
        let examination = self.examination.as_ref();
        diagnostics.extend(examination.iter().flat_map(|of| of.diagnostics_json(layout)));
        diagnostics.extend(self.suspicions.iter().map(Suspicion::to_json));
        let lines = layout.hits.iter().zip(&self.mass_lines).zip(&self.noise);
        let mass_line = |((hit, lines), noise): ((&Hit<f64>, &Vec<f64>), &Vec<f64>)| MassLine {
            dof: hit.dof.to_string(),
            accelerance_m_per_s2_per_n: lines.clone(),
            noise_m_per_s2_per_n: noise.clone(),
        };
        let judgement = self.judgement();
        let judged = judgement.as_ref().map(Judgement::verdict);
        let reasons_of = |judgement| {
            verdict_reasons(judgement, layout, |diagnostic| message_in(diagnostic, layout))
        };
        Solution {
            verdict: judged,
            verdict_reasons: judgement.as_ref().map(reasons_of).unwrap_or_default(),
            results: identification.results_json(),
            not_applicable,
            details: identification.details_json(layout),
            layout_hash: self.layout_hash.and_then(report::hash_text),
            calibration: None,
            firmware: None,
            reference_point: self.reference_point.name(),
            band_hz: self.band_hz,
            band_automatic: layout.test.band_hz.is_none(),
            frf_estimator: None,
            terms: layout.test.terms.name(),
            mass_lines: lines.map(mass_line).collect(),
            frequency_responses: self.reading.clone(),
            notes: self.notes.clone(),
            diagnostics,
            single_faults: examination.map(|of| of.to_json(layout)),
            suspension: self.modes.as_ref().map(|(modes, band)| modes_json(modes, *band, layout)),
            global_fit: self.global_fit.as_ref().map(global_fit_json),
            agreement: comparison_json(&self.comparison, &identification.estimates, layout, judged),
            cannot_see: self.cannot_see(),
        }
    }

    /// The solution as text.
    pub fn to_text(&self) -> String {
        // A few are printed whole; more are compared in one table, after the best.
        let count = self.identification.estimates.len();
        let whole = if count <= SHOWN_WHOLE { count } else { 1 };
        let mut text = self.identification.to_text(&self.layout, self.truth.as_ref(), whole);
        let of_modes = |of: &&Estimate<f64>| of.method.entry().observes != Observable::MassLines;
        if let Some(answer) = self.answer().filter(of_modes) {
            text += &hammer_text(&self.layout, answer);
        }
        if let Some((modes, band)) = &self.modes {
            text += &modes_text(modes, *band, &self.layout);
        }
        if let Some(global) = &self.global_fit {
            text += &global_fit_text(global);
        }
        let judged = self.judgement().as_ref().map(Judgement::verdict);
        let estimates = &self.identification.estimates;
        text += &comparison_text(&self.comparison, estimates, &self.layout, judged);
        if let Some(examination) = &self.examination {
            text += &examination.to_text(&self.layout);
        }
        if let Some(band) = self.band_hz {
            let [low, high] = band.map(|end| (end * 10.0).round() / 10.0);
            text += &format!(
                "mass lines ({}) over {low} to {high} Hz{}, equal weights; linear equations about the {}\n",
                self.layout.test.terms.name(),
                if self.layout.test.band_hz.is_none() { ", found from the responses" } else { "" },
                self.reference_point.name()
            );
        }
        let shown = &self.identification.estimates[..whole];
        let said = |d: &&Diagnostic| shown.iter().any(|of| of.diagnostics.contains(d));
        let rest: Vec<Diagnostic> = self.diagnostics.iter().filter(|d| !said(d)).copied().collect();
        text += &report::sentences(&rest, |d| message_in(d, &self.layout));
        self.suspicions.iter().for_each(|suspicion| text += &suspicion.to_text());
        for note in &self.notes {
            text += &format!("note: {note}\n");
        }
        text + &report::cannot_see_text(&self.cannot_see())
    }

    fn cannot_see(&self) -> Vec<Unseen> {
        report::cannot_see(&self.layout, self.answer().map(|answer| &answer.body))
    }
}

impl Failed {
    fn to_json(&self) -> Refusal {
        Refusal {
            method: self.method.name(),
            code: self.code.to_string(),
            message: self.message.clone(),
            codes: vec![self.code.to_string()],
        }
    }
}

/// A quantity of the channels in use, grouped by hit.
fn by_hit(
    lines: &[DofMassLines<f64, HOST_SENSORS>],
    channels: usize,
    quantity: fn(&MassLines<f64, HOST_SENSORS>) -> &Responses<f64, HOST_SENSORS>,
) -> Vec<Vec<f64>> {
    lines.iter().map(|(_, hit)| quantity(hit).iter().take(channels).copied().collect()).collect()
}

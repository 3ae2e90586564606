//! The solution of frequency responses, from those of mass lines and of suspension modes.

use massline_result::{FrequencyResponsesRead, MassLine, Refusal, TestResult};
use massline_shared::capacity::Unbounded;
use massline_shared::identify::{DofMassLines, Method};
use massline_shared::layout::HostLayout;

use super::suspension::ModalPart;
use super::{MassLinePart, ReferencePoint};
use crate::Error;
use massline_analysis::suspension::warn_of_flexible_mode;
use massline_files::layout_file::{LayoutFile, Reference};
use massline_report::solution::Solution;
use massline_report::words::{hash_text, known};

/// What the result says about how it was made.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Settings {
    reference_point: ReferencePoint,
    layout_hash: Option<u32>,
    title: String,
    reference: Option<Reference>,
    layout: HostLayout,
    reading: FrequencyResponsesRead,
}

impl Settings {
    pub(super) fn new(
        file: &LayoutFile,
        reference_point: ReferencePoint,
        reading: FrequencyResponsesRead,
    ) -> Self {
        Self {
            reference_point,
            layout_hash: file.hash(),
            title: file.title.clone(),
            reference: file.reference,
            layout: file.layout.clone(),
            reading,
        }
    }

    /// The facts of the test, without an answer.
    fn measured(self, notes: Vec<String>) -> TestResult {
        TestResult {
            title: self.title,
            layout_hash: self.layout_hash.and_then(hash_text),
            reference_point: Some(self.reference_point.name().into()),
            terms: Some(self.layout.test.terms.into()),
            band_automatic: self.layout.test.band_hz.is_none(),
            frequency_responses: Some(self.reading),
            reference: self.reference.map(|reference| reference.properties().into()),
            notes,
            ..TestResult::default()
        }
    }
}

/// The answers from both parts as one solution; `notes` are about the way to them.
pub(super) fn solution(
    settings: Settings,
    mass_lines: Option<MassLinePart>,
    modal: Option<ModalPart>,
    notes: Vec<String>,
) -> Solution {
    let layout = settings.layout.clone();
    let mut combined = Solution { measured: settings.measured(notes), ..Solution::default() };
    if let Some(MassLinePart { lines, identification, examination, score_tests, .. }) = mass_lines {
        let measured = lines.lines.iter().map(|line| mass_line(line, &layout));
        combined.measured.mass_lines = measured.collect();
        combined.measured.band_hz = Some(lines.band_hz);
        combined.diagnostics = lines.diagnostics;
        combined.identification = identification;
        combined.examination = Some(examination);
        combined.score_tests = score_tests;
    }
    if let Some(ModalPart { solution, band_hz, diagnostics }) = modal {
        combined.identification.estimates.extend(solution.estimates);
        combined.identification.not_applicable.extend(solution.not_applicable);
        combined.identification.sort();
        if let Some(global) = &solution.global {
            warn_of_flexible_mode(&mut combined.identification.estimates, global, &layout);
        }
        combined.global_fit = solution.global;
        // A small fault is said of the answer, and of no other method's.
        if combined.answer().is_some_and(|answer| answer.method == Method::GlobalFit) {
            combined.score_tests = solution.score_tests;
        }
        combined.diagnostics.extend(diagnostics);
        combined.modes = Some((solution.modes, band_hz));
        combined.comparison = solution.comparison;
    }
    Solution { layout, ..combined }
}

/// A method without an answer, because what it uses could not be had.
pub(super) fn failed(method: Method, error: &Error) -> Refusal {
    Refusal {
        method: method.into(),
        code: error.code().to_owned(),
        message: error.to_string(),
        codes: vec![error.code().to_owned()],
    }
}

/// The mass lines of a hit: sensor 1 x, y, z, … Their noise is estimated from the scatter of the bins about the model.
fn mass_line((hit, lines): &DofMassLines<f64, Unbounded>, layout: &HostLayout) -> MassLine {
    let channels = 3 * layout.sensors.len();
    MassLine {
        dof: layout.hits.get(*hit).map_or_else(String::new, |hit| hit.dof.to_string()),
        hits: None,
        band_hz: None,
        accelerance_m_per_s2_per_n: lines.accelerance.iter().take(channels).copied().collect(),
        noise_m_per_s2_per_n: lines
            .noise
            .iter()
            .take(channels)
            .map(|noise| known(*noise))
            .collect(),
        coherence: None,
    }
}

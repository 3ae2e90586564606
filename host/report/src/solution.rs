//! What this program finds from the data of a test, whoever has measured them, and the result that it makes of it.

use massline_result::{Finding, FindingCode, Refusal, TestResult, Verdict};
use massline_shared::diagnosis::{Diagnostic, Severity};
use massline_shared::identify::Estimate;
use massline_shared::identify::global_fit::GlobalFitSolution;
use massline_shared::layout::HostLayout;

use crate::words::layout_check::error_source;
use crate::words::{
    agreement, cannot_see, details_in, estimates_in, findings, findings_in, global_fit,
    hammer_text, message_in, refusals_in, score_tests_in, single_faults_in, suspension_modes,
    verdict_reasons,
};
use massline_analysis::identification::Identification;
use massline_analysis::judgement::{Evidence, Judgement};
use massline_analysis::limits::BoundedTest;
use massline_analysis::plausibility::Suspicion;
use massline_analysis::score_tests::ScoreTests;
use massline_analysis::single_fault::Examination;
use massline_analysis::suspension::{Comparison, SuspensionModes};
use massline_result::Error;

/// The answers of all methods to a test, and what was found on the way.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Solution {
    /// The answers, and the nuisance parameters of the fit.
    pub identification: Identification,
    /// The search for a single mistake that explains data that contradict the layout; where there are mass lines.
    pub examination: Option<Examination>,
    /// The tests of the answer for small faults.
    pub score_tests: ScoreTests,
    /// Findings about mass lines, modes and sensors.
    pub diagnostics: Vec<Diagnostic>,
    /// The suspension modes and the band they were found in, Hz.
    pub modes: Option<(SuspensionModes, [f64; 2])>,
    /// What the global fit found besides the ten properties.
    pub global_fit: Option<GlobalFitSolution<f64>>,
    /// What all methods say together.
    pub comparison: Comparison,
    /// What of the input looks like another unit or convention than is stated.
    pub suspicions: Vec<Suspicion>,
    /// The methods of a part that has failed as a whole.
    pub failed: Vec<Refusal>,
    /// What was measured, without an answer.
    pub measured: TestResult,
    /// What the rig has seen while measuring.
    pub seen_by_rig: Vec<Diagnostic>,
    /// What is missing of the data, in a sentence.
    pub missing: Option<String>,
    /// Why there is no answer; `None` with one.
    pub no_answer: Option<Error>,
    /// How long the object has rung in a record of the suspension profile, s, where a rig has measured it.
    pub record_s: Option<f64>,
    /// The layout as the answers were found with.
    pub layout: HostLayout,
}

impl Solution {
    /// The answer: that of the best method; `None` without one.
    pub fn answer(&self) -> Option<&Estimate<f64>> {
        self.identification.estimates.first()
    }

    /// The verdict on the answer; `None` without one.
    pub fn judgement(&self) -> Option<Judgement> {
        let priors = self.identification.priors.as_slice();
        let evidence = Evidence {
            examination: self.examination.as_ref(),
            score_tests: Some(&self.score_tests),
            comparison: Some(&self.comparison),
            refusals: self.identification.refusals(),
            diagnostics: [priors, &self.diagnostics, &self.seen_by_rig].concat(),
            stated: self.stated().collect(),
            ..Evidence::of(self.answer()?)
        };
        Some(evidence.judge())
    }

    /// Doubts that are sentences, each with its code.
    fn stated(&self) -> impl Iterator<Item = (FindingCode, String)> + '_ {
        let missing =
            self.missing.iter().map(|missing| (FindingCode::LinesMissing, missing.clone()));
        missing.chain(self.suspicions.iter().filter_map(Suspicion::warning))
    }

    /// The verdict alone.
    pub fn verdict(&self) -> Option<Verdict> {
        self.judgement().map(|judgement| judgement.verdict())
    }

    /// The result, with a sentence for each finding in the names of the layout.
    pub fn result(&self) -> TestResult {
        let Self { layout, identification, measured, .. } = self;
        let message_of = |diagnostic: &Diagnostic| message_in(diagnostic, layout);
        let judgement = self.judgement();
        let verdict = judgement.as_ref().map(Judgement::verdict);
        let mut refusals = refusals_in(identification, layout);
        refusals.extend(self.failed.iter().cloned());
        // What a rig has reported itself is not repeated.
        let is_new = |diagnostic: &&Diagnostic| {
            let same = |seen: &Diagnostic| {
                (seen.code, seen.subject) == (diagnostic.code, diagnostic.subject)
            };
            !self.seen_by_rig.iter().any(same)
        };
        let new_diagnostics = identification.priors.iter().chain(&self.diagnostics).filter(is_new);
        let all_diagnostics: Vec<Diagnostic> =
            self.seen_by_rig.iter().chain(new_diagnostics).copied().collect();
        let mut diagnostics = findings(&all_diagnostics, message_of);
        let examination = self.examination.as_ref();
        diagnostics
            .extend(examination.iter().flat_map(|examination| findings_in(examination, layout)));
        diagnostics.extend(self.suspicions.iter().map(Suspicion::finding));
        diagnostics.extend(self.missing.iter().map(|missing| Finding {
            code: FindingCode::LinesMissing,
            severity: Severity::Warning.into(),
            message: missing.clone(),
        }));
        let by_rig = measured.firmware.is_some();
        let hammer = self.answer().and_then(|answer| hammer_text(layout, answer, by_rig));
        diagnostics.extend(hammer.map(|message| Finding {
            code: FindingCode::HammerGainLimits,
            severity: Severity::Note.into(),
            message,
        }));
        let modes = self.modes.as_ref();
        let result = TestResult {
            verdict,
            verdict_reasons: judgement
                .map(|judgement| verdict_reasons(&judgement, layout, message_of))
                .unwrap_or_default(),
            results: estimates_in(identification, layout),
            not_applicable: refusals,
            agreement: agreement(&self.comparison, &identification.estimates, layout, verdict),
            diagnostics,
            single_faults: examination.map(|examination| single_faults_in(examination, layout)),
            score_tests: score_tests_in(&self.score_tests, layout),
            details: details_in(identification, layout),
            suspension: modes.map(|(modes, band)| suspension_modes(modes, *band, layout)),
            global_fit: self.global_fit.as_ref().map(global_fit),
            cannot_see: cannot_see(layout, self.answer().map(|answer| &answer.body), by_rig),
            characteristic_length_m: Some(layout.characteristic_length()),
            ..measured.clone()
        };
        let bounded = BoundedTest::of(&result, layout, self.record_s);
        let parts = bounded.map(|test| test.parts()).unwrap_or_default();
        TestResult { error_sources: parts.iter().map(error_source).collect(), ..result }
    }
}

//! A rig's result, solved again on the host in double precision: from the mass lines in it, or in the suspension profile
//! from the lines that the rig has stored with it.
//!
//! The rig's and the host's findings are never mixed: the rig's answer stays as it is stored, and the host's
//! findings are marked.
//!
//! | in JSON | from |
//! | --- | --- |
//! | `results` | the rig: its estimates with its diagnostics [^2] |
//! | `diagnostics` | the rig [^3]; an entry with `"found_by": "host"` is the host's |
//! | `not_applicable` | the methods without an answer by the rig, and why; `found_by` is `host` where the host found the reason [^1] |
//! | `host` | the host: `results`, `not_applicable`, `details`, `agreement`, `diagnostics`, `single_faults` |
//! | `suspension`, `global_fit` | the host, in the suspension profile |
//! | `agreement`, `details`, `single_faults` | the host, same contents as under `host` |
//!
//! [^1]: A rig does not store to which method a reason belongs. The host's reason is given where the host
//!     has no answer either.
//!
//! [^2]: In `solve`, `simulate` and `demo` the host's, where it has an answer.
//!
//! [^3]: What it saw while measuring and, where the host has no answer, what it concluded.

use massline_protocol::object::MeasurementResult;
use massline_shared::body::scale;
use massline_shared::diagnosis::{Diagnostic, Severity, Subject};
use massline_shared::identify::global_fit::GlobalFitSolution;
use massline_shared::identify::{Estimate, IdentifySettings, Method, Observable, Observations};
use massline_shared::layout::{HostLayout, TestProfile};
use nalgebra::SVector;

use crate::Error;
use crate::document::{Finding, FoundBy, HostFindings, Marked, Measurement, Unseen};
use crate::identification::{
    Identification, MeasuredLines, Selection, contradicted, identify, layout_of, learned, lines_of,
    sensors_not_rigid,
};
use crate::judgement::{Evidence, Judgement, verdict_line, verdict_reasons};
use crate::report::{
    SolvedHere, cannot_see, comparison_json, comparison_text, diagnostics_json, estimates_of,
    global_fit_json, global_fit_text, hammer_text, message_in, modes_json, modes_text,
    refusals_json, refusals_text, sentences, table, two_digits,
};
use crate::rig_findings::of_measuring;
use crate::rig_lines::StoredTest;
use crate::single_fault::{Examination, NominalTest};
use crate::solve::{Suspicion, band_of_modes, first_error, lacking, no_modal_answer, suspicions};
use crate::suspension::{
    Comparison, MassLineAnswers, SuspensionModes, compare, reciprocity_of_mass_lines,
    warn_of_flexible_mode,
};
use crate::verdict::Verdict;

/// Largest difference between answers of rig and host from one layout, % of scale; a corrected layout makes more.
const SAME_PERCENT: f64 = 1.0;
/// Heading of the host's findings in text.
const HEADING: &str = "solved again here, in double precision";
/// The same where the rig leaves all of it to the host.
const HEADING_OF_ALL: &str = "solved here, in double precision; the rig has no answer of its own";

/// The host's findings from what a rig has measured.
#[derive(Clone, Debug)]
pub struct HostSolution<'a> {
    /// The estimates, and the nuisance parameters of the fit.
    pub identification: Identification,
    /// The search for a single mistake that explains the data, where one was done.
    pub examination: Option<Examination>,
    /// Hits that move against their force or are not reciprocal, sensors that do not move with the others; in the
    /// suspension profile what was found about modes and lines.
    found: Vec<Diagnostic>,
    /// The suspension modes, in the suspension profile.
    modes: Option<(SuspensionModes, [f64; 2])>,
    /// What the global fit found besides the ten properties.
    global_fit: Option<GlobalFitSolution<f64>>,
    /// What looks like another unit or convention.
    suspicions: Vec<Suspicion>,
    /// What is missing of the test.
    notes: Vec<String>,
    /// Which modes do not show, or hardly, where there is no answer in the suspension profile.
    lacking_modes: Option<String>,
    /// How the methods agree.
    comparison: Comparison,
    result: &'a MeasurementResult,
    /// In the suspension profile with the hits that have lines.
    layout: HostLayout,
    selection: Selection,
    profile: TestProfile,
}

impl<'a> HostSolution<'a> {
    /// Solves the mass lines of a result, or the lines that belong to it, with the layout of its measurement. Mass lines are
    /// searched for the single mistake that explains them.
    pub fn new(test: StoredTest<'a>, nominal: &NominalTest, selection: Selection) -> Self {
        let layout = layout_of(test.result, &nominal.layout);
        let (examination, solution) = match test.profile() {
            TestProfile::MassLine => (
                Some(nominal.examine_result(test.result)),
                Self::of_mass_lines(test.result, layout, selection),
            ),
            TestProfile::Suspension => (None, Self::of_lines(test, layout, selection)),
        };
        let suspicions = suspicions(nominal, &solution.identification.estimates);
        Self { examination, suspicions, ..solution }
    }

    fn of_mass_lines(
        result: &'a MeasurementResult,
        layout: HostLayout,
        selection: Selection,
    ) -> Self {
        let lines = lines_of(result);
        let observed = Observations::of_mass_lines(&layout, &lines);
        let identification = identify(&observed, selection, &IdentifySettings::default());
        let comparison = comparison(&identification, &layout, &lines);
        Self {
            found: [
                reciprocity_of_mass_lines(&layout, &lines).as_slice(),
                &sensors_not_rigid(&layout, &lines),
            ]
            .concat(),
            comparison,
            ..Self::without_answer(result, layout, selection, identification)
        }
    }

    fn of_lines(test: StoredTest<'a>, layout: HostLayout, selection: Selection) -> Self {
        let wanted = selection.modal_methods();
        let Some((lines, record_s)) = test.measured_lines(&layout) else {
            let nothing = Identification::default();
            let notes = missing_lines(test).into_iter().collect();
            let profile = TestProfile::Suspension;
            return Self {
                notes,
                profile,
                ..Self::without_answer(test.result, layout, selection, nothing)
            };
        };
        let layout = lines.layout().clone();
        let mut all = match lines.solve(record_s, &wanted, |_, _| ()) {
            Ok(solved) => {
                let mut identification = Identification {
                    estimates: solved.estimates,
                    not_applicable: solved.not_applicable,
                    ..Identification::default()
                };
                identification.sort();
                if let Some(global) = &solved.global {
                    warn_of_flexible_mode(&mut identification.estimates, global, &layout);
                }
                let without_priors =
                    identification.estimates.iter().find(|e| !e.method.entry().uses_priors);
                let mut found = solved.modes.diagnostics.clone();
                found.extend(without_priors.iter().flat_map(|e| contradicted(&layout.priors, e)));
                let band = band_of_modes(&layout.test);
                Self {
                    found,
                    modes: Some((solved.modes, band)),
                    global_fit: solved.global,
                    comparison: solved.comparison,
                    ..Self::without_answer(test.result, layout, selection, identification)
                }
            }
            Err(reasons) => {
                let refused = wanted.iter().map(|method| (*method, reasons.clone()));
                let identification =
                    Identification { not_applicable: refused.collect(), ..Default::default() };
                Self::without_answer(test.result, layout, selection, identification)
            }
        };
        if let (Some((_, reasons)), Ok(readings)) =
            (all.identification.not_applicable.first(), lines.responses())
            && all.identification.estimates.is_empty()
        {
            all.lacking_modes = lacking(lines.layout(), &readings, reasons);
        }
        all.profile = TestProfile::Suspension;
        all.notes.extend(missing_lines(test));
        all
    }

    /// An identification, and nothing else.
    fn without_answer(
        result: &'a MeasurementResult,
        layout: HostLayout,
        selection: Selection,
        identification: Identification,
    ) -> Self {
        Self {
            identification,
            examination: None,
            found: Vec::new(),
            modes: None,
            global_fit: None,
            suspicions: Vec::new(),
            notes: Vec::new(),
            lacking_modes: None,
            comparison: Comparison::default(),
            result,
            layout,
            selection,
            profile: TestProfile::MassLine,
        }
    }

    /// The answer, which the verdict is about and which reports and exports take: the host's best or, where it has none, the
    /// rig's.
    pub fn best(&self) -> Option<Estimate<f64>> {
        let of_host = self.identification.estimates.first().cloned();
        of_host.or_else(|| estimates_of(self.result).into_iter().next())
    }

    /// Which answer is the one to use, where rig and host answer by different methods, and what puts it in doubt; a line.
    pub fn which_to_use(&self) -> String {
        let Identification { estimates, not_applicable, .. } = &self.identification;
        match (self.profile, estimates.first()) {
            (TestProfile::Suspension, Some(best)) => format!(
                "the answer, by {}, solved here in double precision\n",
                best.method.name()
            ),
            (TestProfile::Suspension, None) if !not_applicable.is_empty() => {
                "these answers of the rig are in doubt: solved here in double precision, the same data give none\n".into()
            }
            _ => String::new(),
        }
    }

    /// The verdict on [`Self::best`]; `None` without an answer.
    pub fn judgement(&self) -> Option<Judgement> {
        let Identification { estimates, not_applicable, priors, .. } = &self.identification;
        let answer = self.best()?;
        let evidence = Evidence {
            examination: self.examination.as_ref(),
            comparison: Some(&self.comparison),
            refusals: self.identification.refusals(),
            diagnostics: [priors.as_slice(), &self.found, &self.findings_of_rig()].concat(),
            unit_suspicions: self.suspicions.iter().filter_map(Suspicion::warning).collect(),
            is_unconfirmed: estimates.is_empty() && !not_applicable.is_empty(),
            ..Evidence::of(&answer)
        };
        Some(evidence.judge())
    }

    /// The verdict, and the first line of the text that states it; `None` without an answer.
    pub fn verdict(&self) -> Option<(Verdict, String)> {
        let judgement = self.judgement()?;
        let message_of = |diagnostic: &Diagnostic| message_in(diagnostic, &self.layout);
        Some((judgement.verdict(), verdict_line(&judgement, &self.layout, message_of)))
    }

    /// The findings of the rig that stand beside this answer.
    pub fn findings_of_rig(&self) -> Vec<Diagnostic> {
        match self.identification.estimates.is_empty() {
            true => self.result.diagnostics.to_vec(),
            false => of_measuring(&self.result.diagnostics),
        }
    }

    /// What is to be said of the host's findings before and instead of the rig's.
    pub fn here(&self) -> SolvedHere {
        let Identification { estimates, .. } = &self.identification;
        let table_of = |best: &Estimate<f64>| table(best, None) + &self.hammer_text_of(best);
        // The many answers to the suspension modes are compared in one table, after the best.
        let whole = match self.profile {
            TestProfile::MassLine => estimates.len(),
            TestProfile::Suspension => 1,
        };
        let tables: String = estimates.iter().take(whole).map(table_of).collect();
        SolvedHere {
            answer: self.which_to_use() + &tables,
            answered: estimates.iter().map(|of| of.method).collect(),
        }
    }

    /// What the hammer makes of the answer.
    pub fn hammer_text(&self) -> String {
        self.best().map_or_else(String::new, |answer| self.hammer_text_of(&answer))
    }

    fn hammer_text_of(&self, answer: &Estimate<f64>) -> String {
        let uses_modes = answer.method.entry().observes != Observable::MassLines;
        if uses_modes { hammer_text(&self.layout, answer) } else { String::new() }
    }

    /// The ten properties by every method of the host, and what all of them say together, each with its name.
    pub fn answers(&self) -> Vec<(&'static str, SVector<f64, 10>)> {
        let each = self.identification.estimates.iter().map(|e| (e.method.name(), e.theta()));
        let combined = self.comparison.agreement.as_ref().map(|of| ("combined", of.theta));
        each.chain(combined).collect()
    }

    /// Why there is no answer; `None` with one.
    pub fn error(&self) -> Option<Error> {
        if !self.identification.estimates.is_empty() {
            return None;
        }
        let reasons = self.identification.not_applicable.first();
        let none = || Error::undetermined("lines_missing", self.notes.join("; "));
        Some(reasons.map_or_else(none, |(_, reasons)| {
            match self.profile {
                TestProfile::Suspension => {
                    no_modal_answer(&self.layout, reasons, self.lacking_modes.as_deref())
                }
                TestProfile::MassLine => first_error(reasons, |d| message_in(d, &self.layout))
                    .unwrap_or_else(|| Error::undetermined("no_answer", self.notes.join("; "))),
            }
        }))
    }

    /// Drops the details of sensors and hits; for a bench whose truth is known.
    pub fn without_details(mut self) -> Self {
        self.identification.details = None;
        self
    }

    /// What the test cannot see.
    pub fn cannot_see(&self) -> Vec<Unseen> {
        cannot_see(&self.layout, self.best().as_ref().map(|estimate| &estimate.body))
    }

    /// Adds the findings to the document of the rig's result.
    pub fn add_to(&self, document: &mut Measurement) {
        let Self { identification, layout, .. } = self;
        let message_of = |d: &Diagnostic| message_in(d, layout);
        let warnings = [identification.warnings(), self.found.clone()].concat();
        // A diagnostic that the rig has reported itself is not repeated.
        let of_rig = self.findings_of_rig();
        let is_new = |diagnostic: &&Diagnostic| {
            let (code, subject) = (diagnostic.code, diagnostic.subject);
            !of_rig.iter().any(|other| (other.code, other.subject) == (code, subject))
        };
        let new: Vec<Diagnostic> = warnings.iter().filter(is_new).copied().collect();
        let (mut diagnostics, mut new) =
            (diagnostics_json(&warnings, message_of), diagnostics_json(&new, message_of));
        for found in self.examination.iter().map(|of| of.diagnostics_json(layout)) {
            diagnostics.extend(found.iter().cloned());
            new.extend(found);
        }
        for suspicion in self.suspicions.iter().map(Suspicion::to_json) {
            diagnostics.push(suspicion.clone());
            new.push(suspicion);
        }
        let judgement = self.judgement();
        let judged = judgement.as_ref().map(Judgement::verdict);
        let host = HostFindings {
            results: identification.results_json(),
            not_applicable: identification.not_applicable_json(layout),
            details: identification.details_json(layout),
            agreement: comparison_json(&self.comparison, &identification.estimates, layout, judged),
            single_faults: self.examination.as_ref().map(|of| of.to_json(layout)),
            diagnostics,
        };
        let refusals = self.missing().into_iter().flat_map(|(refused, found_by)| {
            let refusals = refusals_json(&[refused], message_of).into_iter();
            refusals.map(move |refusal| Marked::by(found_by, refusal))
        });
        if document.results.is_empty() {
            document.results = host.results.clone();
        }
        document.verdict = judged;
        let reasons_of = |judgement| verdict_reasons(judgement, layout, message_of);
        document.verdict_reasons = judgement.as_ref().map(reasons_of).unwrap_or_default();
        document.not_applicable.get_or_insert_default().extend(refusals);
        document.notes.extend(self.notes.iter().cloned());
        let modes = self.modes.as_ref().map(|(modes, band)| modes_json(modes, *band, layout));
        document.suspension = modes.map(of_host);
        document.global_fit = self.global_fit.as_ref().map(global_fit_json).map(of_host);
        document.details = Some(host.details.clone().map(of_host));
        document.agreement = Some(host.agreement.clone().map(of_host));
        document.single_faults = host.single_faults.clone().map(of_host);
        let stands = |finding: &Finding| {
            of_rig.iter().any(|diagnostic| diagnostic.code.name() == finding.code)
        };
        document.diagnostics.retain(|marked| stands(&marked.what));
        document.diagnostics.extend(new.into_iter().map(of_host));
        document.host = Some(host);
    }

    /// The methods without an answer by the rig, and why: a line for each.
    pub fn missing_text(&self) -> String {
        let missing: Vec<_> = self.missing().into_iter().map(|(refused, _)| refused).collect();
        refusals_text(&missing, |d| message_in(d, &self.layout))
    }

    /// The findings as text under a heading. In the suspension profile, the answer to use has been printed before.
    pub fn to_text(&self) -> String {
        let of_rig = estimates_of(self.result);
        let is_alone = of_rig.is_empty() && self.profile == TestProfile::Suspension;
        let mut text = format!("{}\n", if is_alone { HEADING_OF_ALL } else { HEADING });
        for estimate in &self.identification.estimates {
            match of_rig.iter().find(|rig| rig.method == estimate.method) {
                Some(rig) => text += &self.comparison(estimate, rig),
                // The many answers to the suspension modes are compared in one table.
                None if self.profile == TestProfile::Suspension => {}
                None => {
                    text += &format!("{}: the rig has no such answer\n", estimate.method.name());
                }
            }
        }
        let here =
            |method: Method| self.identification.estimates.iter().any(|e| e.method == method);
        if !self.identification.estimates.is_empty() {
            for rig in of_rig.iter().filter(|rig| !here(rig.method)) {
                text += &format!("{}: the rig's answer is not confirmed here\n", rig.method.name());
            }
        }
        if let Some((modes, band)) = &self.modes {
            text += &modes_text(modes, *band, &self.layout);
        }
        text += &self.global_fit.as_ref().map_or_else(String::new, global_fit_text);
        let judged = self.judgement().as_ref().map(Judgement::verdict);
        let estimates = &self.identification.estimates;
        text += &comparison_text(&self.comparison, estimates, &self.layout, judged);
        text += &self.identification.nuisance_text(&self.layout);
        text += &sentences(&self.found, |d| message_in(d, &self.layout));
        self.suspicions.iter().for_each(|suspicion| text += &suspicion.to_text());
        for note in &self.notes {
            text += &format!("note: {note}\n");
        }
        if let Some(examination) = &self.examination {
            text += &examination.to_text(&self.layout);
        }
        text
    }

    /// The difference between the rig's answer and the host's.
    fn comparison(&self, host: &Estimate<f64>, rig: &Estimate<f64>) -> String {
        let scale = scale(host.body.mass, self.layout.characteristic_length());
        let difference = 100.0 * (host.theta() - rig.theta()).component_div(&scale).amax();
        let (method, percent) = (host.method.name(), two_digits(difference));
        match difference > SAME_PERCENT {
            true => format!(
                "{method}: the rig's answer, under its own layout and in single precision, differs by {percent} % of scale\n"
            ),
            false => format!("{method}: the rig's answer within {percent} % of scale\n"),
        }
    }

    /// The methods without an answer by the rig for which it has stored no reason, the reasons, and who found them.
    fn missing(&self) -> Vec<((Method, Vec<Diagnostic>), FoundBy)> {
        let of_rig = estimates_of(self.result);
        let missing = |method: &Method| {
            self.selection.contains(*method)
                && !of_rig.iter().any(|estimate| estimate.method == *method)
        };
        let refused = |method: Method| {
            let host = self.identification.not_applicable.iter().find(|(of, _)| *of == method);
            match host {
                Some((_, reasons)) => ((method, reasons.to_vec()), FoundBy::Host),
                None => ((method, self.reasons_of_the_rig()), FoundBy::Rig),
            }
        };
        if self.profile == TestProfile::Suspension {
            // A rig runs none of these methods.
            let refused = self.identification.not_applicable.iter();
            return refused
                .map(|(method, reasons)| ((*method, reasons.to_vec()), FoundBy::Host))
                .collect();
        }
        Method::of_mass_lines().filter(missing).map(refused).collect()
    }

    /// The rig's warnings and errors about the test as a whole, whatever the method.
    fn reasons_of_the_rig(&self) -> Vec<Diagnostic> {
        let whole = self.result.diagnostics.iter().filter(|d| d.subject == Subject::Whole);
        whole.filter(|d| d.severity > Severity::Note).copied().collect()
    }
}

/// What is said of DOFs whose lines the rig does not have any more.
fn missing_lines(test: StoredTest<'_>) -> Option<String> {
    let missing = test.missing();
    (!missing.is_empty()).then(|| {
        format!(
            "the lines of {} are missing: they are deleted with their result, or were lost on the rig; measure these DOFs again",
            missing.join(", ")
        )
    })
}

/// How the methods agree that have answered these mass lines.
fn comparison(
    identification: &Identification,
    layout: &HostLayout,
    lines: &MeasuredLines,
) -> Comparison {
    let estimates = &identification.estimates;
    let settings = IdentifySettings::default().inertia_restraint;
    let budget = estimates.first().map_or_else(|| layout.clone(), |best| learned(layout, best));
    compare(&MassLineAnswers { budget, lines, settings, estimates }, |_, _| ())
}

fn of_host<T>(what: T) -> Marked<T> {
    Marked::by(FoundBy::Host, what)
}

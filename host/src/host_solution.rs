//! A rig's result, solved again on the host in double precision from the mass lines in it.
//!
//! The rig's and the host's findings are never mixed: the rig's answer stays as it is stored, and the host's
//! findings are marked.
//!
//! | in JSON | from |
//! | --- | --- |
//! | `results` | the rig: its estimates with its diagnostics |
//! | `diagnostics` | the rig; an entry with `"found_by": "host"` is the host's |
//! | `not_applicable` | the methods without an answer by the rig, and why; `found_by` is `host` where the host found the reason [^1] |
//! | `host` | the host: `results`, `not_applicable`, `details`, `agreement`, `diagnostics`, `single_faults` |
//! | `agreement`, `details`, `single_faults` | the host, same contents as under `host` |
//!
//! [^1]: A rig does not store to which method a reason belongs. The host's reason is given where the host
//!     has no answer either.

use massline_protocol::object::MeasurementResult;
use massline_shared::body::scale;
use massline_shared::diagnosis::{Diagnostic, Severity, Subject};
use massline_shared::identify::{Estimate, IdentifySettings, Method, Observations};
use massline_shared::layout::HostLayout;

use crate::document::{FoundBy, HostFindings, Marked, Measurement, Unseen};
use crate::identification::{
    Identification, MeasuredLines, Selection, identify, layout_of, learned, lines_of,
};
use crate::report::{
    cannot_see, comparison_json, comparison_text, diagnostics_json, estimates_of, message_in,
    refusals_json, refusals_text, sentences, table,
};
use crate::single_fault::{Examination, NominalTest};
use crate::suspension::{Comparison, MassLineAnswers, compare, reciprocity_of_mass_lines};

/// Heading of the host's findings in text.
const HEADING: &str = "solved again here, in double precision";

/// The host's findings from the mass lines of a rig's result.
#[derive(Clone, Debug)]
pub struct HostSolution<'a> {
    /// The estimates, and the nuisance parameters of the fit.
    pub identification: Identification,
    /// The search for a single mistake that explains the data, where one was done.
    pub examination: Option<Examination>,
    /// Hits that move against their force or are not reciprocal.
    reciprocity: Vec<Diagnostic>,
    /// How the methods agree.
    comparison: Comparison,
    result: &'a MeasurementResult,
    layout: HostLayout,
    selection: Selection,
}

impl<'a> HostSolution<'a> {
    /// Solves the mass lines of a result with the layout of its measurement.
    pub fn new(result: &'a MeasurementResult, layout: &HostLayout, selection: Selection) -> Self {
        let lines = lines_of(result);
        let layout = layout_of(result, layout);
        let observed = Observations::of_mass_lines(&layout, &lines);
        let identification = identify(&observed, selection, &IdentifySettings::default());
        let reciprocity = reciprocity_of_mass_lines(&layout, &lines).to_vec();
        let comparison = comparison(&identification, &layout, &lines);
        Self {
            identification,
            examination: None,
            reciprocity,
            comparison,
            result,
            layout,
            selection,
        }
    }

    /// As [`Self::new`], with a search for the single mistake that explains the data.
    pub fn examined(
        result: &'a MeasurementResult,
        nominal: &NominalTest,
        selection: Selection,
    ) -> Self {
        let examination = Some(nominal.examine_result(result));
        Self { examination, ..Self::new(result, &nominal.layout, selection) }
    }

    /// Drops the details of sensors and hits; for a bench whose truth is known.
    pub fn without_details(mut self) -> Self {
        self.identification.details = None;
        self
    }

    /// What the test cannot see.
    pub fn cannot_see(&self) -> Vec<Unseen> {
        let of_rig = estimates_of(self.result);
        let best = self.identification.estimates.first().or(of_rig.first());
        cannot_see(&self.layout, best.map(|estimate| &estimate.body))
    }

    /// Adds the findings to the document of the rig's result.
    pub fn add_to(&self, document: &mut Measurement) {
        let Self { identification, layout, .. } = self;
        let message_of = |d: &Diagnostic| message_in(d, layout);
        let warnings = [identification.warnings(), self.reciprocity.clone()].concat();
        // A diagnostic that the rig has reported itself is not repeated.
        let is_new = |d: &&Diagnostic| {
            !self.result.diagnostics.iter().any(|of| (of.code, of.subject) == (d.code, d.subject))
        };
        let new: Vec<Diagnostic> = warnings.iter().filter(is_new).copied().collect();
        let (mut diagnostics, mut new) =
            (diagnostics_json(&warnings, message_of), diagnostics_json(&new, message_of));
        for found in self.examination.iter().map(|of| of.diagnostics_json(layout)) {
            diagnostics.extend(found.iter().cloned());
            new.extend(found);
        }
        let host = HostFindings {
            results: identification.results_json(),
            not_applicable: identification.not_applicable_json(layout),
            details: identification.details_json(layout),
            agreement: comparison_json(&self.comparison, &identification.estimates, layout),
            single_faults: self.examination.as_ref().map(|of| of.to_json(layout)),
            diagnostics,
        };
        let refusals = self.missing().into_iter().flat_map(|(refused, found_by)| {
            let refusals = refusals_json(&[refused], message_of).into_iter();
            refusals.map(move |refusal| Marked::by(found_by, refusal))
        });
        document.not_applicable = Some(refusals.collect());
        document.details = Some(host.details.clone().map(of_host));
        document.agreement = Some(host.agreement.clone().map(of_host));
        document.single_faults = host.single_faults.clone().map(of_host);
        document.diagnostics.extend(new.into_iter().map(of_host));
        document.host = Some(host);
    }

    /// The methods without an answer by the rig, and why: a line for each.
    pub fn missing_text(&self) -> String {
        let missing: Vec<_> = self.missing().into_iter().map(|(refused, _)| refused).collect();
        refusals_text(&missing, |d| message_in(d, &self.layout))
    }

    /// The findings as text under a heading.
    pub fn to_text(&self) -> String {
        let mut text = format!("{HEADING}\n");
        let of_rig = estimates_of(self.result);
        for estimate in &self.identification.estimates {
            match of_rig.iter().find(|rig| rig.method == estimate.method) {
                Some(rig) => text += &self.comparison(estimate, rig),
                None => text += &format!("the rig has no such answer:\n{}", table(estimate, None)),
            }
        }
        text += &comparison_text(&self.comparison, &self.identification.estimates, &self.layout);
        text += &self.identification.nuisance_text(&self.layout);
        text += &sentences(&self.reciprocity, |d| message_in(d, &self.layout));
        if let Some(examination) = &self.examination {
            text += &examination.to_text(&self.layout);
        }
        text
    }

    /// The difference between the rig's answer and the host's.
    fn comparison(&self, host: &Estimate<f64>, rig: &Estimate<f64>) -> String {
        let scale = scale(host.body.mass, self.layout.characteristic_length());
        let difference = 100.0 * (host.theta() - rig.theta()).component_div(&scale).amax();
        format!("{}: the rig's answer within {difference:.2e} % of scale\n", host.method.name())
    }

    /// The methods without an answer by the rig, the reasons, and who found them.
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
        Method::of_mass_lines().filter(missing).map(refused).collect()
    }

    /// The rig's warnings and errors about the test as a whole, whatever the method.
    fn reasons_of_the_rig(&self) -> Vec<Diagnostic> {
        let whole = self.result.diagnostics.iter().filter(|d| d.subject == Subject::Whole);
        whole.filter(|d| d.severity > Severity::Note).copied().collect()
    }
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

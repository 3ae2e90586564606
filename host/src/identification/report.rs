//! The result of an identification as JSON and as text.

use massline_shared::diagnosis::Diagnostic;
use massline_shared::identify::maximum_likelihood::LearnedBudget;
use massline_shared::layout::HostLayout;

use super::{Details, Identification};
use crate::document;
use crate::report::{
    Truth, budget_json, budget_text, details_json, details_text, estimate_json, message_in,
    refusals_json, refusals_text, sentences, table,
};

impl Identification {
    /// The estimates, the best first: the entries of `results`.
    pub fn results_json(&self) -> Vec<document::Estimate> {
        self.estimates.iter().map(estimate_json).collect()
    }

    /// The methods without an answer, and why: `not_applicable`.
    pub fn not_applicable_json(&self, layout: &HostLayout) -> Vec<document::Refusal> {
        refusals_json(&self.not_applicable, |d| message_in(d, layout))
    }

    /// The nuisance parameters and influences: `details`, null when the fit has no answer.
    pub fn details_json(&self, layout: &HostLayout) -> Option<document::Details> {
        let Details { nuisances, influences } = self.details.as_ref()?;
        let error_budget = self.learned().map(|learned| budget_json(learned, layout));
        Some(document::Details { error_budget, ..details_json(nuisances, influences, layout) })
    }

    /// The first `count` estimates as tables, why others are missing, and the details of the fit.
    pub fn to_text(&self, layout: &HostLayout, truth: Option<&Truth>, count: usize) -> String {
        let shown = self.estimates.iter().take(count);
        let tables = shown.map(|estimate| table(estimate, truth) + "\n");
        tables.collect::<String>() + &self.nuisance_text(layout)
    }

    /// What the best answer that learns its error budget has learned.
    fn learned(&self) -> Option<&LearnedBudget<f64>> {
        self.estimates.iter().find_map(|estimate| estimate.learned.as_ref())
    }

    /// Why estimates are missing, what was learned about the error budget, and the details of the fit.
    pub fn nuisance_text(&self, layout: &HostLayout) -> String {
        let message_of = |d: &Diagnostic| message_in(d, layout);
        let mut text = refusals_text(&self.not_applicable, message_of);
        text += &sentences(&self.priors, message_of);
        text += &self.learned().map_or_else(String::new, |learned| budget_text(learned, layout));
        if let Some(Details { nuisances, influences }) = &self.details {
            text += &details_text(nuisances, influences, layout);
        }
        text
    }
}

//! An identification as part of a result.

use massline_shared::diagnosis::Diagnostic;
use massline_shared::identify::maximum_likelihood::LearnedBudget;
use massline_shared::layout::HostLayout;

use massline_analysis::identification::{Details, Identification};

use super::{error_budget, estimate_of, fit_details, message_in, refusals};

/// The estimates, the best first.
pub fn estimates_in(
    identification: &Identification,
    layout: &HostLayout,
) -> Vec<massline_result::Estimate> {
    let message_of = |diagnostic: &Diagnostic| message_in(diagnostic, layout);
    identification.estimates.iter().map(|estimate| estimate_of(estimate, message_of)).collect()
}

/// The methods without an answer, and why.
pub fn refusals_in(
    identification: &Identification,
    layout: &HostLayout,
) -> Vec<massline_result::Refusal> {
    refusals(&identification.not_applicable, |d| message_in(d, layout))
}

/// The nuisance parameters and influences; `None` when the fit has no answer.
pub fn details_in(
    identification: &Identification,
    layout: &HostLayout,
) -> Option<massline_result::Details> {
    let Details { nuisances, influences } = identification.details.as_ref()?;
    let budget = learned(identification).map(|learned| error_budget(learned, layout));
    let details = fit_details(nuisances, influences, layout);
    Some(massline_result::Details { error_budget: budget, ..details })
}

/// What the best answer that learns its error budget has learned.
fn learned(identification: &Identification) -> Option<&LearnedBudget<f64>> {
    identification.estimates.iter().find_map(|estimate| estimate.learned.as_ref())
}

//! Predictions before anything is glued: the uncertainty of a layout, what limits it, and better layouts.
//!
//! All predictions are the Cramér-Rao bound under the whole error budget of the layout file, for the body of
//! `[reference]` or an assumed body, and in the suspension profile for assumed modes.

mod assumed_body;
mod assumptions;
mod candidates;
mod criterion;
mod findings;
mod forecast;
mod masses;
mod noise;
mod predicted;
mod suggest;
mod suspension;

pub use assumed_body::{assumed_for_solving, body_for_checks};
pub use assumptions::Assumptions;
pub use candidates::Candidates;
pub use criterion::LayoutCriterion;
pub use findings::{LayoutFindings, gravity_to_be_stated};
pub use forecast::{Forecast, forecast};
pub use masses::MassRange;
pub use predicted::{Advice, DesignReport, PredictedUncertainty};
pub use suggest::{Options, RequestedCount, Suggestion, suggest};

use massline_shared::identify::{Method, Methods};
use massline_shared::layout::TestProfile;

use crate::identification::Selection;

/// The methods that answer the tests of a profile.
fn methods_of(profile: TestProfile) -> Methods {
    match profile {
        TestProfile::MassLine => Method::of_mass_lines().collect(),
        TestProfile::Suspension => Selection::All.modal_methods(),
    }
}

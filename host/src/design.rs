//! Predictions before anything is glued: the uncertainty of a layout, what limits it, and better layouts.
//!
//! All predictions are the Cramér-Rao bound under the whole error budget of the layout file, for the body of
//! `[reference]` or an assumed body.

mod candidates;
mod predicted;
pub mod report;
mod suggest;

pub use candidates::Candidates;
pub use predicted::{Advice, DesignReport, Predicted};
pub use suggest::{Options, Suggestion, Wanted, suggest};

use massline_shared::design::Criterion;

use crate::layout_file::LayoutFile;
use crate::solve::body_for_checks;

/// The criterion for a layout file, with a sentence that names its body. `noise` is relative to 1/m; `length`
/// scales the inertial parameters, m.
fn criterion_for(file: &LayoutFile, length: f64, noise: f64) -> (Criterion<f64>, String) {
    let (body, whose) = body_for_checks(file);
    (Criterion::new(body, length, noise), whose)
}
